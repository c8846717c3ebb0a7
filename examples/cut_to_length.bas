' Cutting to length: feed, clamp, cut. The operator types length and count, presses Start and reads what is done.
OUTPUT clamp = 3, saw = 4
INPUT clamped = 1, saw_up = 2
DIM wanted AS LENGTH AT 3000 LABEL "Length" MIN 5mm MAX 300mm, _
    count_ AT 3002 LABEL "Pieces" MIN 1 MAX 500, done AT 3004 LABEL "Done"

IF wanted = 0mm THEN wanted = 35mm
IF count_ = 0 THEN count_ = 3
done = 0
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
