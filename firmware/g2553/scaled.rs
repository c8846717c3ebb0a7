//! The planner's arithmetic in assembly: the chip's half of `motion::scaled`, to the bit.
//!
//! A number is its mantissa in bits 0..=23 and its exponent in bits 24..=31; operands come in
//! r13:r12 and r15:r14, results go to r13:r12, r11, r14, r15 are free, but that `new` keeps r14 and
//! r15. Cycles are the longest path: times 360, over 410, root 530, plus, minus and new 250, floor
//! 130; exponents that lie 74 apart, as in the planner at most, cost 440 more.

use core::arch::global_asm;

global_asm!(
    r#"
    .section .text.scaled,"axR",@progbits
module.scaled:

    /* left operand: mantissa in r13:r12, exponent in r11; right one: bytes of r15 swapped */
scaled_split:
    mov r13, r11
    mov.b r13, r13
    sub r13, r11
    swpb r11
    swpb r15
    ret

    .global pasapas_scaled_times
pasapas_scaled_times:
    call #scaled_split
    add.b r15, r11
    swpb r15
    mov.b r15, r15
    sub.b #105, r11
    push r10
    push r9
    push r11
    /* the product of 48 bits down by 23 */
    rla r12
    rlc r13
    mov #24, r9
    call #pasapas_product_bits
scaled_restore:
    mov r10, r12
    mov r11, r13
    pop r11
    pop r9
    pop r10
    jmp scaled_close

    .global pasapas_scaled_over
pasapas_scaled_over:
    tst r15
    jeq scaled_most
    call #scaled_split
    sub.b r15, r11
    swpb r15
    mov.b r15, r15
    add.b #104, r11
    push r10
    push r9
    push r11
    /* a quotient of 24 or 25 bits */
    clr r10
    clr r11
    mov #25, r9
1:  sub r14, r12
    subc r15, r13
    jc 2f
    add r14, r12
    addc r15, r13
    clrc
2:  rlc r10
    rlc r11
    rla r12
    rlc r13
    dec r9
    jne 1b
    jmp scaled_restore

    .global pasapas_scaled_plus
pasapas_scaled_plus:
    cmp r15, r13
    jlo 1f
    call #pasapas_swap
1:  call #scaled_align
    add r14, r12
    addc r15, r13
    jmp scaled_close

    .global pasapas_scaled_minus
pasapas_scaled_minus:
    call #scaled_compare
    jlo scaled_zero
    call #pasapas_swap
    call #scaled_align
    sub r12, r14
    subc r13, r15
    mov r14, r12
    mov r15, r13
    jmp scaled_close

    .global pasapas_scaled_new
pasapas_scaled_new:
    mov #128, r11
    /* r13:r12 times 2^(r11 - 128) */
scaled_close:
    tst r13
    jne 2f
    tst r12
    jne 4f
scaled_end:
    ret
1:  clrc
    rrc r13
    rrc r12
    inc.b r11
2:  cmp #0x100, r13
    jhs 1b
    jmp 4f
3:  rla r12
    rlc r13
    dec.b r11
4:  bit #0x80, r13
    jeq 3b
    swpb r11
    bis r11, r13
    ret

    /* Splits both. The mantissa of the left one, which is smaller, goes down by the gap of the exponents;
       the right one's exponent is in r11. */
scaled_align:
    call #scaled_split
scaled_down:
    /* nothing goes down by any gap */
    tst r13
    jne 2f
    mov.b r15, r11
    jmp 2f
1:  rra r13
    rrc r12
    inc r11
2:  cmp.b r15, r11
    jne 1b
    swpb r15
    mov.b r15, r15
    ret

    .global pasapas_scaled_floor
pasapas_scaled_floor:
    call #scaled_split
    cmp #136, r11
    jhs 4f
    /* from 31 bits down */
    mov #7, r14
3:  rla r12
    rlc r13
    dec r14
    jne 3b
    mov #135, r15
    jmp scaled_down
4:  mov #-1, r12
    mov #0x7fff, r13
    ret

    .global pasapas_scaled_root
pasapas_scaled_root:
    call #scaled_split
    push r9
    push r8
    /* What is left of the radicand in r13:r12, twice the root in r15:r14, the root's next bit in r9:r8:
       2^25 is 1. An even power of two leaves the exponent. */
    add #101, r11
    rra r11
    jnc 1f
    rla r12
    rlc r13
1:  clr r14
    clr r15
    clr r8
    mov #0x100, r9
2:  rla r12
    rlc r13
    bis r8, r14
    bis r9, r15
    sub r14, r12
    subc r15, r13
    jc 3f
    add r14, r12
    addc r15, r13
    bic r8, r14
    bic r9, r15
    jmp 4f
3:  add r8, r14
    addc r9, r15
4:  clrc
    rrc r9
    rrc r8
    jnc 2b
    mov r14, r12
    mov r15, r13
    pop r8
    pop r9
    jmp scaled_close

scaled_zero:
    clr r12
    clr r13
    ret
scaled_most:
    mov #-1, r12
    mov #-1, r13
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
