' Kinds that AS does not name.
DIM far, near, n, t, done, rate, open_
far = near + 5mm
IF n > 3st THEN n = 0st
t = TIMER() + 5ms
done = IN(3)
n = n * 2
rate = MIN(rate, 2000st/s)
open_ = done + 1
MoveAxe X, near
shift 3mm, 2
PRINT far; t; done; twice(4mm); open_; scaled(7)
SUB shift(by, times)
  DIM here
  here = by * times
  MoveRel X, here, rate
END SUB
FUNCTION twice(d)
  RETURN d + d
END FUNCTION
FUNCTION scaled(k)
  RETURN k * 1mm
END FUNCTION
