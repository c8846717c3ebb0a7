' Cutting to length: feed, clamp, cut. Length and count are registers that an HMI writes.
OUTPUT clamp = 3, saw = 4
INPUT clamped = 1, saw_up = 2
DIM wanted AS LENGTH AT 3000, count_ AT 3002, done AT 3004

IF wanted = 0mm THEN wanted = 35mm
IF count_ = 0 THEN count_ = 3
SetPos X, 0mm
WHILE done < count_
  MoveRel X, wanted, 60mm/s
  SetOut clamp, ON
  WaitIn clamped, ON, 1s
  SetOut saw, ON
  WaitIn saw_up, FALL, 2s
  WaitIn saw_up, RISE, 5s
  SetOut saw, OFF
  SetOut clamp, OFF
  WaitIn clamped, OFF, 1s
  done = done + 1
WEND
PRINT done; " pieces of "; wanted
