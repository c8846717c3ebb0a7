//! The planner's arithmetic in assembly for a chip with the MPY32: the chip's half of `motion::scaled`, to the bit.
//!
//! A number is its mantissa in bits 0..=23 and its exponent in bits 24..=31; operands come in
//! r13:r12 and r15:r14, results go to r13:r12, r11, r14, r15 are free. Compiled functions above 64 KB call this a hundred
//! times for a block of a path, and nothing else does: with the type of a function its section goes up there, too, and no
//! call needs a gate (`firmware/far`). Cycles with the return, about: times 45, over 280, root 360, plus and minus 65, new 50, floor 50.

use core::arch::global_asm;

global_asm!(
    r#"
    .section .text.scaled,"axR",@progbits
module.scaled:
    .global pasapas_scaled_times
    .type pasapas_scaled_times, @function
pasapas_scaled_times:
    /* MPY32L, MPY32H, OP2L, OP2H; exponents while it works, which takes up to 10 cycles to RES2 (SLAU208, 25.2) */
    mov r12, &0x04d0
    mov.b r13, r12
    mov r12, &0x04d2
    mov r14, &0x04e0
    mov.b r15, r12
    mov r12, &0x04e2
    swpb r13
    swpb r15
    add.b r15, r13
    sub.b #104, r13
    /* RES1, RES2: the mantissa are bits 47 to 24 of the product, or those below them */
    mov &0x04e6, r14
    mov &0x04e8, r15
    tst r15
    jn 1f
    rla r14
    rlc r15
    jz scaled_zero
    dec.b r13
1:  swpb r13
    swpb r14
    mov.b r14, r12
    swpb r15
    mov.b r15, r14
    bis r14, r13
    xor r14, r15
    bis r15, r12
    ret

scaled_zero:
    clr r12
    clr r13
    ret
    .global pasapas_scaled_floor
pasapas_scaled_floor:
    tst r13
    jz scaled_zero
    mov.b r13, r11
    swpb r13
    mov.b r13, r14
    mov #136, r15
    sub r14, r15
    cmp #1, r15
    jl 6f
    /* 32 bits in r11:r13, down by r15 */
    swpb r11
    mov r12, r13
    swpb r13
    mov.b r13, r14
    bis r14, r11
    xor r14, r13
1:  cmp #16, r15
    jlo 2f
    mov r11, r13
    clr r11
    sub #16, r15
    jmp 1b
2:  cmp #8, r15
    jlo 3f
    swpb r13
    mov.b r13, r13
    swpb r11
    mov.b r11, r14
    xor r14, r11
    bis r11, r13
    mov r14, r11
    sub #8, r15
3:  tst r15
    jz 5f
4:  clrc
    rrc r11
    rrc r13
    dec r15
    jnz 4b
5:  mov r13, r12
    mov r11, r13
    ret
6:  mov #-1, r12
    mov #0x7fff, r13
    ret

    .global pasapas_scaled_size
pasapas_scaled_size:
    tst r13
    jge 1f
    inv r12
    inv r13
    inc r12
    adc r13
    .global pasapas_scaled_new
pasapas_scaled_new:
1:  tst r13
    jnz 4f
    tst r12
    jz scaled_zero
    /* 16 bits are most: the top one goes out into the carry */
    mov r12, r13
    mov #121, r11
    cmp #0x100, r13
    jhs 2f
    swpb r13
    mov #113, r11
2:  dec r11
    rla r13
    jnc 2b
    rrc r13
    clr r12
3:  swpb r13
    mov.b r13, r14
    xor r14, r13
    bis r13, r12
    mov r14, r13
    swpb r11
    bis r11, r13
    ret
4:  mov #137, r11
5:  dec r11
    rla r12
    rlc r13
    jnc 5b
scaled_packed:
    rrc r13
    rrc r12
    swpb r12
    mov.b r12, r12
    jmp 3b

    .global pasapas_scaled_squares
pasapas_scaled_squares:
    /* MPYS32L, MPYS32H, OP2L, OP2H, the others with MACS32L and MACS32H */
    mov @r12+, r14
    mov @r12+, r15
    mov r14, &0x04d4
    mov r15, &0x04d6
    mov r14, &0x04e0
    mov r15, &0x04e2
    .rept 2
    mov @r12+, r14
    mov @r12+, r15
    mov r14, &0x04dc
    mov r15, &0x04de
    mov r14, &0x04e0
    mov r15, &0x04e2
    .endr
    mov &0x04e4, r14
    mov &0x04e6, r15
    mov &0x04e8, r12
    mov &0x04ea, r13
    mov #169, r11
    /* up by words, by a byte, by bits */
    tst r13
1:  jnz 2f
    mov r12, r13
    mov r15, r12
    mov r14, r15
    clr r14
    sub #16, r11
    cmp #121-16, r11
    jeq scaled_zero
    tst r13
    jmp 1b
2:  cmp #0x100, r13
    jhs 3f
    swpb r13
    swpb r12
    mov.b r12, r14
    bis r14, r13
    xor r14, r12
    swpb r15
    mov.b r15, r14
    bis r14, r12
    xor r14, r15
    sub #8, r11
3:  dec r11
    rla r15
    rlc r12
    rlc r13
    jnc 3b
    jmp scaled_packed

    .global pasapas_scaled_max
pasapas_scaled_max:
    cmp r15, r13
    jne 1f
    cmp r14, r12
1:  jhs scaled_first
scaled_second:
    mov r14, r12
    mov r15, r13
scaled_first:
    ret

    .global pasapas_scaled_min
pasapas_scaled_min:
    cmp r15, r13
    jne 1f
    cmp r14, r12
1:  jhs scaled_second
    ret

    .global pasapas_scaled_exponent_over
pasapas_scaled_exponent_over:
    sub r14, r12
    subc r15, r13
    swpb r13
    mov.b r13, r12
    sxt r12
    ret
    .size pasapas_scaled_times, .-pasapas_scaled_times

    .section .text.pasapas_scaled_over,"ax",@progbits
module.scaled$over:
    .global pasapas_scaled_over
    .type pasapas_scaled_over, @function
pasapas_scaled_over:
    push r9
    push r10
    tst r15
    jz 3f
    tst r13
    jz 4f
    mov.b r13, r9
    mov.b r15, r10
    swpb r13
    swpb r15
    sub.b r15, r13
    add.b #105, r13
    mov r13, r11
    mov r9, r13
    mov r10, r15
    /* the dividend at least the divisor, so that the quotient has 24 bits */
    cmp r15, r13
    jlo 1f
    jne 2f
    cmp r14, r12
    jhs 2f
1:  rla r12
    rlc r13
    dec.b r11
2:  swpb r11
    clr r10
    mov #2, r9
    call #scaled_digits
    bis r10, r11
    clr r10
    mov #4, r9
    call #scaled_digits
    mov r10, r12
    mov r11, r13
4:  pop r10
    pop r9
    ret
3:  mov #-1, r12
    mov #-1, r13
    jmp 4b

    /* Four times r9 bits of the quotient of r13:r12 over r15:r14 into r10, from below. */
scaled_digits:
    .rept 4
    sub r14, r12
    subc r15, r13
    jc 1f
    add r14, r12
    addc r15, r13
    clrc
1:  rlc r10
    rla r12
    rlc r13
    .endr
    dec r9
    jnz scaled_digits
    ret
    .size pasapas_scaled_over, .-pasapas_scaled_over

    .section .text.pasapas_scaled_root,"ax",@progbits
module.scaled$root:
    .global pasapas_scaled_root
    .type pasapas_scaled_root, @function
pasapas_scaled_root:
    push r9
    push r8
    tst r13
    jz 8f
    mov r13, r11
    mov.b r13, r13
    swpb r11
    mov.b r11, r11
    /* What is left of the radicand in r13:r12, twice the root in r15:r14, the root's next bit in r9, later r8:
       2^25 is 1. An even power of two leaves the exponent. */
    add #101, r11
    rra r11
    jnc 1f
    rla r12
    rlc r13
1:  clr r14
    clr r15
    mov #0x100, r9
    /* as long as the bit is in the upper word the lower one of the root is 0 */
2:  rla r12
    rlc r13
    bis r9, r15
    cmp r15, r13
    jlo 3f
    sub r15, r13
    add r9, r15
    rra r9
    jnc 2b
    jmp 4f
3:  bic r9, r15
    rra r9
    jnc 2b
4:  mov #0x8000, r8
5:  rla r12
    rlc r13
    bis r8, r14
    sub r14, r12
    subc r15, r13
    jc 6f
    add r14, r12
    addc r15, r13
    bic r8, r14
    clrc
    rrc r8
    jnc 5b
    jmp 7f
6:  add r8, r14
    adc r15
    clrc
    rrc r8
    jnc 5b
    /* down from bit 25 */
7:  incd r11
    rra r15
    rrc r14
    rra r15
    rrc r14
    swpb r11
    mov r14, r12
    mov r15, r13
    bis r11, r13
8:  pop r8
    pop r9
    ret
    .size pasapas_scaled_root, .-pasapas_scaled_root

    .section .text.pasapas_scaled_plus,"ax",@progbits
module.scaled$plus:
    .global pasapas_scaled_plus
    .type pasapas_scaled_plus, @function
pasapas_scaled_plus:
    push r10
    cmp r15, r13
    jhs 1f
    mov r13, r11
    mov r15, r13
    mov r11, r15
    mov r12, r11
    mov r14, r12
    mov r11, r14
1:  tst r15
    jz 3f
    call #scaled_align
    add r14, r12
    addc r10, r11
    bit #0x100, r11
    jz 2f
    rra r11
    rrc r12
    inc r13
2:  mov.b r13, r13
    swpb r13
    bis r11, r13
3:  pop r10
    ret
    .size pasapas_scaled_plus, .-pasapas_scaled_plus

    .section .text.pasapas_scaled_minus,"ax",@progbits
module.scaled$minus:
    .global pasapas_scaled_minus
    .type pasapas_scaled_minus, @function
pasapas_scaled_minus:
    push r10
    cmp r15, r13
    jlo 6f
    jne 1f
    cmp r12, r14
    jhs 6f
1:  tst r15
    jz 5f
    call #scaled_align
    sub r14, r12
    subc r10, r11
    /* up by whole bytes first */
2:  tst.b r11
    jn 4f
    jnz 3f
    swpb r12
    mov.b r12, r11
    xor r11, r12
    sub #8, r13
    jmp 2b
3:  rla r12
    rlc r11
    dec r13
    bit #0x80, r11
    jz 3b
4:  mov.b r13, r13
    swpb r13
    bis r11, r13
5:  pop r10
    ret
6:  clr r12
    clr r13
    jmp 5b
    .size pasapas_scaled_minus, .-pasapas_scaled_minus

    .section .text.scaled_align,"ax",@progbits
    .type scaled_align, @function
    /* Splits both, the first the larger one: its mantissa in r11:r12, its exponent in r13; the other mantissa in
       r10:r14, down by the gap of the exponents. */
scaled_align:
    mov.b r13, r11
    swpb r13
    mov.b r13, r13
    mov.b r15, r10
    swpb r15
    mov.b r15, r15
    sub r13, r15
    jz 4f
1:  cmp #-7, r15
    jge 3f
    swpb r14
    mov.b r14, r14
    swpb r10
    bis r10, r14
    clr r10
    add #8, r15
    jnz 1b
    ret
3:  rra r10
    rrc r14
    inc r15
    jnz 3b
4:  ret
    .size scaled_align, .-scaled_align
"#
);
