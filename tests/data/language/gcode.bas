' Words, units, expressions.
G21 G90 G0 X10 Y[2 * 3] Z[1.5mm]
PRINT POS(X); " "; POS(Y); " "; POS(Z)
G91 G1 X-2.5 F600
X1 Y1
PRINT POS(X); " "; POS(Y)
G90 G20 X1
PRINT POS(X)
G21 X[200st]
PRINT POSST(X)
'> 10000um 6000um 1500um
'> 8500um 7000um
'> 25400um
'> 200st
'= done 10
'---
' G92, G53, G28.
G0 X20 Y10
G92 X0
PRINT POS(X); " "; POSST(X)
G0 X5
PRINT POSST(X)
G53 G0 X5
PRINT POSST(X); " "; POS(X)
G28 X10
PRINT POSST(X); " "; POSST(Y)
G28
PRINT POSST(Y)
'> 0um 2000st
'> 2500st
'> 500st -15000um
'> 0st 1000st
'> 0st
'= done 12
'---
' Arcs: ends are exact; a helix; R.
G1 X10 Y0 F600
G3 X0 Y10 I-10 J0
PRINT POS(X); " "; POS(Y)
G2 X10 Y0 R10
PRINT POS(X); " "; POS(Y)
G2 I5
PRINT POS(X); " "; POS(Y)
G18 G3 X20 Z0 I5 K0
PRINT POS(X); " "; POS(Z)
G17 G3 X30 Y0 Z3 I5
PRINT POS(X); " "; POS(Z)
'> 0um 10000um
'> 10000um 0um
'> 10000um 0um
'> 20000um 0um
'> 30000um 3000um
'= done 12
'---
DIM r
r = 2
G1 X10 F600
G2 X0 R[r]
'= fault F09 4
'---
DIM i
i = 3
G1 X10 F600
G2 X0 I[-i]
'= fault F09 4
'---
' Probing by G-code.
Home
G38.2 Z-40 F300
PRINT PROBEDST(Z)
G0 Z-10
G38.3 Z-15 F300
PRINT PROBEOK(Z)
G38.2 Z-15
'~ probe_at("Z", -1840);
'> -1840st
'> 0
'= fault F12 8
'---
' Dwells, outputs, M0, M30.
DIM t AS TIME
t = TIMER()
G4 P0.25
PRINT TIMER() - t >= 250ms
M3 S1000
PRINT OUT(1); OUT(2)
M8
M5
PRINT OUT(1); OUT(2)
M9 : M0
PRINT "on"
M30
PRINT "never"
'~ at(2000, || press_start());
'> 1
'> 10
'> 01
'> on
'= done 13
'---
' F keeps its physical speed across G20 and G21.
DIM a AS TIME, b AS TIME
G1 X10 F60
a = TIMER()
X20
a = TIMER() - a
b = TIMER()
G20 X[30mm]
b = TIMER() - b
PRINT ABS(a - b) < 50ms; a > 9s
'> 11
'= done 10
'---
' SUBs: what is not written passes through.
G91
G1 X5 F6000
by_five
PRINT POS(X)
G90
by_five
PRINT POS(X)
SUB by_five
  G53 G1 X5
END SUB
'> 5000um
'> 5000um
'= done 11
'---
' Canned cycles and where they end.
G0 Z10
G98 G81 X5 Y5 Z-3 R2 F600
PRINT POS(Z)
G99 X10
PRINT POS(X); " "; POS(Z)
G98 X15
PRINT POS(Z)
G80
G0 Z4
G82 X20 Z-1 R2 P0.1
PRINT POS(Z)
G83 X25 Z-3 R1 Q1
PRINT POS(Z)
G91 X5 Y0 R-1 Z-2 L3 G81
PRINT POS(X); " "; POS(Z)
'> 10000um
'> 10000um 2000um
'> 10000um
'> 4000um
'> 4000um
'> 40000um 4000um
'= done 16
'---
' A cycle evaluates its words from left to right before it moves, each once.
DIM zero, n
ON ERROR GOTO oops
G0 Z1
G81 X[5mm / zero] Y2 Z-1 R3 F300
PRINT POSST(Z)
G83 X[f(1)] Y[f(2)] Z[-f(3)] R[f(4)] Q[f(5)] L[f(1)] F[f(300)]
PRINT n
G1 Y[f(2)] X[f(1)] F[f(300)]
G81 X[zero] Z-1 R2 L[zero]
PRINT POSST(X)
G83 X5 Z-1 R2 Q[zero]
PRINT POSST(Z)
END
oops:
PRINT "F"; ERR; " "; ERL
RESUME NEXT
FUNCTION f(a)
  n = n + 1
  PRINT "f"; a
  RETURN a
END FUNCTION
'> F2 5
'> 100st
'> f1
'> f2
'> f3
'> f4
'> f5
'> f1
'> f300
'> 7
'> f2
'> f1
'> f300
'> 100st
'> F20 12
'> 400st
'= done 14
'---
' RESUME NEXT passes by the whole block, whichever part of it failed.
DIM zero
ON ERROR GOTO oops
M3 G1 X5 F[zero]
PRINT POSST(X); OUT(1)
G28 X[1 / zero]
PRINT POSST(X)
G1 X1 F600
PRINT POSST(X)
END
oops:
PRINT "F"; ERR
RESUME NEXT
'> F8
'> 0st0
'> F2
'> 0st
'> 100st
'= done 10
