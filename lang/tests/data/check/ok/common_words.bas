' Common words as names: what the script declares is a name, the statements and functions stay.
DIM count, start = 2, Length AS LENGTH, pos, home AS LENGTH
CONST STEPS = 4
TABLE rows = 5, 6, 7
INPUT wait = 3
Home X
home = POS(X)
loop:
count = count + COUNT(rows) + ABS(-start)
FOR start = 1 TO STEPS
  Length = LENGTH(X, 10st) : pos = start + 1
NEXT start
DO
  START MoveAxe X, Length : Wait 5ms : WaitMove
LOOP UNTIL IN(wait) OR count > 9
IF count < 20 THEN count = count + 1 : GOTO loop
WaitIn wait, ON, 1s
shift home + 1mm, count
GOSUB print
END
print:
PRINT "at "; home; " "; count : RETURN
SUB shift(home AS LENGTH, count)
  IF count > 1 THEN MoveAxe X, home
  Home
END SUB
