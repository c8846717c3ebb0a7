DIM a, b, c, n, s, t, f, g
a = b OR c AND NOT a = 1 XOR b ANDALSO c ORELSE a
a = 1 + 2 * 3 - 4 / 5 MOD 6
a = -b * -c
a = NOT b + 1
a = 1 << 2 + 3 >> 1
a = b < c = TRUE
a = (b + c) * (ABS(-2) + MIN(a, b))
a = n - 1 : s = 2 : t = 3 : f=4 : g =5
b = STEPS(X, 12mm) / 1st + LENGTH(Y, 480st) / 1um
c = COUNT(pads) + INPORT() + CHARIN() + ERR
TABLE pads = -1, - 2, -(3)
a = 10mm / 2mm
a = 5in / 2in + 2min / 1s
a = &HFFFFFFFF AND &b1
