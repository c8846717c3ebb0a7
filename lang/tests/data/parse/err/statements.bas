MoveAxe X
MoveAxe X, 1mm, 2mm/s, 3, 4, 5
MoveAxe X, , 5
START Home
Probe Z, -5mm
ON 3 GOSUB x
ON IN 3 GOSUB x
ON ERROR RESUME NEXT
ON EVERY 5s GOTO x
PLANE XW
SetOut 1
Wait
RESUME
CONST a
CONST IF = 5
DIM a(3, b
TABLE t =
FOR X = 1 TO 3
NEXT
a = (1 + 2
a = 1 + 2)
a = 1 +
a = 1 2
a = WHILE
b = 2147483648
G1 X[1 + Y2
G1 X[(1 + 2] Y2
GOTO
PROFILE mill
x = 5 ELSE
NOT a
-5
