' Heights of a plate on a grid of 3 x 3 points, and how far it is out of level.
CONST PITCH = 25mm
DIM column, row, low AS LENGTH, high AS LENGTH, height AS LENGTH

Home
low = 0mm
high = -80mm
FOR row = 0 TO 2
  FOR column = 0 TO 2
    MoveAxe Z, -10mm
    G0 X[30mm + column * PITCH] Y[30mm + row * PITCH]
    Probe Z, -40mm, 5mm/s
    height = PROBED(Z)
    PRINT "x "; POS(X); ", y "; POS(Y); ": "; height
    low = MIN(low, height)
    high = MAX(high, height)
  NEXT
NEXT
MoveAxe Z, 0mm
PRINT "out of level by "; high - low
