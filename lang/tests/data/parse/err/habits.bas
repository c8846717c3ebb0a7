DELAY 500
PAUSE 1
SLEEP 5
LET x = 5
MoveAxe(1, 2000, 100)
MoveAxe 1, 2000st
SetOut(1,1)
StopAxe(X)
Wait 5 ms
PRINT 5 mm; x
PRINT a, b
OUT(1) = 1
OUT 1, 1
WaitMoov
MoveAx X, 5mm
DIM x AS INTEGER
DIM y AS LENGHT
10 PRINT "x"
GOTO 100
x(1
y[1] = 5
y = a[2]
foo : bar = 1
x1: PRINT 1
DIM x1, x, wait
CALL go(1, 2
TIMER = 5
a = TIMER
a = ERR()
a = MIN(1)
a = SQR(1, 2)
a = POS(1)
a = +5
a = "text"
SUB
EXIT
CONTINUE SUB
UNTIL a
THEN
a = 1 : foo: b = 2
start: a = 1
