DIM i, a, b
b = 3
FOR i = 1 TO 1000
  a = b + i
NEXT
