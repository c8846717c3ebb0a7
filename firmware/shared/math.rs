//! The compiler's run-time helpers, in assembly: there is no libgcc in the link.
//!
//! Names and registers are those of TI's EABI (SLAA534, section 6): 16-bit operands in r12 and
//! r13, 32-bit operands in r13:r12 and r15:r14, result in r12 or r13:r12; r11 to r15 are free to
//! use, r4 to r10 are kept. Division by zero yields all ones, the caller tests before.

use core::arch::global_asm;

global_asm!(
    r#"
    .section .text.mspabi_mul,"ax",@progbits
module.math$mspabi_mul:
    .global __mspabi_mpyi
__mspabi_mpyi:
    .if {multiplier}
    /* MPY, OP2, RESLO */
    mov r12, &0x04c0
    mov r13, &0x04c8
    mov &0x04ca, r12
    ret
    .else
    mov r12, r14
    clr r12
    jmp 3f
1:  add r14, r12
2:  rla r14
3:  clrc
    rrc r13
    jc 1b
    jne 2b
    ret
    .endif

    .section .text.mspabi_mull,"ax",@progbits
module.math$mspabi_mull:
    .global __mspabi_mpyl
__mspabi_mpyl:
    .if {multiplier}
    mov r12, &0x04d0
    mov r13, &0x04d2
    mov r14, &0x04e0
    mov r15, &0x04e2
    mov &0x04e4, r12
    mov &0x04e6, r13
    ret
    .else
    push r10
    mov r12, r10
    mov r13, r11
    clr r12
    clr r13
    jmp 3f
1:  add r10, r12
    addc r11, r13
2:  rla r10
    rlc r11
3:  clrc
    rrc r15
    rrc r14
    jc 1b
    jne 2b
    tst r15
    jne 2b
    pop r10
    ret
    .endif

    .section .text.mspabi_div,"ax",@progbits
module.math$mspabi_div:
    .global __mspabi_remu
__mspabi_remu:
    call #__mspabi_divu
    mov r14, r12
    ret
    .global __mspabi_divu
__mspabi_divu:
    clr r14
    mov #16, r15
1:  rla r12
    rlc r14
    jc 2f
    cmp r13, r14
    jlo 3f
2:  sub r13, r14
    bis #1, r12
3:  dec r15
    jne 1b
    ret

    .section .text.mspabi_divl,"ax",@progbits
module.math$mspabi_divl:
    .global __mspabi_divul
__mspabi_divul:
    push r9
    push r10
    call #pasapas_udivmod
    pop r10
    pop r9
    ret

    .section .text.mspabi_reml,"ax",@progbits
module.math$mspabi_reml:
    .global __mspabi_remul
__mspabi_remul:
    push r9
    push r10
    call #pasapas_udivmod
    mov r10, r12
    mov r11, r13
    pop r10
    pop r9
    ret

    .section .text.mspabi_divls,"ax",@progbits
module.math$mspabi_divls:
    .global __mspabi_divli
__mspabi_divli:
    push r8
    mov r13, r8
    xor r15, r8
    call #pasapas_abs2
    call #__mspabi_divul
pasapas_sign:
    rla r8
    pop r8
    jnc 1f
    br #pasapas_neg
1:  ret

    .global __mspabi_remli
__mspabi_remli:
    push r8
    mov r13, r8
    call #pasapas_abs2
    call #__mspabi_remul
    jmp pasapas_sign

    .section .text.sign,"ax",@progbits
module.math$sign:
    /* magnitudes of r13:r12 and r15:r14: twice they change places and what is first loses its sign */
pasapas_abs2:
    call #1f
1:  call #pasapas_swap
    /* |r13:r12| */
pasapas_abs:
    tst r13
    jge 1f
    /* -(r13:r12) */
pasapas_neg:
    inv r12
    inv r13
    inc r12
    adc r13
1:  ret

    .section .text.mspabi_sll,"ax",@progbits
module.math$mspabi_sll:
    .global __mspabi_slll
1:  rla r12
    rlc r13
    dec r14
__mspabi_slll:
    tst r14
    jne 1b
    ret

    .section .text.mspabi_srl,"ax",@progbits
module.math$mspabi_srl:
    .global __mspabi_srll
1:  clrc
    rrc r13
    rrc r12
    dec r14
__mspabi_srll:
    tst r14
    jne 1b
    ret

    .section .text.mspabi_sra,"ax",@progbits
module.math$mspabi_sra:
    .global __mspabi_sral
1:  rra r13
    rrc r12
    dec r14
__mspabi_sral:
    tst r14
    jne 1b
    ret

    .section .text.mspabi_sli,"ax",@progbits
module.math$mspabi_sli:
    .global __mspabi_slli
1:  rla r12
    dec r13
__mspabi_slli:
    tst r13
    jne 1b
    ret

    .section .text.mspabi_sri,"ax",@progbits
module.math$mspabi_sri:
    .global __mspabi_srli
1:  clrc
    rrc r12
    dec r13
__mspabi_srli:
    tst r13
    jne 1b
    ret

    .section .text.mspabi_srai,"ax",@progbits
module.math$mspabi_srai:
    .global __mspabi_srai
1:  rra r12
    dec r13
__mspabi_srai:
    tst r13
    jne 1b
    ret

    .section .text.mul_div,"ax",@progbits
module.math$mul_div:
    .global pasapas_mul_div
    /* r13:r12 times r15:r14 over the long on the stack, rounded down, all ones if it does not
       fit; 450 cycles for the product, 500 for the quotient */
pasapas_mul_div:
    push r10
    push r9
    call #pasapas_product
    mov 6(r1), r12
    mov 8(r1), r13
    jmp pasapas_quotient

    /* r13:r12 times r15:r14: high half in r11:r10, low half in r15:r14; uses r9 */
pasapas_product:
    .if {multiplier}
    /* MPY32L, MPY32H, OP2L, OP2H; RES0 to RES3 are ready in time in this order (SLAU208, 25.2). No
       interrupt uses it: its state cannot be saved (erratum MPY1). */
    mov r12, &0x04d0
    mov r13, &0x04d2
    mov r14, &0x04e0
    mov r15, &0x04e2
    mov &0x04e4, r14
    mov &0x04e6, r15
    mov &0x04e8, r10
    mov &0x04ea, r11
    ret
    .else
    mov #32, r9
    /* r11:r10 = r13:r12 times the r9 low bits of r15:r14, down by r9 */
pasapas_product_bits:
    clr r10
    clr r11
1:  bit #1, r14
    jeq 2f
    add r12, r10
    addc r13, r11
2:  rrc r11
    rrc r10
    rrc r15
    rrc r14
    dec r9
    jne 1b
    ret
    .endif

    .global pasapas_fraction
    /* r13:r12 times 2^32 over r15:r14 */
pasapas_fraction:
    push r10
    push r9
    mov r12, r10
    mov r13, r11
    mov r14, r12
    mov r15, r13
    clr r14
    clr r15
pasapas_quotient:
    cmp r13, r11
    jlo 1f
    jne 2f
    cmp r12, r10
    jhs 2f
1:  call #pasapas_divide
3:  pop r9
    pop r10
    ret
2:  mov #-1, r12
    mov #-1, r13
    jmp 3b

    /* r13:r12 over r15:r14: quotient in r13:r12, remainder in r11:r10; uses r9, r14, r15 */
pasapas_udivmod:
    call #pasapas_swap
    clr r10
    clr r11
    /* the same of r11:r10:r15:r14 over r13:r12 */
pasapas_divide:
    .if {roomy}
    /* by 15 bits a word of the quotient at a time, the upper one only where there is one */
    tst r13
    jne 4f
    tst r12
    jn 4f
    tst r10
    jne 5f
    cmp r12, r15
    jhs 5f
    mov r15, r10
    clr r15
    jmp 6f
5:  call #pasapas_word
6:  mov r15, r13
    mov r14, r15
    push r13
    call #pasapas_word
    mov r15, r12
    pop r13
    ret
    /* r10:r15 over r12: 16 bits of quotient in r15, remainder in r10; uses r9 */
pasapas_word:
    mov #4, r9
7:  .rept 4
    rla r15
    rlc r10
    cmp r12, r10
    jlo 8f
    sub r12, r10
    inc r15
8:
    .endr
    dec r9
    jne 7b
    ret
4:
    .endif
    mov #32, r9
1:  rla r14
    rlc r15
    rlc r10
    rlc r11
    jc 2f
    cmp r13, r11
    jlo 3f
    jne 2f
    cmp r12, r10
    jlo 3f
2:  sub r12, r10
    subc r13, r11
    bis #1, r14
3:  dec r9
    jne 1b
    mov r14, r12
    mov r15, r13
    ret

    /* r13:r12 and r15:r14 change places */
pasapas_swap:
    xor r12, r14
    xor r14, r12
    xor r12, r14
    xor r13, r15
    xor r15, r13
    xor r13, r15
    ret

    .section .text.high,"ax",@progbits
module.math$high:
    .global pasapas_high
    /* high half of r13:r12 times r15:r14 */
pasapas_high:
    push r10
    push r9
    call #pasapas_product
    mov r10, r12
    mov r11, r13
    pop r9
    pop r10
    ret

    .section .text.crc16,"ax",@progbits
module.math$crc16:
    .global pasapas_crc16
    /* r12 CRC, r13 byte (high byte 0) */
pasapas_crc16:
    xor r13, r12
    .if {roomy}
    /* four bits at a time, 24 cycles; rrum.w #4, r12 is 0f5c (SLAU208, 6.6.3) */
    mov r12, r14
    and #15, r14
    rla r14
    .short 0x0f5c
    xor crc16_steps(r14), r12
    mov r12, r14
    and #15, r14
    rla r14
    .short 0x0f5c
    xor crc16_steps(r14), r12
    ret
    /* r12 CRC, r13 word, high byte first */
    .global pasapas_crc16_word
pasapas_crc16_word:
    mov r13, r15
    swpb r13
    and #0xff, r13
    and #0xff, r15
    call #pasapas_crc16
    mov r15, r13
    jmp pasapas_crc16

    .section .rodata.crc16,"a",@progbits
module.math$crc16_steps:
    .balign 2
    /* what four zero bits make of a CRC of 0 to 15 */
crc16_steps:
    .short 0x0000, 0xcc01, 0xd801, 0x1400, 0xf001, 0x3c00, 0x2800, 0xe401
    .short 0xa001, 0x6c00, 0x7800, 0xb401, 0x5000, 0x9c01, 0x8801, 0x4400
    .else
    /* 8 rounds of 9 cycles at most */
    mov #8, r14
1:  clrc
    rrc r12
    jnc 2f
    xor #0xa001, r12
2:  dec r14
    jne 1b
    ret
    .endif
    "#,
    multiplier = const cfg!(feature = "f5529") as u8,
    roomy = const cfg!(feature = "f5529") as u8,
);

#[cfg(feature = "f5529")]
unsafe extern "C" {
    fn pasapas_crc16(crc: u16, byte: u16) -> u16;
    fn pasapas_crc16_word(crc: u16, word: u16) -> u16;
    fn pasapas_mul_div(a: u32, b: u32, c: u32) -> u32;
}

/// `a * b / c`, rounded down, all ones if it does not fit; twin of `firmware::motion::math::mul_div`.
#[cfg(feature = "f5529")]
#[inline(always)]
pub fn mul_div(a: u32, b: u32, c: u32) -> u32 {
    // SAFETY: a pure function of its arguments.
    unsafe { pasapas_mul_div(a, b, c) }
}

/// The assembly twin of [`lang::wire::crc16`].
#[cfg(feature = "f5529")]
#[inline(always)]
pub fn crc16(crc: u16, byte: u8) -> u16 {
    // SAFETY: a pure function of its register arguments.
    unsafe { pasapas_crc16(crc, u16::from(byte)) }
}

/// The same of a word, high byte first.
#[cfg(feature = "f5529")]
#[inline(always)]
pub fn crc16_word(crc: u16, word: u16) -> u16 {
    // SAFETY: a pure function of its register arguments.
    unsafe { pasapas_crc16_word(crc, word) }
}
