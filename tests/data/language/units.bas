' PRINT in units: fixed decimals, rounded half away from zero, no minus of what rounds to 0.
DIM d AS LENGTH, t AS TIME, v AS SPEED, a AS ACCEL, n, half AS LENGTH
d = 2.54mm
PRINT d; " "; d IN um; " "; d IN mm; " "; d IN in
'> 2540um 2540um 2.540mm 0.1000in
PRINT "x="; -d IN mm; ";"
'> x=-2.540mm;
PRINT 1um IN in; " "; -1um IN in; " "; -2um IN in; " "; 0mm IN mm
'> 0.0000in 0.0000in -0.0001in 0.000mm
half = 1um
PRINT half IN in; " "; -half IN in; " "; -2 * half IN in; " "; (half - 1um) IN mm; " "; -5 * half IN mm
'> 0.0000in 0.0000in -0.0001in 0.000mm -0.005mm
n = -2147483647
PRINT (n - 1) * 1um IN mm; " "; (n - 1) * 1um IN in; " "; n * -1um IN mm; " "; n * -1um IN in
'> -2147483.648mm -84546.6003in 2147483.647mm 84546.6003in
t = 1500ms
PRINT t IN s; " "; t IN min; " "; t IN ms; " "; -t IN min; " "; t / 5 IN min
'> 1.500s 0.03min 1500ms -0.03min 0.01min
v = 1200mm/min
PRINT v IN mm/min; " "; v IN mm/s; " "; v IN in/min; " "; v IN um/s
'> 1200.0mm/min 20.000mm/s 47.24in/min 20000um/s
a = 250mm/s2
PRINT a IN mm/s2; " "; a IN um/s2; " "; 100st IN st; " "; 2000st/s IN st/s; " "; 5st/s2 IN st/s2
'> 250.000mm/s2 250000um/s2 100st 2000st/s 5st/s2
PRINT third(d) IN mm; "|"; d IN MM
'> third
'> 0.847mm|2.540mm
SetPos X, 3.5mm
PRINT "x="; POS(X) IN mm; " y="; POS(Y) IN mm
'> x=3.500mm y=0.000mm
END
'= done 31
FUNCTION third(e AS LENGTH) AS LENGTH
  PRINT "third"
  RETURN (e + 1um) / 3
END FUNCTION
'---
' A name of the script's own that is spelled as a unit means what it meant.
DIM s, mm, k AS LENGTH
s = 1
mm = 5
k = 1mm
ON IN s RISE GOSUB hit
PRINT IN(s); mm; k IN mm; k in mm
'> 051.000mm1.000mm
END
'= done 9
hit: RETURN
