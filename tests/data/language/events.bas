' A tick is served between statements and during waits; the wait keeps its own end.
DIM ticks, t AS TIME
ON EVERY 100ms GOSUB tick
t = TIMER()
Wait 1050ms
ON EVERY OFF
t = TIMER() - t
Wait 500ms
PRINT ticks; " "; t >= 1050ms ANDALSO t < 1060ms
SUB tick
  ticks = ticks + 1
END SUB
'> 10 1
'= done 12
'---
' An edge is remembered once while its handler runs.
DIM n
ON IN 3 RISE GOSUB hit
Wait 3s
PRINT n
END
hit:
n = n + 1
Wait 1s
RETURN
'~ for i in 0..4 { at(500 + 100 * i, || set_in(3, true)); at(550 + 100 * i, || set_in(3, false)); }
'> 2
'= done 6
'---
' Several are served in the order of their ON lines; a handler is not interrupted.
ON IN 4 RISE GOSUB second
ON IN 3 FALL GOSUB first
ON IN 5 RISE GOSUB third
Wait 2s
END
first:
PRINT "in 3"
RETURN
second:
PRINT "in 4 begins"
Wait 500ms
PRINT "in 4 ends"
RETURN
third:
PRINT "in 5"
RETURN
'~ set_in(3, true);
'~ at(500, || set_in(4, true));
'~ at(600, || set_in(5, true)); at(700, || set_in(3, false));
'> in 4 begins
'> in 4 ends
'> in 3
'> in 5
'= done 6
'---
' ON IN n OFF
DIM n
ON IN 3 RISE GOSUB hit
Wait 1s
ON IN 3 OFF
Wait 1s
PRINT n
SUB hit
  n = n + 1
END SUB
'~ at(500, || set_in(3, true)); at(600, || set_in(3, false)); at(1500, || set_in(3, true));
'> 1
'= done 10
'---
' Never inside a move, but during WaitMove.
DIM n, during
ON EVERY 200ms GOSUB tick
MoveAxe X, 50mm, 50mm/s
during = n
START MoveAxe X, 0mm, 50mm/s
WaitMove X
PRINT during <= 1; n > 3
END
tick:
n = n + 1
RETURN
'> 11
'= done 9
'---
' An error in an event handler; a GOTO out of the error handler ends the event handler too.
DIM a, n
ON ERROR GOTO oops
ON IN 3 RISE GOSUB hit
Wait 1s
PRINT "never"
oops:
PRINT "error "; ERR
GOTO on_
on_:
ON IN 3 OFF
ON IN 4 RISE GOSUB other
Wait 1s
END
hit:
a = 1 / a
RETURN
other:
PRINT "other is served"
RETURN
'~ at(300, || set_in(3, true)); at(600, || set_in(4, true));
'> error 2
'> other is served
'= done 14
'---
' WaitIn and its timeout, TIMEDOUT, edges.
DIM t AS TIME
WaitIn? 3, ON, 500ms
PRINT TIMEDOUT
WaitIn? 3, ON, 5s
PRINT TIMEDOUT; IN(3)
WaitIn 3, FALL
WaitIn 3, OFF
t = TIMER()
PRINT t >= 2s ANDALSO t < 2050ms
WaitIn 3, RISE, 100ms
'~ at(1000, || set_in(3, true)); at(2000, || set_in(3, false));
'> 1
'> 01
'> 1
'= fault F13 11
'---
' Characters: CHARIN takes the last one received.
DIM c
Send 65
WaitChar 66
PRINT CHARIN()
Wait 2s
PRINT CHARIN(); " "; CHARIN()
WaitChar? 68, 100ms
PRINT TIMEDOUT
WaitChar 68, 100ms
'~ at(500, || send_char(66)); at(1000, || send_char(67)); at(1500, || send_char(69));
'> 0
'> 69 0
'> 1
'= fault F13 10
'---
' A wait for what never comes ends the run.
WaitIn 3, ON
PRINT "never"
'= stopped 2
'---
' WaitStart: a press that begins during the wait.
Wait 1s
WaitStart
PRINT TIMER() > 2s
'~ at(500, || press_start()); at(3000, || press_start());
'> 1
'= done 4
'---
' Pulse returns when the pulse is over; SetPort sets 1..8.
DIM t AS TIME
SetPort &B10100101
PRINT OUT(1); OUT(2); OUT(3); OUT(4); OUT(5); OUT(6); OUT(7); OUT(8); OUT(9)
t = TIMER()
Pulse 2, 250ms
t = TIMER() - t
PRINT OUT(2); t >= 250ms ANDALSO t < 260ms
SetOut 4, 7
PRINT OUT(4); INPORT()
'~ set_in(1, true); set_in(3, true);
'> 101001010
'> 01
'> 15
'= done 10
'---
DIM n
n = 17
SetOut n, ON
'= fault F20 3
'---
DIM n AS TIME
n = -1ms
Wait n
'= fault F20 3
'---
DIM c
c = 32
Send c
'= fault F20 3
'---
' Handlers of errors have no F; the interrupted place's holds again behind them, also inside a
' handler of an event.
DIM zero, i, t AS TIME
ON ERROR GOTO oops
ON EVERY 700ms GOSUB tick
G61 G1 X1 F600
i = 1 / zero
t = TIMER()
G1 X3
t = TIMER() - t
PRINT t > 190ms ANDALSO t < 250ms
Wait 800ms
ON EVERY OFF
t = TIMER()
G1 X5
t = TIMER() - t
PRINT t > 190ms ANDALSO t < 250ms
END
tick:
G21 G90 G61 G1 Y[POS(Y) + 0.1mm] F300
i = 1 / zero
t = TIMER()
G1 Y[POS(Y) + 1mm]
t = TIMER() - t
PRINT "tick "; t > 190ms ANDALSO t < 250ms
RETURN
oops:
G21 G90 G61 G1 Z[POS(Z) + 0.1mm] F60
PRINT "F"; ERR
RESUME NEXT
'> F2
'> 1
'> F2
'> tick 1
'> 1
'= done 18
'---
' The probe of the chain wiring has edges as the others have; input 1 has nothing to do with them.
DIM n
ON IN 17 RISE GOSUB hit
Wait 1s
PRINT n
END
hit:
n = n + 1
RETURN
'~ at(200, || set_in(1, true)); at(400, || set_in(17, true)); at(600, || set_in(17, false)); at(800, || set_in(17, true));
'> 2
'= done 6
'---
' An edge in a pause is remembered; the clock of ON EVERY stands still there.
DIM n, ticks
ON IN 3 RISE GOSUB hit
ON EVERY 150ms GOSUB tick
Wait 400ms
PRINT n; " "; ticks
END
hit:
n = n + 1
RETURN
tick:
ticks = ticks + 1
RETURN
'~ at(50, || press_stop()); at(200, || set_in(3, true)); at(600, || press_start());
'> 1 2
'= done 7
'---
' Edges that came in one move are served before the next statement, one behind the other.
DIM a
ON IN 3 RISE GOSUB one
ON IN 4 RISE GOSUB two
MoveAxe X, 5mm
a = 2
PRINT "next"; a
END
one:
PRINT "one"; a
RETURN
two:
PRINT "two"; a
RETURN
'~ at(100, || { set_in(4, true); set_in(3, true); });
'> one0
'> two0
'> next2
'= done 8
'---
' The same behind an error handler, whichever way it is left.
DIM a, zero
ON ERROR GOTO oops
ON IN 3 RISE GOSUB one
ON IN 4 RISE GOSUB two
a = 1 / zero
PRINT "next"
zero = 1
a = 1 / (zero - 1)
END
oops:
MoveAxe X, zero * 5mm + 2mm
IF zero = 0 THEN RESUME NEXT
GOTO past
past:
PRINT "past"
END
one:
PRINT "one"
RETURN
two:
PRINT "two"
RETURN
'~ at(50, || set_in(3, true)); after(240, || set_in(4, true));
'> one
'> next
'> two
'> past
'= done 17
'---
' Handlers are served while a pulse lasts; it ends in time while one runs.
DIM n
ON EVERY 50ms GOSUB tick
Pulse 3, 200ms
PRINT "over"; n
END
tick:
n = n + 1
PRINT n
IF n < 3 THEN RETURN
ON EVERY OFF
Wait 100ms
PRINT OUT(3)
RETURN
'> 1
'> 2
'> 3
'> 0
'> over3
'= done 6
