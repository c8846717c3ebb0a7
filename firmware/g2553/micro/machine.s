/* The machine that runs micro-code (notation.s), and the table of its operations and routines. */

    .section .text.micro,"axR",@progbits
module.micro:
    .global micro
micro:
    pop r11
    /* r11 = where micro-code begins */
micro_enter:
    push r10
    mov r11, r10
micro_next:
    mov r2, r15
    push #micro_next
    mov.b @r10+, r14
    rla.b r14
    jc micro_formula
    cmp #2*MICRO_OWNS, r14
    jhs 1f
    mov micro_table(r14), r11
micro_go:
    bit #1, r11
    jne micro_enter
    br r11
1:  rra r14
    mov.b micro_offsets-MICRO_OWNS(r14), r11
    rla r11
    cmp #MICRO_BYTES, r14
    jlo 2f
    mov.b @r10+, r14
2:  add r11, r0
micro_base:

micro_formula:
    mov r14, r11
    and #0x1e, r11
    .short 0x121b, formula_table /* push formula_table(r11): LLVM's assembler has none */
    mov.b @r10+, r11
    /* the flags leave r14 one by one: F_RECORD, F_AXIS, F_NEW */
    rla.b r14
    jc 5f
    rla r11
    add #0x200, r11
    rla.b r14
    jnc 3f
    add r8, r11
3:  mov 2(r11), r15
4:  rla.b r14
    mov @r11, r14
    jc 6f
    ret
5:  add r9, r11
    rla.b r14
    jnc 3b
    clr r15
    jmp 4b
6:  call #pasapas_swap
    call #pasapas_scaled_new
    br #pasapas_swap

formula_load:
    mov r14, r12
    mov r15, r13
    tst r13
    ret
formula_store:
    mov r13, 2(r11)
formula_put:
    mov r12, 0(r11)
    ret
formula_word:
    mov r14, r12
    tst r12
    ret
formula_clear:
    clr 0(r11)
    ret
formula_base:
    mov r14, r9
    ret
formula_bound:
    call #pasapas_scaled_min
    jmp formula_store
formula_add:
    add r14, r12
    addc r15, r13
    ret
formula_sub:
    sub r14, r12
    subc r15, r13
    ret

    .global negate
    .set negate, pasapas_neg

    FORMULA_TABLE

micro_call:
    mov.b @r10+, r11
    mov.b @r10+, r15
    swpb r15
    bis r15, r11
    jmp micro_go

micro_end:
    incd r1
    mov r10, r14
    inc r14
    bic #1, r14
    pop r10
    mov r15, r2
    br r14

micro_fault:
    mov.b @r10+, r12
    add #FAULTED, r12
    jmp micro_return
micro_not_yet:
    mov #NOT_YET, r12
    jmp micro_return
micro_done:
    clr r12
    jmp micro_return
micro_below:
    cmp r14, r12
    jhs micro_refuse
    ret
micro_wanted:
    bit #2, r15
    jeq micro_nothing
micro_refuse:
    mov #EX_ILLEGAL_VALUE, r12
micro_return:
    incd r1
    pop r10
    mov r15, r2
    ret

micro_literal:
    mov.b @r10+, r12
    jmp micro_low
micro_word:
    mov.b @r10+, r12
    mov.b @r10+, r14
    swpb r14
    bis r14, r12
    ret
    /* a byte of the board's profile */
micro_profile:
    mov.b @r10+, r12
    add &BOARD, r12
    mov.b @r12, r12
    tst r12
    ret
micro_addi:
    add.b @r10+, r12
    ret
micro_andi:
    and.b @r10+, r12
    ret
micro_cmpi:
    cmp r14, r12
    ret
micro_testi:
    bit.b @r10+, r12
    ret
micro_shift:
    tst r13
    jeq 1f
    swpb r14
    add r14, r13
1:  ret

    /* of a byte of RAM: r14 = its number */
micro_get:
    mov.b BYTES(r14), r12
    jmp micro_low
micro_put:
    mov.b r12, BYTES(r14)
    ret
micro_let:
    .short 0x4afe, BYTES        /* mov.b @r10+, BYTES(r14): the same */
    ret
micro_bits_on:
    bis.b @r10+, BYTES(r14)
    ret
micro_bits_off:
    bic.b @r10+, BYTES(r14)
    ret
micro_compare:
    cmp.b BYTES(r14), r12
    ret
micro_up:
    inc.b BYTES(r14)
    ret
micro_axis_on:
    bis.b r12, BYTES(r14)
    ret
micro_axis_off:
    bic.b r12, BYTES(r14)
    ret

    /* The next of the axes from 8 = 4 * Z down: jumps while there is one. */
micro_next_axis:
    sub #4, r8
    jge micro_goto
    jmp 1f
micro_up_axis:
    add #4, r8
    cmp #12, r8
    jmp if_not_equal
micro_if_zero:
    tst.b BYTES(r14)
    jmp if_equal
micro_if_none:
    bit.b @r10+, BYTES(r14)
    jmp if_equal
micro_if_is:
    cmp.b @r10+, BYTES(r14)
    jmp if_equal
micro_if_not_axis:
    push r12
    call #axis_bit
    bit.b r12, BYTES(r14)
    pop r12
    jmp if_equal
    /* of r12 - r14 */
micro_case:
    cmp r14, r12
    jmp if_equal
micro_if_equal:
    mov r15, r2
if_equal:
    jeq micro_goto
1:  inc r10
    ret
micro_if_set:
    tst.b BYTES(r14)
    jmp if_not_equal
micro_if_any:
    bit.b @r10+, BYTES(r14)
    jmp if_not_equal
micro_if_is_not:
    cmp.b @r10+, BYTES(r14)
    jmp if_not_equal
micro_case_not:
    cmp r14, r12
    jmp if_not_equal
micro_if_not_equal:
    mov r15, r2
if_not_equal:
    jeq 1b
micro_goto:
    mov.b @r10, r14
    sxt r14
    add r14, r10
    mov r15, r2
    ret
micro_if_carry:
    bit #1, r15
    jmp if_not_equal
micro_if_negative:
    bit #4, r15
    jmp if_not_equal
micro_if_not_negative:
    bit #4, r15
    jmp if_equal
micro_if_overflow:
    bit #0x100, r15
    jmp if_not_equal

    /* r13:r12 = 0 when carry is set */
micro_zero_if_carry:
    bit #1, r15
    jeq micro_nothing
    clr r12
micro_low:
    clr r13
    ret
    /* flags of r13:r12 as a whole: Z, N */
micro_test_long:
    mov r12, r14
    bis r13, r14
    tst r14
    ret

micro_half:
    rra r12
    ret
    /* the next axes are 8 = 4 * Z down to 0 */
micro_first_axis:
    mov #8, r8
micro_nothing:
    ret
    /* on with the r12th of the places that follow, from 0: a byte each as of a jump */
micro_switch:
    add r12, r10
    jmp micro_goto
    /* returns a fault in r12, goes on with 0 */
micro_or_return:
    tst r12
    jne micro_return
    ret

    /* Addresses, then of the machine's own operations how far they lie behind micro_base. */
    MICRO_TABLES
    .balign 2, 0
