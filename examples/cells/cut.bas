' Bars come on a belt. A light barrier stops it where the saw cuts to length; then it carries the piece into a box.
OUTPUT belt = 5, saw = 6
INPUT mark = 1, gone = 2
DIM n

FOR n = 1 TO 3
  SetOut belt, ON
  WaitIn mark, ON, 10s           ' F13 when no bar comes
  SetOut belt, OFF
  Wait 200ms                     ' the belt stands
  Pulse saw, 800ms
  Wait 200ms
  SetOut belt, ON
  WaitIn mark, OFF, 10s
NEXT
WaitIn gone, ON, 10s
SetOut belt, OFF
PRINT "3 pieces"
