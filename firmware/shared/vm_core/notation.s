/* What the instructions of the VM have in common. Operands are fetched byte by byte, nothing is aligned. */

    /* r12 = address of the cell that the operand names */
    .macro CELL_HERE
    mov.b @r5+, r12
    rla r12
    rla r12
    add r7, r12
    .endm
    /* the same in half the bytes and twice the time */
    .macro CELL
    call #vm_cell
    .endm
    /* r12 = address of the cell that the code names; r12 is twice the code, a multiple of 4 and that */
    .macro LOW_CELL
    and #6, r12
    rla r12
    add r7, r12
    .endm
    /* r13 = signed distance operand */
    .macro REL
    mov.b @r5+, r13
    sxt r13
    .endm
    /* r12 = 16-bit operand, r13 lost */
    .macro WORD
    call #vm_operand
    .endm
    .macro POP
    mov @r6+, r10
    mov @r6+, r11
    .endm
    .macro PUSH_R13_R12
    sub #4, r6
    mov r10, 0(r6)
    mov r11, 2(r6)
    mov r12, r10
    mov r13, r11
    .endm
    .macro NEXT_HERE
    mov.b @r5+, r12
    rla.b r12
    jc vm_high
    jn vm_mid
    br vm_handlers(r12)
    .endm
