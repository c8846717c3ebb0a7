DIM unused, n
CONST SPARE = 3
Home X
MoveAxe X, 400mm
MoveAxe X, 5mm, 500mm/s
MoveAxe Y, 5mm, -5mm/s
MoveAxe X, 5mm, 5mm/s, 9000mm/s2
Wait -5ms
Probe Z, -20mm, 2000st/s, 3
Send 3
FOR n = 1 TO 3 STEP 0
NEXT
G91 G1 X0.00051 F9000
G64 P0.1
G90 G0 X0 Y0
G2 X10 Y0 R2
G2 X20 Y0 I1
IF n = 3 THEN
  END
  PRINT "never"
END IF
DO
  PRINT "for ever"
LOOP
PRINT "never"
nowhere:
PRINT "again"
SUB idle
END SUB
