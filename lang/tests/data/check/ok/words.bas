' Words of issue 3-senses: values in DIM, WAIT UNTIL.
CONST WIDE = 12mm
DIM n = 5, far AS LENGTH = WIDE, lit AS TRUTH = ON, place = far * n
DIM seen(3) = 4, n, n + 1
WAIT UNTIL IN(3) AND n > 2
WAIT UNTIL POS(X) >= far, 250ms
IF TIMEDOUT THEN PRINT "late"
IF n > 7 THEN WAIT UNTIL NOT IN(4), place / 1mm * 1ms : DIM inner = 3 ELSE WAIT UNTIL IN(1)
WaitIn? 3, ON, 10ms
IF TIMEDOUT THEN PRINT seen(1); place; inner; lit
twice 3
SUB twice(count_of)
  DIM sum = count_of * 2, left(2) = 9
  WAIT UNTIL sum > left(0), 1s
END SUB
