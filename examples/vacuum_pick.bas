' Pick and place by a vacuum sensor: a pick is tried three times, and a part that falls off on the way is told at once.
PROFILE "picker"                 ' output vacuum, analog input pressure, input held below 1.2 V
CONST TRAY_X = 20mm, PITCH = 15mm, BELT_X = 150mm
CONST PICK = -22.5mm, PLACE = -12mm
DIM part, try, placed, lost, best AS VOLTAGE

SUB grip
  MoveAxe Z, PICK, 40mm/s
  SetOut vacuum, ON
  WaitIn? held, ON, 300ms
END SUB

Home
ON IN held FALL GOSUB dropped
FOR part = 0 TO 4
  G0 X[TRAY_X + part * PITCH] Y30
  FOR try = 1 TO 3
    grip
    IF held_now() THEN EXIT FOR
    SetOut vacuum, OFF
    MoveAxe Z, 0mm
  NEXT
  IF try > 3 THEN
    PRINT "pocket "; part; " is empty"
    CONTINUE FOR
  END IF
  MoveAxe Z, 0mm
  best = AIN(pressure)
  G0 X[BELT_X] Y60
  IF held_now() THEN
    MoveAxe Z, PLACE, 40mm/s
    SetOut vacuum, OFF
    WaitIn held, OFF, 500ms      ' F13 if the part sticks
    placed = placed + 1
    PRINT "part "; part; " placed, held at "; best
  ELSE
    SetOut vacuum, OFF
  END IF
  MoveAxe Z, 0mm
NEXT
PRINT placed; " placed, "; lost; " lost"
END

FUNCTION held_now() AS TRUTH
  RETURN IN(held)
END FUNCTION

dropped:
IF OUT(vacuum) THEN lost = lost + 1
RETURN
