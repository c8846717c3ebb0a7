DIM n, m
ON IN 3 RISE GOSUB jam
ON EVERY 1s GOSUB tick
Home
Wait 100ms
n = n + 1
Wait work(5) * 1ms
PRINT n; " "; m
END
jam:
  PRINT "jam"
  RETURN
SUB tick
  DIM k
  k = k + 1
  PRINT "tick "; k
END SUB
FUNCTION work(ms)
  Wait 1ms
  m = m + ms
  RETURN ms
END FUNCTION
