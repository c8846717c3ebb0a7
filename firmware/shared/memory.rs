//! What the compiler calls to copy and to fill memory, in assembly: there is no libgcc in the link.
//!
//! Registers are those of TI's EABI (SLAA534, section 6), as in `math.rs`.

use core::arch::global_asm;

global_asm!(
    r#"
    .section .text.memcpy,"ax",@progbits
module.math$memcpy:
    .global memcpy
    /* r12 to, r13 from, r14 bytes; returns r12 */
memcpy:
    mov r12, r15
    bit #1, r12
    jne 2f
    bit #1, r13
    jne 2f
    .if {roomy}
    /* four words at a time: mov @r13+, n(r15) */
    jmp 6f
5:  .short 0x4dbf, 0, 0x4dbf, 2, 0x4dbf, 4, 0x4dbf, 6
    add #8, r15
6:  sub #8, r14
    jc 5b
    add #8, r14
    .endif
    /* words as long as there are two bytes, and both ends are even */
    jmp 4f
3:  mov @r13+, r11
    mov r11, 0(r15)
    incd r15
4:  decd r14
    jc 3b
    incd r14
    jmp 2f
1:  mov.b @r13+, r11
    mov.b r11, 0(r15)
    inc r15
    dec r14
2:  tst r14
    jne 1b
    ret

    .section .text.memmove,"ax",@progbits
module.math$memmove:
    .global memmove
    /* as memcpy; from the end when the places overlap that way */
memmove:
    cmp r13, r12
    jlo memcpy
    mov r12, r15
    add r14, r15
    add r14, r13
    jmp 2f
1:  dec r13
    dec r15
    mov.b @r13, r11
    mov.b r11, 0(r15)
    dec r14
2:  tst r14
    jne 1b
    ret

    .section .text.memset,"ax",@progbits
module.math$memset:
    .global memset
memset:
    mov r12, r15
    .if {roomy}
    /* words, of an even place */
    bit #1, r12
    jne 2f
    mov.b r13, r13
    mov r13, r11
    swpb r11
    bis r13, r11
    jmp 4f
3:  mov r11, 0(r15)
    incd r15
4:  decd r14
    jc 3b
    incd r14
    .endif
    jmp 2f
1:  mov.b r13, 0(r15)
    inc r15
    dec r14
2:  tst r14
    jne 1b
    ret
    "#,
    roomy = const cfg!(feature = "f5529") as u8,
);
