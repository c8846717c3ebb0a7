' Parts from a tape: the next pocket comes while the head is away. A pocket without a part is passed over, three at most.
OUTPUT pump = 3, advance = 5
INPUT held = 3
CONST LOW = -22.5mm, PLACE = -12mm
DIM n, tries, got

Home
FOR n = 0 TO 3
  tries = 0
  DO
    pick
    Pulse advance, 50ms
    tries = tries + 1
  LOOP UNTIL got = 1 OR tries = 3
  IF got = 0 THEN
    PRINT "no part on the tape"
    END
  END IF
  G0 X[60mm + n * 12mm] Y60
  MoveAxe Z, PLACE, 40mm/s
  SetOut pump, OFF
  WaitIn held, OFF, 500ms
  MoveAxe Z, 0mm
NEXT
PRINT "4 parts placed"
END

SUB pick
  G0 X20 Y30
  MoveAxe Z, LOW, 40mm/s
  SetOut pump, ON
  WaitIn? held, ON, 400ms
  IF TIMEDOUT THEN
    got = 0
    SetOut pump, OFF
  ELSE
    got = 1
  END IF
  MoveAxe Z, 0mm
END SUB
