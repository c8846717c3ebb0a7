' A test bench: a tester on the host measures at each of five places and answers good or bad.
CONST READY = 82, GOOD = 71, BAD = 66   ' R, G, B
OUTPUT reject = 8
TABLE place = 10mm, 22.5mm, 35mm, 47.5mm, 60mm
DIM i, answer, rejected

Home X
FOR i = 0 TO COUNT(place) - 1
  MoveAxe X, place(i)
  Send READY
  DO                             ' anything else is not for us
    answer = CHARIN()
  LOOP UNTIL answer = GOOD OR answer = BAD
  IF answer = BAD THEN
    Pulse reject, 200ms
    rejected = rejected + 1
  END IF
NEXT
WaitChar? 69, 2s                 ' E: the tester is done
IF TIMEDOUT THEN PRINT "the tester does not answer"
PRINT rejected; " rejected"
