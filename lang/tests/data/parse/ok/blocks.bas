DIM a, b, c
IF a THEN b = 1 : c = 2 ELSE IF b THEN c = 3 ELSE c = 4
IF a = 1 THEN ' a block
  b = 1
ELSEIF a = 2 THEN
  b = 2
ELSE
  b = 3
END IF
IF a THEN G1 X5 F300 ELSE Home
IF a THEN (a remark)
  b = 1
ELSE : b = 2
END IF
SELECT CASE a + 1
CASE 1, 3
  b = 1
CASE 5 TO 9, IS < 0
  b = 2
CASE ELSE
  b = 3
END SELECT
FOR a = 1 TO 10 STEP 2 : b = b + a : NEXT a
WHILE a > 0
  a = a - 1
  IF a = 5 THEN CONTINUE WHILE
WEND
DO : LOOP UNTIL IN(1)
DO WHILE a < 3
  EXIT DO
LOOP
REPEAT 5
  MoveRel X, 0.1mm
END REPEAT
IF _
  a THEN b = 1
