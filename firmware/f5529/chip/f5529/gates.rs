//! Calls from compiled functions above 64 KB to assembly below it (see `firmware/far`): `CALLA` to the gate,
//! `CALL` from there, and back by `RETA`, which the assembler does not know.
//!
//! Arguments on the stack are pushed once more. The linker drops gates that nothing calls. `f5529/scaled.rs` needs none.

core::arch::global_asm!(
    r#"
    .macro gates names:vararg
    .irp name, \names
    .section .text.gate.\name,"ax",@progbits
    .global gate.\name
gate.\name:
    call #\name
    .short 0x0110
    .endr
    .endm

    gates memcpy, memmove, memset, memcmp
    gates __mspabi_mpyi, __mspabi_mpyl
    gates __mspabi_divu, __mspabi_remu, __mspabi_divul, __mspabi_remul, __mspabi_divli, __mspabi_remli
    gates __mspabi_slll, __mspabi_srll, __mspabi_sral, __mspabi_slli, __mspabi_srli, __mspabi_srai
    gates pasapas_fraction, pasapas_high, pasapas_crc16, pasapas_crc16_word, pasapas_verify, pasapas_vm_run, pasapas_flash

    .section .text.gate.pasapas_mul_div,"ax",@progbits
    .global gate.pasapas_mul_div
gate.pasapas_mul_div:
    mov 6(r1), r11
    push r11
    mov 6(r1), r11
    push r11
    call #pasapas_mul_div
    add #4, r1
    .short 0x0110

    .section .text.gate.pasapas_observe,"ax",@progbits
    .global gate.pasapas_observe
gate.pasapas_observe:
    mov 4(r1), r11
    push r11
    call #pasapas_observe
    incd r1
    .short 0x0110
    "#
);
