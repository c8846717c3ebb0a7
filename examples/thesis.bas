' Six lines of G-code for a plotter of 25 steps/mm: relative words, two arcs, no F.
PROFILE "thesis"
F600
G91 G17 G21
G0 X0 Y0 Z2
G0 X10 Y10 Z-2
G1 X10 Y10
G2 X0 Y-5 J-2.5
G3 X5 Y0 I2.5
M30
