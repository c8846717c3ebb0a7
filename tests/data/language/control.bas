' FOR: the limit and step are evaluated once, and tested before the first pass.
DIM i, n
n = 3
FOR i = 1 TO n
  n = 10
  PRINT i
NEXT
PRINT i; n
FOR i = 5 TO 1 : PRINT "never" : NEXT
PRINT i
FOR i = 5 TO 1 STEP -2 : PRINT i : NEXT i
PRINT i
'> 1
'> 2
'> 3
'> 410
'> 5
'> 5
'> 3
'> 1
'> -1
'= done 12
'---
DIM i
FOR i = 2147483646 TO 2147483647
  PRINT i
NEXT
'> 2147483646
'> 2147483647
'= fault F01 4
'---
DIM i, s
FOR i = 1 TO 3 STEP s
NEXT
'= fault F20 2
'---
DIM p AS LENGTH
FOR p = 0mm TO 1mm STEP 0.4mm
  PRINT p
NEXT
'> 0um
'> 400um
'> 800um
'= done 4
'---
' REPEAT runs n times; 0 or less runs none.
DIM n
REPEAT 3 : n = n + 1 : END REPEAT
PRINT n
REPEAT -n : PRINT "never" : END REPEAT
REPEAT n
  n = n + 1
  IF n = 5 THEN CONTINUE REPEAT
  IF n = 6 THEN EXIT REPEAT
  PRINT n
END REPEAT
'> 3
'> 4
'= done 11
'---
DIM n
WHILE n < 5
  n = n + 1
  IF n = 2 THEN CONTINUE WHILE
  IF n = 4 THEN EXIT WHILE
  PRINT n
WEND
DO
  n = n - 1
LOOP UNTIL n <= 0
DO WHILE n < 2
  n = n + 1
LOOP
DO UNTIL n = 4 : n = n + 1 : LOOP WHILE TRUE
PRINT n
'> 1
'> 3
'> 4
'= done 15
'---
' SELECT CASE
DIM i
FOR i = -1 TO 10 STEP 2
  SELECT CASE i
    CASE 1, 3 : PRINT i; " odd"
    CASE 5 TO 7 : PRINT i; " mid"
    CASE IS < 0 : PRINT i; " low"
    CASE ELSE : PRINT i; " else"
  END SELECT
NEXT
'> -1 low
'> 1 odd
'> 3 odd
'> 5 mid
'> 7 mid
'> 9 else
'= done 10
'---
' One-line IF: its parts take all statements of the line; ELSE joins the nearest IF.
DIM a
a = 1
IF a = 1 THEN PRINT "one" : PRINT "and" ELSE PRINT "not" : PRINT "never"
IF a = 2 THEN PRINT "two" : PRINT "never"
IF a = 1 THEN IF a = 2 THEN PRINT "never" ELSE PRINT "nearest"
IF a THEN                        ' a comment opens the block
  PRINT "block"
ELSEIF a = 5 THEN
  PRINT "never"
ELSE
  PRINT "never"
END IF
'> one
'> and
'> nearest
'> block
'= done 13
'---
' GOTO leaves blocks; GOSUB, labels of a SUB.
DIM i
FOR i = 1 TO 9
  IF i = 3 THEN GOTO out_
NEXT
PRINT "never"
out_:
PRINT i
GOSUB twice
work
END
twice:
PRINT "sub"
RETURN
SUB work
  GOSUB inner
  PRINT "behind"
  RETURN
  PRINT "never"
inner:
  PRINT "inner"
  RETURN
END SUB
'> 3
'> sub
'> inner
'> behind
'= done 11
'---
' RETURN without GOSUB.
PRINT 1
RETURN
'> 1
'= fault F16 3
'---
RESUME NEXT
'= fault F16 1
'---
' A call stack overrun by GOTO.
again:
GOSUB deeper
END
deeper:
GOTO again
'= fault F16 3
'---
' Leaving a SUB drops the GOSUBs still open in it.
DIM n
FOR n = 1 TO 50
  work
NEXT
PRINT n
END
SUB work
  GOSUB inner
  EXIT SUB
inner:
  EXIT SUB
END SUB
'> 51
'= done 7
'---
' A FUNCTION that ends without RETURN gives 0; parameters go by value.
DIM a
a = 4
PRINT half(a); half(3); a; none
FUNCTION half(n)
  n = n / 2
  IF n > 1 THEN RETURN n
  EXIT FUNCTION
END FUNCTION
FUNCTION none AS LENGTH
END FUNCTION
'> 2040um
'= done 11
'---
' END ends the run, inside a SUB too; its line is the end's.
first
SUB first
  second
  PRINT "never"
END SUB
SUB second
  PRINT "here"
  END
END SUB
'> here
'= done 9
'---
' Functions in expressions, nested calls, arguments from left to right.
PRINT sum(sum(1, 2), sum(3, sum(4, 5)))
SUB nothing(a, b)
  PRINT a; b
END SUB
FUNCTION sum(a, b)
  nothing a, b
  RETURN a + b
END FUNCTION
'> 12
'> 45
'> 39
'> 312
'> 15
'= done 9
'---
' CONTINUE FOR adds, then tests; EXIT leaves the innermost of its kind.
DIM i, j
FOR i = 1 TO 3
  FOR j = 1 TO 3
    IF j = 2 THEN CONTINUE FOR
    DO
      IF j = 3 THEN EXIT FOR
      EXIT DO
    LOOP
    PRINT i; j
  NEXT
NEXT
'> 11
'> 21
'> 31
'= done 12
