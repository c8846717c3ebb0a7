DIM i
TABLE holes(2) = 10mm, 10mm; 20mm, 10mm
G0 Z5
G99 G81 X0 Y0 Z-3 R1 F100
X10
G98 X20
G82 X30 P0.5
G83 X40 Q1 L2
G80
G0 Z10
FOR i = 0 TO COUNT(holes) - 1
  G98 G81 X[holes(i, 0)] Y[holes(i, 1)] Z[-2mm * i] R1
NEXT
G81 X50 Z-2 R1
G91 X5 Z-3 R-1
