' TIMERs, and edges since the last look.
INPUT part = 3
DIM t AS TIMER, idle AS TIMER = 2s, n, gone AS TIME
t = 0s
WHILE t < 500ms
  IF RISE(part) THEN n = n + 1 : idle = 0s
  IF FALL(4) OR rise(part) THEN gone = t
WEND
PRINT t; " "; idle; " "; n
watch 2s
SUB watch(longest AS TIME)
  DIM t
  t = 5
  IF idle > longest AND t = 5 THEN PRINT gone
END SUB
