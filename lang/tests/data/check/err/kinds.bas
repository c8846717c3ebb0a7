DIM a
a = 3mm + 2s
' ---
Wait 5
' ---
Wait 5mm
' ---
MoveAxe X, 5
' ---
DIM a AS LENGTH
a = 2mm * 3mm
' ---
DIM a
a = 10 / 2mm
' ---
DIM a, b
a = 5mm
b = 5st
IF a > b THEN END
' ---
DIM a
a = 4
IF NOT a THEN END
' ---
DIM a
a = 4
IF a AND IN(3) THEN END
' ---
DIM a, b, c
IF a < b < c THEN END
' ---
IF POS(X) THEN END
' ---
SetOut 3, 5mm
' ---
DIM done
done = IN(1)
done = 4
' ---
DIM n
n = 1
n = 5mm
' ---
DIM d
d = 5mm
d = 7
' ---
DIM d AS STEPS
d = 5mm
' ---
DIM p AS LENGTH
FOR p = 0mm TO 10mm
NEXT
' ---
DIM p
FOR p = 1 TO 10mm
NEXT
' ---
DIM p AS TRUTH
FOR p = 0 TO 1
NEXT
' ---
TABLE t = 5mm, 3, 4mm
PRINT t(0)
' ---
DIM i
TABLE t(2) = 5mm, 3; 4mm, 2
PRINT t(0, i)
' ---
SUB go(d AS LENGTH)
  MoveAxe X, d
END SUB
go 5
' ---
FUNCTION half(d AS LENGTH) AS LENGTH
  RETURN 3
END FUNCTION
PRINT half(1mm)
' ---
SELECT CASE POS(X)
  CASE 3
    END
END SELECT
' ---
DIM a(4)
a(1mm) = 3
' ---
DIM i
i = 5mm << 2
' ---
PRINT SQR(5mm)
PRINT MIN(5mm, 3)
PRINT STEPS(X, 5)
PRINT LENGTH(X, 5mm)
' ---
SetPos X, 5st
' ---
MoveAxe X, 5mm, 5
MoveAxe X, 5mm, 5mm
MoveAxe X, 5mm, 5mm/s, 5mm/s
' ---
WaitIn 3, ON, 5
' ---
G1 X[5s] F300
' ---
G1 X5 F[5mm]
' ---
G4 P[5mm]
' ---
G92 X[5st]
' ---
ON EVERY 5 GOSUB tick
SUB tick
END SUB
' ---
REPEAT 3mm
END REPEAT
' ---
DIM x_1, y_1
x_1 = 5mm MOD 2s
y_1 = NOT 5mm
