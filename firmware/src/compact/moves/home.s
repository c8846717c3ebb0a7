/* Reference runs, and the reference switches as limit switches. */
    .section .text.moves,"axR",@progbits
module.moves.home:

    /* PHASE of a reference run: each is the place of its jump in fx_home. */
    .set HOME_BEGIN, 2          /* N and BITS are set */
    .set HOME_REST, 4           /* braking */
    .set HOME_PAUSE, 6
    .set HOME_OPEN, 8           /* braking behind the switch */
    .set HOME_CLEAR, 10
    .set HOME_FAST, 12          /* toward the switch; from here on the axis may move */
    .set HOME_SLOW, 14          /* off it */
    /* BITS of a reference run: input number of the switch and */
    .set HOME_INVERT, 0x40      /* it is off when closed */
    .set HOME_COMMAND, 0x80     /* command 106: HOME_RECORD holds the rest */
    /* Where the switch opened: nothing is watched meanwhile. */
    .set OPENED, CAUGHT

    /* Home, Home? and commands 106, 1110: fast to the switch, rest, slowly off it, clearance. */
    .global fx_home
fx_home:
    jne 1f
    sub #OP_HOME, r12
    cmp #OP_HOME_QUERY-OP_HOME, r12
    jne 0f
    call #operand_byte
0:  mov.b #HOME_BEGIN, &PHASE
    call #home_by_profile
1:  call #axis_n
    bit #AXIS_PRESENT, A_FLAGS(r9)
    jeq home_lacks
    call #home_pace
    .if HAS_COMMANDS
    tst.b &BITS
    jge 2f
    mov #HOME_RECORD, r9
    .endif
2:  mov.b &PHASE, r10
    tst.b &MOVING
    jeq 3f
    cmp #HOME_FAST, r10
    jlo home_wait
3:  add r10, r0
home_wait:
    jmp home_wait_far
    jmp home_begin
    jmp home_rest
    jmp home_pause
    jmp home_open
    jmp home_clear
    jmp home_fast

    /* slow */
    call #home_closed
    mov #FAULTED+F_HOME_STAYS_CLOSED, r10
    jne home_missed
    mov.b #HOME_OPEN, &PHASE
    call #formula
    F load ACTUAL, AXIS
    F store OPENED, , LAST
    call #hit_at
    jmp home_wait

home_fast:
    call #home_closed
    mov #FAULTED+F_HOME_NOT_FOUND, r10
    jeq home_missed
    mov.b #HOME_REST, &PHASE
    call #motion_stop
    jmp home_wait

home_missed:
    tst.b &MOVING
    jne home_wait
    .if HAS_COMMANDS
    call #axis_at
    .endif
    call #settle_here
    mov #TRACE_HOME, r7
    call #event_here
    cmp #FAULTED+F_HOME_NOT_FOUND, r10
    jne 1f
    cmp.b #OP_HOME_QUERY, &EFFECT
    jeq 2f
1:  mov r10, r12
2:  ret

home_begin:
    clr.b &WATCH
    call #axis_bit
    bic.b r12, &HOMED
    call #formula
    FN int 0
    F store OFFSET, AXIS, LAST
    mov.b #HOME_REST, &PHASE
    call #home_closed
    jne home_wait
    mov.b #HOME_FAST, &PHASE
    mov A_FLAGS(r9), r7
    jmp home_seek

home_lacks:
    br #aim_lacks

home_rest:
    mov A_HOME_PAUSE(r9), &TIME
    incd.b &PHASE
home_wait_far:
    br #not_yet

home_pause:
    tst &TIME
    jne home_wait
    mov.b #HOME_SLOW, &PHASE
    call #formula
    FR load A_HOME_SLOW, SHORT, NEW
    F least TEMP
    F store TEMP, , LAST
    mov A_FLAGS(r9), r7
    xor #AXIS_HOME_POSITIVE, r7
    /* Moves by the stroke, in positive direction when r7 says so. */
home_seek:
    call #formula
    FR load A_HOME_STROKE, LONG, LAST
    call #to_steps
    bit #AXIS_HOME_POSITIVE, r7
    jne 1f
    call #negate
1:  call #formula
    F add ACTUAL, AXIS
    F store STEPS, AXIS, LAST
home_go:
    br #begin_axis

home_open:
    incd.b &PHASE
    call #axis_bit
    bis.b r12, &HOMED
    /* what the axis went on after the switch had opened counts from there */
    call #formula
    FR load A_HOME_POSITION, LONG, LAST
    call #to_steps
    call #formula
    F add ACTUAL, AXIS
    F sub OPENED
    F store ACTUAL, AXIS, LAST
    call #formula
    FR load A_HOME_CLEARANCE, LONG, LAST
    bit #AXIS_HOME_POSITIVE, A_FLAGS(r9)
    jeq 1f
    call #negate
1:  call #formula
    FR add A_HOME_POSITION, LONG, LAST
    call #to_steps
    .if HAS_COMMANDS
    call #axis_at
    .endif
    call #settle
    jmp home_go

home_clear:
    mov #TRACE_OK<<8|TRACE_HOME, r7
    /* An event with the axis's position: r7 = kind and outcome. Leaves r12 = DONE. */
event_here:
    call #formula
    F load ACTUAL, AXIS, LAST
    br #event

    /* Z clear when the switch is closed. Uses r11 to r15. */
home_closed:
    mov.b &BITS, r12
    .if HAS_COMMANDS
    and #31, r12
    call #unfiltered
    bit.b #HOME_INVERT, &BITS
    jeq 1f
    xor #1, r12
    .else
    call #unfiltered
    .endif
1:  tst r12
    ret

    /* Plans the reference run of the axis r12, which becomes N. Uses r11. */
home_by_profile:
    mov.b r12, &N
    call #reference
    mov.b r12, &BITS
    ret
    /* r12 = input number of the reference switch of axis r12. */
reference:
    add &BOARD, r12
    mov.b B_REFERENCE(r12), r12
    ret

    /* TEMP = pace toward the switch. Uses r11 to r15. */
home_pace:
    call #axis_pace
    .if HAS_COMMANDS
    tst.b &BITS
    jn 1f
    .endif
    call #formula
    FR load A_HOME_FAST, SHORT, NEW, LAST
    br #speed_least
    .if HAS_COMMANDS
1:  call #formula
    F load HOME_UP, NEW
    F least TEMP+4
    F store TEMP+4
    F load HOME_DOWN, NEW
    F least TEMP+8
    F store TEMP+8
    F load HOME_SPEED, NEW, LAST
    br #speed_least
    .endif

    /* An axis that moves toward its closed reference switch outside homing: F06. Each millisecond.
       No register is kept. */
    .global limits
limits:
    tst.b &MOVING
    jeq 4f
    mov.b &EFFECT, r12
    sub #OP_HOME, r12
    cmp #OP_HOME_QUERY-OP_HOME+1, r12
    jlo 4f
    mov #8, r8
1:  call #axis_at
    call #axis_bit
    mov r12, r10
    bit.b r10, &MOVING
    jeq 3f
    /* negative and a switch at the positive end, or the other way round */
    mov.b &NEGATIVE, r13
    and r10, r13
    jeq 2f
    mov #AXIS_HOME_POSITIVE, r13
2:  xor A_FLAGS(r9), r13
    bit #AXIS_HOME_POSITIVE, r13
    jeq 3f
    mov r8, r12
    rra r12
    rra r12
    call #reference
    mov r12, r7
    call #unfiltered
    tst r12
    jeq 3f
    bic.b r10, &HOMED
    mov.b r7, &FAULT_IN
    call #motion_halt
    mov #F_LIMIT_SWITCH, r12
    br #fail
3:  sub #4, r8
    jge 1b
4:  ret
