' A conveyor with a jam switch: its handler stops the belt, backs off and waits for Start,
' then the run goes on where it was.
OUTPUT belt = 3, lamp = 5
INPUT jam = 4
DIM i, jams

ON IN jam RISE GOSUB clear
SetOut belt, ON
FOR i = 1 TO 6
  Wait 800ms                     ' a part travels
  MoveRel X, 25mm, 50mm/s        ' the pusher
  MoveRel X, -25mm, 80mm/s
NEXT
SetOut belt, OFF
PRINT jams; " jams"
END

clear:
jams = jams + 1
SetOut belt, OFF
SetOut lamp, ON
WaitIn jam, OFF
WaitStart
SetOut lamp, OFF
SetOut belt, ON
RETURN
