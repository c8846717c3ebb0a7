PROFILE "mill"
CONST PITCH = 2.54mm, N = 7
OUTPUT pump = 1 : INPUT part = 3
DIM i, px AS LENGTH, seen(8)
DIM qty AS TIME AT 3000
KEEP parts
TABLE pads = 10mm, 12.54mm, _
  15.08mm
TABLE spots(2) = 10mm,5mm;  20mm,5mm;  30mm,8mm
start_here: i = 1
seen(i) = -2147483648
MoveAxe X, 10mm, 25mm/s, 250mm/s2
START MoveRel z, -5mm
WaitMove : WaitMove Z
MoveSpeed X, -2000st/s
StopAxe X : StopAll
Home : Home? Z, X
Probe? Z, -20mm, 5mm/s, part, OFF
ProbeMask Z, -20mm, 5mm/s, &H0F, 0
SetPos X, 0mm
SetOut pump, NOT IN(part)
Pulse 2, 50ms : SetPort &B1010 : Motors OFF, X
Wait 1.5s
WaitIn part, RISE, 5s
WaitIn? 3, ON
WaitStart : Send 65 : WaitChar 66 : WaitChar? 66, 1min
PRINT : PRINT "hole "; i; " at "; pads(i) + POS(X);
PLANE XZ
ON ERROR GOTO trouble : ON ERROR STOP
ON IN 3 RISE GOSUB jam : ON IN 3 OFF
ON EVERY 2s GOSUB jam : ON EVERY OFF
GOSUB jam : GOTO start_here
CALL drill(1, 2mm) : drill 1, 2mm : drill (1, 2mm) : drill(1), 2mm : CALL none : none
END
trouble: PRINT ERR; ERL: RESUME NEXT
jam: RETURN
SUB drill(n, depth AS LENGTH)
  DIM k
  k = half(n)
  EXIT SUB
END SUB
SUB none
END SUB
FUNCTION half(n) AS NUMBER
  RETURN n / 2
END FUNCTION
