Home Y
SetPos Y, 0mm
G0 Y500
G53 G0 Y500
G53 G0 Y[100st]
MoveAxe Y, -5st
