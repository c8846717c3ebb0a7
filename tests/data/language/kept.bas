' Arrays that are kept, and tables whose columns have names.
KEEP total, seen(3) AS LENGTH, lit(2)
DIM i, depth
TABLE spots(x, y, depth) = 10mm, 5mm, 1; 20mm, 6mm, 2; 30mm, 7mm, 3
FOR i = 0 TO 2
  seen(i) = spots(i, x) + spots(i, Y)
  total = total + spots(i, depth)
NEXT
lit(1) = 7
depth = 1
PRINT seen(0); " "; seen(1); " "; seen(2); " "; total; " "; lit(0); lit(1); " "; spots(2, 0); " "; depth
'> 15000um 26000um 37000um 6 07 30000um 1
PRINT seen(i)
'= fault F03 13
