//! The planner's arithmetic in assembly: the chip's half of `motion::scaled`, to the bit.
//!
//! A number is its mantissa in bits 0..=23 and its exponent in bits 24..=31; operands come in
//! r13:r12 and r15:r14, results go to r13:r12, r11, r14, r15 are free. Cycles are the longest
//! path: times 340, over 370, root 560, plus 250, minus 400, new and floor 200.

use core::arch::global_asm;

global_asm!(
    r#"
    .section .text.scaled,"axR",@progbits
module.scaled:

    /* saves r8 to r10 for scaled_pop and splits both operands: exponents to r11 and r10, mantissas
       stay; zero ones are sent home by the callers first */
scaled_split:
    pop r11
    push r10
    push r9
    push r8
    push r11
    mov r13, r11
    swpb r11
    mov.b r11, r11
    mov r15, r10
    swpb r10
    mov.b r10, r10
    mov.b r13, r13
    mov.b r15, r15
    ret

    .global pasapas_scaled_times
pasapas_scaled_times:
    tst r13
    jeq scaled_zero
    tst r15
    jeq scaled_zero
    call #scaled_split
    add r10, r11
    sub #105, r11
    clr r9
    clr r8
    mov #24, r10
1:  rra r8
    rrc r9
    rra r15
    rrc r14
    jnc 2f
    add r12, r9
    addc r13, r8
2:  dec r10
    jne 1b
scaled_carry:
    /* 25 bits in r8:r9, exponent of the case that the upper one is clear in r11 */
    bit #0x100, r8
    jeq scaled_pack
    rra r8
    rrc r9
    inc r11
scaled_pack:
    mov r9, r12
    swpb r11
    and #0xff00, r11
    bis r11, r8
    mov r8, r13
scaled_pop:
    pop r8
    pop r9
    pop r10
    ret

scaled_zero:
    clr r12
    clr r13
    ret

    .global pasapas_scaled_over
pasapas_scaled_over:
    tst r15
    jeq scaled_most
    tst r13
    jeq scaled_zero
    call #scaled_split
    sub r10, r11
    add #105, r11
    call #scaled_compare
    jhs 2f
    rla r12
    rlc r13
    dec r11
2:  mov #24, r10
3:  sub r14, r12
    subc r15, r13
    jc 4f
    add r14, r12
    addc r15, r13
    clrc
4:  rlc r9
    rlc r8
    rla r12
    rlc r13
    dec r10
    jne 3b
    mov.b r8, r8
    jmp scaled_pack
scaled_most:
    mov #-1, r12
    mov #-1, r13
    ret

    .global pasapas_scaled_plus
pasapas_scaled_plus:
    call #scaled_compare
    jhs 2f
    xor r12, r14
    xor r14, r12
    xor r12, r14
    xor r13, r15
    xor r15, r13
    xor r13, r15
2:  tst r15
    jeq scaled_home
    call #scaled_split
    call #scaled_align
    add r12, r9
    addc r13, r8
    jmp scaled_carry
scaled_home:
    ret

    .global pasapas_scaled_minus
pasapas_scaled_minus:
    call #scaled_compare
    jlo scaled_zero
    jeq scaled_zero
    call #scaled_split
    call #scaled_align
    sub r9, r12
    subc r8, r13
2:  bit #0x80, r13
    jne 3f
    rla r12
    rlc r13
    dec r11
    jmp 2b
3:  mov r12, r9
    mov r13, r8
    jmp scaled_pack

    /* mantissa of the smaller one (in r15:r14) down by the gap of the exponents, to r8:r9 */
scaled_align:
    mov r14, r9
    mov r15, r8
    sub r11, r10
    jeq 3f
    cmp #-23, r10
    jge 1f
    clr r9
    clr r8
    ret
1:  rra r8
    rrc r9
    inc r10
    jne 1b
3:  ret

    .global pasapas_scaled_root
pasapas_scaled_root:
    tst r13
    jeq scaled_zero
    clr r15
    call #scaled_split
    push r7
    push r6
    add #104, r11
    /* remainder r15:r14, root r8:r9; the radicand leaves r13:r12 from bit 23 on, two bits a
       round, one in the first round when the exponent is odd */
    clr r14
    clr r9
    clr r8
    mov #24, r10
    swpb r13
    swpb r12
    mov.b r12, r7
    bis r7, r13
    xor r7, r12
    rra r11
    jnc 1f
    inc r11
    jmp 2f
1:  rla r12
    rlc r13
    rlc r14
2:  rla r12
    rlc r13
    rlc r14
    rlc r15
    rla r9
    rlc r8
    /* trial = 2 root + 1 after the shift: four times the old root and one */
    setc
    mov r9, r7
    rlc r7
    mov r8, r6
    rlc r6
    sub r7, r14
    subc r6, r15
    jc 3f
    add r7, r14
    addc r6, r15
    jmp 4f
3:  bis #1, r9
4:  dec r10
    jeq 5f
    rla r12
    rlc r13
    rlc r14
    rlc r15
    jmp 2b
5:  pop r6
    pop r7
    jmp scaled_pack

    .global pasapas_scaled_new
pasapas_scaled_new:
    mov #136, r11
    tst r13
    jn 2f
    jne 1f
    tst r12
    jeq scaled_zero
1:  dec r11
    rla r12
    rlc r13
    jn 2f
    jmp 1b
2:  mov.b r13, r14
    swpb r14
    swpb r12
    mov.b r12, r12
    bis r14, r12
    swpb r13
    mov.b r13, r13
    swpb r11
    bis r11, r13
    ret

    .global pasapas_scaled_floor
pasapas_scaled_floor:
    mov r13, r11
    swpb r11
    mov.b r11, r11
    sub #136, r11
    jge 2f
    cmp #-31, r11
    jl scaled_zero
    /* mantissa to the top: bytes of r13:r12 up by one */
    mov.b r13, r13
    swpb r13
    swpb r12
    mov.b r12, r14
    bis r14, r13
    xor r14, r12
1:  clrc
    rrc r13
    rrc r12
    inc r11
    jne 1b
    ret
2:  mov #-1, r12
    mov #0x7fff, r13
    ret

    .global pasapas_scaled_max
pasapas_scaled_max:
    call #scaled_compare
    jlo scaled_second
scaled_first:
    ret

    .global pasapas_scaled_min
pasapas_scaled_min:
    call #scaled_compare
    jlo scaled_first
scaled_second:
    mov r14, r12
    mov r15, r13
    ret
    /* flags of r13:r12 less r15:r14 as numbers without a sign */
scaled_compare:
    cmp r15, r13
    jne 1f
    cmp r14, r12
1:  ret

    .section .text.scaled_size,"ax",@progbits
    .global pasapas_scaled_size
pasapas_scaled_size:
    tst r13
    jge 1f
    inv r12
    inv r13
    inc r12
    adc r13
1:  br #pasapas_scaled_new

    .section .text.scaled_exponent,"ax",@progbits
module.scaled$exponent:
    .global pasapas_scaled_exponent_over
pasapas_scaled_exponent_over:
    sub r14, r12
    subc r15, r13
    swpb r13
    mov.b r13, r12
    sxt r12
    ret
    "#
);
