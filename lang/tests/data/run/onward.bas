' One program begins another; here the host goes on behind it.
DIM n
n = 1
PRINT "another one"
IF n = 1 THEN RUN "another one"
RUN "Drill 2"
