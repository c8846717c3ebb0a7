' A program has 256 cells: the last one is there, also for a routine.
DIM a(251), n, last
FOR n = 0 TO 250
  a(n) = n * 3
NEXT
last = twice(a(250))
PRINT a(250); " "; a(0); " "; last; " "; 1 + twice(twice(n))
'> 750 0 1500 1005
'= done 13
FUNCTION twice(value)
  value = value + value
  RETURN value
END FUNCTION
