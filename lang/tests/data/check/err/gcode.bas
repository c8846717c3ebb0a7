G1 X10
' ---
G5 X10
' ---
G41 D1
' ---
G0 X10 X20
' ---
G0 G1 X10
' ---
X10
' ---
G0 X10 I5
' ---
G0 X10 P3
' ---
G1 F300
G2 X10
' ---
G1 F300
G2 X10 R5 I5
' ---
G1 F300
G2 R5
' ---
G1 F300
G18 G2 X10 J5
' ---
G4
' ---
G4 X3
' ---
G81 X10 Y10 R1 F100
' ---
G81 X10 Y10 Z-3 F100
' ---
G82 X10 Y10 Z-3 R1 F100
' ---
G83 X10 Y10 Z-3 R1 F100
' ---
G83 X10 Y10 Z-3 R1 Q-1 F100
' ---
G53 G2 X10 I5 F100
' ---
G38.2 X10 Z5 F100
' ---
G92
' ---
G28 G1 X5 F100
' ---
M48
' ---
M98 P5
' ---
G1 F300 A10
' ---
G0 X99999999
' ---
G[3] X5
' ---
IF IN(1) THEN G20
G0 X10
' ---
IF IN(1) THEN
  G91
ELSE
  G90
END IF
G0 X10
' ---
IF IN(1) THEN G1 F300
X10
' ---
IF IN(1) THEN G1 F300 X10
G1 X20
' ---
inch
G0 X1
metric
SUB inch
  G20
  both
END SUB
SUB metric
  G21
  both
END SUB
SUB both
  G0 X1
END SUB
' ---
ON IN 1 RISE GOSUB hit
G90 G1 X10 F300
END
hit:
G0 X5
RETURN
' ---
ON IN 1 RISE GOSUB hit
G90 G1 X10 F300
END
hit:
G21 G90 G61 G1 X5
RETURN
' ---
again:
G1 X10 F100
G20
GOTO again
' ---
ON ERROR GOTO oops
again:
G0 X10
END
oops:
GOTO again
' ---
G0 X10 (unclosed
' ---
IF IN(1) THEN PLANE XZ
G1 F300
G2 X10 Z0 R5
' ---
G0 K5
' ---
G1 X5 Q3 L2 F100
' ---
M3 M5
