' SYNC is a word where a statement of an output follows; elsewhere it is a name.
OUTPUT valve = 1
DIM sync, lag AS TIME, way AS LENGTH
sync = 2
lag = -20ms
way = 2mm
SYNC SetOut valve, ON
SYNC SetOut valve, sync > 1, 15ms
SYNC SetOut valve, OFF, lag
SYNC Pulse 2, 20ms, way
SYNC Pulse 2, lag * -1, -1mm
sync = sync + 1
F600
M62 P1
G1 X1
M63 P[sync] G1 X2
M64 P2
M65 P2
