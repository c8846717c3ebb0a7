' Homing with a plan for what may go wrong: a switch that is not found, and anything else.
OUTPUT lamp = 5
DIM failures

ON ERROR GOTO trouble
Home Z
Home? X                          ' does not stop the run
IF NOT HOMED(X) THEN PRINT "X goes on without its reference"
Home Y                           ' F10 goes to trouble
IF HOMED(Y) THEN MoveAxe Y, 50mm
MoveAxe X, 10mm
SetOut lamp, failures > 0
END

trouble:
failures = failures + 1
PRINT "fault "; ERR; " in line "; ERL
IF failures > 3 THEN END
RESUME NEXT
