/* Arrays and tables of the program. */

vm_loadelem:
    mov r10, r14
    mov r11, r15
    call #vm_element
    mov @r12+, r10
    mov @r12, r11
    jmp vm_next
vm_storeelem:
    mov @r6+, r14
    mov @r6+, r15
    call #vm_element
    jmp vm_store_at
    /* r12 = address of the element r15:r14 */
vm_element:
    mov.b @r5+, r12
    mov.b @r5+, r13
    call #vm_inside
    add r14, r12
    rla r12
    rla r12
    add r7, r12
    ret
vm_check:
    mov.b @r5+, r13
    call #vm_inside_top
    jmp vm_next
    /* r15:r14 = the top, F03 unless it lies from 0 to r13 - 1 */
vm_inside_top:
    mov r10, r14
    mov r11, r15
    /* F03 unless r15:r14 does */
vm_inside:
    tst r15
    jne vm_f03
    cmp r13, r14
    jhs vm_f03
    ret

    /* the row on the top becomes the value of the column whose offset is the operand */
vm_table:
    mov.b @r5+, r12
    jmp 1f
vm_tablefar:
    WORD
1:  add &CORE_VM+CORE_DATA, r12
    mov.b @r12+, r8
    mov.b @r12+, r13
    mov.b @r12+, r14
    swpb r14
    bis r14, r13
    mov.b @r12+, r9
    mov.b @r12+, r14
    swpb r14
    bis r14, r9
    call #vm_inside_top
    /* r8 bytes a row, the highest first */
    mov r8, r13
2:  add r14, r12
    dec r13
    jne 2b
    mov r12, r10
    mov.b @r10+, r12
    sxt r12
    mov r12, r13
    swpb r13
    sxt r13
3:  dec r8
    jeq 5f
    mov #8, r15
4:  rla r12
    rlc r13
    dec r15
    jne 4b
    mov.b @r10+, r15
    bis r15, r12
    jmp 3b
5:  mov r9, r14
    call #vm_times
    jmp vm_next
