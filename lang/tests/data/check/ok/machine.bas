PROFILE "charly"
START MoveAxe X, 2000st, 2000st/s, 20000st/s2, 10000st/s2
MoveRel Y, -5mm, 25mm/s
WaitMove : WaitMove X
MoveSpeed Z, -100st/s
StopAxe Z
StopAll
Home Z, X
Home? Y
Probe Z, 20mm, 2mm/s
Probe? Z, 20mm, 900st/s, 4, OFF
ProbeMask Z, 20mm, 500st/s, &H0F, 3
IF PROBEOK(Z) THEN PRINT PROBED(Z); PROBEDST(Z)
SetPos Z, 5mm
SetOut 3, 1 : Pulse 4, 20ms : SetPort &B1010
Motors ON : Motors OFF, X
WaitIn 3, ON
WaitIn? 3, RISE, 2s
IF TIMEDOUT THEN PRINT "late"
WaitStart
Send 65 : WaitChar 66 : WaitChar? 67, 1s
PRINT CHARIN(); IN(17); OUT(3); INPORT(); POS(X); POSST(Y); MOVING(Z); HOMED(X); ERR
PRINT STEPS(X, 12mm); LENGTH(X, 480st); SGN(-5mm); ABS(-5mm); SQR(99)
PRINT STEPS(X, POS(X))
