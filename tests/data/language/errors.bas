' RESUME NEXT goes on behind the failing statement; ERR and ERL say what and where.
DIM a, b
ON ERROR GOTO oops
PRINT ERR; ERL
a = 1 / b
PRINT "on"
a = SQR(-a - 1) : PRINT "same line"
END
oops:
PRINT ERR; " in "; ERL
RESUME NEXT
'> 00
'> 2 in 5
'> on
'> 20 in 7
'> same line
'= done 8
'---
' After a failing line of a block behind that block, after a one-line IF on the next line.
DIM a, i
ON ERROR GOTO oops
IF 1 / a = 1 THEN
  PRINT "never"
ELSE
  PRINT "never"
END IF
PRINT "after if"
IF a = 1 THEN
  PRINT "never"
ELSEIF 1 / a = 1 THEN
  PRINT "never"
END IF
PRINT "after elseif"
IF 1 / a = 1 THEN PRINT "never" ELSE PRINT "never"
PRINT "after one line"
SELECT CASE 1 / a
  CASE ELSE : PRINT "never"
END SELECT
PRINT "after select"
SELECT CASE a
  CASE 1 / a : PRINT "never"
  CASE ELSE : PRINT "never"
END SELECT
PRINT "after case"
FOR i = 1 / a TO 3 : PRINT "never" : NEXT
PRINT "after for"
FOR i = 2147483647 TO 2147483647
  PRINT "pass"
NEXT
PRINT "after next"
WHILE 1 / a > 0 : PRINT "never" : WEND
PRINT "after while"
DO
  PRINT "once"
LOOP WHILE 1 / a > 0
PRINT "after loop"
DO UNTIL 1 / a > 0
  PRINT "never"
LOOP
PRINT "after do"
REPEAT 1 / a : PRINT "never" : END REPEAT
PRINT "after repeat"
END
oops:
PRINT "F"; ERR; " "; ERL
RESUME NEXT
'> F2 4
'> after if
'> F2 12
'> after elseif
'> F2 16
'> after one line
'> F2 18
'> after select
'> F2 23
'> after case
'> F2 27
'> after for
'> pass
'> F1 31
'> after next
'> F2 33
'> after while
'> once
'> F2 37
'> after loop
'> F2 39
'> after do
'> F2 43
'> after repeat
'= done 45
'---
' A fault inside a one-line IF's part goes on behind that statement.
DIM a
ON ERROR GOTO oops
IF a = 0 THEN a = 1 / a : PRINT "part" ELSE PRINT "never"
END
oops:
RESUME NEXT
'> part
'= done 5
'---
' Inside a SUB and a FUNCTION.
DIM a
ON ERROR GOTO oops
work
PRINT five
END
oops:
PRINT ERL
RESUME NEXT
SUB work
  a = 1 / a
  PRINT "in work"
END SUB
FUNCTION five
  a = 1 / a
  RETURN 5
END FUNCTION
'> 11
'> in work
'> 15
'> 5
'= done 6
'---
' A GOTO in the handler leaves it and drops all open calls; a fault behind it is handled again.
DIM a, tries
ON ERROR GOTO oops
again:
IF tries < 30 THEN work
PRINT tries
END
oops:
tries = tries + 1
GOTO again
SUB work
  deeper
END SUB
SUB deeper
  a = 1 / a
END SUB
'> 30
'= done 7
'---
' A fault inside the handler stops the run.
DIM a
ON ERROR GOTO oops
a = 1 / a
END
oops:
PRINT "once"
a = a MOD a
RESUME NEXT
'> once
'= fault F02 8
'---
' ON ERROR STOP, the default.
DIM a
ON ERROR GOTO oops
a = 1 / a
ON ERROR STOP
a = 1 / a
END
oops:
PRINT "handled"
RESUME NEXT
'> handled
'= fault F02 6
'---
' END in the handler.
DIM a
ON ERROR GOTO oops
a = 1 / a
oops:
PRINT "end"
END
'> end
'= done 7
'---
' A handled fault changes no output.
DIM a
ON ERROR GOTO oops
SetOut 3, ON
a = 1 / a
PRINT OUT(3)
END
oops:
RESUME NEXT
'> 1
'= done 7
'---
' F16 is not handled.
ON ERROR GOTO oops
RETURN
oops:
PRINT "never"
RESUME NEXT
'= fault F16 3
