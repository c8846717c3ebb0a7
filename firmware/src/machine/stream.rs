//! A job larger than the program area, run from RAM in pieces (`lang::wire`, Streaming).
//!
//! Flash cannot be written while steps are made, so the pieces stay in RAM: [`WAITING`] of them, without the axes'
//! part of the profile, which is the same for all. They lie in the memory that a stored program has for its cells. The piece
//! that runs is a copy with that part in front: an image like a stored one. The code is linked after the program
//! area, where the last segment has room. The VM, the check and the run state are those of stored programs; where a
//! piece ends the next one begins.

use crate::machine::chip::Chip;
use crate::machine::controller::Controller;
use crate::machine::flash::Image;
use crate::machine::pool::{self, MEMORY_WORDS, PIECE_POOL, QUEUE_WORDS, WAITING_WORDS};
use crate::modbus::FRAME;
use crate::verify::{self, Bytes, CODE, MACHINE};
use lang::fault::Fault;
use lang::image::{HEADER, at};
use lang::record::feature;
use lang::vm::flag;
#[allow(
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
/// Words of the image that runs.
pub const FRAME_WORDS: usize = PIECE_WORDS + MACHINE_WORDS;
/// What a piece must not use: its data is gone when it ends.
const FOREIGN: u16 = feature::KEEP | feature::LINES;
/// Byte of the header that says whether a piece answers a call: the first KEEP cell.
const ANSWERS: u16 = 17;
/// Its word.
const ANSWERS_WORD: u16 = ANSWERS / 2;
/// First word of the code in a piece.
const CODE_WORD: usize = HEADER / 2;
/// Bytes of scratch memory that a check may have.
pub const SCRATCH: usize = 2 * PIECE_WORDS - HEADER;

const _: () = assert!(WAITING as usize * PIECE_WORDS == WAITING_WORDS);

/// What is known of a streamed job.
pub struct Stream {
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
    /// The last piece was accepted.
    finished: bool,
    /// The newest piece has ended and no other is there.
    dry: bool,
    /// The axes rest since then.
    rests: bool,
    /// [`STREAM_CALL`]
    call: u16,
}

impl Default for Stream {
    fn default() -> Stream {
        Stream::new()
    }
}

impl Stream {
    /// At reset.
    pub const fn new() -> Stream {
        Stream {
            accepted: 0,
            begun: 0,
            places: WAITING as u8,
            filling: 0,
            next: 0,
            starved: 0,
            result: 0,
            open: false,
            running: false,
            finished: false,
            dry: false,
            rests: false,
            call: 0,
        }
    }

    /// Whether the run waits for the next piece.
    pub fn is_dry(&self) -> bool {
        self.dry
    }

    /// Whether a queue of events may have the memory of the last pieces.
    pub fn gives_queue(&self) -> bool {
        !self.open || u16::from(self.places) == BESIDE_QUEUE
    }

    /// The slot after one.
    fn after(&self, n: u8) -> u8 {
        if n + 1 >= self.places { 0 } else { n + 1 }
    }

    /// No piece waits, and none was the last.
    #[inline(never)]
    fn forget(&mut self) {
        self.accepted = self.begun;
        self.filling = self.next;
        self.finished = false;
        self.dry = false;
        self.rests = false;
    }

    /// A status register.
    pub fn read(&self, address: u16) -> u16 {
        match address {
            STREAM_ACCEPTED => self.accepted,
            STREAM_BEGUN => self.begun,
            STREAM_DRY => u16::from(self.dry),
            STREAM_STARVED => self.starved,
            STREAM_RESULT => u16::from(self.result),
            STREAM_CALL => self.call,
            STREAM_SLOTS => u16::from(self.places) + 1,
            STREAM_BYTES => 2 * PIECE_WORDS as u16 - HEADER as u16,
            _ => (FRAME as u16 - 9) / 2,
        }
    }
}

/// A piece that waits, as the image that it will be.
struct Waiting<C> {
    chip: C,
    /// Address of its slot.
    slot: u16,
}

impl<C: Chip> Bytes for Waiting<C> {
    fn byte(&self, offset: u16) -> u8 {
        const HEAD: u16 = HEADER as u16;
        self.chip.byte(if offset < HEAD {
            self.slot + offset
        } else if offset < CODE {
            self.chip.frame() + offset
        } else {
            self.slot + (offset - (CODE - HEAD)).min(2 * PIECE_WORDS as u16 - 1)
        })
    }

    fn crc(crc: u16, byte: u8) -> u16 {
        C::crc(crc, byte)
    }
}

impl<C: Chip> Controller<C> {
    /// Address of a slot for a piece that waits.
    fn slot_at(&self, n: u8) -> u16 {
        self.chip.pool() + 2 * (PIECE_POOL + usize::from(n) * PIECE_WORDS) as u16
    }

    /// Whether the run waits for a handler.
    pub fn awaits_handler(&self) -> bool {
        self.stream.call != 0 && self.vm.is_piece
    }

    /// A handler has begun, that of the event in `slot` or of the fault: what was to come is forgotten.
    #[inline(never)]
    pub fn call_host(&mut self, place: Called, slot: u8, fault: u8) {
        let stream = &mut self.stream;
        let idle = stream.dry && matches!(place, Called::Behind) && fault == 0;
        let place = if idle { Called::Idle } else { place };
        stream.call = u16::from_le_bytes([place as u8 | slot << 4, fault]);
        stream.forget();
        self.vm.pc = self.chip.nothing();
    }

    /// The pieces that came are forgotten; none runs.
    pub fn forget_pieces(&mut self) {
        self.stream.forget();
        self.close_stream();
    }

    /// A stored program has its memory again.
    pub fn close_stream(&mut self) {
        self.vm.is_piece = false;
        self.stream.open = false;
    }

    /// Address of the memory after the pool of a stored program, for others while there are no pieces; its end is
    /// that of the whole memory, [`Controller::spare_words`].
    pub fn spare(&self) -> u16 {
        self.chip.pool() + 2 * const { pool::words(&C::PART) } as u16
    }

    /// Words of [`Controller::spare`].
    pub const fn spare_words() -> usize {
        MEMORY_WORDS - pool::words(&C::PART)
    }

    /// Address of [`SCRATCH`] bytes for the check of a stored program: those of the code of the piece that runs, which
    /// none does then.
    pub fn scratch(&self) -> u16 {
        self.chip.frame() + CODE
    }

    /// The piece has come to its end: the next one begins, or the run waits for it; `false` when it was
    /// the last.
    ///
    /// # Errors
    /// Its check refuses the next one.
    pub fn follow_piece(&mut self) -> Result<bool, Fault> {
        if !self.vm.is_piece {
            return Ok(false);
        }
        if self.stream.begun == self.stream.accepted {
            if self.stream.finished {
                return Ok(false);
            }
            // The end is executed again.
            self.vm.pc -= 1;
            self.stream.dry = true;
            self.stream.rests |= self.motor.rests();
            return Ok(true);
        }
        if self.stream.rests {
            self.stream.starved = self.stream.starved.wrapping_add(1);
        }
        let (slot, frame) = (self.slot_at(self.stream.next), self.chip.frame());
        self.chip.copy(slot, frame, CODE_WORD as u16);
        let code = (PIECE_WORDS - CODE_WORD) as u16;
        self.chip.copy(slot + HEADER as u16, frame + CODE, code);
        // The copy is what runs: the check may have the memory of the slot.
        let mut result = self.chip.check(frame, (C::PART.features & !FOREIGN) as u8, slot);
        if !fits(&Image(self.chip.clone(), frame)) {
            result = Refusal::Memory as u8;
        }
        if result != 0 {
            self.stream.result = result;
            self.stream.forget();
            return Err(Fault::ImageRefused);
        }
        let (open, handler) = (self.vm.flags & (flag::EVENT | flag::ERROR), self.vm.handler);
        self.begin_image(frame, 0);
        self.vm.flags = open;
        self.vm.handler = handler;
        self.program.pc = self.vm.pc.wrapping_sub(1);
        let stream = &mut self.stream;
        stream.next = stream.after(stream.next);
        stream.begun = stream.begun.wrapping_add(1);
        stream.dry = false;
        stream.rests = false;
        Ok(true)
    }

    /// A word of the axes' part of the profile.
    pub fn write_stream_machine(&mut self, index: u16, value: u16) {
        // What waits was sealed with the words before.
        self.stream.forget();
        if usize::from(index) < MACHINE_WORDS {
            self.chip.set_word(self.chip.frame() + HEADER as u16 + 2 * index, value);
        }
    }

    /// A word of the next piece; with its last one it is complete.
    ///
    /// # Errors
    /// No slot is free or no job open, the piece is too long or its CRC wrong.
    #[inline(never)]
    pub fn write_piece(&mut self, index: u16, value: u16) -> Result<(), Exception> {
        let waiting = self.stream.accepted.wrapping_sub(self.stream.begun);
        if !self.stream.open || waiting >= u16::from(self.stream.places) {
            return Err(Exception::Busy);
        }
        if usize::from(index) >= PIECE_WORDS {
            return Err(Exception::IllegalValue);
        }
        let slot = self.slot_at(self.stream.filling);
        self.chip.set_word(slot + 2 * index, value);
        let piece = Waiting { chip: self.chip.clone(), slot };
        // The host does not know yet that what it sends was forgotten.
        if self.stream.call != 0 && index >= ANSWERS_WORD && piece.byte(ANSWERS) == 0 {
            return Err(Exception::Busy);
        }
        // What an earlier piece left here has another number.
        if index < CODE_WORD as u16
            || index + MACHINE_WORDS as u16 != (piece.word(at::LEN as u16).wrapping_sub(1)) / 2
            || piece.word(at::PROFILE as u16) != self.stream.accepted
        {
            return Ok(());
        }
        let stream = &mut self.stream;
        if verify::sound(&piece, 2 * FRAME_WORDS as u16).is_none() {
            stream.result = Refusal::Crc as u8;
            return Err(Exception::DeviceFailure);
        }
        stream.result = 0;
        stream.call = 0;
        // Who feeds the job has not said that the piece before was the last.
        stream.finished = false;
        stream.filling = stream.after(stream.filling);
        stream.accepted = stream.accepted.wrapping_add(1);
        Ok(())
    }

    /// A code for STREAM_CONTROL; `idle` tells whether no program runs and no axis moves.
    ///
    /// # Errors
    /// Busy, or a code that there is not.
    #[inline(never)]
    pub fn control_stream(&mut self, value: u16, idle: bool) -> Result<(), Exception> {
        let code = Code::from_number(value).ok_or(Exception::IllegalValue)?;
        let stream = &mut self.stream;
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
        let fault = self.session.is(RunState::Fault);
        if !idle || fault {
            return Err(Exception::Busy);
        }
        if let Code::Open = code {
            stream.begun = 0;
            stream.next = 0;
            let places = if self.trace.has_queue() { BESIDE_QUEUE } else { WAITING };
            stream.places = places as u8;
            stream.starved = 0;
            stream.running = false;
            stream.call = 0;
            stream.forget();
            stream.open = true;
            self.vm.give_cells();
            return Ok(());
        }
        if stream.accepted == stream.begun || self.blocked() {
            return Err(Exception::Busy);
        }
        self.vm.is_piece = true;
        self.vm.flags = 0;
        self.vm.handler = 0;
        if self.follow_piece().is_err() {
            self.vm.is_piece = false;
            return Err(Exception::DeviceFailure);
        }
        self.stream.running = true;
        self.begun();
        Ok(())
    }
}

/// Whether a piece's cells and stacks fit into its pool.
fn fits<C: Chip>(piece: &Image<C>) -> bool {
    let of = |place: usize| usize::from(piece.byte(place as u16));
    let entries = of(at::CELLS) + of(at::STACK) + of(at::CALLS);
    4 * entries <= 2 * PIECE_POOL
}
