DIM i, x_1
N10 G90 G21
G1X10F300
g1 x-.5 y+2. z[ i * 2mm ]f[1200mm/min] (speed: 'fast') S1000 ; a comment: all of it
G0 X[i] : G0 Y1 ' BASIC again
X10 Y20
  Z-5
(a remark) G4 P1.5
; whole line
% whole line
M3 S1000 : IF i THEN G0 Z5 ELSE G0 Z0
begin: G81 X1.123456789012345678901 R2 Z-3 P.5
i = 3 : N20
G1 X1 _
   Y2
' A block may begin with any word.
I-5 J0 X10
I.5 J0 X10
R5 X10
I5 J0 X10
P1 Q2 R-1
L[i] X[i]
i5 = 3
r1 = 2: K2 X1
