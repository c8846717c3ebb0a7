' Glue along two sides of a plate in one path: the valve opens at its begin and closes at its end.
OUTPUT valve = 4

Home
G0 X20 Y20
MoveAxe Z, -30mm, 60mm/s
SetOut valve, ON
G1 X60 F600
G1 Y50
Wait 1ms                         ' the path is at its end
SetOut valve, OFF
MoveAxe Z, 0mm
