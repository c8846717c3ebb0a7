' Needs nothing but the board: no Home, no switches.
DIM i
FOR i = 1 TO 5
  MoveRel X, 10mm, 10mm/s
  PRINT "move "; i
  Wait 500ms
NEXT
