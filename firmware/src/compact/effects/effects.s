/* Effects that move nothing. An effect is polled until it is done; in phase 0 it takes its operands
   and arguments. Each is entered with r12 = its code, Z set in phase 0, and leaves r12 = DONE,
   NOT_YET or FAULTED + fault. They may destroy all registers and emit one trace event a call. The
   phase of those from SetOut on is 1 as soon as they were called. */

    .section .text.effects,"axR",@progbits
module.effects:

/* Goes on with the effect under way. */
    .global effect_poll
effect_poll:
    mov.b &EFFECT, r12
    cmp.b #EFFECT_END, r12
    jeq fx_end
    mov #-2, r14
    mov #effect_ends, r13
1:  incd r14
    cmp.b @r13+, r12
    jhs 1b
    mov.b &PHASE, r13
    cmp #OP_SET_OUT, r12
    jlo 2f
    mov.b #1, &PHASE
2:  mov effect_table(r14), r14
    bit #1, r14
    jne 3f
    tst r13
    br r14
3:  br #micro_enter

fx_out_short:
    mov r12, r13
    and #1, r13
    sub #OP_OUT_SHORT-2, r12
    rra r12
    jmp fx_output
fx_set_out:
    call #pop_value
    bis r13, r12
    mov r12, r10
    mov #16, r12
    call #pop_small
    mov r10, r13
/* Output r12 on (r13 not 0) or off, traced; F20 beyond those there are. */
fx_output:
    mov r12, r15
    call #set_output
    tst r12
    jne fx_range
    clr r14
    tst r13
    jeq 1f
    inc r14
1:  swpb r15
    bis #TRACE_OUT, r15
    mov r15, r12
    jmp emit_small

fx_pulse:
    jne 1f
    call #pop_time
    mov #16, r12
    call #pop_small
    mov.b r12, &N
    mov #1, r13
    call #fx_output
    tst r12
    jeq fx_not_yet
    ret
1:  call #time_left
    jne fx_not_yet
    mov.b &N, r12
    clr r13
    jmp fx_output

fx_set_port:
    jne 1f
    call #pop_value
    mov.b r12, &BITS
1:  inc.b &N
    clr r13
    rra.b &BITS
    rlc r13
    mov.b &N, r12
    cmp #9, r12
    jhs fx_done
    /* the enable and the lamp are not the script's, nor are those that do not exist */
    mov &BOARD, r14
    cmp.b B_ENABLE(r14), r12
    jeq 1b
    cmp.b B_LAMP(r14), r12
    jeq 1b
    call #fx_output
    tst r12
    jne 1b
    jmp fx_not_yet

fx_motors:
    call #operand_byte
    inc r12
    call #mask_of
    mov r14, r10
    cmp #8, r10
    jne 1f
    dec r10
1:  call #pop_value
    bis r12, r13
    tst r13
    jne 1f
    bic.b r10, &HOMED
1:  mov &BOARD, r12
    mov.b B_ENABLE(r12), r12
    call #set_output
fx_done:
    clr r12
    ret

fx_wait:
    jne 1f
    call #pop_time
    mov r12, r14
    mov r13, r15
    mov #TRACE_WAIT, r12
    call #emit
1:  call #time_left
    jeq fx_done
fx_not_yet:
    mov #NOT_YET, r12
    ret

/* Z set when no time is left. Clobbers r12. */
time_left:
    mov &TIME, r12
    bis &TIME+2, r12
    tst r12
    ret

/* Flags of a wait into r10 and BITS, its timeout into TIME, -1 for ever without one. A negative
   timeout is F20, and the caller's caller goes on. */
wait_begin:
    call #operand_byte
    mov r12, r10
    mov.b r12, &BITS
    mov #-1, &TIME
    mov #-1, &TIME+2
    bit #FLAG_TIMEOUT, r12
    jeq fx_return
/* The same of a time without flags; it is also left in r13:r12. Clobbers r14. */
pop_time:
    call #pop_to_time
    jge fx_return
    jmp fx_out_of_range

/* The top, 1 to r12 (pop_between: r11 to r12), is taken into r12; any other is F20, and the caller's
   caller goes on. Clobbers r11, r13 to r15. */
pop_number:
    mov #1, r11
pop_between:
    call #pop_small
    cmp r11, r12
    jlo fx_out_of_range
    cmp r12, r15
    jhs fx_return
fx_out_of_range:
    incd r1
fx_range:
    mov #FAULTED+F_VALUE_RANGE, r12
fx_return:
    ret

/* TIME = the top, which is taken and also left in r13:r12, flags as of r13. Clobbers r14. */
pop_to_time:
    call #pop_value
    mov r12, &TIME
    mov r13, &TIME+2
    tst r13
    ret

fx_wait_in:
    jne 4f
    call #wait_begin
    bit #FLAG_LEVEL, r10
    jeq 1f
    call #pop_value
    bic #3, r10
    bis r13, r12
    tst r12
    jeq 1f
    inc r10
    /* bit 1 of the want: an edge, so the other level comes first; bit 0 becomes the level then */
1:  bit #2, r10
    jeq 2f
    xor #1, r10
2:  mov.b r10, &BITS
    mov r10, r12
    rla.b r12
    rlc.b r12
    rlc.b r12
    and #3, r12
    inc r12
    bit #FLAG_INPUT_ON_STACK, r10
    jeq 3f
    mov #17, r12
    call #pop_number
3:  mov.b r12, &N
4:  mov.b &N, r12
    call #input
    mov.b &BITS, r14
    xor r14, r12
    bit #1, r12
    jeq 5f
    bic.b #2, &BITS
    bis #2, r14
5:  mov r14, r13
    and #1, r14
    mov #TRACE_WAIT_IN, r12
    bit #2, r13
    jne fx_missed

/* The end of a wait, met or timed out or not yet: r12 = TraceKind, r14 = value to trace. */
fx_met:
    mov #TRACE_OK, r13
    jmp 1f
fx_missed:
    mov &TIME, r13
    bis &TIME+2, r13
    tst r13
    jne fx_not_yet
1:  bis.b &N, r13
    swpb r13
    bis r13, r12
    call #emit_small
    bit.b #FLAG_WAIT_QUERY, &BITS
    jne 2f
    tst r13
    jn fx_return
    mov #FAULTED+F_TIMED_OUT, r12
    ret
2:  bic.b #R_TIMED_OUT, &RUN_FLAGS
    tst r13
    jn fx_return
    bis.b #R_TIMED_OUT, &RUN_FLAGS
    ret

fx_wait_char:
    jne 1f
    call #wait_begin
    call #pop_character
    mov.b r12, &N
1:  mov.b &N, r14
    mov #TRACE_WAIT_CHAR, r12
    cmp.b r14, &CHAR_IN
    jne fx_missed
    clr.b &CHAR_IN
    jmp fx_met

fx_send:
    call #pop_character
    mov.b r12, &CHAR_OUT
    inc.b &CHAR_OUT+1
    mov r12, r14
    mov #TRACE_SEND, r12
    jmp emit_small

/* r12 = the top, a character from 33 to 125; any other is F20, and the caller's caller goes on.
   Clobbers r13 to r15. */
pop_character:
    mov #125, r12
    mov #33, r11
    jmp pop_between

fx_wait_start:
    jne 1f
    bis.b #R_WAITING, &RUN_FLAGS
1:  bit.b #R_WAITING, &RUN_FLAGS
    jne fx_not_yet
    mov #TRACE_OK*256+TRACE_WAIT_START, r12
    clr r14
    jmp emit_small

fx_end:
    mov #END_DONE, r12
    call #run_finish
    jmp fx_not_yet

fx_out_state:
    mov #16, r12
    call #pop_number
    call #mask_of
    and &OUTPUT, r14
    jmp 1f
fx_timed_out:
    bit.b #R_TIMED_OUT, &RUN_FLAGS
1:  clr r12
    adc r12
    jmp 2f
fx_in:
    mov #17, r12
    call #pop_number
    jmp 1f
fx_in_short:
    sub #OP_IN_SHORT-1, r12
1:  call #input
2:  clr r13
    call #push_value
    clr r12
    ret

/* The first code behind each effect's, and the effect. Codes between them are those of a larger part:
   the image check refuses them. */
effect_ends:
    .byte OP_IN_SHORT, OP_TIMED_OUT, OP_OUT_SHORT, OP_MOVE_TO, OP_RAPID, OP_FEED, OP_HOME, OP_PROBE
    .byte OP_SET_POS, OP_STOP_AXE, OP_WAIT_MOVE, OP_SET_OUT, OP_PULSE, OP_SET_PORT, OP_MOTORS
    .byte OP_WAIT, OP_WAIT_IN, OP_WAIT_START, OP_SEND, OP_WAIT_CHAR, OP_PRINT_TEXT
    .byte OP_PRINT_NUMBER, OP_PRINT_END, OP_IN, OP_OUT_STATE, OP_READ, EFFECT_END
    .balign 2, 0
effect_table:
    .short fx_set_pos_zero, fx_in_short, fx_timed_out, fx_out_short, fx_move, fx_linear, fx_feed
    .short fx_home, fx_probe, fx_set_pos, fx_stop, fx_wait_move, fx_set_out, fx_pulse
    .short fx_set_port, fx_motors, fx_wait, fx_wait_in, fx_wait_start, fx_send, fx_wait_char
    .short fx_print_text, fx_print_value, fx_print_end, fx_in, fx_out_state, fx_read
