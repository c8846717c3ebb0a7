/* Reference runs, and the reference switches as limit switches. */
    .section .text.micro,"axR",@progbits
module.moves.home:

    /* PHASE of a reference run: each is its place in fx_home's switch. */
    .set HOME_BEGIN, 1          /* N and BITS are set */
    .set HOME_REST, 2           /* braking */
    .set HOME_PAUSE, 3
    .set HOME_OPEN, 4           /* braking behind the switch */
    .set HOME_CLEAR, 5
    .set HOME_FAST, 6           /* toward the switch; from here on the axis may move */
    .set HOME_SLOW, 7           /* off it */
    /* BITS of a reference run: input number of the switch and */
    .set HOME_INVERT, 0x40      /* it is off when closed */
    .set HOME_COMMAND, 0x80     /* command 106: HOME_RECORD holds the rest */
    /* Where the switch opened: nothing is watched meanwhile. */
    .set OPENED, CAUGHT

    /* Home, Home? and commands 106, 1110: fast to the switch, rest, slowly off it, clearance. */
    ROUTINE_ODD fx_home
    IF_NOT_EQUAL 1f
    ADDI -OP_HOME
    CASE_NOT OP_HOME_QUERY-OP_HOME, 0f
    DO operand_byte
0:  DO home_by_profile
1:  DO axis_n
    DO axis_there
    IF_EQUAL home_lacks
    /* the pace toward the switch */
    DO axis_pace
    IF_ANY BITS, HOME_COMMAND, 2f
    FR load A_HOME_FAST, SHORT, NEW
    GOTO 3f
2:  F load HOME_UP, NEW
    F bound TEMP+4
    F load HOME_DOWN, NEW
    F bound TEMP+8
    F load HOME_SPEED, NEW
    CALL home_record
3:
    DO speed_least
    GET PHASE
    IF_ZERO MOVING, 4f
    CMPI HOME_FAST
    IF_CARRY 4f
    NOT_YET_
4:  DO micro_switch
    .byte 0
    TO home_begin
    TO home_rest
    TO home_pause
    TO home_open
    TO home_clear
    TO home_fast
    TO home_slow
    PLACES_END
home_slow:
    DO home_closed
    IF_NOT_EQUAL home_stays_closed
    LET PHASE, HOME_OPEN
    DO here
    F store OPENED
    DO motion_hit
    NOT_YET_

home_fast:
    DO home_closed
    IF_EQUAL home_not_found
    LET PHASE, HOME_REST
    DO motion_stop
home_wait:
    NOT_YET_

home_stays_closed:
    IF_SET MOVING, home_wait
    DO home_missed
    FAULT F_HOME_STAYS_CLOSED
home_not_found:
    IF_SET MOVING, home_wait
    DO home_missed
    IF_IS EFFECT, OP_HOME_QUERY, home_failed
    FAULT F_HOME_NOT_FOUND
home_lacks:
    FAULT F_VALUE_RANGE

home_clear:
    DO here
    EVENT_OK TRACE_HOME
home_failed:
    RETURN

home_begin:
    DO axis_bit
    AXIS_OFF HOMED
    AXIS_OFF PLACED
    LIT 0
    F store OFFSET, AXIS
    UP PHASE
    DO home_closed
    IF_NOT_EQUAL home_wait
    LET PHASE, HOME_FAST
    FR load A_FLAGS, SHORT
    GOTO home_seek

home_rest:
    FR load A_HOME_PAUSE, SHORT
    F store TIME
    UP PHASE
    NOT_YET_

home_pause:
    F load TIME
    DO test_long
    IF_NOT_EQUAL home_wait
    LET PHASE, HOME_SLOW
    FR load A_HOME_SLOW, SHORT, NEW
    DO speed_least
    FR load A_FLAGS, SHORT
    ADDI AXIS_HOME_POSITIVE
    /* Moves by the stroke, in positive direction when r12 says so. */
home_seek:
    PUT FLAGS
    FR load A_HOME_STROKE, LONG
    DO to_steps
    IF_ANY FLAGS, AXIS_HOME_POSITIVE, 1f
    DO negate
1:  F add ACTUAL, AXIS
    F store STEPS, AXIS
    GOTO home_go

home_open:
    UP PHASE
    DO axis_bit
    AXIS_ON HOMED
    /* what the axis went on after the switch had opened counts from there */
    FR load A_HOME_POSITION, LONG
    DO to_steps
    F add ACTUAL, AXIS
    F sub OPENED
    F store ACTUAL, AXIS
    FR load A_FLAGS, SHORT
    PUT FLAGS
    FR load A_HOME_CLEARANCE, LONG
    IF_NONE FLAGS, AXIS_HOME_POSITIVE, 1f
    DO negate
1:  FR add A_HOME_POSITION, LONG
    DO to_steps
    DO axis_at
    CALL settle
home_go:
    DO begin_axis
    RETURN

    /* A reference run that failed ends where the axis stands. */
    ROUTINE_ODD home_missed
    DO axis_at
    DO settle_here
    DO here
    EVENT TRACE_HOME
    RETURN
    .balign 2, 0

home_record:
    mov #HOME_RECORD, r9
    ret

    /* Z clear when the switch is closed. Uses r11 to r15. */
    ROUTINE_ODD home_closed
    GET BITS
    ANDI 31
    DO unfiltered
    IF_NONE BITS, HOME_INVERT, 1f
    ADDI 1
1:  TESTI 1
    RETURN

    /* Plans the reference run of the axis r12, which becomes N. Uses r11. */
    ROUTINE_ODD home_by_profile
    PUT N
    CALL reference
    PUT BITS
    RETURN
    .balign 2, 0

    /* r12 = input number of the reference switch of axis r8, of axis r12. */
reference_at:
    mov r8, r12
    rra r12
    rra r12
reference:
    add &BOARD, r12
    mov.b B_REFERENCE(r12), r12
    ret

    /* An axis that moves toward its closed reference switch outside homing: F06. Each millisecond.
       No register is kept. */
    .global limits
limits:
    MICRO
    IF_ZERO MOVING, 9f
    DO map_homes
    IF_CARRY 1f
9:  RETURN
1:  DO micro_first_axis
1:  CALL reference_at
    PUT TEMP
    DO unfiltered
    IF_EQUAL 5f
    IF_NOT_AXIS MOVING, 5f
    DO axis_at
    FR word A_FLAGS, SHORT
    /* a switch at the positive end, or the other way round */
    IF_NOT_AXIS NEGATIVE, 2f
    ADDI AXIS_HOME_POSITIVE
2:  TESTI AXIS_HOME_POSITIVE
    IF_EQUAL 5f
    DO axis_bit
    AXIS_OFF HOMED
    GET TEMP
    PUT FAULT_IN
    DO motion_halt
    LIT F_LIMIT_SWITCH
    DO fail
    RETURN
5:  NEXT_AXIS 1b
    RETURN
    .balign 2, 0
