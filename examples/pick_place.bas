' Pick and place: twelve parts from a tray of 3 columns and 4 rows onto a belt.
OUTPUT vacuum = 3
INPUT held = 3                   ' vacuum switch: a part hangs on the nozzle
CONST TRAY_X = 20mm, TRAY_Y = 30mm, PITCH = 15mm
CONST BELT_X = 150mm, BELT_Y = 60mm
CONST PICK = -22.5mm, PLACE = -12mm
DIM column, row, placed

Home
FOR row = 0 TO 3
  FOR column = 0 TO 2
    G0 X[TRAY_X + column * PITCH] Y[TRAY_Y + row * PITCH]
    MoveAxe Z, PICK, 40mm/s
    SetOut vacuum, ON
    WaitIn? held, ON, 400ms
    MoveAxe Z, 0mm
    IF TIMEDOUT THEN             ' an empty pocket
      SetOut vacuum, OFF
      PRINT "no part in row "; row; ", column "; column
      CONTINUE FOR
    END IF
    G0 X[BELT_X] Y[BELT_Y]
    MoveAxe Z, PLACE, 40mm/s
    SetOut vacuum, OFF
    WaitIn held, OFF, 500ms      ' F13 if the part sticks
    MoveAxe Z, 0mm
    placed = placed + 1
  NEXT
NEXT
PRINT placed; " parts placed"
