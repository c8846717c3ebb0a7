//! The VM's memory and the instructions that its assembly core leaves to Rust.

use core::ptr::{addr_of, addr_of_mut};
use lang::vm::flag;

/// Words of RAM for cells, expression stack and call stack; see the RAM map in `main.rs`.
pub const POOL_WORDS: usize = 96;

/// The pool: call stack from its start upward, cells behind it, the expression stack from its end
/// downward.
pub static mut CALLS: [u16; POOL_WORDS] = [0; POOL_WORDS];

/// Registers of the VM, as the core loads and stores them.
#[repr(C)]
pub struct State {
    /// Address in flash of the next instruction.
    pub pc: u16,
    /// Address of the value below the top.
    pub sp: u16,
    /// Top of the expression stack, low word first.
    pub top: [u16; 2],
    /// Address of the code.
    pub code: u16,
    /// Address of the cells.
    pub cells: u16,
    /// The machine stack on entry of the core.
    pub frame: u16,
    /// Place of the next entry of the call stack.
    pub calls: u16,
    /// End of the call stack.
    pub calls_end: u16,
    /// `sp` of the open FUNCTION's empty stack.
    pub base: u16,
    /// Address of the program's data.
    pub data: u16,
    /// Come back at the next backward jump or call.
    pub poll: u8,
    /// [`flag`] bits.
    pub flags: u8,
}

/// The VM.
pub static mut VM: State = State {
    pc: 0,
    sp: 0,
    top: [0; 2],
    code: 0,
    cells: 0,
    frame: 0,
    calls: 0,
    calls_end: 0,
    base: 0,
    data: 0,
    poll: 0,
    flags: 0,
};

const _: u8 = flag::MORE;
