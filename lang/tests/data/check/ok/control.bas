DIM i, n, p AS LENGTH
SELECT CASE n
  CASE 1, 3 : PRINT "odd"
  CASE 5 TO 9 : PRINT "mid"
  CASE IS < 0
    PRINT "low"
  CASE ELSE
    END
END SELECT
FOR p = 0mm TO n * 1mm STEP n * 0.5mm
  IF p > 5mm THEN EXIT FOR ELSE CONTINUE FOR
NEXT p
DO UNTIL IN(1)
  n = n + 1
  IF n MOD 7 = 0 THEN EXIT DO
LOOP
DO
  n = n - 1
LOOP WHILE n > 0 ANDALSO NOT IN(2)
WHILE n < 3 ORELSE OUT(2)
  n = n + 1
WEND
REPEAT n
  again 2
END REPEAT
GOSUB beep
i = &HFF AND NOT 3
i = -7 MOD 3 + (1 << 4) - 2 * 3 XOR 5
again 3
GOTO done
beep:
PRINT "beep"
RETURN
done:
END
SUB again(m)
  DIM k
  FOR k = m TO 0 STEP -1
    IF k = 1 THEN RETURN
    GOSUB inner
  NEXT
  EXIT SUB
inner:
  PRINT k
  RETURN
END SUB
