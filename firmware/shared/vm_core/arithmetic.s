/* Arithmetic: an instruction takes the top as its right operand, what lies below as its left one. */

    .section .text.vm,"ax",@progbits
module.vm:

    /* r13:r12 = magnitude of the left operand, popped, r15:r14 of the right one, r8 negative when their
       signs differ */
vm_signs:
    mov @r6+, r12
    mov @r6+, r13
    mov r10, r14
    mov r11, r15
    mov r13, r8
    xor r15, r8
    br #pasapas_abs2

vm_mul:
    call #vm_signs
    call #pasapas_product
    bis r11, r10
    tst r10
    jne vm_overflow
    mov r14, r12
    mov r15, r13
    jmp vm_signed
vm_mod:
    .short 0x1216, 2            /* push 2(r6): LLVM's assembler has none */
    call #vm_divide
    mov r10, r12
    mov r11, r13
    pop r8
    jmp vm_signed
vm_div:
    call #vm_divide
    /* the result is magnitude r13:r12 with the sign of r8, which it must have unless it is 0 */
vm_signed:
    tst r8
    jge 1f
    call #pasapas_neg
1:  xor r13, r8
    jn 2f
vm_set:
    mov r12, r10
    mov r13, r11
    jmp vm_next
2:  bis r12, r13
    tst r13
    jeq vm_set
vm_overflow:
    jmp vm_f01
vm_divide:
    mov r10, r14
    bis r11, r14
    tst r14
    jeq vm_f02
    call #vm_signs
    br #pasapas_udivmod

    /* Heron's way down from above: (x + a / x) / 2 until that grows no smaller. Over 0, which the root
       of 0 comes to, a quotient is all ones. */
vm_sqr:
    tst r11
    jl vm_f20
    push r11
    push r10
    mov #-1, r8
1:  mov @r1, r12
    mov 2(r1), r13
    mov r8, r14
    clr r15
    call #pasapas_udivmod
    add r8, r12
    rrc r12
    cmp r8, r12
    jhs 2f
    mov r12, r8
    jmp 1b
2:  mov r8, r12
    clr r13
    add #4, r1
    jmp vm_set

    /* bit 1 of r12 says right */
vm_shl:
vm_shr:
    tst r11
    jne vm_f04
    cmp #32, r10
    jhs vm_f04
    mov r10, r14
    mov r12, r8
    POP
    jmp 3f
1:  bit #2, r8
    jne 2f
    rla r10
    rlc r11
    jmp 3f
2:  rra r11
    rrc r10
3:  dec r14
    jge 1b
    jmp vm_next

vm_abs:
    tst r11
    jge vm_to_next
vm_neg:
    clr r12
    clr r13
    jmp vm_minus
vm_sub:
    mov @r6+, r12
    mov @r6+, r13
vm_minus:
    sub r10, r12
    subc r11, r13
    bit #0x100, r2
    jeq vm_set
    jmp vm_overflow

vm_min:
    call #vm_compare
    jl vm_take_left
    jmp vm_next
vm_max:
    call #vm_compare
    jl vm_to_next
vm_take_left:
    mov r8, r10
    mov r9, r11
vm_to_next:
    jmp vm_next
    /* left in r9:r8, popped; r13:r12 = left less right, and its flags; the top stays right */
vm_compare:
    mov @r6+, r8
    mov @r6+, r9
    mov r8, r12
    mov r9, r13
    sub r10, r12
    subc r11, r13
    ret

vm_and:
    and @r6+, r10
    and @r6+, r11
    jmp vm_next
vm_or:
    bis @r6+, r10
    bis @r6+, r11
    jmp vm_next
vm_xor:
    xor @r6+, r10
    xor @r6+, r11
    jmp vm_next
