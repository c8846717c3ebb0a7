/* Entry, ways out, and what every program does most: cells, sums, small numbers. */

    .global pasapas_vm_run
pasapas_vm_run:
    .if CORE_SAVES
    push r4
    push r5
    push r6
    push r7
    push r8
    push r9
    push r10
    .endif
    /* the first fields of State in their order */
    mov #CORE_VM, r12
    mov @r12+, r5
    mov @r12+, r6
    mov @r12+, r10
    mov @r12+, r11
    mov @r12+, r4
    mov @r12+, r7
    mov r1, &CORE_VM+CORE_FRAME
    jmp vm_next

    /* faults, at any depth of the machine stack */
vm_f01:
    mov #1, r12
    jmp vm_fault
vm_f02:
    mov #2, r12
    jmp vm_fault
vm_f03:
    mov #3, r12
    jmp vm_fault
vm_f04:
    mov #4, r12
    jmp vm_fault
vm_f16:
    mov #16, r12
    jmp vm_fault
vm_f20:
    mov #20, r12
vm_fault:
    mov &CORE_VM+CORE_FRAME, r1
    bis #0x100, r12
    jmp vm_exit
    /* what the main loop does */
vm_end:
vm_tosteps:
vm_tolength:
vm_err:
vm_erl:
vm_course:
vm_leave:
vm_onerror:
vm_onerrorstop:
vm_resumenext:
    .if CORE_MATHS
vm_resume:
vm_sin:
vm_cos:
vm_atan2:
vm_muldiv:
vm_sync:
vm_setaout:
    .endif
    rra r12
    jmp vm_exit

vm_high:
    rla.b r12
    jc vm_effect
    jn vm_inline
    bit #0x40, r12
    jne vm_store
    add r7, r12
vm_load_at:
    sub #4, r6
    mov r10, 0(r6)
    mov r11, 2(r6)
    mov @r12+, r10
    mov @r12, r11
    NEXT_HERE
vm_loadfar:
    CELL
    jmp vm_load_at
vm_storefar:
    CELL
    jmp vm_store_at
vm_store:
    and #0x3f, r12
    add r7, r12
vm_store_at:
    mov r10, 0(r12)
    mov r11, 2(r12)
vm_drop:
    POP
    jmp vm_next
vm_addcell:
    CELL_HERE
    add @r12+, r10
    addc @r12, r11
    jmp 1f
vm_add:
    add @r6+, r10
    addc @r6+, r11
1:  bit #0x100, r2
    jeq vm_next
    jmp vm_f01
vm_mid:
    cmp.b #0xc0, r12
    jhs 1f
    br vm_handlers(r12)
1:  rra r12
    and #31, r12
    clr r13
vm_push:
    PUSH_R13_R12
vm_next:
    NEXT_HERE

vm_effect:
    bis #0x100, r12
1:  rra r12
    rra r12
    bis #0x80, r12
vm_exit:
    mov r5, &CORE_VM+CORE_PC
    mov r6, &CORE_VM+CORE_SP
    mov r10, &CORE_VM+CORE_TOP
    mov r11, &CORE_VM+CORE_TOP+2
    .if CORE_SAVES
    pop r10
    pop r9
    pop r8
    pop r7
    pop r6
    pop r5
    pop r4
    .endif
    ret
    /* effects below 0xb0 bring whole thousands, for the stack; r12 is four times the code */
vm_inline:
    cmp #4*0x30, r12
    jhs 1b
    rra r12
    mov vm_inlines-0x40(r12), r8
1:  mov #1000, r14
    mov.b @r5+, r12
    sxt r12
    call #vm_scaled
    sub #0x100, r8
    jc 1b
    mov.b r8, r12
    jmp vm_exit

vm_operand:
    mov.b @r5+, r12
    mov.b @r5+, r13
    swpb r13
    bis r13, r12
    ret
vm_cell:
    CELL_HERE
    ret
