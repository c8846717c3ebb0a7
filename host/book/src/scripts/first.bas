' Four holes at the corners of 40 x 20 mm.
CONST WIDTH = 40mm, HEIGHT = 20mm

Home
hole 0mm, 0mm
hole WIDTH, 0mm
hole WIDTH, HEIGHT
hole 0mm, HEIGHT
G0 X0 Y0
END

SUB hole(across AS LENGTH, up AS LENGTH)
  G0 X[across] Y[up]
  MoveAxe Z, -2mm, 4mm/s       ' drill
  MoveAxe Z, 0mm               ' and out again
END SUB
