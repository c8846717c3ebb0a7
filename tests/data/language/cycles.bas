' R in work um and Z in machine steps: the work offset counts for R only.
SetPos Z, -6mm
G0 Z5
G99 G83 X1 Y2 Z[900st] R4 Q[50st] F600
'@ rapid 0 0 1100
'@ rapid 100 200 1100
'@ rapid 100 200 1000
'@ line 100 200 950
'@ rapid 100 200 1000
'@ rapid 100 200 975
'@ line 100 200 900
'@ rapid 100 200 1000
'= done 4
'---
' R in machine steps and Z in work um.
SetPos Z, -6mm
G0 Z5
G99 G83 X1 Z2 R[1000st] Q[150st] F600
G81 X2 Z3.5 R[900st]
'@ rapid 0 0 1100
'@ rapid 100 0 1100
'@ rapid 100 0 1000
'@ line 100 0 850
'@ rapid 100 0 1000
'@ rapid 100 0 875
'@ line 100 0 800
'@ rapid 100 0 1000
'@ rapid 200 0 1000
'@ rapid 200 0 900
'@ line 200 0 950
'@ rapid 200 0 900
'= done 5
'---
' Relative: Z counts from R, each in its unit.
SetPos Z, -6mm
G91 G99 G83 Z[-150st] R-1 Q1 F600
G83 X0 Z-1 R[-10st] Q[70st]
'@ rapid 0 0 -100
'@ line 0 0 -200
'@ rapid 0 0 -100
'@ rapid 0 0 -175
'@ line 0 0 -250
'@ rapid 0 0 -100
'@ rapid 0 0 -110
'@ line 0 0 -180
'@ rapid 0 0 -110
'@ rapid 0 0 -155
'@ line 0 0 -210
'@ rapid 0 0 -110
'= done 4
'---
' G98 compares the Z before the cycles with an R in steps as work positions, in one move.
SetPos Z, -6mm
G0 Z2
G98 G81 X1 Z-3 R[700st] F600
G80
G0 Z0
G81 X2 Z-3 R[700st]
G83 X3 Z[250st] R[700st] Q4
'@ rapid 0 0 800
'@ rapid 100 0 800
'@ rapid 100 0 700
'@ line 100 0 300
'@ rapid 100 0 800
'@ rapid 100 0 600
'@ rapid 100 0 700
'@ rapid 200 0 700
'@ line 200 0 300
'@ rapid 200 0 700
'@ rapid 300 0 700
'@ line 300 0 300
'@ rapid 300 0 700
'@ rapid 300 0 325
'@ line 300 0 250
'@ rapid 300 0 700
'= done 8
'---
' Words in brackets stay as literal ones do: constants of the cycle's own line.
CONST CLEAR = 5mm
CONST DEPTH = 3mm
F300
G0 Z19
G99 G81 X0 Y0 R[CLEAR] Z[-DEPTH]
X10
G80
'@ rapid 0 0 1900
'@ rapid 0 0 500
'@ line 0 0 -300
'@ rapid 0 0 500
'@ rapid 1000 0 500
'@ line 1000 0 -300
'@ rapid 1000 0 500
'= done 8
'---
' A constant depth of each peck, for the second hole too.
CONST PECK = 2mm
F300
G99 G83 X0 Y0 R1 Z-3 Q[PECK]
X10
G80
'@ rapid 0 0 100
'@ line 0 0 -100
'@ rapid 0 0 100
'@ rapid 0 0 -75
'@ line 0 0 -300
'@ rapid 0 0 100
'@ rapid 1000 0 100
'@ line 1000 0 -100
'@ rapid 1000 0 100
'@ rapid 1000 0 -75
'@ line 1000 0 -300
'@ rapid 1000 0 100
'= done 6
'---
' A constant dwell: 2 s at the bottom of each hole.
F300
G99 G82 X0 Y0 R1 Z-3 P[2]
X10
G80
IF TIMER() > 4s THEN PRINT "dwelt"
'@ rapid 0 0 100
'@ line 0 0 -300
'@ rapid 0 0 100
'@ rapid 1000 0 100
'@ line 1000 0 -300
'@ rapid 1000 0 100
'> dwelt
'= done 6
'---
' A CONST of a SUB stays with the cycle that the SUB began, as do its units.
CONST DEPTH = 1mm
F300
Begin
G21 X10
G80
SUB Begin
  CONST DEPTH = 2mm
  G21 G99 G81 X0 Y0 R1 Z[-DEPTH]
END SUB
'@ rapid 0 0 100
'@ line 0 0 -200
'@ rapid 0 0 100
'@ rapid 1000 0 100
'@ line 1000 0 -200
'@ rapid 1000 0 100
'= done 10
