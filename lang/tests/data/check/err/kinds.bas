DIM a
a = 3mm + 2s
Wait 5
MoveAxe X, 5
IF NOT a THEN END
b = 4
