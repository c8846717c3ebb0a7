DIM lenght
lenght = 3
PRINT length_1
' ---
DIM counter
conter = 3
' ---
DIM a, a
' ---
CONST A = 3
A = 4
' ---
CONST A = b + 1
DIM b
' ---
CONST A = POS(X)
' ---
DIM a
CONST B = a
' ---
OUTPUT pump = 3
pump = ON
' ---
DIM a(3)
a = 4
' ---
DIM a
a(2) = 4
' ---
DIM a(3)
a(3) = 4
PRINT a(1, 2)
' ---
DIM a(0)
' ---
TABLE t = 1, 2, 3
PRINT t(3)
PRINT t
t(0) = 4
' ---
TABLE t(2) = 1, 2; 3
PRINT t(0, 0)
' ---
TABLE t = 1, 2; 3, 4
PRINT t(0)
' ---
SUB go(a)
  PRINT a
END SUB
go 1, 2
' ---
SUB go
END SUB
PRINT go
' ---
DIM go_1
CALL go_1
' ---
GOTO nowhere
' ---
GOTO inner
SUB go
inner:
END SUB
go
' ---
GOTO inside
IF IN(1) THEN
inside:
  PRINT 1
END IF
' ---
again:
again:
GOTO again
' ---
SUB a
  b
END SUB
SUB b
  a
END SUB
a
' ---
FUNCTION fac(n)
  RETURN n * fac(n - 1)
END FUNCTION
PRINT fac(5)
' ---
GOSUB work
END
work:
GOSUB work
RETURN
' ---
EXIT FOR
' ---
WHILE IN(1)
  EXIT DO
WEND
' ---
CONTINUE WHILE
' ---
EXIT SUB
' ---
SUB go
  EXIT FUNCTION
END SUB
go
' ---
RETURN 5
' ---
ON IN 1 RISE GOSUB work
ON IN 2 RISE GOSUB work
ON IN 3 RISE GOSUB work
ON EVERY 5s GOSUB work
ON EVERY 9s GOSUB work
SUB work
END SUB
' ---
ON IN 1 RISE GOSUB work
SUB work(a)
  PRINT a
END SUB
' ---
ON ERROR GOTO oops
SUB go
oops:
END SUB
go
' ---
ON ERROR GOTO oops
DO
oops:
LOOP
' ---
ON EVERY 1s GOSUB work
work
SUB work
  DIM i
  i = 1
  PRINT i
END SUB
' ---
ON IN 1 RISE GOSUB work
GOSUB work
END
work:
REPEAT 3
  PRINT "again"
END REPEAT
RETURN
' ---
ON ERROR GOTO oops
park 5mm
END
oops:
park 5mm
END
SUB park(d AS LENGTH)
  MoveAxe Z, d
END SUB
' ---
CONST A = 1 << 40
' ---
DIM a
a = 10 / 0
a = 2147483647 + 1
a = ABS(-2147483648)
' ---
DIM q AT 3001
DIM r AT 2998
' ---
DIM q AT 3000, r AT 3000
' ---
SUB go
  DIM q AT 3000
  KEEP k
END SUB
go
' ---
KEEP a, b, c, d, e, h, i, j, k
' ---
KEEP k(9)
' ---
KEEP a(5), b(4)
' ---
KEEP k(0)
' ---
TABLE t(px, px) = 1, 2
PRINT t(0, px)
' ---
TABLE t(px, depth) = 1, 2; 3
PRINT t(0, px)
' ---
TABLE t(px, depth) = 1, 2; 3, 4
PRINT t(0, width)
' ---
FUNCTION five
  RETURN 5
END FUNCTION
PRINT five(3)
' ---
PROFILE "mil"
PRINT 1
' ---
SUB go
  IF IN(1) THEN GOTO out
END SUB
out:
go
' ---
PRINT COUNT(5)
' ---
DIM X_1
PRINT X + 1
' ---
DIM a LABEL "A", b MIN 1
' ---
DIM a AS LENGTH AT 3000 MIN 1, b AT 3002 MIN 5 MAX 4
' ---
KEEP k MAX 3
