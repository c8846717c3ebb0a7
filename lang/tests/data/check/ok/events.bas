DIM jams
ON ERROR GOTO oops
ON IN 3 RISE GOSUB jam
ON EVERY 500ms GOSUB tick
Home? X
MoveAxe X, 100mm
ON IN 3 OFF
ON EVERY OFF
END
tick:
PRINT "alive"
RETURN
oops:
PRINT "fault "; ERR; " in line "; ERL
jams = jams + 1
IF jams > 3 THEN END
RESUME NEXT
SUB jam
  SetOut 3, ON
  Wait 1s
  SetOut 3, OFF
END SUB
