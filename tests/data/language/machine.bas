' Positions: commanded um, rounded to steps once; a thousand small moves end where one ends.
DIM i
REPEAT 300
  MoveRel X, 0.333mm
END REPEAT
PRINT POS(X); " "; POSST(X)
MoveRel Y, 3st
PRINT POS(Y); " "; POSST(Y)
MoveAxe Y, 2st
PRINT POS(Y); " "; POSST(Y); " "; i
'> 99900um 9990st
'> 30um 3st
'> 20um 2st 0
'= done 10
'---
' Work positions and machine positions.
Home X
MoveAxe X, 50mm
SetPos X, 0mm
PRINT POS(X); " "; POSST(X)
MoveAxe X, 10mm
PRINT POS(X); " "; POSST(X)
MoveAxe X, 100st
PRINT POS(X); " "; POSST(X)
Home X
PRINT POS(X); " "; POSST(X)
'> 0um 5000st
'> 10000um 6000st
'> -49000um 100st
'> 0um 0st
'= done 11
'---
' Soft limits hold for homed axes.
PRINT HOMED(X)
MoveAxe X, -10mm
Home X
PRINT HOMED(X)
MoveAxe X, 300mm
MoveAxe X, 300.01mm
'> 0
'> 1
'= fault F05 7
'---
DIM v AS SPEED
MoveAxe X, 1mm, v
'= fault F08 2
'---
' Home? and a switch that is not there.
Home? X
PRINT HOMED(X)
Home X
'~ switch_at("X", -80000);
'> 0
'= fault F10 4
'---
' Probe: caught at that step; Probe? on a miss; PROBED as a work position.
Home
SetPos Z, 100mm
Probe Z, 60mm, 5mm/s
PRINT PROBED(Z); " "; PROBEDST(Z); " "; PROBEOK(Z)
MoveAxe Z, 90mm
Probe? Z, 85mm, 5mm/s
PRINT PROBEOK(Z); " "; POS(Z)
Probe Z, 85mm, 5mm/s
'~ probe_at("Z", -1840);
'> 81600um -1840st 1
'> 0 85000um
'= fault F12 9
'---
' Input already active.
Wait 50ms
Probe? Z, -20mm, 5mm/s, 3
'~ set_in(3, true);
'= fault F19 3
'---
' START, MOVING, WaitMove; a new target replaces the old.
START MoveAxe X, 50mm, 20mm/s
START MoveAxe Y, 20mm, 20mm/s
PRINT MOVING(X); MOVING(Y); MOVING(Z)
Wait 500ms
START MoveAxe X, 0mm, 20mm/s
WaitMove Y
PRINT MOVING(Y)
WaitMove
PRINT POS(X); " "; POS(Y)
'> 110
'> 0
'> 0um 20000um
'= done 10
'---
' MoveRel counts from the target of a moving axis.
START MoveRel X, 10mm, 10mm/s
START MoveRel X, 10mm, 10mm/s
WaitMove
PRINT POS(X)
'> 20000um
'= done 5
'---
MoveSpeed X, 20mm/s
Wait 500ms
PRINT MOVING(X)
StopAxe X
PRINT MOVING(X); POS(X) > 8mm ANDALSO POS(X) < 13mm
MoveSpeed X, 0st/s
'> 1
'> 01
'= fault F08 6
'host
'---
MoveSpeed X, 20mm/s
WaitMove X
'= fault F20 2
'host
'---
' END lets STARTed moves finish.
START MoveAxe X, 20mm
END
'~ expect_pos("X", 2000);
'= done 3
'---
' TIMER begins with the first statement.
PRINT TIMER() < 2ms
Wait 1s
PRINT TIMER() >= 1s; TIMER() < 1100ms
'> 1
'> 11
'= done 4
'---
' KEEP starts at 0.
KEEP parts, total AS LENGTH
parts = parts + 1
PRINT parts; " "; total
'> 1 0um
'= done 4
'---
' StopAll; Motors OFF clears HOMED.
Home X
START MoveAxe X, 100mm
StopAll
PRINT MOVING(X); POS(X) < 100mm; HOMED(X)
Motors OFF, X
PRINT HOMED(X)
'> 011
'> 0
'= done 7
'---
' A machine without Z moves X and Y as fast as any: 20 mm at 20 mm/s.
PROFILE "laser"
G1 X20 F1200
G91 Y20
G4 P0
PRINT TIMER() > 1900ms; TIMER() < 2500ms
'> 11
'= done 6
