//! The VM's core in assembly: token threading, 32-bit operations with overflow checks.
//!
//! Its twin is `lang::vm`; the opcode table is `lang::isa`. The core runs the pure instructions
//! that are worth their bytes here and leaves with the code of everything else: effects, and the
//! few pure instructions that the main loop does in Rust (`vm.rs`).
//!
//! | register | holds |
//! |---|---|
//! | r4 | address of the code in flash |
//! | r5 | next instruction |
//! | r6 | expression stack, growing down; the value below the top |
//! | r7 | cells |
//! | r11:r10 | top of the expression stack |
//! | r8, r9, r12 to r15 | scratch |
//!
//! With n values on the stack r6 is `4 n` below its end: the lowest slot holds what was in r11:r10
//! when the stack was empty. So a stack of depth d needs d slots.
//!
//! Cycles (with the dispatch of 10): add 18, load 24, store 27, small constant 27, `nextbyte` 44.

use crate::vm::{CALLS, CALLS_END_AT, FRAME_AT, SAVES, State, VM};
use ::core::arch::global_asm;
use ::core::mem::offset_of;
use lang::isa::Op;

/// What [`run`] returns when the slice is used up.
pub const YIELD: u16 = 0x200;
/// What [`run`] returns when an event handler was left.
pub const HANDLER_END: u16 = 0x300;

#[cfg(feature = "g2955")]
unsafe extern "C" {
    fn pasapas_vm_run() -> u16;
}

/// Runs until an instruction that the core leaves to its caller (its code is returned), a fault,
/// whose number is returned plus 100
/// hexadecimal, or the poll flag at a backward jump or a call.
#[cfg(feature = "g2955")]
pub fn run() -> u16 {
    // SAFETY: the state in `VM` was made by `vm.rs` for a verified program, so every address that
    // the core forms lies in the pool or in the program.
    unsafe { pasapas_vm_run() }
}

// Operands are fetched byte by byte, nothing is aligned. `vm_next` lies in the middle: a jump
// reaches 1 KB either way.
global_asm!(
    r#"
    .section .text.vm,"ax",@progbits
module.vm:

    /* r13 = address of the cell that the operand names */
    .macro CELL_HERE
    mov.b @r5+, r13
    rla r13
    rla r13
    add r7, r13
    .endm
    .macro CELL
    .if {small}
    call #vm_cell
    .else
    CELL_HERE
    .endif
    .endm
    /* r12 = signed distance operand */
    .macro REL
    mov.b @r5+, r12
    sxt r12
    .endm
    /* r12 = 16-bit operand, r13 lost */
    .macro WORD_HERE
    mov.b @r5+, r12
    mov.b @r5+, r13
    swpb r13
    bis r13, r12
    .endm
    .macro WORD
    .if {small}
    call #vm_operand
    .else
    WORD_HERE
    .endif
    .endm
    .macro POP
    mov @r6+, r10
    mov @r6+, r11
    .endm
    /* a jump whose target only the smaller core has within 1 KB */
    .macro FAR target
    .if {small}
    jmp \target
    .else
    br #\target
    .endif
    .endm
    .macro NEXT_HERE
    mov.b @r5+, r12
    rla.b r12
    jc vm_high
    jn vm_mid
    br vm_table(r12)
    .endm
    /* the next instruction; where it ends a frequent one it saves the jump to vm_next, 2 cycles */
    .macro NEXT
    .if {small}
    jmp vm_next
    .else
    NEXT_HERE
    .endif
    .endm

    .global pasapas_vm_run
pasapas_vm_run:
    .if {saves}
    push r4
    push r5
    push r6
    push r7
    push r8
    push r9
    push r10
    .endif
    mov #{vm}, r12
    mov @r12+, r5
    mov @r12+, r6
    mov @r12+, r10
    mov @r12+, r11
    mov @r12+, r4
    mov @r12+, r7
    mov r1, &{vm}+{frame}
    FAR vm_next

    /* faults: codes 0x100 + number */
vm_f01:
    mov #0x101, r12
    jmp vm_exit
vm_f02:
    mov #0x102, r12
    jmp vm_exit
vm_f03:
    mov #0x103, r12
    jmp vm_exit
vm_f04:
    mov #0x104, r12
    jmp vm_exit
vm_f16:
    mov #0x110, r12
    jmp vm_exit
vm_f20:
    mov #0x114, r12
    jmp vm_exit
vm_yield:
    mov #{yield_code}, r12
    jmp vm_exit
vm_soft:
    rra r12
vm_exit:
    mov #{vm}, r13
    mov r5, 0(r13)
    mov r6, 2(r13)
    mov r10, 4(r13)
    mov r11, 6(r13)
    .if {saves}
    pop r10
    pop r9
    pop r8
    pop r7
    pop r6
    pop r5
    pop r4
    .endif
    ret

    /* --- arithmetic that is rare or slow --- */
vm_mul:
    mov @r6+, r12
    mov @r6+, r13
    mov r10, r14
    mov r11, r15
    mov r13, r8
    xor r15, r8
    call #pasapas_abs2
    call #pasapas_product
    bis r11, r10
    tst r10
    jne vm_f01
    mov r14, r12
    mov r15, r13
    tst r8
    jge 1f
    call #pasapas_neg
    tst r13
    jl vm_set
    bis r12, r13
    tst r13
    jne vm_f01
    jmp vm_set
1:  tst r13
    jl vm_f01
    jmp vm_set

vm_div:
    call #vm_divide
    call #__mspabi_divli
    /* only the least number over -1 has a negative quotient of equal signs */
    tst r9
    jl vm_set
    tst r13
    jl vm_f01
    jmp vm_set
vm_mod:
    call #vm_divide
    call #__mspabi_remli
    jmp vm_set
vm_divide:
    mov r10, r14
    bis r11, r14
    tst r14
    jne 1f
    incd r1
    jmp vm_f02
1:  mov @r6+, r12
    mov @r6+, r13
    mov r10, r14
    mov r11, r15
    mov r13, r9
    xor r15, r9
    ret

    /* digit by digit: root in r13:r12, its next bit in r15:r14, the rest in r11:r10 */
vm_sqr:
    tst r11
    jl vm_f20
    clr r12
    clr r13
    clr r14
    mov #0x4000, r15
1:  mov r12, r8
    mov r13, r9
    add r14, r8
    addc r15, r9
    clrc
    rrc r13
    rrc r12
    cmp r9, r11
    jlo 3f
    jne 2f
    cmp r8, r10
    jlo 3f
2:  sub r8, r10
    subc r9, r11
    add r14, r12
    addc r15, r13
3:  clrc
    rrc r15
    rrc r14
    rra r15
    rrc r14
    mov r14, r8
    bis r15, r8
    tst r8
    jne 1b
    jmp vm_set

vm_shl:
    call #vm_count
    call #__mspabi_slll
    jmp vm_set
vm_shr:
    call #vm_count
    call #__mspabi_sral
    jmp vm_set
vm_count:
    tst r11
    jne 1f
    cmp #32, r10
    jhs 1f
    mov @r6+, r12
    mov @r6+, r13
    mov r10, r14
    ret
1:  incd r1
    jmp vm_f04

vm_sgn:
    tst r11
    jl 1f
    bis r11, r10
    clr r11
    tst r10
    jeq vm_to_next
    mov #1, r10
    jmp vm_to_next
1:  mov #-1, r10
    mov #-1, r11
    jmp vm_to_next
vm_abs:
    tst r11
    jge vm_to_next
vm_neg:
    inv r10
    inv r11
    inc r10
    adc r11
    bit #0x100, r2
    jne vm_f01
    jmp vm_to_next

vm_min:
    call #vm_compare
    jl vm_take_left
    jmp vm_to_next
vm_max:
    call #vm_compare
    jl vm_to_next
vm_take_left:
    mov r8, r10
    mov r9, r11
    jmp vm_to_next
    /* left in r9:r8, popped; flags as of left less right; the top stays right */
vm_compare:
    mov @r6+, r8
    mov @r6+, r9
    mov r8, r12
    mov r9, r13
    sub r10, r12
    subc r11, r13
    ret

    /* --- constants --- */
vm_minus:
    mov.b @r5+, r12
    inv r12
    mov #-1, r13
    jmp vm_push
vm_tens:
    mov.b @r5+, r12
    clr r13
    mov #10, r14
    jmp vm_scaled
vm_hundreds:
    mov #100, r14
    REL
    jmp 2f
vm_thousands:
    call #vm_thousand
    FAR vm_next
    /* pushes 1000 times the operand byte */
vm_thousand:
    REL
    /* 125 x = 128 x - 3 x fits into 16 bits; three shifts make it 1000 x */
    mov.b r12, r13
    swpb r13
    rra r13
    sub r12, r13
    sub r12, r13
    sub r12, r13
    mov r13, r12
    clr r13
    tst r12
    jge 1f
    inv r13
1:  rla r12
    rlc r13
    rla r12
    rlc r13
    rla r12
    rlc r13
    sub #4, r6
    mov r10, 0(r6)
    mov r11, 2(r6)
    mov r12, r10
    mov r13, r11
    ret
vm_wordtens:
    mov #10, r14
    WORD
2:  clr r13
    tst r12
    jge vm_scaled
    inv r13
vm_scaled:
    push r11
    clr r15
    call #__mspabi_mpyl
    pop r11
    jmp vm_push
vm_word:
    WORD
    jmp 1f
vm_triple:
    WORD
    mov.b @r5+, r13
    sxt r13
    jmp vm_push
vm_long:
    WORD
    mov.b @r5+, r13
    mov.b @r5+, r14
    swpb r14
    bis r14, r13
    jmp vm_push
1:  clr r13
    tst r12
    jge vm_push
    inv r13
    jmp vm_push

vm_set:
    mov r12, r10
    mov r13, r11
vm_to_next:
    jmp vm_next

    /* --- arrays --- */
vm_loadelem:
    call #vm_element
    mov @r13+, r10
    mov @r13, r11
    jmp vm_next
vm_storeelem:
    mov r10, r8
    mov r11, r9
    POP
    call #vm_element
    mov r8, 0(r13)
    mov r9, 2(r13)
    POP
    jmp vm_next
vm_element:
    mov.b @r5+, r13
    mov.b @r5+, r12
    tst r11
    jne 1f
    cmp r12, r10
    jhs 1f
    add r10, r13
    rla r13
    rla r13
    add r7, r13
    ret
1:  incd r1
    FAR vm_f03

    /* --- the hot middle --- */
vm_high:
    rla.b r12
    jc vm_effect
    jn vm_inline
    bit #0x40, r12
    jne vm_store
vm_load:
    add r7, r12
    sub #4, r6
    mov r10, 0(r6)
    mov r11, 2(r6)
    mov @r12+, r10
    mov @r12, r11
    NEXT_HERE
vm_loadfar:
    mov.b @r5+, r12
    rla r12
    rla r12
    jmp vm_load
vm_effect:
    bis #0x100, r12
1:  rra r12
    rra r12
    bis #0x80, r12
    jmp vm_exit_far
    /* effects below 0xC0: the first sixteen bring whole thousands */
vm_inline:
    cmp #4*0x30, r12
    jhs 1b
    rra r12
    mov vm_inlines-0x40(r12), r8
    mov r8, r9
    swpb r9
    mov.b r9, r9
1:  call #vm_thousand
    dec r9
    jne 1b
    mov.b r8, r12
    jmp vm_exit_far
vm_storefar:
    mov.b @r5+, r12
    rla r12
    rla r12
    jmp 1f
vm_store:
    and #0x3f, r12
1:  add r7, r12
    mov r10, 0(r12)
    mov r11, 2(r12)
    POP
    NEXT_HERE
vm_addcell:
    CELL_HERE
    add @r13+, r10
    addc @r13, r11
    bit #0x100, r2
    jeq vm_next
    br #vm_f01
vm_add:
    add @r6+, r10
    addc @r6+, r11
    bit #0x100, r2
    jeq vm_next
    FAR vm_f01
vm_sub:
    mov @r6+, r12
    mov @r6+, r13
    sub r10, r12
    subc r11, r13
    bit #0x100, r2
    jeq vm_set
    FAR vm_f01
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
vm_not:
    inv r10
    inv r11
    jmp vm_next
vm_iszero:
    bis r10, r11
    clr r10
    tst r11
    jne 1f
    mov #1, r10
1:  clr r11
    jmp vm_next
vm_mid:
    cmp.b #0xc0, r12
    jhs 1f
    br vm_table(r12)
1:  rra r12
    bit #0x10, r12
    jne vm_skip
    and #15, r12
    jmp vm_push_u
vm_byte:
    mov.b @r5+, r12
vm_push_u:
    clr r13
vm_push:
    sub #4, r6
    mov r10, 0(r6)
    mov r11, 2(r6)
    mov r12, r10
    mov r13, r11
vm_next:
    NEXT_HERE
    .if {small}
vm_operand:
    WORD_HERE
    ret
vm_cell:
    CELL_HERE
    ret
    .endif

vm_drop:
    POP
    jmp vm_next

    /* --- jumps --- */
vm_skip:
    and #15, r12
    inc r12
    jmp vm_jump_zero
vm_jumpzero:
    REL
vm_jump_zero:
    bis r10, r11
    tst r11
    mov @r6+, r10
    mov @r6+, r11
    jeq vm_take
    jmp vm_next
vm_jumpnonzero:
    REL
    bis r10, r11
    tst r11
    mov @r6+, r10
    mov @r6+, r11
    jne vm_take
    jmp vm_next
vm_jump:
    REL
vm_take:
    add r12, r5
    tst r12
    jge vm_next
vm_poll:
    tst.b &{vm}+{poll}
    jeq vm_next
    FAR vm_yield
vm_jumpfar:
    WORD
    mov r12, r5
    add r4, r5
    jmp vm_poll
vm_exit_far:
    FAR vm_exit

    /* comparisons: outcome 1 less, 2 equal, 4 greater, against the mask of the code */
vm_compare_jump:
    call #vm_outcome
    REL
    bit r15, r14
    jne vm_take
    jmp vm_next
vm_compare_value:
    call #vm_outcome
    sub #4, r6
    mov r10, 0(r6)
    mov r11, 2(r6)
    clr r10
    clr r11
    bit r15, r14
    adc r10
    jmp vm_next
vm_outcome:
    rra r12
    mov.b vm_masks-0x24(r12), r14
    call #vm_compare
    mov #1, r15
    jl 1f
    bis r12, r13
    tst r13
    mov #2, r15
    jeq 1f
    mov #4, r15
1:  mov @r6+, r10
    mov @r6+, r11
    ret

vm_andalso:
    WORD
    bis r10, r11
    tst r11
    jne 1f
    jmp 2f
vm_orelse:
    WORD
    bis r10, r11
    tst r11
    jeq 1f
    mov #1, r10
2:  clr r11
    mov r12, r5
    add r4, r5
    jmp vm_next
1:  POP
    jmp vm_next

    /* --- loops: r13 the cell, the limit on the stack --- */
vm_for:
    CELL
    REL
    call #vm_cell_against_top
    POP
    jl vm_take
    jmp vm_next
vm_next_one:
    CELL
    REL
    add #1, 0(r13)
    adc 2(r13)
    bit #0x100, r2
    jne vm_undo_inc
    call #vm_cell_against_top
    POP
    jge vm_take
    jmp vm_next
vm_nextshort:
    mov.b @r5+, r13
    mov r13, r14
    rra r14
    rra r14
    rra r14
    rra r14
    and #15, r13
    rla r13
    rla r13
    add r7, r13
    jmp 1f
vm_nextword:
    CELL_HERE
    mov.b @r5+, r14
    mov.b @r5+, r15
    swpb r15
    bis r15, r14
    clr r9
    tst r14
    jge 2f
    inv r9
    jmp 2f
vm_nextbyte:
    CELL_HERE
    mov.b @r5+, r14
1:  clr r9
    /* r9:r14 = the limit */
2:  REL
    add #1, 0(r13)
    adc 2(r13)
    bit #0x100, r2
    jne vm_undo_inc
    sub @r13+, r14
    subc @r13, r9
    jl vm_loop_left
    add r12, r5
    tst.b &{vm}+{poll}
    jne vm_loop_polled
    NEXT_HERE
vm_loop_polled:
    br #vm_yield
vm_loop_left:
    FAR vm_next
    /* F01 leaves the cell as it was */
vm_undo_inc:
    sub #1, 0(r13)
    sbc 2(r13)
    jmp 1f
vm_undo_dec:
    add #1, 0(r13)
    adc 2(r13)
    jmp 1f
vm_undo_add:
    sub r10, 0(r13)
    subc r11, 2(r13)
1:  br #vm_f01
    /* flags as of top less cell: less means that the cell lies above */
vm_cell_against_top:
    mov r10, r14
    mov r11, r15
    sub @r13+, r14
    subc @r13, r15
    ret

vm_forstep:
    CELL
    REL
    mov r10, r8
    bis r11, r8
    tst r8
    jne 1f
    br #vm_f20
1:  call #vm_beyond
    jl vm_take
    jmp vm_next
vm_nextstep:
    CELL
    REL
    add r10, 0(r13)
    addc r11, 2(r13)
    bit #0x100, r2
    jne vm_undo_add
    call #vm_beyond
    jge vm_take
    jmp vm_next
    /* step on the top, limit below: both popped; less means that the cell lies beyond */
vm_beyond:
    mov @r6+, r14
    mov @r6+, r15
    mov @r13+, r8
    mov @r13, r9
    tst r11
    mov @r6+, r10
    mov @r6+, r11
    jl 1f
    sub r8, r14
    subc r9, r15
    ret
1:  sub r14, r8
    subc r15, r9
    ret
vm_repeat:
    CELL
    REL
    mov @r13+, r14
    mov @r13, r15
    sub #1, r14
    sbc r15
    jl 1f
    mov r14, r8
    bis r15, r8
    tst r8
    jeq 1f
    mov r15, 0(r13)
    mov r14, -2(r13)
    jmp vm_take_far
1:  FAR vm_next
vm_take_far:
    FAR vm_take

vm_inc:
    CELL
1:  add #1, 0(r13)
    adc 2(r13)
    bit #0x100, r2
    jne vm_undo_inc
    FAR vm_next
vm_dec:
    CELL
    sub #1, 0(r13)
    sbc 2(r13)
    bit #0x100, r2
    jne vm_undo_dec
    FAR vm_next
vm_addto:
    CELL
    add r10, 0(r13)
    addc r11, 2(r13)
    bit #0x100, r2
    jne vm_undo_add
    POP
    FAR vm_next
    /* r12 is twice the code */
vm_incshort:
    sub #2*{incshort}, r12
    rla r12
    mov r12, r13
    add r7, r13
    jmp 1b
vm_zero:
    sub #2*{zero}, r12
    rla r12
    add r7, r12
    clr 0(r12)
    clr 2(r12)
    FAR vm_next
vm_dup:
    mov r10, r12
    mov r11, r13
    FAR vm_push
vm_over:
    mov @r6, r12
    mov 2(r6), r13
    FAR vm_push
    .if {has_events}
vm_more:
    bis.b #{more}, &{vm}+{flags}
    FAR vm_next
    .else
    .set vm_more, vm_next
    .endif
vm_check:
    tst r11
    jl 1f
    mov @r6+, r12
    mov @r6+, r13
    tst r13
    jl 1f
    cmp r11, r13
    jl 2f
    jne 1f
    cmp r10, r12
    jhs 1f
2:  br #vm_set
1:  br #vm_f03

    /* --- calls: an entry is 12 bits of return address and 4 of kind --- */
vm_call:
    mov.b @r5+, r12
    jmp 1f
vm_callfar:
    WORD
1:  mov #{kind_sub}, r14
    jmp vm_enter
vm_func:
    mov.b @r5+, r12
    jmp 1f
vm_funcfar:
    WORD
1:  mov &{vm}+{base}, r14
    mov r6, &{vm}+{base}
    sub r6, r14
    /* depth times 4 into the bits above 12, with the FUNCTION bit */
    swpb r14
    rla r14
    rla r14
    bis #0x8000, r14
    jmp vm_enter
vm_gosub:
    REL
    add r5, r12
    sub r4, r12
    jmp 1f
vm_gosubfar:
    WORD
1:  mov #{kind_gosub}, r14
vm_enter:
    mov &{vm}+{calls}, r15
    cmp &{vm}+{calls_end}, r15
    jhs vm_no_call
    sub r4, r5
    bis r14, r5
    mov r5, 0(r15)
    incd &{vm}+{calls}
    mov r12, r5
    add r4, r5
    FAR vm_poll
vm_no_call:
    br #vm_f16

    /* r12 = the newest entry, r13 its kind in the top bits, r15 its place */
vm_entry:
    mov &{vm}+{calls}, r15
    cmp #{calls_start}, r15
    jeq 1f
    decd r15
    mov @r15, r12
    mov r12, r13
    and #0xf000, r13
    ret
1:  incd r1
    jmp vm_no_call
vm_exitsub:
    call #vm_entry
    cmp #{kind_gosub}, r13
    jne vm_leave
    mov r15, &{vm}+{calls}
    jmp vm_exitsub
vm_return:
    call #vm_entry
vm_leave:
    cmp #{kind_event}+1, r13
    jhs vm_no_call
    mov r15, &{vm}+{calls}
    mov r12, r5
    and #0x0fff, r5
    add r4, r5
    .if {has_events}
    cmp #{kind_event}, r13
    jeq 1f
    .endif
    FAR vm_poll
    .if {has_events}
1:  mov #{handler_end}, r12
    br #vm_exit
    .endif
vm_give:
    call #vm_entry
    mov r15, &{vm}+{calls}
    cmp #{kind_gosub}, r13
    jeq vm_give
    tst r13
    jge vm_no_call
    mov r12, r5
    and #0x0fff, r5
    add r4, r5
    and #0x7000, r13
    swpb r13
    rra r13
    rra r13
    add r13, &{vm}+{base}
    FAR vm_next

    /* --- tables --- */
vm_table_op:
    mov.b @r5+, r12
    jmp 1f
vm_tablefar:
    WORD
1:  call #vm_column
2:  br #vm_set
vm_tablepair:
    mov.b @r5+, r12
    push r10
    push r11
    call #vm_column
    mov r12, r10
    mov r13, r11
    pop r13
    pop r12
    sub #4, r6
    mov r10, 0(r6)
    mov r11, 2(r6)
    mov r12, r10
    mov r13, r11
    mov r8, r12
    sub &{vm}+{data}, r12
    call #vm_column
    jmp 2b
    /* column at offset r12, row on the top: r13:r12 = the value, r8 = what follows the column;
       the top is lost */
vm_column:
    mov r12, r14
    add &{vm}+{data}, r14
    mov.b @r14+, r15
    mov.b @r14+, r13
    bit #{column_long}, r15
    jeq 1f
    mov.b @r14+, r12
    swpb r12
    bis r12, r13
1:  tst r11
    jne 6f
    cmp r13, r10
    jhs 6f
    clr r9
    bit #{column_scaled}, r15
    jeq 2f
    mov.b @r14+, r9
    mov.b @r14+, r12
    swpb r12
    bis r12, r9
2:  and #3, r15
    inc r15
    mov r14, r8
    mov r15, r12
3:  add r13, r8
    add r10, r14
    dec r12
    jne 3b
    add r15, r14
    dec r14
    mov.b @r14, r12
    sxt r12
    clr r13
    tst r12
    jge 4f
    inv r13
4:  dec r15
    jeq 5f
    dec r14
    mov #8, r10
7:  rla r12
    rlc r13
    dec r10
    jne 7b
    mov.b @r14, r10
    bis r10, r12
    jmp 4b
5:  tst r9
    jeq 8f
    mov r9, r14
    clr r15
    call #__mspabi_mpyl
8:  ret
6:  /* drop what the callers of this routine left on the machine stack */
    mov &{vm}+{frame}, r1
    br #vm_f03

    .section .rodata.vm,"a",@progbits
module.vm$tables:
vm_masks:
    .byte 2, 5, 1, 3, 4, 6
    .byte 0, 0, 0, 0
    .byte 2, 5, 1, 3, 4, 6
    .balign 2
vm_table:
    .short vm_soft, vm_byte, vm_minus, vm_tens, vm_hundreds, vm_thousands, vm_word, vm_wordtens
    .short vm_triple, vm_long, vm_loadfar, vm_storefar, vm_loadelem, vm_storeelem, vm_inc, vm_dec
    .short vm_addto, vm_drop, vm_add, vm_sub, vm_mul, vm_div, vm_mod, vm_neg
    .short vm_abs, vm_sgn, vm_min, vm_max, vm_sqr, vm_and, vm_or, vm_xor
    .short vm_not, vm_iszero, vm_shl, vm_shr
    .short vm_compare_value, vm_compare_value, vm_compare_value
    .short vm_compare_value, vm_compare_value, vm_compare_value
    .short vm_jump, vm_jumpfar, vm_jumpzero, vm_jumpnonzero
    .short vm_compare_jump, vm_compare_jump, vm_compare_jump
    .short vm_compare_jump, vm_compare_jump, vm_compare_jump
    .short vm_andalso, vm_orelse
    .short vm_for, vm_next_one, vm_forstep, vm_nextstep, vm_nextbyte, vm_repeat
    .short vm_call, vm_callfar, vm_func, vm_funcfar, vm_gosub, vm_gosubfar
    .short vm_return, vm_exitsub, vm_give
    .short vm_soft, vm_soft, vm_soft, vm_soft, vm_soft, vm_soft
    .short vm_table_op, vm_tablefar, vm_tablepair, vm_check, vm_soft, vm_soft, vm_more
    .short vm_dup, vm_over
    .short vm_incshort, vm_incshort, vm_incshort, vm_incshort
    .short vm_zero, vm_zero, vm_zero, vm_zero, vm_nextshort, vm_nextword, vm_addcell
    /* effect and number of values of the codes from 0xA0 on */
vm_inlines:
    .byte {move_to}, 1, {move_to}+1, 1, {move_to}+2, 1
    .byte {rapid}+2, 2, {rapid}+3, 1
    .byte {line}, 1, {line}+1, 1, {line}+2, 2, {line}+3, 1
    .byte {linear}, 1, {linear}, 2, {linear}, 3
    .byte {move_flags}, 2, {probe}, 2, {feed}, 1, {wait}, 1
    "#,
    vm = sym VM,
    calls_start = sym CALLS,
    poll = const offset_of!(State, poll),
    flags = const offset_of!(State, flags),
    base = const offset_of!(State, base),
    calls = const offset_of!(State, calls),
    calls_end = const CALLS_END_AT,
    data = const offset_of!(State, data),
    frame = const FRAME_AT,
    saves = const SAVES,
    has_events = const crate::vm::PART.features & lang::record::feature::EVENTS,
    // 60 bytes less for 9 cycles at wide operands.
    small = const 1,
    more = const lang::vm::flag::MORE,
    incshort = const Op::IncShort as u8,
    zero = const Op::Zero as u8,
    move_to = const Op::MoveTo as u8,
    rapid = const Op::Rapid as u8,
    line = const Op::Line as u8,
    linear = const Op::Linear as u8,
    move_flags = const Op::Move as u8,
    probe = const Op::Probe as u8,
    feed = const Op::Feed as u8,
    wait = const Op::Wait as u8,
    yield_code = const YIELD,
    handler_end = const HANDLER_END,
    kind_gosub = const (lang::vm::entry::GOSUB as u16) << 12,
    kind_sub = const (lang::vm::entry::SUB as u16) << 12,
    kind_event = const (lang::vm::entry::EVENT as u16) << 12,
    column_long = const lang::image::COLUMN_LONG,
    column_scaled = const lang::image::COLUMN_SCALED,
);

// The table above is in the order of the codes.
const _: () = assert!(
    Op::Byte as u8 == 0x01
        && Op::Add as u8 == 0x12
        && Op::Eq as u8 == 0x24
        && Op::JumpEq as u8 == 0x2E
        && Op::For as u8 == 0x36
        && Op::Give as u8 == 0x44
        && Op::More as u8 == 0x51
        && Op::AddCell as u8 == 0x5E
        && Op::MoveToMm as u8 == 0xA0
        && Op::WaitSeconds as u8 == 0xAF
);
