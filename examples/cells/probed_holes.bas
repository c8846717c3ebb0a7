' Holes in a board that is not level: each is as deep as the height that was probed at its place says.
TABLE hole(2) = 35mm, 35mm; 60mm, 35mm; 60mm, 50mm; 35mm, 50mm
CONST DEPTH = 1mm
DIM i, top AS LENGTH

Home
FOR i = 0 TO COUNT(hole) - 1
  G0 X[hole(i, 0)] Y[hole(i, 1)]
  MoveAxe Z, -15mm
  Probe Z, -25mm, 4mm/s
  top = PROBED(Z)
  MoveAxe Z, top + 2mm
  M3
  Wait 300ms                     ' the spindle runs up
  MoveAxe Z, top - DEPTH, 2mm/s
  MoveAxe Z, top + 2mm
  M5
  MoveAxe Z, 0mm
  PRINT "hole "; i; ": top at "; top
NEXT
