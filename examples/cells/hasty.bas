' Wrong on purpose: it trusts a fixed time for the vacuum and never asks whether a part hangs on the nozzle.
OUTPUT pump = 3
DIM n

ON ERROR GOTO trouble
Home
FOR n = 0 TO 2
  G0 X[20mm + n * 15mm] Y30
  MoveAxe Z, -22.5mm, 40mm/s
  SetOut pump, ON
  Wait 10ms
  MoveAxe Z, 0mm
  G0 X60 Y60
  MoveAxe Z, -12mm, 40mm/s
  SetOut pump, OFF
  Wait 100ms
  MoveAxe Z, 0mm
NEXT
PRINT "placed"
END

trouble:
SetOut pump, OFF
PRINT "stopped"
