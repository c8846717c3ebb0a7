' A laser engraver: three nested squares; M3 and M5 switch the laser, which is off between moves.
PROFILE "laser"
DIM i

Home
F1200
FOR i = 1 TO 3
  G0 X[50mm - i * 10mm] Y[50mm - i * 10mm]
  G91
  M3 S[i * 200]
  square i * 20mm
  M5
  G90
NEXT
G0 X0 Y0

SUB square(side)
  G1 X[side]
  G1 Y[side]
  G1 X[-side]
  G1 Y[-side]
END SUB
