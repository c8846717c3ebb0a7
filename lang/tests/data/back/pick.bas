' Tray to nest with a part check.
OUTPUT vacuum = 1
INPUT part = 3
CONST PITCH = 12.5mm
DIM row, column, misses
Home
FOR row = 0 TO 2
  FOR column = 0 TO 3
    MoveAxe X, 20mm + column * PITCH
    MoveAxe Y, row * PITCH
    pick
    IF IN(part) THEN
      MoveAxe X, 150mm
      place
    ELSE
      misses = misses + 1
      PRINT "missed "; misses
      IF misses > 3 THEN END
    END IF
  NEXT
NEXT
MoveAxe Z, 0mm
END

SUB pick
  MoveAxe Z, -12mm, 20mm/s
  SetOut vacuum, ON
  Wait 250ms
  MoveAxe Z, 0mm
END SUB

SUB place
  MoveAxe Z, -12mm, 20mm/s
  SetOut vacuum, OFF
  Wait 250ms
  MoveAxe Z, 0mm
END SUB
