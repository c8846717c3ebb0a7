' What a SUB does not write passes through it.
G90 G1 F600 X0
lift
X10
G91
lift
X10
G90
REPEAT 3
  step_
END REPEAT
G90 X5
GOSUB inch
X1
G21
END
inch:
G20
RETURN
SUB lift
  G53 G1 Z0
END SUB
SUB step_
  G91 X1
  IF IN(1) THEN EXIT SUB
  G90
  G91
END SUB
