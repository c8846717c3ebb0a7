//! A job larger than the program area, run from RAM in pieces (`lang::wire`, Streaming).
//!
//! Flash cannot be written while steps are made, so the pieces stay in RAM: [`WAITING`] of them, without the axes'
//! part of the profile, which is the same for all, in the memory that a stored program has for its cells. What
//! runs is a copy in a frame that has that part: an image like a stored one. The code is linked behind the program
//! area, where the last segment has room. The VM, the check and the run state are those of stored programs; only
//! where a piece ends the next one begins instead of the run's end.

use crate::check;
use crate::controller::{Controller, FEATURES};
use crate::flash::Image;
use crate::pool::{PIECE_POOL, POOL_WORDS, QUEUE_WORDS, WAITING_WORDS, behind};
use crate::vm::vm;
use core::ptr::{addr_of, addr_of_mut};
use firmware::modbus::FRAME;
use firmware::verify::{self, Bytes, CODE, MACHINE};
use lang::fault::Fault;
use lang::image::{HEADER, at};
use lang::isa::Op;
use lang::record::feature;
use lang::vm::flag;
#[expect(
    clippy::wildcard_imports,
    reason = "the table of the registers: what this file serves"
)]
use lang::wire::{Stream as Code, *};

/// Pieces that wait, beside the one that runs: 2 KB.
const WAITING: u16 = 8;
/// The same where a queue of events has the memory of the last.
const BESIDE_QUEUE: u16 = 5;
const _: () = assert!((WAITING - BESIDE_QUEUE) as usize * PIECE_WORDS == QUEUE_WORDS);
/// Words of a piece, header, code and data: two requests of the link. Their check takes 4 ms, in which the
/// planner stands still: less than what the step engine has ahead.
const PIECE_WORDS: usize = 126;
/// Words of the axes' part of the profile.
const MACHINE_WORDS: usize = ((CODE - MACHINE) / 2) as usize;
/// Words of an image.
const FRAME_WORDS: usize = PIECE_WORDS + MACHINE_WORDS;
/// What a piece must not use: its data is gone when it ends.
const FOREIGN: u16 = feature::KEEP | feature::LINES;
/// Byte of the header that says whether a piece answers a call: the first KEEP cell.
const ANSWERS: u16 = 17;
/// Its word.
const ANSWERS_WORD: u16 = ANSWERS / 2;
/// What the VM stands at while it waits for a handler.
static NOTHING: u8 = Op::End as u8;
/// First word of the code in a piece.
const CODE_WORD: usize = HEADER / 2;

const _: () = assert!(WAITING as usize * PIECE_WORDS == WAITING_WORDS);

struct Store {
    /// The image of the piece that runs.
    frame: [u16; FRAME_WORDS],
    /// Pieces accepted.
    accepted: u16,
    /// Pieces begun.
    begun: u16,
    /// How many may wait.
    places: u8,
    /// Slot of the next piece to arrive.
    filling: u8,
    /// Slot of the next piece to run.
    next: u8,
    starved: u16,
    result: u8,
    /// The memory of a stored program's cells is the pieces'.
    open: bool,
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
    frame: [0; FRAME_WORDS],
    accepted: 0,
    begun: 0,
    places: WAITING as u8,
    filling: 0,
    next: 0,
    starved: 0,
    result: 0,
    open: false,
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

/// A piece that waits, as the image that it will be.
struct Waiting<'a> {
    slot: &'a [u16],
    frame: &'a [u16],
}

impl Bytes for Waiting<'_> {
    fn byte(&self, offset: u16) -> u8 {
        let at = usize::from(offset / 2);
        let word = if at < CODE_WORD {
            self.slot.get(at)
        } else if at < CODE_WORD + MACHINE_WORDS {
            self.frame.get(at)
        } else {
            self.slot.get(at - MACHINE_WORDS)
        };
        let [low, high] = word.copied().unwrap_or_default().to_le_bytes();
        if offset & 1 == 0 { low } else { high }
    }

    fn crc(crc: u16, byte: u8) -> u16 {
        Image::crc(crc, byte)
    }
}

/// The words of a piece that waits.
fn slot(n: u8) -> &'static mut [u16] {
    let at = PIECE_POOL + usize::from(n) * PIECE_WORDS;
    behind(at).get_mut(..PIECE_WORDS).unwrap_or_default()
}

/// Address of the image that runs.
fn frame() -> u16 {
    // SAFETY: only an address is taken.
    unsafe { addr_of!(STREAM.frame) as u16 }
}

/// The slot after one.
fn after(n: u8) -> u8 {
    if n + 1 >= stream().places { 0 } else { n + 1 }
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

/// Whether a queue of events may have the memory of the last pieces.
pub fn gives_queue() -> bool {
    let stream = stream();
    !stream.open || u16::from(stream.places) == BESIDE_QUEUE
}

/// Memory of the last pieces, for others while there are none. No stored program has cells there.
pub fn memory() -> &'static mut [u16] {
    behind(POOL_WORDS)
}

/// Memory for the check of a stored program: that of the code of the piece that runs, which none does then.
pub fn scratch() -> &'static mut [u8; check::SCRATCH] {
    const { assert!(CODE as usize + check::SCRATCH <= 2 * FRAME_WORDS) };
    // SAFETY: it lies inside the frame, at an even address, and the check is over before a piece begins.
    unsafe { &mut *(usize::from(frame() + CODE) as *mut [u8; check::SCRATCH]) }
}

/// A stored program has its memory again.
pub fn close() {
    stream().owns = false;
    stream().open = false;
}

/// The piece has come to its end: the next one begins, or the run waits for it; `false` when it was
/// the last.
///
/// # Errors
/// Its check refuses the next one.
pub fn follow(controller: &mut Controller) -> Result<bool, Fault> {
    let stream = stream();
    if !stream.owns {
        return Ok(false);
    }
    if stream.begun == stream.accepted {
        if stream.finished {
            return Ok(false);
        }
        // The end is executed again.
        vm().pc -= 1;
        stream.dry = true;
        stream.rests |= controller.motor.rests();
        return Ok(true);
    }
    if stream.rests {
        stream.starved = stream.starved.wrapping_add(1);
    }
    let slot = slot(stream.next);
    stream.frame[..CODE_WORD].copy_from_slice(&slot[..CODE_WORD]);
    stream.frame[CODE_WORD + MACHINE_WORDS..].copy_from_slice(&slot[CODE_WORD..]);
    // The copy is what runs: the check may have the memory.
    const { assert!(check::SCRATCH <= 2 * PIECE_WORDS) };
    // SAFETY: the slot is larger, at an even address, and of bytes.
    let scratch = unsafe { &mut *slot.as_mut_ptr().cast::<[u8; check::SCRATCH]>() };
    let mut result = check::verify(frame(), (FEATURES & !FOREIGN) as u8, scratch);
    if !fits(&Image(frame())) {
        result = Err(Refusal::Memory as u8);
    }
    if let Err(refusal) = result {
        stream.result = refusal;
        forget(stream);
        return Err(Fault::ImageRefused);
    }
    let vm = vm();
    let (open, handler) = (vm.flags & (flag::EVENT | flag::ERROR), vm.handler);
    vm.begin(frame(), 0);
    vm.flags = open;
    vm.handler = handler;
    controller.program.pc = vm.pc.wrapping_sub(1);
    stream.next = after(stream.next);
    stream.begun = stream.begun.wrapping_add(1);
    stream.dry = false;
    stream.rests = false;
    Ok(true)
}

/// Whether a piece's cells and stacks fit into its pool.
fn fits(piece: &Image) -> bool {
    let of = |place: usize| usize::from(piece.byte(place as u16));
    let entries = of(at::CELLS) + of(at::STACK) + of(at::CALLS);
    4 * entries <= 2 * PIECE_POOL
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
        STREAM_SLOTS => u16::from(stream.places) + 1,
        STREAM_BYTES => 2 * PIECE_WORDS as u16 - HEADER as u16,
        _ => (FRAME as u16 - 9) / 2,
    }
}

/// A word of the axes' part of the profile.
pub fn write_machine(index: u16, value: u16) {
    let stream = stream();
    // What waits was sealed with the words before.
    forget(stream);
    let machine = &mut stream.frame[CODE_WORD..][..MACHINE_WORDS];
    if let Some(place) = machine.get_mut(usize::from(index)) {
        *place = value;
    }
}

/// A word of the next piece; with its last one it is complete.
///
/// # Errors
/// No slot is free or no job open, the piece is too long or its CRC wrong.
#[inline(never)]
pub fn write(index: u16, value: u16) -> Result<(), Exception> {
    let stream = stream();
    if !stream.open || stream.accepted.wrapping_sub(stream.begun) >= u16::from(stream.places) {
        return Err(Exception::Busy);
    }
    let filling = stream.filling;
    let slot = slot(filling);
    let Some(place) = slot.get_mut(usize::from(index)) else {
        return Err(Exception::IllegalValue);
    };
    *place = value;
    let piece = Waiting { slot, frame: &stream.frame };
    // The host does not know yet that what it sends was forgotten.
    if stream.call != 0 && index >= ANSWERS_WORD && piece.byte(ANSWERS) == 0 {
        return Err(Exception::Busy);
    }
    // What an earlier piece left here has another number.
    if index < CODE_WORD as u16
        || index + MACHINE_WORDS as u16 != (piece.word(at::LEN as u16) - 1) / 2
        || piece.word(at::PROFILE as u16) != stream.accepted
    {
        return Ok(());
    }
    if verify::sound(&piece, 2 * FRAME_WORDS as u16).is_none() {
        stream.result = Refusal::Crc as u8;
        return Err(Exception::DeviceFailure);
    }
    stream.result = 0;
    stream.call = 0;
    stream.filling = after(filling);
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
    let fault = controller.session.is(RunState::Fault);
    if !idle || fault {
        return Err(Exception::Busy);
    }
    if let Code::Open = code {
        stream.begun = 0;
        stream.next = 0;
        let places = if controller.trace.has_queue() { BESIDE_QUEUE } else { WAITING };
        stream.places = places as u8;
        stream.starved = 0;
        stream.running = false;
        stream.call = 0;
        forget(stream);
        stream.open = true;
        vm().give_cells();
        return Ok(());
    }
    if stream.accepted == stream.begun || controller.blocked() {
        return Err(Exception::Busy);
    }
    stream.owns = true;
    vm().flags = 0;
    vm().handler = 0;
    if follow(controller).is_err() {
        stream.owns = false;
        return Err(Exception::DeviceFailure);
    }
    stream.running = true;
    controller.begun();
    Ok(())
}
