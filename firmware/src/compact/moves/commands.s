/* What commands (firmware/src/rules/commands.rs) call: their arguments, inputs that keep a level, work positions.
   r5 = the next argument. */
    .section .text.micro,"axR",@progbits
module.moves.commands:

    /* acc = the next argument */
command_long:
    mov @r5+, r12
    mov @r5+, r13
    ret

    /* acc = the next argument, a float: thousandths of it */
    ROUTINE_ODD command_float
    DO command_long
    F store TEMP+8
    CALL command_scaled
    F store TEMP
    /* 1000/512, so that no exponent of a float leaves the range of scaled numbers */
    LIT 125
    DO new
    SHIFT -6
    F times TEMP
    DO rounded
    IF_NONE TEMP+11, 0x80, 1f
    DO negate
1:  RETURN
    .balign 2, 0

    /* The float r13:r12 without its sign as a scaled number, times 2^22: the exponents' zeros differ. */
command_scaled:
    rla r13
    mov r13, r14
    setc
    rrc.b r13
    and #0xff00, r14
    bis r14, r13
    ret

    /* Input r12 keeps the level r4, until -1 frees it; not one whose role stops the machine. Leaves
       r12 = 0 or an exception. */
force_input:
    mov &BOARD, r14
    add #B_REFERENCE, r14
    mov #B_END_OF_STOPS-B_REFERENCE, r15
1:  cmp.b @r14+, r12
    jeq 3f
    dec r15
    jne 1b
    call #mask_of
    inc r4
    cmp #3, r4
    jhs 3f
    clr r12
    bic r14, &FORCED
    dec r4
    jn 4f
    /* bis and bic leave the flags */
    bis r14, &FORCED
    bic r14, &INPUT
    jeq 4f
    bis r14, &INPUT
4:  ret
3:  br #illegal_value

    /* Work position of the axis r12 becomes r15:r14 steps: r12 = 0 or an exception.
       Keeps r4 to r7 and r10. */
    .global set_work_position
set_work_position:
    call #axis_select
    mov r14, r12
    mov r15, r13
    MICRO
    CALL work_position_is
    RETURN
    .balign 2, 0
