' What a PLC did with an InterpCNC: length and number from its panel, feed, cut, count.
PROFILE "mill"
DIM span AS LENGTH AT 3000
DIM wanted AT 3002
KEEP made
OUTPUT knife = 3 : INPUT strip = 1

IF span = 0mm THEN span = 40mm : wanted = 2
Home X
SetPos X, 0mm
made = 0
DO
  WaitIn? strip, ON, 500ms
  IF TIMEDOUT THEN PRINT "no strip after "; made : END
  MoveRel X, span, 30mm/s
  Pulse knife, 80ms
  made = made + 1
LOOP UNTIL made >= wanted
PRINT made; " cut"
