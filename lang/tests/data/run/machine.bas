TABLE spots(2) = 10mm, 5mm; 20mm, -5mm; 123.456mm, 8mm
DIM i, c, f AS SPEED
f = 10mm/s
MoveAxe X, 12mm
MoveAxe Y, 480st, 2000st/s
MoveRel Z, -1.25mm, f, 250mm/s2, 25000st/s2
START MoveAxe X, 0mm, 20mm/s
WaitMove X: WaitMove
MoveSpeed Y, -5mm/s: StopAxe Y: StopAll
Home Z, X
Home? Y
Probe Z, -20mm, 2mm/s
Probe? Z, -20mm, 2mm/s, 4, OFF
ProbeMask Z, -20mm, 100st/s, 3, 1
SetPos X, 0mm
SetOut 1, ON: SetOut 5, OFF: SetOut i + 1, i
Pulse 2, 50ms: SetPort &HFF
Motors ON: Motors OFF, Z
WaitIn 3, ON: WaitIn 3, RISE, 2s: WaitIn? 3, i, 1s
WaitStart: Send 65: WaitChar 66, 1s: WaitChar? 67
PRINT "at "; POS(X); " "; POSST(X); " "; f; " "; TIMER(); TRUE;
G0 X1 Y2 Z3
G1 X10 F600
G1 X[100st] Y5
G2 X20 Y0 I5 J-5
G3 X0 R10
G91 G1 X1 Y1
G3 X2 Y2 I1 J1
G90 G53 G0 Z0
G61 G1 X5
FOR i = 0 TO COUNT(spots) - 1
  G0 X[spots(i, 0)] Y[spots(i, 1)]
  FOR c = 0 TO 1: PRINT spots(i, c): NEXT
NEXT
G4 P0.5
M3 S1000
M5
PRINT STEPS(X, 12.344mm); " "; LENGTH(X, 480st)
