DIM i, j, n, s
FOR i = 1 TO 3: s = s + i: NEXT
PRINT "for "; s
FOR i = 10 TO 1 STEP -4: s = s + i: NEXT
PRINT "step "; s; " "; i
n = 0
FOR i = n + 1 TO n: PRINT "never": NEXT
WHILE n < 3: n = n + 1: IF n = 2 THEN CONTINUE WHILE
  PRINT "while "; n
WEND
DO
  n = n - 1
  IF n = 0 THEN EXIT DO
LOOP
PRINT "do "; n
DO UNTIL n >= 2
  n = n + 1
LOOP
DO: n = n - 1: LOOP WHILE n > 0
REPEAT 3
  n = n + 2
END REPEAT
REPEAT n - 6: PRINT "never": END REPEAT
PRINT "repeat "; n
FOR i = 0 TO 9
  SELECT CASE i
    CASE 1, 3: PRINT "1 or 3"
    CASE 5 TO 6: PRINT "5 to 6"
    CASE IS > 8: PRINT "above 8"
    CASE 0: PRINT "0"
    CASE ELSE: j = j + 1
  END SELECT
NEXT
PRINT "else "; j
IF i = 10 ANDALSO j = 4 THEN PRINT "both" ELSE PRINT "neither"
IF i = 9 ORELSE j = 4 THEN PRINT "one"
s = (i = 9) ORELSE (j = 4)
PRINT s; NOT s; NOT (s = 1)
GOSUB deep
PRINT twice(twice(3)) + twice(1)
END
deep:
  PRINT "gosub"
  GOSUB deeper
  RETURN
deeper:
  PRINT "gosub 2"
  RETURN

FUNCTION twice(v)
  DIM r
  r = r + v
  RETURN r * 2
END FUNCTION
