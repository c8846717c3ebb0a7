' A round-cornered pocket, 40 x 25 mm with corners of 8 mm, cleared from the middle outward in
' three layers of 1 mm. The tighter the corner, the slower it is taken. The arcs are written in numbers, so
' that chips that draw none run them as short lines.
CONST LAYERS = 3
DIM layer

Home
M3 S12000
G0 X50 Y40
SetPos X, 0mm                    ' lower left corner of the pocket
SetPos Y, 0mm
G0 X8 Y6 Z-10
FOR layer = 1 TO LAYERS
  G1 Z[-10mm - layer * 1mm] F240
  inner
  middle
  outer
NEXT
G0 Z0
M5

SUB inner                        ' corners of 2 mm
  G1 X8 Y6 F2400
  G1 X32
  G3 X34 Y8 J2
  G1 Y17
  G3 X32 Y19 I-2
  G1 X8
  G3 X6 Y17 J-2
  G1 Y8
  G3 X8 Y6 I2
END SUB

SUB middle                       ' corners of 5 mm
  G1 X8 Y3
  G1 X32
  G3 X37 Y8 J5
  G1 Y17
  G3 X32 Y22 I-5
  G1 X8
  G3 X3 Y17 J-5
  G1 Y8
  G3 X8 Y3 I5
END SUB

SUB outer                        ' corners of 8 mm
  G1 X8 Y0
  G1 X32
  G3 X40 Y8 J8
  G1 Y17
  G3 X32 Y25 I-8
  G1 X8
  G3 X0 Y17 J-8
  G1 Y8
  G3 X8 Y0 I8
END SUB
