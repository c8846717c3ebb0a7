' One R and G98 throughout: nothing is kept at run time.
DIM i
TABLE holes(2) = 10mm, 10mm; 20mm, 10mm
G0 Z5
F100
FOR i = 0 TO COUNT(holes) - 1
  G81 X[holes(i, 0)] Y[holes(i, 1)] Z-3 R1
NEXT
G80
