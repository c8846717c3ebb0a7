' Six holes on a circle of 40 mm. The table holds the cosines and sines, times the radius.
TABLE hole(2) = 20mm, 0mm; 10mm, 17.321mm; -10mm, 17.321mm; _
                -20mm, 0mm; -10mm, -17.321mm; 10mm, -17.321mm
DIM i

Home
G0 X60 Y60
G92 X0 Y0                        ' the centre
M3
G4 P1 F90                        ' the spindle runs up
FOR i = 0 TO COUNT(hole) - 1
  G98 G82 X[hole(i, 0)] Y[hole(i, 1)] Z-18 R-9 P0.2
NEXT
G80
M5
G53 G0 X0 Y0
