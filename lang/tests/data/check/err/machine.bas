PROFILE "laser"
MoveAxe Z, 5mm
' ---
PROFILE "laser"
G0 X5 Z5
' ---
SetOut 17, ON
' ---
PRINT IN(0)
' ---
PROFILE "thesis"
OUTPUT lamp = 3
SetOut lamp, ON
' ---
WaitIn 18, ON
Pulse 99, 5ms
' ---
PROFILE "laser"
M8
