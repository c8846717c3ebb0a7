/* Constants. */

vm_tens:
    mov.b @r5+, r12
    jmp 1f
vm_wordtens:
    WORD
1:  mov #10, r14
    jmp vm_times_word
vm_hundreds:
    mov #100, r14
    jmp vm_times_byte
vm_thousands:
    mov #1000, r14
vm_times_byte:
    mov.b @r5+, r12
    sxt r12
vm_times_word:
    call #vm_scaled
    jmp vm_next
    /* pushes r14 times the signed r12; keeps r8 and r9 */
vm_scaled:
    clr r13
    tst r12
    jge 1f
    inv r13
1:  sub #4, r6
    mov r10, 0(r6)
    mov r11, 2(r6)
    /* r11:r10 = r13:r12 times r14 */
vm_times:
    clr r10
    clr r11
1:  clrc
    rrc r14
    jnc 2f
    add r12, r10
    addc r13, r11
2:  rla r12
    rlc r13
    tst r14
    jne 1b
    ret
vm_long:
    WORD
    mov.b @r5+, r13
    mov.b @r5+, r14
    swpb r14
    bis r14, r13
    jmp vm_push
vm_word:
    WORD
    mov #1, r14
    jmp vm_times_word
vm_byte:
    mov #1, r14
    jmp vm_times_byte
vm_dup:
    mov r10, r12
    mov r11, r13
    jmp vm_push
vm_over:
    mov @r6, r12
    mov 2(r6), r13
    jmp vm_push
