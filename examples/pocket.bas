' A round-cornered pocket, 40 x 25 mm with corners of 6 mm, in three layers of 1 mm.
CONST LAYERS = 3
DIM layer

Home
M3 S12000
G0 X50 Y40
SetPos X, 0mm                    ' lower left corner of the pocket
SetPos Y, 0mm
G0 X6 Y0 Z-10
FOR layer = 1 TO LAYERS
  G1 Z[-10mm - layer * 1mm] F60
  outline
NEXT
G0 Z0
M5

SUB outline
  G1 X34 Y0 F400
  G3 X40 Y6 J6
  G1 Y19
  G3 X34 Y25 I-6
  G1 X6
  G3 X0 Y19 J-6
  G1 Y6
  G3 X6 Y0 I6
END SUB
