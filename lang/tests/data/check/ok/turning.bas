DIM a AS ANGLE, n, t, v AS LENGTH
a = ATAN2(3mm, 4mm) + 90deg - 500mdeg
n = SIN(a) + COS(2 * a) + SIN(30deg)
t = SCALE(n, 0, 10, 0s, 5s)
v = SCALE(t, 0s, 5s, 0mm, 100mm)
PRINT a; " "; a IN deg; " "; n; " "; t IN s; " "; v; SCALE(5, 0, 10, 0, 4)
' ---
' The script's own names stay what they are.
DIM scale(3), atan2
CONST COS = 5
atan2 = scale(1) + cos + atan2
PRINT sin(4)
FUNCTION sin(x_)
  RETURN x_ * 2
END FUNCTION
