' Feeder: index a strip by one pitch until the sensor sees a part; three tries, then help is called.
OUTPUT blow = 3, horn = 7
INPUT part = 1
CONST PITCH = 12mm
DIM tries, fed

SetPos X, 0mm
DO UNTIL fed = 4
  tries = 0
  DO
    MoveRel X, PITCH, 40mm/s
    WaitIn? part, ON, 300ms
    tries = tries + 1
  LOOP WHILE TIMEDOUT ANDALSO tries < 3
  IF TIMEDOUT THEN
    SetOut horn, ON
    WaitStart                    ' someone fills the strip
    SetOut horn, OFF
  ELSE
    Pulse blow, 150ms            ' the part goes into the chute
    WaitIn part, OFF, 1s
    fed = fed + 1
  END IF
LOOP
PRINT fed; " parts fed over "; POS(X)
