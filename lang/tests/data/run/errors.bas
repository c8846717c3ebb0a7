DIM a, b, list(3)
KEEP total
ON ERROR GOTO oops
a = 1 / b
PRINT "after "; a
IF 1 / b = 0 THEN
  PRINT "not here"
END IF
PRINT "behind the block"
FOR a = 1 / b TO 3
  PRINT "nor here"
NEXT
list(5 + b) = 7
PRINT 1 + half(0)
MoveAxe X, 999mm
total = 5
b = -1
Wait b * 1ms
GOTO past
PRINT "never"
past:
a = 1 / (b + 1) + half(1)
PRINT "end"
ON ERROR STOP
a = list(7 + b)
END
oops:
  PRINT "F"; ERR; " in "; ERL
  IF ERL = 18 THEN GOTO past
  RESUME NEXT
FUNCTION half(n)
  DIM r
  r = 10 / n
  PRINT "half "; n; " "; r
  RETURN r / 2
END FUNCTION
