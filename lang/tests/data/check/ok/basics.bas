CONST PITCH = 2.54mm
OUTPUT pump = 3 : INPUT part = 3
DIM i, px AS LENGTH, seen(8), t
TABLE spots(2) = 10mm,5mm; 20mm,5mm; 30mm,8mm
KEEP parts
Home
FOR i = 0 TO COUNT(spots) - 1
  px = spots(i, 0) + PITCH
  MoveAxe X, px, 20mm/s
  seen(i) = IN(part)
  IF NOT IN(part) THEN CONTINUE FOR
  SetOut pump, ON : Wait 250ms : SetOut pump, OFF
  drill 3mm, 2
NEXT
t = TIMER()
PRINT "done after "; t; parts
parts = parts + 1
G0 X0 Y0
G1 X10 Y[i * PITCH] F300
X20
G2 X30 Y0 R10
END
SUB drill(depth, n)
  REPEAT n
    MoveAxe Z, -depth
    MoveAxe Z, 0mm
  END REPEAT
END SUB
