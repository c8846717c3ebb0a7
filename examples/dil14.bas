' A DIL-14 socket: 14 holes, 0.1 inch apart, in two rows 0.3 inch apart.
' The drilling of the charlyrobot manual: from hole to hole at the machine's own speed, the drill
' comes down at 1000 steps/s.
PROFILE "charly"
CONST PITCH = 0.1in, ROWS = 0.3in
CONST DEPTH = 0.1in              ' Z counts downward on this machine

Home
G91 F[10000st/s]                 ' X and Y go together, as that machine moves them
G1 X[2 * PITCH] Y[2 * PITCH]
row PITCH                        ' seven holes to the right
G1 X[PITCH] Y[ROWS]
row -PITCH                       ' and seven back
END

SUB row(step_ AS LENGTH)
  REPEAT 7
    MoveRel X, step_
    MoveRel Z, DEPTH, 1000st/s
    MoveRel Z, -DEPTH
  END REPEAT
END SUB
