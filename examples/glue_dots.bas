' Glue dots along two edges of a plate; the number of dots and the dose come from an HMI.
OUTPUT valve = 4
DIM dots AT 3000, dose AS TIME AT 3002
DIM i

IF dots = 0 THEN dots = 5        ' nothing set: a sample
IF dose = 0ms THEN dose = 120ms
Home
edge 20mm
edge 60mm
MoveAxe X, 0mm

SUB edge(at_ AS LENGTH)
  MoveAxe Y, at_
  FOR i = 0 TO dots - 1
    MoveAxe X, 15mm + i * 8mm
    MoveAxe Z, -30mm, 60mm/s
    Pulse valve, dose
    Wait 50ms                    ' the thread breaks
    MoveAxe Z, -25mm, 10mm/s
  NEXT
  MoveAxe Z, 0mm
END SUB
