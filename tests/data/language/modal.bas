' The Z before the first cycle is a run-time value: held through a loop, let go by other motion.
DIM i
G0 Z12
FOR i = 1 TO 2
  G99 G81 X[i] Z-1 R[i * 2mm] F900
  PRINT POS(Z)
NEXT
G98 G81 X9 Z-1 R1
PRINT POS(Z)
G0 Z7
FOR i = 1 TO 2
  G98 G81 X[i] Z-1 R[i * 2mm]
  PRINT POS(Z)
NEXT
MoveAxe Z, 18mm
G98 G81 X9 Z-1 R1
PRINT POS(Z)
'> 2000um
'> 4000um
'> 12000um
'> 7000um
'> 7000um
'> 18000um
'= done 17
'---
' Words of a cycle stay, computed ones too.
DIM depth, i
depth = 3
G0 Z5
G99 G83 X1 Z[-depth] R[depth - 2] Q[depth - 1] F900
depth = 9
X2
PRINT POS(X); " "; POS(Z)
FOR i = 3 TO 4 : X[i] : NEXT
PRINT POS(X); " "; POS(Z)
G91 X1 L3
PRINT POS(X); " "; POS(Z)
'~ expect_pos("Z", 200);
'> 2000um 1000um
'> 4000um 1000um
'> 7000um 2000um
'= done 12
'---
' A handler starts without modal state; what held before it holds behind it, F included.
DIM a AS TIME, b AS TIME
ON IN 3 RISE GOSUB hit
G91 G20 G1 X0.5 F10
a = TIMER()
X0.5
a = TIMER() - a
Wait 1s
b = TIMER()
X0.5
b = TIMER() - b
PRINT POS(X); " "; ABS(a - b) < 50ms
END
hit:
G90 G21 G64 G1 Y5 F3000
RETURN
'~ at(6500, || set_in(3, true));
'> 38100um 1
'= done 13
'---
' The error handler too, and a GOTO out of it brings its state along.
DIM z_1
ON ERROR GOTO oops
G91 G1 X5 F3000
z_1 = 1 / z_1
X5
PRINT POS(X)
z_1 = -1
z_1 = SQR(z_1)
END
oops:
IF ERR = 20 THEN G90 : GOTO out_
RESUME NEXT
out_:
G21 G64 G1 X1 F3000
PRINT POS(X)
'> 10000um
'> 1000um
'= done 16
'---
' Blocks under G64 join; what stands between them runs meanwhile.
DIM i, t AS TIME
t = TIMER()
F6000
FOR i = 1 TO 5
  G1 X[i * 10]
NEXT
i = i * 2
PRINT i; " "; POS(X)
'> 12 50000um
'= done 9
'---
' F by a StepRate and by a Speed.
DIM t AS TIME
G1 X10 F[1000st/s]
t = TIMER()
X20
G4 P0
PRINT TIMER() - t > 950ms; TIMER() - t < 1100ms
t = TIMER()
X30 F[10mm/s]
G4 P0
PRINT TIMER() - t > 950ms; TIMER() - t < 1100ms
'> 11
'> 11
'= done 11
'---
' A GOSUB that leaves its modal words behind, and one that does not write any.
GOSUB metric
G1 X2 F3000
GOSUB quiet
X3
PRINT POS(X)
END
metric:
G91 G20
RETURN
quiet:
PRINT "quiet"
RETURN
'> quiet
'> 127000um
'= done 7
'---
' G28 through a point, relative too; G53 under G91 is a machine position.
G91 G0 X10 Y10
G28 X5
PRINT POSST(X); " "; POSST(Y)
G53 G0 Y3
PRINT POSST(Y)
'> 0st 1000st
'> 300st
'= done 6
'---
' A fault in a move of a path is raised where the path is waited for.
Home X
G1 X10 F3000
G1 X400
PRINT "never"
'= fault F05 4
'---
' Soft limits hold at every extreme of an arc.
Home X, Y
G1 X5 Y10 F3000
G2 X5 Y30 I0 J10
'= fault F05 4
'---
' A move that a soft limit refuses leaves the commanded place.
Home X
ON ERROR GOTO oops
MoveAxe X, 10mm
MoveAxe X, -5mm
MoveRel X, 1mm
PRINT POS(X); POSST(X)
END
oops:
PRINT "F"; ERR
RESUME NEXT
'> F5
'> 11000um1100st
'= done 8
'---
PROFILE "thesis"
' The profile's default feed, 10 mm/s.
DIM t AS TIME
t = TIMER()
G1 X20
G4 P0
PRINT TIMER() - t > 1900ms; TIMER() - t < 2300ms
'> 11
'= done 7
