' Holes from a table: the loop that a drill file becomes.
TABLE holes(2) = 10mm, 5mm; 12.54mm, 5mm; 15.08mm, 5mm; 17.62mm, 5mm; 20.16mm, 12.62mm
DIM i
Home
F300
M3
FOR i = 0 TO COUNT(holes) - 1
  G81 X[holes(i, 0)] Y[holes(i, 1)] Z-2 R1 F120
NEXT
M5
FOR i = 0 TO COUNT(holes) - 1
  G0 X[holes(i, 0)] Y[holes(i, 1)]
  G1 Z-2 F120
  G0 Z2
NEXT
M2
