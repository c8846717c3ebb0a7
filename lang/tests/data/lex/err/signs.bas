? "hello"
x++
x += 1
x -= 1
IF a == 1 THEN x = 2
IF a != 1 && b || !c THEN x = 2
IF a => 1 THEN x = a % 3
// comment
/* comment */
{ }
Dim x%, a$
x% = 5
x := 5
y = x ^ 2 \ 3
y = a & b | ~c
PRINT "open
PRINT “quoted”
größe = 1
y = a – 1
foo _ bar
a = 1 @ 2
y = (a)_
