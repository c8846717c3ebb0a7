/* Effects: how they are called, and what firmware/src/rules/effects.rs builds on. An effect is polled until it is
   done; in phase 0 it takes its operands
   and arguments. Each is micro-code, entered with r12 = its code, Z set in phase 0, and leaves r12 =
   DONE, NOT_YET or FAULTED + fault. They may destroy all registers and emit one trace event a call. PHASE
   is 1 as soon as they were called. */

    .section .text.effects,"axR",@progbits
module.effects$table:
effect_codes:
    .subsection 0x100
    .balign 2, 0
effect_table:

    .section .text.micro,"axR",@progbits
module.effects:

/* Goes on with the effect under way. */
    .global effect_poll
effect_poll:
    mov.b &EFFECT, r12
    clr r14
    mov #effect_codes, r13
1:  incd r14
    cmp.b @r13+, r12
    jlo 1b
    tst.b &PHASE
    jne 2f
    inc.b &PHASE
    setz
2:  mov effect_table-2(r14), r11
    jmp micro_enter

    EFFECT OP_MOTORS, fx_motors
    /* The bit of axis 3, which stands for all of them, is 6. */
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
    DONE_

    /* UNIT = 1 when the top, which is taken, is not 0, else 0 */
    ROUTINE_ODD pop_level
    LET UNIT, 0
    DO pop_value
    DO test_long
    IF_EQUAL 3f
    UP UNIT
3:  RETURN

    .balign 2, 0

    EFFECT EFFECT_END, fx_end

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
