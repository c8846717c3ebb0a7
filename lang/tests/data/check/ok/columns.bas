KEEP k(2) AS TIME, m
CONST COLS = 2
TABLE old(COLS) = 1, 2; 3, 4
TABLE pads(px, width, on_for) = 1mm, 2, 5s; 3mm, 4, 6s
DIM width, t
width = pads(1, width) + old(0, 1)
t = pads(0, on_for)
k(1) = t
m = COUNT(pads) + width
MoveAxe X, pads(m - m, px)
