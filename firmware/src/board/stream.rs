//! A job larger than the program area, run from RAM in pieces (`lang::wire`, Streaming).
//!
//! Flash cannot be written while steps are made, so the pieces stay in RAM: [`SLOTS`] images, of
//! which one runs and the others wait. The code is linked behind the program area, where the last
//! segment has room. The VM, the check and the run state are those of stored
//! programs; only where a piece ends the next one begins instead of the run's end.

use crate::check;
use crate::controller::{Controller, FEATURES};
use crate::flash::Image;
use crate::vm::vm;
use core::ptr::{addr_of, addr_of_mut};
use firmware::modbus::FRAME;
use firmware::verify::{self, Bytes, CODE, MACHINE};
use lang::image::HEADER;
use lang::isa::Op;
use lang::record::feature;
use lang::vm::flag;
#[expect(
    clippy::wildcard_imports,
    reason = "the table of the registers: what this file serves"
)]
use lang::wire::{Stream as Code, *};

/// Pieces in RAM: one runs, one waits, one is being filled.
const SLOTS: u16 = 3;
/// Words of a piece: header, axes' part of the profile, code and data. The check of 186 bytes
/// takes 4 ms, in which the planner stands still: less than what the step engine has ahead.
const SLOT_WORDS: usize = 176;
/// What a piece must not use: its data is gone when it ends.
const FOREIGN: u16 = feature::KEEP | feature::LINES;
/// Byte of the header that says whether a piece answers a call: the first KEEP cell.
const ANSWERS: u16 = 17;
/// Its word.
const ANSWERS_WORD: u16 = ANSWERS / 2;
/// What the VM stands at while it waits for a handler.
static NOTHING: u8 = Op::End as u8;
/// First word of the code.
const CODE_WORD: u16 = CODE / 2;

struct Store {
    slots: [[u16; SLOT_WORDS]; SLOTS as usize],
    /// Pieces accepted.
    accepted: u16,
    /// Pieces begun.
    begun: u16,
    /// Slot of the next piece to arrive.
    filling: u8,
    /// Slot of the next piece to run.
    next: u8,
    starved: u16,
    result: u8,
    /// A run was begun since the stream was opened.
    running: bool,
    /// The VM stands in a piece.
    owns: bool,
    /// The last piece was accepted.
    finished: bool,
    /// The newest piece has ended and no other is there.
    dry: bool,
    /// The axes rest since then.
    rests: bool,
    /// [`STREAM_CALL`]
    call: u16,
}

static mut STREAM: Store = Store {
    slots: [[0; SLOT_WORDS]; SLOTS as usize],
    accepted: 0,
    begun: 0,
    filling: 0,
    next: 0,
    starved: 0,
    result: 0,
    running: false,
    owns: false,
    finished: false,
    dry: false,
    rests: false,
    call: 0,
};

fn stream() -> &'static mut Store {
    // SAFETY: only the main loop calls this and keeps no reference over another call.
    unsafe { &mut *addr_of_mut!(STREAM) }
}

/// Address of a slot.
fn slot(n: u8) -> u16 {
    // SAFETY: only an address is taken.
    unsafe { addr_of!(STREAM.slots) as u16 + u16::from(n) * (2 * SLOT_WORDS as u16) }
}

/// The slot after one.
fn after(n: u8) -> u8 {
    if u16::from(n) + 1 == SLOTS { 0 } else { n + 1 }
}

/// Whether the VM stands in a piece, not in the stored program.
pub fn owns() -> bool {
    stream().owns
}

/// Whether the run waits for a handler.
pub fn waits() -> bool {
    stream().call != 0 && stream().owns
}

/// Whether the run waits for the next piece.
pub fn is_dry() -> bool {
    stream().dry
}

/// A handler has begun, that of the event in `slot` or of the fault: what was to come is forgotten.
#[inline(never)]
pub fn call(place: Called, slot: u8, fault: u8) {
    let stream = stream();
    let idle = stream.dry && matches!(place, Called::Behind) && fault == 0;
    let place = if idle { Called::Idle } else { place };
    stream.call = u16::from_le_bytes([place as u8 | slot << 4, fault]);
    forget(stream);
    vm().pc = addr_of!(NOTHING) as u16;
}

/// No piece waits, and none was the last.
#[inline(never)]
fn forget(stream: &mut Store) {
    stream.accepted = stream.begun;
    stream.filling = stream.next;
    stream.finished = false;
    stream.dry = false;
    stream.rests = false;
}

/// The pieces that came are forgotten; none runs.
pub fn forget_pieces() {
    forget(stream());
    close();
}

/// Memory of the pieces, for others while there are none.
pub fn memory() -> &'static mut [u16] {
    stream().slots.as_flattened_mut()
}

/// The stored program begins.
pub fn close() {
    stream().owns = false;
}

/// The piece has come to its end: the next one begins, or the run waits for it; `false` when it was
/// the last.
pub fn follow(controller: &mut Controller) -> bool {
    let stream = stream();
    if !stream.owns {
        return false;
    }
    if stream.begun == stream.accepted {
        if stream.finished {
            return false;
        }
        // The end is executed again.
        vm().pc -= 1;
        stream.dry = true;
        stream.rests |= controller.motor.rests();
        return true;
    }
    if stream.rests {
        stream.starved = stream.starved.wrapping_add(1);
    }
    let vm = vm();
    let (open, handler) = (vm.flags & (flag::EVENT | flag::ERROR), vm.handler);
    vm.begin(slot(stream.next), 0);
    vm.flags = open;
    vm.handler = handler;
    controller.effect_pc = vm.pc.wrapping_sub(1);
    stream.next = after(stream.next);
    stream.begun = stream.begun.wrapping_add(1);
    stream.dry = false;
    stream.rests = false;
    true
}

/// A status register.
pub fn read(address: u16) -> u16 {
    let stream = stream();
    match address {
        STREAM_ACCEPTED => stream.accepted,
        STREAM_BEGUN => stream.begun,
        STREAM_DRY => u16::from(stream.dry),
        STREAM_STARVED => stream.starved,
        STREAM_RESULT => u16::from(stream.result),
        STREAM_CALL => stream.call,
        STREAM_SLOTS => SLOTS,
        STREAM_BYTES => 2 * SLOT_WORDS as u16 - CODE,
        _ => (FRAME as u16 - 9) / 2,
    }
}

/// A word of the axes' part of the profile, for every slot.
pub fn write_machine(index: u16, value: u16) {
    let at = usize::from(MACHINE / 2 + index);
    for slot in &mut stream().slots {
        if let Some(place) = slot.get_mut(at) {
            *place = value;
        }
    }
}

/// A word of the next piece; its last one has it checked.
///
/// # Errors
/// No slot is free, the piece is too long or was refused.
#[inline(never)]
pub fn write(index: u16, value: u16) -> Result<(), Exception> {
    let stream = stream();
    // The slot of the running piece is not free, also not while the run waits for another.
    let room = if stream.running { SLOTS - 1 } else { SLOTS };
    if stream.accepted.wrapping_sub(stream.begun) >= room {
        return Err(Exception::Busy);
    }
    let in_slot = if index < HEADER as u16 / 2 { index } else { index + (CODE - MACHINE) / 2 };
    let slots = &mut stream.slots;
    let Some(place) = slots
        .get_mut(usize::from(stream.filling))
        .and_then(|slot| slot.get_mut(usize::from(in_slot)))
    else {
        return Err(Exception::IllegalValue);
    };
    *place = value;
    let address = slot(stream.filling);
    let piece = Image(address);
    // The host does not know yet that what it sends was forgotten.
    if stream.call != 0 && in_slot >= ANSWERS_WORD && piece.byte(ANSWERS) == 0 {
        return Err(Exception::Busy);
    }
    // What an earlier piece left here has another number.
    if in_slot < CODE_WORD
        || in_slot != (piece.word(6) - 1) / 2
        || piece.word(18) != stream.accepted
    {
        return Ok(());
    }
    let mut scratch = [0; check::SCRATCH];
    stream.result = if verify::sound(&piece, 2 * SLOT_WORDS as u16).is_none() {
        Refusal::Crc as u8
    } else {
        check::verify(address, (FEATURES & !FOREIGN) as u8, &mut scratch).err().unwrap_or(0)
    };
    if stream.result != 0 {
        return Err(Exception::DeviceFailure);
    }
    stream.call = 0;
    stream.filling = after(stream.filling);
    stream.accepted = stream.accepted.wrapping_add(1);
    Ok(())
}

/// A code for STREAM_CONTROL; `idle` tells whether no program runs and no axis moves.
///
/// # Errors
/// Busy, or a code that there is not.
#[inline(never)]
pub fn control(controller: &mut Controller, value: u16, idle: bool) -> Result<(), Exception> {
    let stream = stream();
    let code = Code::from_number(value).ok_or(Exception::IllegalValue)?;
    if let Code::Finish = code {
        if stream.call != 0 {
            return Err(Exception::Busy);
        }
        stream.finished = true;
        return Ok(());
    }
    // A repeated request finds the run begun.
    if let Code::Run = code
        && stream.running
    {
        return Ok(());
    }
    let fault = controller.session.state() as u8 == RunState::Fault as u8;
    if !idle || fault {
        return Err(Exception::Busy);
    }
    if let Code::Open = code {
        stream.begun = 0;
        stream.next = 0;
        stream.starved = 0;
        stream.running = false;
        stream.call = 0;
        forget(stream);
        return Ok(());
    }
    if stream.accepted == 0 || controller.blocked() {
        return Err(Exception::Busy);
    }
    stream.owns = true;
    stream.running = true;
    vm().flags = 0;
    vm().handler = 0;
    follow(controller);
    controller.begun();
    Ok(())
}
