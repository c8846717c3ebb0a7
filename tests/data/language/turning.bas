' Sines in 1/10000, angles in 1/1000 degrees, scales with products of 64 bits.
DIM a AS ANGLE, n, i, x_ AS LENGTH
PRINT SIN(30deg); " "; COS(30deg); " "; SIN(-90deg); " "; COS(180deg); " "; 90deg; " "; 12.5deg IN deg
'> 5000 8660 -10000 -10000 90000mdeg 12.500deg
a = 30deg
PRINT SIN(a); " "; COS(a); " "; SIN(a * 13); " "; SIN(-a); " "; COS(a - 390deg)
'> 5000 8660 5000 -5000 10000
n = 3
PRINT ATAN2(n, 4) IN deg; " "; ATAN2(n, -4) IN deg; " "; ATAN2(-n, -4); " "; ATAN2(n - 3, n - 3); " "; ATAN2(n * 1mm, 3mm)
'> 36.870deg 143.130deg -143130mdeg 0mdeg 45000mdeg
PRINT ATAN2(0, -n) IN deg; " "; ATAN2(-n, 0) IN deg
'> 180.000deg -90.000deg
n = 1000
PRINT SCALE(n, 0, 4095, 0mm, 100mm); " "; SCALE(n, 0, 4095, 100mm, 0mm); " "; SCALE(n, 2000, 1000, -5, 5); " "; SCALE(5000, 0, n, 0, 7)
'> 24420um 75580um 5 35
n = 2147483647
PRINT SCALE(n, 0, 2147483647, 0, 2147483647); " "; SCALE(-n, 0, 2147483647, 0, 1000)
'> 2147483647 -1000
FOR i = 0 TO 360 STEP 120
  x_ = 10mm * COS(i * 1deg) / 10000
  PRINT x_ IN mm
NEXT
'> 10.000mm
'> -5.000mm
'> -5.000mm
'> 10.000mm
n = SCALE(n, i, i, 0, 5)
'= fault F02 27
'---
' RESUME runs the failed statement again, where something has changed.
DIM a, b, i, n
ON ERROR GOTO oops
PRINT "p"; 12 / a; "q"
'> F2 in 4
'> p12q
a = 0
IF a = 5 THEN
  PRINT "never"
ELSEIF 12 / a = 12 THEN
  PRINT "elseif"
END IF
'> F2 in 10
'> elseif
a = 0
SELECT CASE 12
  CASE 3, 12 / a : PRINT "case"
  CASE ELSE : PRINT "else"
END SELECT
'> F2 in 17
'> case
a = 0
FOR i = 1 / a TO 2 : PRINT i : NEXT
'> F2 in 23
'> 1
'> 2
a = 0
WHILE n < 2 / a
  n = n + 1
  PRINT "w"; n
WEND
'> F2 in 28
'> w1
'> w2
a = 0
b = 7
b = b + half(3) : PRINT b
'> half
'> F2 in 61
'> 10
a = 0
Wait 1ms / a : Wait (a - 1) * 1ms : PRINT "waited"
'> F2 in 42
'> waited
n = SQR(-a)
'> F20 in 45
PRINT n
'> 0
GOSUB far
'> F2 in 57
'> far 1
END
'= done 52
far:
a = 0
b = a
PRINT "far "; 1 / a
RETURN
FUNCTION half(of)
  PRINT "half"
  RETURN of / a
END FUNCTION
oops:
PRINT "F"; ERR; " in "; ERL
a = a + 1
IF ERR = 20 THEN a = 0
RESUME
'---
' Without a fault it is F16.
RESUME
'= fault F16 2
'---
' A PRINT of more bytes than an entry of the statement table holds is one statement all the same.
DIM a, d AS LENGTH
ON ERROR GOTO oops
d = 1mm
PRINT d IN mm; d IN in; d IN mm; d IN in; d IN mm; d IN in; d IN mm; d IN in; 1 / a
'> F2 5
'> 1.000mm0.0394in1.000mm0.0394in1.000mm0.0394in1.000mm0.0394in1
a = 0
PRINT d IN mm; d IN in; d IN mm; d IN in; d IN mm; d IN in; d IN mm; d IN in; 1 / a; 1 / (a - 1)
'> F2 9
'> F2 9
'> 1.000mm0.0394in1.000mm0.0394in1.000mm0.0394in1.000mm0.0394in01
END
'= done 13
oops:
a = a + 1
PRINT "F"; ERR; " "; ERL
RESUME
