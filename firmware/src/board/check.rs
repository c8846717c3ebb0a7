//! The check of an image in assembly: the twin of [`firmware::verify::verify`], a quarter of what
//! the compiler makes of that. `tests/tests/image_check.rs` holds the two together.
//!
//! | register | holds |
//! |---|---|
//! | r4 | instruction |
//! | r5 | its code |
//! | r6 | its entry of [`SHAPES`] |
//! | r7 | the instruction behind it |
//! | r8 | values that it takes |
//! | r9 | depth of the expression stack |
//! | r10 | scratch memory: [`CODE_START`] to [`ANCHOR_TABLE`] |
//! | r11 to r15 | free |
//!
//! Addresses are absolute. 1 KB of code takes about 20 ms.

use ::core::arch::global_asm;
use firmware::verify::{ANCHORS, CODE, MACHINE};
use lang::image::{FORMAT, MAX_EVENTS};
use lang::isa::{FINGERPRINT, LOW_CELLS, Op, SHORT_CELLS, flags};
use lang::record::{AxisRecord, feature};
use lang::wire::Refusal;

use crate::vm::PART;
use shapes::{ENDS, FIRST_EFFECT, GROUPS, INDEX, Kind, LOW, MASKS, MASKS_LEN, SHAPES};

#[path = "check_shapes.rs"]
mod shapes;

/// Offset in the scratch memory of the code's address.
pub const CODE_START: u8 = 0;
/// Of the address behind the code, where the data begins.
pub const CODE_END: u8 = 2;
/// Of the address behind the image.
const IMAGE_END: u8 = 4;
/// Of the image's address.
const IMAGE: u8 = 6;
/// Of the machine stack on entry, for the way out of any depth.
const FRAME: u8 = 8;
/// Of what the header leaves of the pool, where ON lines take of it.
const FREE: u8 = 10;
/// Bytes of the pool that ON lines take.
const EVENT_POOL: [u16; 2] =
    if PART.features & feature::EVENTS != 0 { PART.event_pool } else { [0, 0] };
/// Of the anchors.
const ANCHOR_TABLE: u8 = FREE + if EVENT_POOL[0] != 0 { 2 } else { 0 };
/// Scratch memory of the check, bytes.
#[cfg(feature = "g2955")]
pub const SCRATCH: usize = ANCHOR_TABLE as usize + ANCHORS;

/// Address of the watchdog's control register (SLAU144, 10.3.1).
const WDTCTL: u16 = 0x0120;
#[cfg(feature = "g2955")]
unsafe extern "C" {
    fn pasapas_verify(image: u16, features: u16, scratch: *mut u8) -> u16;
}

/// Checks the image at an address, of which [`firmware::verify::sound`] has found length and CRC
/// good. `features` are those of this firmware.
///
/// # Errors
/// A [`Refusal`] as its number.
#[cfg(feature = "g2955")]
pub fn verify(image: u16, features: u8, scratch: &mut [u8; SCRATCH]) -> Result<(), u8> {
    // SAFETY: the routine reads the image and writes nothing but the scratch memory.
    match unsafe { pasapas_verify(image, features.into(), scratch.as_mut_ptr()) } {
        0 => Ok(()),
        refusal => Err(refusal as u8),
    }
}

global_asm!(
    r#"
    .section .text.verify,"ax",@progbits
module.check:
    .global pasapas_verify
pasapas_verify:
    .if {saves}
    push r4
    push r5
    push r6
    push r7
    push r8
    push r9
    push r10
    .endif
    mov r14, r10
    mov r12, {image}(r10)
    mov r1, {frame}(r10)
    mov r12, r4

    /* header */
    mov #{version}, r15
    cmp.b #{format}, 0(r4)
    jne 9f
    cmp #{fingerprint}, 2(r4)
    jne 9f
    mov #{feature}, r15
    mov.b 1(r4), r11
    bic.b r13, r11
    tst.b r11
    jne 9f
    mov #{memory}, r15
    mov.b 15(r4), r12
    mov.b 16(r4), r13
    mov.b 14(r4), r11
    mov.b r12, r14
    and #15, r14
    rra r12
    rra r12
    rra r12
    rra r12
    cmp r14, r12
    jlo 9f
    /* 4 (cells + stack) + 2 calls = 2 (2 (cells + stack) + calls) */
    add r11, r12
    rla r12
    mov.b r13, r14
    rra r14
    rra r14
    rra r14
    rra r14
    add r14, r12
    rla r12
    mov #{pool_many}, r14
    .if {pool_many}-{pool_one}
    bit.b #{many}, 1(r4)
    jne 1f
    mov #{pool_one}, r14
1:
    .endif
    cmp r12, r14
    jlo 9f
    .if {event_pool}
    sub r12, r14
    mov r14, {free}(r10)
    .endif
    and #15, r13
    cmp #9, r13
    jhs 9f
    mov.b 17(r4), r12
    add r13, r12
    cmp r12, r11
    jlo 9f
    mov #{code_refusal}, r15
    tst.b 11(r4)
    jne 9f
    mov 6(r4), r12
    add r4, r12
    mov r12, {image_end}(r10)
    mov r4, r12
    add #{code}, r12
    mov r12, {code_start}(r10)
    mov.b 9(r4), r13
    mov.b 10(r4), r14
    swpb r14
    bis r14, r13
    tst r13
    jeq 9f
    .if {room} - {code} > {max_code} - 1
    cmp #{max_code}, r13
    jhs 9f
    .endif
    add r13, r12
    mov r12, {code_end}(r10)
    cmp r12, {image_end}(r10)
    jlo 9f
    /* axes that are there have a scale */
    add #{axes}, r4
    mov #3, r13
2:  bit #{present}, 0(r4)
    jeq 3f
    tst 2(r4)
    jeq 9f
    tst 4(r4)
    jeq 9f
3:  add #{axis_size}, r4
    dec r13
    jne 2b
    jmp pasapas_verify_code

pasapas_verify_fail:
    mov #{code_refusal}, r15
9:  mov {frame}(r10), r1
    mov r15, r12
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

    /* first pass: instructions, operands, depths; leaves the anchors */
pasapas_verify_code:
    mov r10, r11
    mov #{anchors}, r12
1:  mov.b #-1, {anchor}(r11)
    inc r11
    dec r12
    jne 1b
    mov @r10, r4
    clr r9
2:  tst r9
    jne 3f
    mov r4, r12
    sub @r10, r12
    mov r12, r11
    rla r11
    rla r11
    swpb r11
    mov.b r11, r11
    and #63, r12
    add r10, r11
    cmp.b #-1, {anchor}(r11)
    jne 3f
    mov.b r12, {anchor}(r11)
3:  call #pasapas_verify_insn
    cmp r7, {code_end}(r10)
    jlo pasapas_verify_fail
    tst r6
    jge 4f
    cmp r8, r9
    jne pasapas_verify_fail
4:  mov r5, r11
    bic #1, r11
    cmp #{func}, r11
    jne 5f
    cmp #8, r9
    jhs pasapas_verify_fail
5:  call #pasapas_verify_operands
    call #pasapas_verify_after
    mov {image}(r10), r11
    mov.b 15(r11), r11
    and #15, r11
    cmp r9, r11
    jlo pasapas_verify_fail
    mov r7, r4
    cmp {code_end}(r10), r4
    jlo 2b
    bit #{ends}, r6
    jeq pasapas_verify_fail

    /* second pass: jumps */
    mov @r10, r4
    clr r9
1:  call #pasapas_verify_insn
    /* r13 = target, r14 = depth there */
    cmp.b #{sub_near}, r6
    jlo 5f
    clr r14
    mov.b 1(r4), r13
    cmp.b #{sub_far}, r6
    jlo 3f
    mov.b 2(r4), r15
    swpb r15
    bis r15, r13
    cmp.b #{address}, r6
    jlo 3f
    mov r9, r14
    cmp.b #{distance}, r6
    jlo 3f
    sub r8, r14
    mov.b -1(r7), r13
    sxt r13
    cmp.b #{skip}, r6
    jlo 2f
    mov r5, r13
    sub #{skip_less_one}, r13
2:  add r7, r13
    jmp 4f
3:  add @r10, r13
4:  push r4
    push r9
    call #pasapas_verify_lands
    pop r9
    pop r4
    call #pasapas_verify_insn
5:  call #pasapas_verify_after
    mov r7, r4
    cmp {code_end}(r10), r4
    jlo 1b

    /* targets that stand elsewhere: main program, ON lines, statement table */
    mov {image}(r10), r6
    mov 12(r6), r13
    call #pasapas_verify_start
    mov {code_end}(r10), r5
    mov {image}(r10), r6
    mov.b 1(r6), r6
    .if {has_events}
    bit #{events}, r6
    jeq 2f
    cmp {image_end}(r10), r5
    jhs pasapas_verify_broken
    mov.b @r5+, r4
    tst r4
    jeq 2f
    cmp #{max_events}+1, r4
    jhs pasapas_verify_broken
    .if {event_pool}
    mov #{event_pool}, r13
    mov r4, r12
3:  add #{event_bytes}, r13
    dec r12
    jne 3b
    cmp r13, {free}(r10)
    jlo pasapas_verify_broken
    .endif
1:  push r4
    push r6
    call #pasapas_verify_word
    push r5
    call #pasapas_verify_start
    pop r5
    pop r6
    pop r4
    dec r4
    jne 1b
2:
    .endif
    .if {has_lines}
    bit #{lines}, r6
    jeq pasapas_verify_good
    call #pasapas_verify_word
    mov r13, r5
    add {code_end}(r10), r5
    jc pasapas_verify_broken
    cmp r5, {image_end}(r10)
    jlo pasapas_verify_broken
    mov @r10, r14
    /* r5 = entry, r14 = address of its statement */
3:  cmp {image_end}(r10), r5
    jhs pasapas_verify_table_end
    mov.b @r5+, r11
    mov r11, r12
    and #31, r12
    cmp #31, r12
    jne 4f
    mov.b @r5+, r13
    add r13, r12
4:  bit #0x80, r11
    jeq 5f
    inc r5
    bit #0x40, r11
    jeq 5f
    inc r5
5:  push r5
    push r11
    push r12
    push r14
    mov r14, r13
    call #pasapas_verify_place
    pop r14
    pop r12
    pop r11
    pop r5
    add r12, r14
    bit #32, r11
    jeq 7f
    call #pasapas_verify_word
    push r5
    push r14
    call #pasapas_verify_start
    pop r14
    pop r5
    jmp 8f
7:  cmp {code_end}(r10), r14
    jhs 8f
    push r5
    push r14
    mov r14, r13
    call #pasapas_verify_place
    pop r14
    pop r5
8:  cmp {code_end}(r10), r14
    jlo 3b
    jmp pasapas_verify_good
    /* a fault finds its statement; the last instruction, an END, needs none */
pasapas_verify_table_end:
    inc r14
    cmp {code_end}(r10), r14
    jlo pasapas_verify_broken
    .endif
pasapas_verify_good:
    clr r15
    jmp 9b
pasapas_verify_broken:
    br #pasapas_verify_fail

    .if {has_events} | {has_lines}
    /* r13 = number at r5, which lies in the image; r5 behind it */
pasapas_verify_word:
    mov r5, r13
    incd r13
    cmp r13, {image_end}(r10)
    jlo pasapas_verify_broken
    mov.b @r5+, r13
    mov.b @r5+, r15
    swpb r15
    bis r15, r13
    ret
    .endif

    /* a statement begins at address r13 of the code; uses r4 to r9 */
pasapas_verify_start:
    add @r10, r13
pasapas_verify_place:
    clr r14
    /* an instruction begins at r13 with depth r14 before it */
pasapas_verify_lands:
    cmp {code_end}(r10), r13
    jhs pasapas_verify_broken
    mov r13, r11
    sub @r10, r11
    jlo pasapas_verify_broken
    rla r11
    rla r11
    swpb r11
    mov.b r11, r11
1:  mov r10, r12
    add r11, r12
    mov.b {anchor}(r12), r4
    cmp.b #-1, r4
    jeq 2f
    mov r11, r15
    swpb r15
    rra r15
    rra r15
    add r15, r4
    add @r10, r4
    cmp r4, r13
    jhs 3f
2:  dec r11
    jge 1b
    mov @r10, r4
3:  clr r9
4:  cmp r13, r4
    jhs 5f
    push r13
    call #pasapas_verify_insn
    pop r13
    call #pasapas_verify_after
    mov r7, r4
    jmp 4b
5:  jne pasapas_verify_broken
    cmp r14, r9
    jne pasapas_verify_broken
    ret

    /* reads the instruction at r4; uses r11 to r13 */
pasapas_verify_insn:
    /* the whole check takes longer than the watchdog's 43 ms */
    mov #{kick}, &{watchdog}
    mov.b @r4, r5
    .if {runs}
    mov r5, r12
    mov #{index}, r11
1:  mov.b @r11+, r6
    mov r6, r13
    bis #-4, r13
    add r13, r12
    jc 1b
    rra r6
    bic #1, r6
    .else
    mov r5, r6
    sub #{effect_shift}, r6
    cmp #{first_effect}, r5
    jhs 1f
    mov r5, r6
    cmp #{low}, r5
    jlo 1f
    sub #{low}, r6
    rra r6
    rra r6
    rra r6
    rra r6
    add #{low}, r6
1:  mov.b {index}(r6), r6
    .endif
    mov {shapes}(r6), r6
    cmp #-1, r6
    jeq pasapas_verify_broken
    mov r6, r7
    and #7, r7
    inc r7
    add r4, r7
    mov r6, r8
    swpb r8
    and #7, r8
    cmp #{first_effect}, r5
    jlo 4f
    mov #{masks}, r11
2:  cmp.b @r11+, r5
    jeq 3f
    incd r11
    cmp #{masks}+{masks_len}, r11
    jlo 2b
    ret
3:  mov.b 1(r4), r12
    and.b @r11+, r12
    call #pasapas_verify_count
    mov.b 2(r4), r12
    and.b @r11, r12
    /* adds the bits of r12 to r8 */
pasapas_verify_count:
    clrc
    rrc r12
    adc r8
    tst r12
    jne pasapas_verify_count
4:  ret

    /* depth behind the instruction */
pasapas_verify_after:
    sub r8, r9
    jn pasapas_verify_broken
    mov r6, r11
    swpb r11
    rra r11
    rra r11
    rra r11
    and #3, r11
    add r11, r9
    bit #{ends}, r6
    jeq 1f
    clr r9
1:  ret

    /* cells, data, axes and event slots that the instruction names */
pasapas_verify_operands:
    mov {image}(r10), r15
    mov.b 14(r15), r14
    mov.b 1(r4), r12
    .if {has_events}
    cmp.b #{event}, r5
    jeq 6f
    .endif
    mov.b r6, r11
    rra r11
    rra r11
    rra r11
    mov.b pasapas_verify_table(r11), r11
    add r11, r0
pasapas_verify_first:
pasapas_verify_low:
    mov r5, r12
    and #{low_cells}-1, r12
    jmp pasapas_verify_cell
pasapas_verify_short:
    mov r5, r12
pasapas_verify_nibbles:
    and #{short_cells}-1, r12
pasapas_verify_cell:
    cmp r14, r12
    jhs 7f
pasapas_verify_none:
    ret
pasapas_verify_array:
    mov.b 2(r4), r13
    add r13, r12
    cmp r12, r14
    jlo 7f
    ret
pasapas_verify_axis_number:
    cmp #3, r12
    jhs 7f
    ret
pasapas_verify_axis:
    cmp #3, r12
    jhs 7f
    mov #{axes_in_image}, r13
2:  tst r12
    jeq 3f
    add #{axis_size}, r13
    dec r12
    jmp 2b
3:  add r15, r13
    bit #{present}, 0(r13)
    jeq 7f
    ret
    .if {has_events}
6:  /* ON IN and ON EVERY name a slot that has a handler */
    mov r12, r13
    and #{event_kind}, r13
    cmp #{on_rise}, r13
    jeq 8f
    cmp #{on_fall}, r13
    jeq 8f
    cmp #{on_every}, r13
    jne pasapas_verify_none
8:  bit.b #{events}, 1(r15)
    jeq 7f
    mov {code_end}(r10), r13
    cmp {image_end}(r10), r13
    jhs 7f
    mov.b @r13, r13
    and #3, r12
    cmp r13, r12
    jhs 7f
    ret
    .endif
    /* whole thousands in the code: as many as the flags behind them ask for */
pasapas_verify_inline_probe:
    bit.b #{sensor}, -1(r7)
    jne 7f
    mov.b -2(r7), r12
    jmp pasapas_verify_speed
pasapas_verify_inline:
    mov.b -1(r7), r12
    and #7, r12
    call #pasapas_verify_count
    mov r5, r12
    sub #{linear_mm_less_one}, r12
    cmp r12, r8
    jne 7f
    clr r8
    ret
pasapas_verify_inline_move:
    mov.b -1(r7), r12
pasapas_verify_speed:
    bit #{speed}, r12
    jeq 7f
    ret
pasapas_verify_text_far:
    mov.b 2(r4), r13
    swpb r13
    bis r13, r12
pasapas_verify_text:
    call #pasapas_verify_inside
    mov.b @r12+, r11
    add r11, r12
    jmp pasapas_verify_ends_inside
pasapas_verify_pair:
    call #pasapas_verify_column
    sub {code_end}(r10), r12
    jmp pasapas_verify_column
pasapas_verify_column_far:
    mov.b 2(r4), r13
    swpb r13
    bis r13, r12
pasapas_verify_column:
    call #pasapas_verify_inside
    mov.b @r12+, r11
    cmp #16, r11
    jhs 7f
    mov.b @r12+, r15
    bit #{column_long}, r11
    jeq 4f
    mov.b @r12+, r13
    swpb r13
    bis r13, r15
4:  bit #{column_scaled}, r11
    jeq 5f
    incd r12
5:  and #3, r11
6:  add r15, r12
    jc 7f
    dec r11
    jge 6b
pasapas_verify_ends_inside:
    cmp r12, {image_end}(r10)
    jlo 7f
    ret
    /* r12 = address of the data offset r12 */
pasapas_verify_inside:
    add {code_end}(r10), r12
    jc 7f
    cmp {image_end}(r10), r12
    jhs 7f
    ret
7:  br #pasapas_verify_fail

    .section .rodata.verify,"a",@progbits
module.check$tables:
    /* one for each Kind, in their order: distances, which must fit: a negative .skip is refused */
    .skip -((pasapas_verify_ends_inside - pasapas_verify_first) >> 8)
pasapas_verify_table:
    .byte pasapas_verify_none - pasapas_verify_first
    .byte pasapas_verify_cell - pasapas_verify_first
    .byte pasapas_verify_low - pasapas_verify_first
    .byte pasapas_verify_short - pasapas_verify_first
    .byte pasapas_verify_array - pasapas_verify_first
    .byte pasapas_verify_column - pasapas_verify_first
    .byte pasapas_verify_column_far - pasapas_verify_first
    .byte pasapas_verify_pair - pasapas_verify_first
    .byte pasapas_verify_text - pasapas_verify_first
    .byte pasapas_verify_text_far - pasapas_verify_first
    .byte pasapas_verify_axis_number - pasapas_verify_first
    .byte pasapas_verify_axis - pasapas_verify_first
    .byte pasapas_verify_inline - pasapas_verify_first
    .byte pasapas_verify_inline_move - pasapas_verify_first
    .byte pasapas_verify_inline_probe - pasapas_verify_first
    .byte pasapas_verify_none - pasapas_verify_first
    .byte pasapas_verify_none - pasapas_verify_first
    .byte pasapas_verify_none - pasapas_verify_first
    .byte pasapas_verify_none - pasapas_verify_first
    .byte pasapas_verify_cell - pasapas_verify_first
    .byte pasapas_verify_nibbles - pasapas_verify_first
    .byte pasapas_verify_none - pasapas_verify_first
"#,
    kick = const crate::boot::WATCHDOG_KICK,
    watchdog = const WDTCTL,
    image = const IMAGE,
    frame = const FRAME,
    code_start = const CODE_START,
    code_end = const CODE_END,
    image_end = const IMAGE_END,
    free = const FREE,
    event_pool = const EVENT_POOL[0],
    event_bytes = const EVENT_POOL[1],
    max_events = const MAX_EVENTS,
    anchor = const ANCHOR_TABLE,
    anchors = const ANCHORS,
    version = const Refusal::Version as u8,
    feature = const Refusal::Feature as u8,
    memory = const Refusal::Memory as u8,
    code_refusal = const Refusal::Code as u8,
    format = const FORMAT,
    fingerprint = const FINGERPRINT,
    many = const feature::INTERPOLATE | feature::START,
    events = const feature::EVENTS,
    lines = const feature::LINES,
    pool_one = const crate::vm::POOL_LIMITS[0],
    pool_many = const crate::vm::POOL_LIMITS[1],
    code = const CODE,
    room = const PART.room_for(false),
    max_code = const 64 * ANCHORS + 1,
    axes = const MACHINE + 8,
    axes_in_image = const MACHINE + 8,
    axis_size = const AxisRecord::SIZE,
    present = const AxisRecord::PRESENT,
    func = const Op::Func as u8,
    ends = const ENDS,
    sub_near = const (Kind::SubNear as u8) << 3,
    sub_far = const (Kind::SubFar as u8) << 3,
    address = const (Kind::Address as u8) << 3,
    distance = const (Kind::Distance as u8) << 3,
    skip = const (Kind::Skip as u8) << 3,
    low_cells = const LOW_CELLS,
    linear_mm_less_one = const Op::LinearMm as u8 - 1,
    speed = const flags::SPEED,
    sensor = const flags::SENSOR,
    skip_less_one = const Op::Skip as u8 - 1,
    short_cells = const SHORT_CELLS,
    first_effect = const FIRST_EFFECT,
    effect_shift = const FIRST_EFFECT - LOW - GROUPS,
    low = const LOW,
    runs = const cfg!(feature = "g2553") as u8,
    index = sym INDEX,
    shapes = sym SHAPES,
    masks = sym MASKS,
    masks_len = const MASKS_LEN,
    saves = const crate::vm::SAVES,
    has_events = const PART.features & feature::EVENTS,
    has_lines = const PART.features & feature::LINES,
    event = const Op::Event as u8,
    event_kind = const flags::EVENT_KIND,
    on_rise = const flags::ON_RISE,
    on_fall = const flags::ON_FALL,
    on_every = const flags::ON_EVERY,
    column_long = const lang::image::COLUMN_LONG,
    column_scaled = const lang::image::COLUMN_SCALED,
);

// Codes that hold a cell's number are aligned to it; the moves along lines are in their order.
const _: () = assert!(
    (Op::IncShort as u8 | Op::Zero as u8) % LOW_CELLS == 0
        && (Op::Load as u8 | Op::Store as u8) % SHORT_CELLS == 0
        && Op::LinearMm3 as u8 == Op::LinearMm as u8 + 2
);
