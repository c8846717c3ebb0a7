' What only larger parts have: RESUME, SIN, COS, ATAN2, SCALE.
DIM a AS ANGLE, n, b, out AS LENGTH
ON ERROR GOTO oops
a = 30deg
PRINT SIN(a); " "; COS(a); " "; ATAN2(n - 3, n + 4)
n = 1000
out = SCALE(n, 0, 4095, -5mm, 5mm)
PRINT out
PRINT 100 / b
n = SCALE(n, b, 2, 0, 10)
PRINT n
END
oops:
  PRINT "F"; ERR; " in "; ERL
  b = b + 2
  IF ERL = 10 THEN b = 3
  RESUME
