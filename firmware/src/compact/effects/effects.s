/* Effects that move nothing. An effect is polled until it is done; in phase 0 it takes its operands
   and arguments. Each is entered with r12 = its code, Z set in phase 0, and leaves r12 = DONE,
   NOT_YET or FAULTED + fault; most are micro-code. They may destroy all registers and emit one trace
   event a call. The phase of those from SetOut on is 1 as soon as they were called. */

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
    mov effect_table(r14), r14
    mov.b &PHASE, r13
    cmp #OP_SET_OUT, r12
    jlo 2f
    mov.b #1, &PHASE
2:  bit #1, r14
    jne 3f
    tst r13
    br r14
3:  tst r13
    br #micro_enter

    ROUTINE_ODD fx_out_short
    ADDI 2-OP_OUT_SHORT
    PUT UNIT
    DO half
    GOTO fx_output
    ROUTINE_ODD fx_set_out
    DO pop_level
    LIT 16
    DO pop_small
    /* Output r12 on (bit 0 of UNIT) or off, traced; F20 beyond those there are. */
    ROUTINE_ODD fx_output
    PUT N
    CALL output_unit
    IF_NOT_EQUAL 1f
    LIT 0
    GET UNIT
    ANDI 1
    EVENT TRACE_OUT
    RETURN
1:  FAULT F_VALUE_RANGE

    ROUTINE_ODD fx_pulse
    IF_NOT_EQUAL 1f
    DO pop_time
    DO or_return
    LIT 16
    DO pop_small
    LET UNIT, 1
    DO fx_output
    DO or_return
    NOT_YET_
1:  F load TIME
    DO test_long
    IF_NOT_EQUAL fx_not_yet_near
    LET UNIT, 0
    GET N
    GOTO fx_output

    ROUTINE_ODD fx_set_port
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
    IF_CARRY 2f
    CALL port_own
    IF_EQUAL 1b
    DO fx_output
    CMPI 0
    IF_NOT_EQUAL 1b
fx_not_yet_near:
    NOT_YET_
2:  DONE_

    /* bits of one axis or of all */
    ROUTINE_ODD fx_motors
    DO operand_byte
    DO axis_select
    DO axis_bit
    CMPI 6
    IF_NOT_EQUAL 1f
    ADDI 1
1:  PUT RAMPS
    DO pop_level
    IF_SET UNIT, 2f
    GET RAMPS
    AXIS_OFF HOMED
2:  CALL enable_unit
    DONE_

    ROUTINE_ODD fx_wait
    IF_NOT_EQUAL 1f
    DO pop_time
    DO or_return
    F load TIME
    EVENT TRACE_WAIT
1:  F load TIME
    DO test_long
    IF_NOT_EQUAL fx_not_yet_near
    DONE_

    /* BITS = flags of a wait, TIME = its timeout, -1 for ever without one: r12 = 0, or F20 for a negative
       one. */
    ROUTINE_ODD wait_begin
    DO operand_byte
    PUT BITS
    DO scaled_most
    F store TIME
    IF_ANY BITS, FLAG_TIMEOUT, 1f
    DONE_
    /* TIME = the top, a time without flags: the same. */
    ROUTINE_ODD pop_time
1:  DO pop_value
    F store TIME
    F load TIME
    IF_NEGATIVE 2f
    DONE_
2:  FAULT F_VALUE_RANGE

    /* UNIT = 1 when the top, which is taken, is not 0, else 0. */
    ROUTINE_ODD pop_level
    LET UNIT, 0
    DO pop_value
    DO test_long
    IF_EQUAL 1f
    UP UNIT
1:  RETURN

    ROUTINE_ODD fx_wait_in
    IF_NOT_EQUAL 4f
    DO wait_begin
    DO or_return
    IF_NONE BITS, FLAG_LEVEL, 1f
    DO pop_level
    BITS_OFF BITS, 3
    GET UNIT
    AXIS_ON BITS
1:  CALL wait_input
    IF_NONE BITS, FLAG_INPUT_ON_STACK, 3f
    LIT 17
    DO pop_number
    DO or_range
3:  PUT N
4:  GET N
    DO input
    CALL wait_differs
    IF_EQUAL 6f
    BITS_OFF BITS, 2
    GOTO 5f
6:  IF_ANY BITS, 2, 5f
    LIT 0
    GET BITS
    ANDI 1
    EVENT_OK TRACE_WAIT_IN
    GOTO wait_met
5:  F load TIME
    DO test_long
    IF_NOT_EQUAL fx_wait_longer
    GET BITS
    ANDI 1
    EVENT TRACE_WAIT_IN
    GOTO wait_missed

    ROUTINE_ODD fx_wait_char
    IF_NOT_EQUAL 1f
    DO wait_begin
    DO or_return
    DO pop_character
    DO or_range
    PUT N
1:  GET N
    CALL char_came
    IF_NOT_EQUAL 2f
    LET CHAR_IN, 0
    LIT 0
    GET N
    EVENT_OK TRACE_WAIT_CHAR
wait_met:
    IF_NONE BITS, FLAG_WAIT_QUERY, 1f
    BITS_OFF RUN_FLAGS, R_TIMED_OUT
1:  DONE_
2:  F load TIME
    DO test_long
    IF_NOT_EQUAL fx_wait_longer
    GET N
    EVENT TRACE_WAIT_CHAR
wait_missed:
    IF_NONE BITS, FLAG_WAIT_QUERY, 3f
    BITS_ON RUN_FLAGS, R_TIMED_OUT
    DONE_
3:  FAULT F_TIMED_OUT

    ROUTINE_ODD fx_send
    DO pop_character
    DO or_range
    PUT CHAR_OUT
    UP CHAR_OUT+1
    EVENT TRACE_SEND
    RETURN

    /* acc = the top, a character from 33 to 125, or 0. */
    ROUTINE_ODD pop_character
    LIT 125
    DO pop_number
    CMPI 33
    IF_CARRY 1f
    LIT 0
1:  RETURN

    ROUTINE_ODD fx_wait_start
    IF_NOT_EQUAL 1f
    BITS_ON RUN_FLAGS, R_WAITING
1:  IF_ANY RUN_FLAGS, R_WAITING, fx_wait_longer
    LIT 0
    EVENT_OK TRACE_WAIT_START
    RETURN

    ROUTINE_ODD fx_end
    LIT END_DONE
    CALL run_finish
fx_wait_longer:
    NOT_YET_

    ROUTINE_ODD fx_timed_out
    LIT 0
    IF_NONE RUN_FLAGS, R_TIMED_OUT, 1f
    LIT 1
1:  DO push_small
    DONE_
    ROUTINE_ODD fx_out_state
    LIT 16
    DO pop_number
    DO or_range
    CALL output_level
    DO push_small
    DONE_
    ROUTINE_ODD fx_in
    LIT 17
    DO pop_number
    DO or_range
    GOTO 1f
    ROUTINE_ODD fx_in_short
    ADDI 1-OP_IN_SHORT
1:  DO input
    DO push_small
    DONE_
    .balign 2, 0

/* Sets output r12 as UNIT says: Z clear beyond those there are. Uses r12 to r14. */
output_unit:
    mov.b &UNIT, r13
    and #1, r13
    call #set_output
    tst r12
    ret
/* The same of the drivers' enable. */
enable_unit:
    mov &BOARD, r12
    mov.b B_ENABLE(r12), r12
    jmp output_unit
/* r12 = level of output r12. Uses r14. */
output_level:
    call #mask_of
    clr r12
    and &OUTPUT, r14
    adc r12
    ret
/* Z set for output r12 being the enable or the lamp: they are not the script's. Uses r14. */
port_own:
    mov &BOARD, r14
    cmp.b B_ENABLE(r14), r12
    jeq 1f
    cmp.b B_LAMP(r14), r12
1:  ret
/* r12 = the input that the instruction names. Bit 1 of the want: an edge, so the other level comes
   first; bit 0 becomes the level then. */
wait_input:
    bit.b #2, &BITS
    jeq 1f
    xor.b #1, &BITS
1:  mov.b &BITS, r12
    rla.b r12
    rlc.b r12
    rlc.b r12
    and #3, r12
    inc r12
    ret
/* Z clear when the level r12 is not the wanted one. Uses r14. */
wait_differs:
    mov.b &BITS, r14
    xor r14, r12
    and #1, r12
    ret
/* Z set when r12 is the character that has come. */
char_came:
    cmp.b r12, &CHAR_IN
    ret
/* r12 = the top, 1 to r12, which is taken; 0 for any other. Uses r13 to r15. */
pop_number:
    call #pop_small
    cmp r12, r15
    jhs 1f
    clr r12
1:  ret
/* TIME = the top, which is taken and also left in r13:r12. Uses r14. */
pop_to_time:
    call #pop_value
    mov r12, &TIME
    mov r13, &TIME+2
    ret
/* Z set when no time is left. Uses r12. */
time_left:
    mov &TIME, r12
    bis &TIME+2, r12
    tst r12
    ret

/* The first code behind each effect's, and the effect. Codes between them are those of a larger part:
   the image check refuses them. */
effect_ends:
    .byte OP_IN_SHORT, OP_TIMED_OUT, OP_OUT_SHORT, OP_MOVE_TO, OP_RAPID, OP_FEED, OP_HOME, OP_PROBE
    .byte OP_SET_POS, OP_STOP_AXE, OP_WAIT_MOVE, OP_SET_OUT, OP_PULSE, OP_SET_PORT, OP_MOTORS
    .byte OP_WAIT, OP_WAIT_IN, OP_WAIT_START, OP_SEND, OP_WAIT_CHAR, OP_PRINT_TEXT
    .byte OP_PRINT_NUMBER, OP_PRINT_END, OP_IN, OP_OUT_STATE, OP_READ, EFFECT_END, EFFECT_END+1
    .balign 2, 0
effect_table:
    .short fx_set_pos_zero, fx_in_short, fx_timed_out, fx_out_short, fx_move, fx_linear, fx_feed
    .short fx_home, fx_probe, fx_set_pos, fx_stop, fx_wait_move, fx_set_out, fx_pulse
    .short fx_set_port, fx_motors, fx_wait, fx_wait_in, fx_wait_start, fx_send, fx_wait_char
    .short fx_print_text, fx_print_value, fx_print_end, fx_in, fx_out_state, fx_read, fx_end
