' The first pass of a loop with constant bounds is certain: what it writes holds behind it.
CONST LAST = 3
DIM i
FOR i = 1 TO LAST
  G91 G1 X[i] F300
NEXT
X5
REPEAT 2
  G20
END REPEAT
X1
FOR i = 3 TO 1 STEP -1
  IF IN(1) THEN EXIT FOR
  G21
NEXT
G21 X1
