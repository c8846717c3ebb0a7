' Two-hand start of a press: both buttons within half a second, both free before the next stroke.
INPUT left = 1, right = 2
CONST TOGETHER = 500ms
DIM strokes, left_at AS TIME, right_at AS TIME

ON IN left RISE GOSUB left_down
ON IN right RISE GOSUB right_down
Home Z
DO WHILE strokes < 2
  WaitIn left, OFF
  WaitIn right, OFF
  WaitIn left, ON
  WaitIn? right, ON, TOGETHER
  IF NOT TIMEDOUT ANDALSO ABS(left_at - right_at) <= TOGETHER THEN
    MoveAxe Z, -40mm
    MoveAxe Z, 0mm
    strokes = strokes + 1
  ELSE
    PRINT "both buttons together"
  END IF
LOOP
PRINT strokes; " strokes"
END

left_down:
left_at = TIMER()
RETURN

right_down:
right_at = TIMER()
RETURN
