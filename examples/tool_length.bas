' Tool length: touch the plate of 5 mm that lies on the work, then Z 0 is the work's surface.
CONST PLATE = 5mm

Home
MoveAxe X, 120mm
MoveAxe Y, 80mm
Probe? Z, -60mm, 8mm/s           ' fast, to find it
IF NOT PROBEOK(Z) THEN
  PRINT "no tool, or no plate"
  MoveAxe Z, 0mm
  END
END IF
MoveRel Z, 2mm
Probe Z, -60mm, 1mm/s            ' slowly, to be exact
SetPos Z, PLATE + POS(Z) - PROBED(Z)
PRINT "the tool touches at "; PROBEDST(Z)
MoveAxe Z, 15mm
