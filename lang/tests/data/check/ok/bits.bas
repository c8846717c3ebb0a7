' Bits of Numbers: read, written, of arrays, of names of one letter.
CONST FLAGS = 6
DIM n, s, i = 2, seen(4), on_, low AS TRUTH
n.3 = ON
n.31 = NOT IN(2)
s.0 = n.3 ANDALSO n.31
seen(i + 1).15 = on_
seen(0).1=OFF
low = seen(i).4 AND NOT (n + 1).2
IF n.3 THEN s.1 = TRUE ELSE s.1 = FALSE
IF FLAGS.1 AND low THEN PRINT n.3; " "; s; (n).0
WHILE NOT on_.7
  on_.7 = n.0
WEND
G1 X[n.3 * 5] F100
G4 P.5
