Probe? X : probe X ' comment
label: moveaxe X,5mm/s REM rest
10mm/min 5in(3) &h1f_0 1_000 .5mm "text: 'x'" <> <= << _
  continued
stop: error = time
G1X10Y-.5F[a(1)] (c:') ; d ' e
x_1 = t2max - s
IF a THEN G0X1ELSE G0X2
