//! The virtual machine: runs the code of a verified image.
//!
//! It owns no memory and knows no hardware. The caller brings the image, one slice for cells,
//! expression stack and call stack, and a [`State`]; it calls `Vm::run`, does what the returned
//! [`Exit`] asks for, and calls again. A core written in assembly works on the same memory and the
//! same state, so that the two can take turns.
//!
//! The pool: cells from its start, four bytes each, least byte first; behind them the expression
//! stack, growing upward; the call stack from the end of [`Header::pool_bytes`] downward.

use crate::fault::Fault;
use crate::image::Header;

/// Why the VM came back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// The instruction at `pc` is an effect; its arguments are on the stack. Go on with
    /// `Vm::complete` or `Vm::fault`.
    Effect,
    /// The slice is used up; call again.
    Budget,
    /// An event handler or an error handler was left; [`State::flags`] says which are still open.
    HandlerEnd,
    /// The instruction at `pc` failed; go on with `Vm::fault`.
    Fault(Fault),
    /// The run has ended.
    End,
}

/// Bits of [`State::flags`].
pub mod flag {
    /// An event handler is open.
    pub const EVENT: u8 = 1;
    /// An error handler is open.
    pub const ERROR: u8 = 1 << 1;
    /// The next effect does not end its statement.
    pub const MORE: u8 = 1 << 2;
}

/// Kinds of entries of the call stack: the top four bits of an entry of two bytes, the top byte of
/// one of four. An entry of a FUNCTION has [`entry::FUNC`] set and, below it, the depth of the
/// expression that calls it.
pub mod entry {
    /// GOSUB
    pub const GOSUB: u8 = 1;
    /// SUB
    pub const SUB: u8 = 2;
    /// Event handler.
    pub const EVENT: u8 = 3;
    /// Error handler; its address is that of the failing instruction.
    pub const ERROR: u8 = 4;
    /// FUNCTION, with bits 0..2 the depth.
    pub const FUNC: u8 = 8;
}

/// No error handler.
pub const NO_HANDLER: usize = usize::MAX;

/// Registers of the VM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State {
    /// Address of the next instruction; at an effect or a fault, of that instruction.
    pub pc: usize,
    /// Values on the expression stack.
    pub sp: u8,
    /// How many of them belong to callers of the open FUNCTIONs.
    pub base: u8,
    /// Entries on the call stack.
    pub calls: u8,
    /// [`flag`] bits.
    pub flags: u8,
    /// Address of the error handler, or [`NO_HANDLER`].
    pub handler: usize,
    /// Number of the last fault, 0 before one: ERR.
    pub fault: u8,
    /// Where it happened.
    pub fault_pc: usize,
}

impl State {
    /// The state in which a run begins.
    pub const fn new(header: &Header) -> State {
        State {
            pc: header.entry,
            sp: 0,
            base: 0,
            calls: 0,
            flags: 0,
            handler: NO_HANDLER,
            fault: 0,
            fault_pc: 0,
        }
    }
}
