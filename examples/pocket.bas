' A round-cornered pocket, 40 x 25 mm with corners of 8 mm, cleared from the middle outward in
' three layers of 1 mm. The tighter the corner, the slower it is taken.
CONST LAYERS = 3
CONST RINGS = 3
DIM layer, ring, inset AS LENGTH, r AS LENGTH

Home
M3 S12000
G0 X50 Y40
SetPos X, 0mm                    ' lower left corner of the pocket
SetPos Y, 0mm
G0 X8 Y6 Z-10
FOR layer = 1 TO LAYERS
  G1 Z[-10mm - layer * 1mm] F240
  FOR ring = RINGS - 1 TO 0 STEP -1
    inset = ring * 3mm
    r = 8mm - inset
    outline
  NEXT
NEXT
G0 Z0
M5

SUB outline
  G1 X8 Y[inset] F2400
  G1 X32
  G3 X[40mm - inset] Y8 J[r]
  G1 Y17
  G3 X32 Y[25mm - inset] I[-r]
  G1 X8
  G3 X[inset] Y17 J[-r]
  G1 Y8
  G3 X8 Y[inset] I[r]
END SUB
