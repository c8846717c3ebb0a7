' Literals and their stored units.
PRINT 2.54mm; " "; 0.1in; " "; 350um; " "; 6600st; " "; 1.5s; " "; 2min; " "; 1200mm/min
PRINT 25mm/s; " "; 40in/min; " "; 2000st/s; " "; 250mm/s2; " "; 25000st/s2; " "; &H1F; &B1010; 1_000
PRINT .5mm; " "; -2147483648; " "; &HFFFFFFFF
'> 2540um 2540um 350um 6600st 1500ms 120000ms 20000um/s
'> 25000um/s 16933um/s 2000st/s 250000um/s2 25000st/s2 31101000
'> 500um -2147483648 -1
'= done 4
'---
' Truth serves as a Number; comparisons give 1 or 0.
DIM n, t
n = 3
t = n > 2
PRINT t; n = 3; n <> 3; TRUE + TRUE; NOT t; NOT n; ON; FALSE
n = t
PRINT n; 5 AND 3; 5 OR 3; 5 XOR 3; (n > 0) AND (n < 0)
'> 11020-410
'> 11760
'= done 7
'---
' The algebra of kinds.
DIM d AS LENGTH
d = 10mm
PRINT d + 5mm; " "; d * 3; " "; 3 * d; " "; d / 4; " "; d / 3mm; " "; d MOD 3mm; " "; d MOD 7; " "; -d
PRINT ABS(-d); " "; MIN(d, 3mm); " "; MAX(d, 3mm); " "; SGN(-d); " "; d > 3mm; " "; SQR(99)
'> 15000um 30000um 30000um 2500um 3 1000um 4um -10000um
'> 10000um 3000um 10000um -1 1 9
'= done 5
'---
' Division truncates toward zero, MOD has the dividend's sign, shifts.
DIM a, b
a = -7 : b = 2
PRINT a / b; " "; a MOD b; " "; 7 / -2; " "; 7 MOD -2; " "; a >> 1; " "; 1 << 31; " "; 3 << 31
PRINT 2 + 3 * 4 - 10 / 5 MOD 2; " "; 1 OR 2 AND 4; " "; 1 + 1 << 2; " "; -2 * -3; " "; NOT 1 = 2
'> -3 -1 -3 1 -4 -2147483648 -2147483648
'> 14 1 8 6 1
'= done 5
'---
' The least number.
DIM a, b
a = -2147483648 : b = -1
PRINT a MOD b
PRINT a / b
'> 0
'= fault F01 5
'---
DIM a
a = -2147483648
PRINT -a
'= fault F01 3
'---
DIM a
a = -2147483648
PRINT ABS(a)
'= fault F01 3
'---
DIM a
PRINT 5 / a
'= fault F02 2
'---
DIM a
PRINT 5 MOD a
'= fault F02 2
'---
DIM a
a = 2147483647
a = a + 1
'= fault F01 3
'---
DIM a
a = 65536
a = a * a
'= fault F01 3
'---
DIM a
a = 32
PRINT 1 << a
'= fault F04 3
'---
DIM a
a = -1
PRINT 1 >> a
'= fault F04 3
'---
DIM a
a = -1
PRINT SQR(a)
'= fault F20 3
'---
DIM a(3), i
i = 3
a(i) = 1
'= fault F03 3
'---
TABLE t = 1, 2, 3
DIM i
i = -1
PRINT t(i)
'= fault F03 4
'---
TABLE t(2) = 1, 10mm; 2, 20mm; 3, 30mm
DIM i
FOR i = 0 TO COUNT(t) - 1
  PRINT t(i, 0); " "; t(i, 1)
NEXT
PRINT t(3 - 1, 0)
PRINT t(i, 0)
'> 1 10000um
'> 2 20000um
'> 3 30000um
'> 3
'= fault F03 7
'---
' Only ANDALSO and ORELSE stop early.
DIM calls
PRINT FALSE ANDALSO count_; TRUE ORELSE count_; calls
PRINT FALSE AND count_; TRUE OR count_; calls
PRINT (calls > 5) ANDALSO count_; (calls > 1) ORELSE count_; calls
FUNCTION count_ AS TRUTH
  calls = calls + 1
  RETURN TRUE
END FUNCTION
'> 010
'> 012
'> 012
'= done 9
'---
' Conversions by the profile, 100 steps/mm, rounded half away from zero.
DIM d AS LENGTH, s AS STEPS
d = 5um : s = -480st
PRINT STEPS(X, d); " "; STEPS(X, -d); " "; STEPS(X, 4um); " "; LENGTH(X, s); " "; STEPS(X, 12mm)
'> 1st -1st 0st -4800um 1200st
'= done 4
'---
' Evaluation is from left to right.
DIM trail
PRINT step_(1) + step_(2) * step_(3); " "; trail
FUNCTION step_(n)
  trail = trail * 10 + n
  RETURN n
END FUNCTION
'> 7 123
'= done 7
'---
' Locals are 0 at each call; globals are seen inside.
DIM total
add 3
add 4
PRINT total
SUB add(n)
  DIM local, list(2)
  local = local + n
  list(1) = list(1) + local
  total = total + list(1)
  n = 99
END SUB
'> 7
'= done 12
'---
' A local hides a global; an array's elements count from 0.
DIM n, list(3)
n = 5
list(0) = 1 : list(2) = 3
inner
PRINT n; list(0); list(1); list(2)
SUB inner
  DIM n
  n = 7
  PRINT n
END SUB
'> 7
'> 5103
'= done 11
'---
' FUNCTIONs of a PRINT run before its line begins, from left to right.
DIM a
a = 5
PRINT "a"; f(1); "b"; a; f(2); "c"; a
PRINT a; g(); a
PRINT "x"; f(3)
END
FUNCTION f(n)
  PRINT "f"; n
  a = a + n
  RETURN a
END FUNCTION
FUNCTION g()
  a = 0
  RETURN 7
END FUNCTION
'> f1
'> f2
'> a6b68c8
'> 870
'> f3
'> x3
'= done 7
'---
' A fault in a PRINT leaves no part of its line.
DIM zero, i
ON ERROR GOTO oops
PRINT "x"; 1 / zero; "y"
PRINT i; IN(i + 90)
PRINT "z"
END
oops:
PRINT "F"; ERR
RESUME NEXT
'> F2
'> F20
'> z
'= done 7
'---
' Both indices are evaluated before they are tested; so are both limits of a CASE.
DIM r
TABLE t(2) = 1, 2; 3, 4
ON ERROR GOTO oops
r = 7
PRINT t(r, f(0))
PRINT t(1, f(2))
PRINT t(f(1), f(1))
PRINT t(f(-1), f(3))
SELECT CASE r
CASE f(8) TO f(9), f(7) TO f(7)
  PRINT "seven"
END SELECT
SELECT CASE r
CASE 8 TO 1 / (r - 7)
  PRINT "never"
END SELECT
END
oops:
PRINT "F"; ERR; " "; ERL
RESUME NEXT
FUNCTION f(n)
  PRINT "f"; n
  RETURN n
END FUNCTION
'> f0
'> F3 6
'> f2
'> F3 7
'> f1
'> f1
'> 4
'> f-1
'> f3
'> F3 9
'> f8
'> f9
'> f7
'> f7
'> seven
'> F2 15
'= done 18
'---
' Common words as names: what is declared is a name, statements and functions stay what they are.
DIM count, start, wait = 3, home AS LENGTH
TABLE rows = 5, -6
home = 2mm
loop:
count = count + COUNT(rows) + ABS(rows(1))
FOR start = 1 TO wait : Wait 1ms : NEXT start
IF count < 10 THEN GOTO loop
PRINT count; " "; start; " "; home
'> 16 4 2000um
'= done 9
