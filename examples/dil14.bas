' A DIL-14 socket: 14 holes, 0.1 inch apart, in two rows 0.3 inch apart.
' The drilling of the charlyrobot manual, with its speeds in steps per second.
PROFILE "charly"
CONST PITCH = 0.1in, ROWS = 0.3in
CONST DEPTH = 0.1in              ' Z counts downward on this machine
CONST FAST = 9000st/s, DRILL = 1000st/s

Home
MoveRel X, 2 * PITCH, FAST
MoveRel Y, 2 * PITCH, FAST
row PITCH                        ' seven holes to the right
MoveRel X, PITCH, FAST
MoveRel Y, ROWS, FAST
row -PITCH                       ' and seven back
END

SUB row(pitch_ AS LENGTH)
  REPEAT 7
    MoveRel X, pitch_, FAST
    MoveRel Z, DEPTH, DRILL
    MoveRel Z, -DEPTH, FAST
  END REPEAT
END SUB
