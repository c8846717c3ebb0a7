' A test bench: each device is carried over a tester, which answers good or bad, and put where it belongs.
OUTPUT pump = 3
INPUT held = 3, good = 5
CONST PICK = -22.5mm, PLACE = -12mm
DIM n, bad

Home
FOR n = 0 TO 3
  G0 X[20mm + n * 15mm] Y30
  MoveAxe Z, PICK, 40mm/s
  SetOut pump, ON
  WaitIn held, ON, 400ms
  MoveAxe Z, 0mm
  G0 X100 Y30
  Wait 100ms                     ' the tester measures
  IF IN(good) THEN
    G0 X140 Y60
  ELSE
    bad = bad + 1
    PRINT "device "; n; " is bad"
    G0 X180 Y60
  END IF
  MoveAxe Z, PLACE, 40mm/s
  SetOut pump, OFF
  WaitIn held, OFF, 500ms
  MoveAxe Z, 0mm
NEXT
PRINT bad; " bad"
