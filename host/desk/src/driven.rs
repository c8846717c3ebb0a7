//! A machine whose program runs outside of the chip: a simulation's engine evaluates expressions and follows jumps, and hands
//! the machine one statement after the other.
//!
//! The chip's VM runs an image made by [`image`] that contains no program, only room: [`RINGS`] rings of [`SLOTS`]
//! instructions each, so that a statement that waits below an open handler keeps its slot, and addresses at which
//! handlers begin. When the VM reaches such an address, the engine is called and runs the handler itself. Everything else is
//! the machine's: faults, waits, events, the trace.

use firmware::machine::core;
use firmware::machine::vm::{Vm, YIELD};
use lang::fault::Fault;
use lang::image::{HEADER, Header, MAX_EVENTS, seal};
use lang::isa::Op;
use lang::profile::Profile;
use lang::record::{MachineRecord, feature};
use lang::vm::flag;

use super::{Desk, PER_MS, memory};

/// Bytes of a place: More, an instruction with three operands.
const SLOT: u16 = 8;
/// Places of a ring.
const SLOTS: u16 = 128;
/// The program's, an event handler's, an error handler's.
const RINGS: u16 = 3;
/// Where the handlers of events begin in the code, one place each; after them that of errors, and a place where nothing
/// stands.
const STUBS: u16 = RINGS * SLOTS * SLOT;
const ERROR: u16 = STUBS + MAX_EVENTS as u16 * SLOT;
const NOWHERE: u16 = ERROR + SLOT;
const CODE: u16 = NOWHERE + SLOT;
/// The data: number of handlers and their places, where the statement table lies, the table, a text of PRINT.
const TABLE: u16 = 1 + 2 * MAX_EVENTS as u16 + 2;
const TEXT: u16 = TABLE + CODE / SLOT;
/// Longest text that is printed at once.
pub const LONGEST_TEXT: usize = 255;
/// Calls: one for each handler that may be open.
const CALLS: u8 = 4;

/// Where the image lies.
pub const IMAGE: u16 = memory::AREA;
const START: u16 = IMAGE + (HEADER + MachineRecord::SIZE) as u16;

/// What the machine is to do next.
#[derive(Clone, Copy, Debug)]
pub enum Request {
    /// An instruction with its values.
    Code {
        /// Its bytes, as many as `length`.
        code: [u8; 4],
        /// See `code`.
        length: usize,
        /// Its values, as many as `count`.
        values: [i32; 5],
        /// See `values`.
        count: usize,
        /// No handler comes between it and what follows, nor while it waits.
        more: bool,
    },
    /// A fault that the engine has found.
    Fault(Fault),
}

/// What a handler is for that the machine has entered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entered {
    /// The ON line with this slot.
    Event(u8),
    /// A fault.
    Error,
}

/// See the module.
#[derive(Debug, Default)]
pub struct Driven {
    /// Time that the engine's own instructions take before the next request, ticks.
    owed: u64,
    request: Option<Request>,
    /// Requests that a handler came before.
    put_aside: Vec<Option<Request>>,
    /// Handlers that are open.
    depth: usize,
    /// The next free place of each ring.
    next: [u16; RINGS as usize],
    /// Line of the statement at each place.
    lines: Vec<u32>,
    /// Line of the statement that is under way.
    line: u32,
    /// Nothing is left to do.
    idle: bool,
    entered: Option<Entered>,
}

/// The image for a machine.
fn image(profile: &Profile) -> Vec<u8> {
    let mut data = vec![MAX_EVENTS as u8];
    (0..MAX_EVENTS as u16).for_each(|slot| data.extend((STUBS + slot * SLOT).to_le_bytes()));
    data.extend(TABLE.to_le_bytes());
    data.extend((0..CODE / SLOT).map(|_| SLOT as u8));
    data.extend([0; LONGEST_TEXT + 1]);
    let machine = MachineRecord::of(profile).to_bytes();
    let header = Header {
        features: (feature::LINES | feature::EVENTS) as u8,
        len: HEADER + machine.len() + usize::from(CODE) + data.len(),
        code_len: CODE.into(),
        entry: 0,
        cells: 0,
        stack: 8,
        frame: 8,
        calls: CALLS,
        keeps: 0,
        keep_base: 0,
        profile_hash: 0,
    };
    let code = vec![Op::End.code(); CODE.into()];
    let mut bytes = [&header.bytes()[..], &machine, &code, &data].concat();
    seal(&mut bytes);
    bytes
}

impl Desk {
    /// The image lies in flash, and programs are driven from now on.
    pub fn drive(&self, profile: &Profile) {
        self.put(IMAGE, &image(profile));
        *self.0.driven.borrow_mut() =
            Some(Driven { lines: vec![0; (CODE / SLOT).into()], ..Driven::default() });
    }

    fn with_driven<R>(&self, what: impl FnOnce(&mut Driven) -> R) -> Option<R> {
        self.0.driven.borrow_mut().as_mut().map(what)
    }

    /// A new program begins: nothing is asked for, no handler is open.
    pub fn forget_requests(&self) {
        self.with_driven(|own| {
            own.request = None;
            own.put_aside.clear();
            (own.depth, own.owed, own.idle, own.entered) = (0, 0, false, None);
        });
    }

    /// What follows is the doing of a statement of this line.
    pub fn set_line(&self, line: u32) {
        self.with_driven(|own| own.line = line);
    }

    /// Line of the statement at an address in the code.
    pub fn line_at(&self, pc: u16) -> u32 {
        let line = self.with_driven(|own| own.lines.get(usize::from(pc / SLOT)).copied());
        line.flatten().unwrap_or_default()
    }

    /// The engine's own instructions take this time, ticks.
    pub fn owe(&self, ticks: u64) {
        self.with_driven(|own| own.owed += ticks);
    }

    /// Time that is owed, ticks.
    pub fn owed(&self) -> u64 {
        self.with_driven(|own| own.owed).unwrap_or_default()
    }

    /// Asks for something; what was asked for before is done.
    pub fn ask(&self, request: Request) {
        self.with_driven(|own| {
            own.request = Some(request);
            own.idle = false;
        });
    }

    /// The machine is to look whether anything has come.
    pub fn wake(&self) {
        self.with_driven(|own| own.idle = false);
    }

    /// Whether a request has not been taken yet.
    pub fn is_asked(&self) -> bool {
        self.with_driven(|own| own.request.is_some()) == Some(true)
    }

    /// Whether the machine has done all that it was asked for.
    pub fn is_idle(&self) -> bool {
        self.with_driven(|own| own.idle) == Some(true)
    }

    /// The handler that the machine has entered since the last call.
    pub fn take_entered(&self) -> Option<Entered> {
        self.with_driven(|own| own.entered.take()).flatten()
    }

    /// A handler has been left: what it came before goes on.
    pub fn leave_handler(&self) {
        self.with_driven(|own| {
            own.depth = own.depth.saturating_sub(1);
            own.request = own.put_aside.pop().flatten();
        });
    }

    /// All handlers have been left, and with them what they came before.
    pub fn leave_all(&self) {
        self.with_driven(|own| {
            own.depth = 0;
            own.put_aside.clear();
        });
    }

    /// Whether the VM stands where a handler begins.
    pub fn stands_at_handler(pc: u16) -> bool {
        (START + STUBS..START + NOWHERE).contains(&pc)
    }

    /// Address of the handler of errors.
    pub fn error_handler() -> u16 {
        START + ERROR
    }

    /// A text of PRINT, at most [`LONGEST_TEXT`] bytes; gives the data offset by which it is printed.
    pub fn put_text(&self, text: &[u8]) -> u16 {
        let text = &text[..text.len().min(LONGEST_TEXT)];
        self.put(START + CODE + TEXT, &[text.len() as u8]);
        self.put(START + CODE + TEXT + 1, text);
        TEXT
    }

    /// The VM's turn in a driven program; `None` in one that is not.
    pub(super) fn run_driven(&self, vm: &mut Vm<Desk>) -> Option<u16> {
        let mut driven = self.0.driven.borrow_mut();
        let own = driven.as_mut()?;
        if Desk::stands_at_handler(vm.pc) {
            let slot = (vm.pc - START - STUBS) / SLOT;
            let event = usize::from(slot) < MAX_EVENTS;
            own.entered = Some(if event { Entered::Event(slot as u8) } else { Entered::Error });
            own.put_aside.push(own.request.take());
            own.depth += 1;
            own.idle = true;
            vm.pc = START + NOWHERE;
            // Who runs the handler says where something may come between.
            vm.flags |= flag::WITHIN;
            return Some(YIELD);
        }
        if own.owed != 0 {
            // To the end of the millisecond, as on the board.
            let now = self.ticks();
            let span = own.owed.min((now / PER_MS + 1) * PER_MS - now);
            own.owed -= span;
            let left = own.owed;
            drop(driven);
            self.spend(span);
            if left != 0 {
                return Some(YIELD);
            }
            return self.run_driven(vm);
        }
        let Some(request) = own.request.take() else {
            own.idle = true;
            return Some(YIELD);
        };
        let ring = own.depth.min(usize::from(RINGS) - 1);
        let place = ring as u16 * SLOTS + own.next[ring];
        own.next[ring] = (own.next[ring] + 1) % SLOTS;
        if let Some(line) = own.lines.get_mut(usize::from(place)) {
            *line = own.line;
        }
        drop(driven);
        let at = START + place * SLOT;
        match request {
            Request::Fault(fault) => {
                vm.pc = at + 1;
                Some(FAULT | u16::from(fault.number()))
            }
            Request::Code { code, length, values, count, more } => {
                self.put(at, &code[..length.min(code.len())]);
                vm.pc = at;
                values.iter().take(count).for_each(|value| vm.push(*value));
                vm.flags &= !flag::MORE;
                vm.flags |= if more { flag::MORE } else { 0 };
                Some(core::run(vm, |_| false))
            }
        }
    }
}

/// What the VM's core adds to the number of a fault.
const FAULT: u16 = 0x100;
