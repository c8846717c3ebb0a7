' A drill table: holes of a small circuit board, sorted by tool. M6 waits for the tool change.
TABLE small(2) = 2.54mm, 2.54mm; 5.08mm, 2.54mm; 7.62mm, 2.54mm; 10.16mm, 2.54mm; _
                 10.16mm, 10.16mm; 7.62mm, 10.16mm; 5.08mm, 10.16mm; 2.54mm, 10.16mm
TABLE large(2) = 0mm, 0mm; 30mm, 0mm; 30mm, 20mm; 0mm, 20mm
CONST TOP = -20mm                ' upper side of the board
DIM i

Home
G0 X40 Y40
SetPos X, 0mm                    ' the board's corner
SetPos Y, 0mm
T1 M6 M3
G99 F120
FOR i = 0 TO COUNT(small) - 1
  G81 X[small(i, 0)] Y[small(i, 1)] Z[TOP - 2mm] R[TOP + 1mm]
NEXT
G53 G0 Z0
M5
T2 M6 M3
F80
FOR i = 0 TO COUNT(large) - 1
  G83 X[large(i, 0)] Y[large(i, 1)] Z[TOP - 2.4mm] R[TOP + 1mm] Q1.2
NEXT
G53 G0 Z0
M5
