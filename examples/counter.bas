' Counting with KEEP: parts made, kept through power loss, and a signal after each ten.
OUTPUT box_full = 6, punch = 4
INPUT part = 2
KEEP parts, boxes
DIM run_

REPEAT 12
  WaitIn part, RISE
  Pulse punch, 80ms
  parts = parts + 1
  run_ = run_ + 1
  IF parts MOD 10 = 0 THEN
    boxes = boxes + 1
    SetOut box_full, ON
    WaitStart                    ' an empty box stands there
    SetOut box_full, OFF
  END IF
END REPEAT
PRINT run_; " parts in this run, "; parts; " in all, "; boxes; " boxes"
