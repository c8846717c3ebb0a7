/* Jumps and loops. */

    /* bit 1 of r12 says unless 0 */
vm_jumpzero:
vm_jumpnonzero:
    mov r12, r14
    REL
    bis r10, r11
    tst r11
    mov @r6+, r10
    mov @r6+, r11
    jeq 1f
    xor #2, r14
1:  bit #2, r14
    jeq vm_take
    jmp vm_next

    /* Comparisons: less, equal, greater are bits 0 to 2 of r15, and of the code. */
vm_jumplt:
vm_jumpeq:
vm_jumple:
vm_jumpgt:
vm_jumpne:
vm_jumpge:
    call #vm_outcome
    REL
    POP
    bit r15, r14
    jne vm_take
    jmp vm_next
vm_lt:
vm_eq:
vm_le:
vm_gt:
vm_ne:
vm_ge:
    call #vm_outcome
    clr r10
    clr r11
    bit r15, r14
    adc r10
    jmp vm_next
vm_outcome:
    mov r12, r14
    rra r14
    call #vm_compare
    mov #1, r15
    jl 1f
    bis r12, r13
    tst r13
    mov #2, r15
    jeq 1f
    mov #4, r15
1:  ret

vm_jump:
    REL
vm_take:
    add r13, r5
    tst r13
    jge vm_next
vm_poll:
    tst.b &CORE_VM+CORE_POLL
    jeq vm_next
    mov #CORE_YIELD, r12
    jmp vm_exit

    /* Loops: r12 the cell, r13 the distance, limit and step on the stack. */
vm_forstep:
    CELL
    REL
    mov r10, r8
    bis r11, r8
    tst r8
    jeq vm_f20
    call #vm_beyond
    jl vm_take
    jmp vm_next
vm_nextstep:
    CELL
    REL
    add r10, 0(r12)
    addc r11, 2(r12)
    bit #0x100, r2
    jne vm_undo_add
    call #vm_beyond
    jge vm_take
    jmp vm_next
    /* step and limit are popped; less means that the cell lies beyond */
vm_beyond:
    mov @r6+, r14
    mov @r6+, r15
    mov @r12+, r8
    mov @r12, r9
    tst r11
    mov @r6+, r10
    mov @r6+, r11
    jl 1f
    sub r8, r14
    subc r9, r15
    ret
1:  sub r14, r8
    subc r15, r9
    ret

vm_nextshort:
    LOW_CELL
    mov.b @r5+, r14
    clr r9
    jmp 1f
vm_nextword:
    CELL_HERE
    mov.b @r5+, r14
    mov.b @r5+, r15
    swpb r15
    bis r15, r14
    clr r9
    tst r14
    jge 1f
    inv r9
    /* r9:r14 = the limit */
1:  REL
    add #1, 0(r12)
    adc 2(r12)
    bit #0x100, r2
    jne vm_undo_inc
    sub @r12+, r14
    subc @r12, r9
    jge vm_take
vm_flow_next:
    jmp vm_next

    /* F01 leaves the cell as it was. */
vm_undo_inc:
    sub #1, 0(r12)
    sbc 2(r12)
    jmp 1f
vm_undo_add:
    sub r10, 0(r12)
    subc r11, 2(r12)
1:  jmp vm_f01

vm_inc:
    CELL
    jmp 1f
vm_incshort:
    LOW_CELL
1:  add #1, 0(r12)
    adc 2(r12)
    bit #0x100, r2
    jne vm_undo_inc
    jmp vm_flow_next
vm_zero:
    LOW_CELL
    clr 0(r12)
    clr 2(r12)
    jmp vm_flow_next
