' Nothing calls these, so nothing says what their names are: they are Numbers.
SUB again(m)
  DIM k
  FOR k = m TO 0 STEP -1
    PRINT k
  NEXT
END SUB
SUB tied(a, b)
  DIM c
  FOR c = a TO b STEP a
    a = b + c
    b = c + a
    c = a + b
  NEXT
END SUB
