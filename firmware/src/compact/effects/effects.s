/* Effects that move nothing. An effect is polled until it is done; in phase 0 it takes its operands
   and arguments. Each is micro-code, entered with r12 = its code, Z set in phase 0, and leaves r12 =
   DONE, NOT_YET or FAULTED + fault. They may destroy all registers and emit one trace event a call. PHASE
   is 1 as soon as they were called. */

    .section .text.micro,"axR",@progbits
module.effects:

/* Goes on with the effect under way. */
    .global effect_poll
effect_poll:
    mov.b &EFFECT, r12
    mov #-2, r14
    mov #effect_ends, r13
1:  incd r14
    cmp.b @r13+, r12
    jhs 1b
    tst.b &PHASE
    jne 2f
    inc.b &PHASE
    setz
2:  mov effect_table(r14), r11
    jmp micro_enter

    /* bit 0 of the code says on or off */
fx_out_short:
    ADDI 2-OP_OUT_SHORT
    PUT UNIT
    DO half
    GOTO fx_output
fx_set_out:
    DO pop_level
    POP_NUMBER 1, 16
/* Output r12 takes the level of bit 0 of UNIT, traced; F20 beyond those there are. */
    ROUTINE_ODD fx_output
    PUT N
    DO output_unit
    IF_EQUAL fx_range
    GET UNIT
    ANDI 1
    EVENT TRACE_OUT
    RETURN
fx_range:
    FAULT F_VALUE_RANGE

fx_pulse:
    IF_NOT_EQUAL 1f
    DO pop_time
    POP_NUMBER 1, 16
    LET UNIT, 1
    DO fx_output
    DO or_return
fx_not_yet:
    NOT_YET_
1:  DO time_up
    LET UNIT, 0
    GET N
    GOTO fx_output

    /* BITS: the outputs that remain */
fx_set_port:
    IF_NOT_EQUAL 1f
    DO pop_value
    PUT BITS
1:  UP N
    GET BITS
    PUT UNIT
    DO half
    PUT BITS
    GET N
    CMPI 9
    IF_CARRY fx_done
    /* not the script's: the enable and the lamp */
    PROFILE B_ENABLE
    COMPARE N
    IF_EQUAL 1b
    PROFILE B_LAMP
    COMPARE N
    IF_EQUAL 1b
    GET N
    DO fx_output
    /* they change together, unless a host that traces must hear of each first */
    IF_NONE TRACING, T_FULL, 1b
    GOTO fx_not_yet

fx_motors:
    DO operand_byte
    DO axis_select
    DO axis_bit
    CASE_NOT 6, 1f
    LIT 7
1:  PUT RAMPS
    DO pop_level
    IF_SET UNIT, 2f
    GET RAMPS
    AXIS_OFF HOMED
    AXIS_OFF PLACED
2:  PROFILE B_ENABLE
    DO output_unit
fx_done:
    DONE_

fx_wait:
    IF_NOT_EQUAL 1f
    DO pop_time
    EVENT TRACE_WAIT
1:  DO time_up
    DONE_

    /* BITS holds the flags; the level that is wanted in bit 0, and in bit 1 that the other one has to
       come first */
fx_wait_in:
    IF_NOT_EQUAL 3f
    DO wait_begin
    IF_NONE BITS, FLAG_LEVEL, 1f
    DO pop_level
    BITS_OFF BITS, 3
    GET UNIT
    AXIS_ON BITS
    /* the input in the two top bits */
1:  GET BITS
    DO half
    DO half
    DO half
    DO half
    DO half
    DO half
    ADDI 1
    IF_NONE BITS, FLAG_INPUT_ON_STACK, 2f
    POP_NUMBER 1, 17
2:  PUT N
3:  GET N
    DO input
    PUT UNIT
    GET BITS
    ANDI 1
    COMPARE UNIT
    IF_EQUAL 4f
    BITS_OFF BITS, 2
    GOTO 5f
4:  IF_NONE BITS, 2, 1f
5:  DO time_up
    EVENT TRACE_WAIT_IN
    GOTO fx_missed
1:  EVENT_OK TRACE_WAIT_IN
    /* the end of a wait, met or timed out */
fx_met:
    IF_NONE BITS, FLAG_WAIT_QUERY, fx_done
    BITS_OFF RUN_FLAGS, R_TIMED_OUT
    DONE_

fx_wait_char:
    IF_NOT_EQUAL 1f
    DO wait_begin
    POP_NUMBER 33, 125
    PUT N
1:  GET N
    COMPARE CHAR_IN
    IF_EQUAL 1f
    DO time_up
    EVENT TRACE_WAIT_CHAR
fx_missed:
    IF_ANY BITS, FLAG_WAIT_QUERY, 2f
    FAULT F_TIMED_OUT
2:  BITS_ON RUN_FLAGS, R_TIMED_OUT
    DONE_
1:  LET CHAR_IN, 0
    EVENT_OK TRACE_WAIT_CHAR
    GOTO fx_met

fx_send:
    POP_NUMBER 33, 125
    PUT CHAR_OUT
    UP CHAR_OUT+1
    EVENT TRACE_SEND
    RETURN

fx_wait_start:
    IF_NOT_EQUAL 1f
    BITS_ON RUN_FLAGS, R_WAITING
1:  IF_ANY RUN_FLAGS, R_WAITING, 2f
    LIT 0
    EVENT_OK TRACE_WAIT_START
    RETURN

    /* UNIT = 1 when the top, which is taken, is not 0, else 0 */
    ROUTINE_ODD pop_level
    LET UNIT, 0
    DO pop_value
    DO test_long
    IF_EQUAL 3f
    UP UNIT
3:  RETURN

fx_end:
    LIT END_DONE
    CALL run_finish
2:  NOT_YET_

fx_in_short:
    ADDI 1-OP_IN_SHORT
    GOTO 1f
fx_in:
    POP_NUMBER 1, 17
1:  DO input
    GOTO 2f
fx_out_state:
    POP_NUMBER 1, 16
    DO output
    GOTO 2f
fx_timed_out:
    LIT 0
    IF_NONE RUN_FLAGS, R_TIMED_OUT, 2f
    LIT 1
2:  CALL push_small
    DONE_
    .balign 2, 0

/* Output r12 takes the level of bit 0 of UNIT: Z set when it does not exist. Clobbers r12 to r14. */
output_unit:
    mov.b &UNIT, r13
    and #1, r13
    br #set_output

/* The effect is not done while time is left. Clobbers r14. */
time_up:
    mov &TIME, r14
    bis &TIME+2, r14
    tst r14
    jne micro_not_yet
fx_return:
    ret

/* Flags of a wait into BITS, its timeout into TIME, -1 for ever without one; a negative one is F20. */
wait_begin:
    call #operand_byte
    mov.b r12, &BITS
    mov #-1, &TIME
    mov #-1, &TIME+2
    bit #FLAG_TIMEOUT, r12
    jeq fx_return
/* TIME and acc = the top, which is taken; a negative one is F20. */
pop_time:
    call #pop_value
    mov r12, &TIME
    mov r13, &TIME+2
    tst r13
    jge fx_return
fx_out_of_range:
    mov #FAULTED+F_VALUE_RANGE, r12
    mov r2, r15                 ; micro-code's flags
    jmp micro_return

/* r12 = the top, which is taken; F20 unless it lies between the two bytes that follow. */
pop_number:
    mov.b @r10+, r11
    mov.b @r10+, r15
    call #pop_value
    tst r13
    jne fx_out_of_range
    cmp r11, r12
    jlo fx_out_of_range
    cmp r12, r15
    jhs fx_return
    jmp fx_out_of_range

/* The first code behind each effect's, and the effect. Codes between them are those of a larger part:
   the image check refuses them. */
effect_ends:
    .byte OP_LINEAR, OP_MOVE_TO, OP_PROBE, OP_HOME, OP_STOP_AXE, OP_SET_POS_ZERO, OP_OUT_SHORT
    .byte OP_PRINT_END, OP_WAIT_START, OP_SET_OUT, OP_PULSE, OP_WAIT_IN, OP_MOTORS, OP_WAIT_CHAR
    .byte OP_WAIT, OP_SEND, OP_SET_PORT, OP_FEED, OP_PRINT_NUMBER, OP_PRINT_TEXT, OP_SET_POS
    .byte OP_IN_SHORT, OP_TIMED_OUT, OP_IN, OP_OUT, OP_READ, OP_MOVE_SPEED
    .if HAS_EVENTS
    .byte OP_EVENT+1
    .endif
    .byte 0xff
    .balign 2, 0
effect_table:
    .short fx_wait_move, fx_linear, fx_move, fx_probe, fx_home, fx_stop, fx_set_pos_zero
    .short fx_out_short, fx_print_end, fx_wait_start, fx_set_out, fx_pulse, fx_wait_in, fx_motors
    .short fx_wait_char, fx_wait, fx_send, fx_set_port, fx_feed, fx_print_number, fx_print_text
    .short fx_set_pos, fx_in_short, fx_timed_out, fx_in, fx_out_state, fx_read
    .if HAS_EVENTS
    .short fx_event
    .endif
    .short fx_end
