//! Where the VM's registers and memory lie; `ram.rs` lays them out.

pub use crate::ram::FRAME_AT;
use lang::part::Part;

/// The part that this image is for.
pub const PART: Part = if cfg!(feature = "whole") {
    firmware::WHOLE
} else {
    Part::named(env!("PASAPAS_PART")).expect("build.rs knows it")
};

/// Offset of the registers from their symbol.
pub const VM_AT: usize = 0;

/// Registers of the VM, as its core loads and stores them: `VM_STATE` in `ram.rs`.
#[repr(C)]
pub struct State {
    /// Address in flash of the next instruction.
    pub pc: u16,
    /// Address of the value below the top.
    pub sp: u16,
    /// Top of the expression stack, low word first.
    pub top: i32,
    /// Address of the code.
    pub code: u16,
    /// Address of the cells, where the call stack ends.
    pub cells: u16,
    /// Place of the next entry of the call stack.
    pub calls: u16,
    /// `sp` of the open FUNCTION's empty stack.
    pub base: u16,
    /// Address of the program's data.
    pub data: u16,
    /// Address of the error handler, 0 for none.
    pub handler: u16,
    /// Address of the failing instruction of the last fault.
    pub fault_pc: u16,
    /// Number of the last fault.
    pub fault: u8,
    /// Input that caused it, from 1, or 0.
    pub fault_input: u8,
    /// Come back at the next backward jump or call.
    pub poll: u8,
    /// [`lang::vm::flag`] bits.
    pub flags: u8,
    /// Number of cells.
    pub cell_count: u8,
    /// How the run is to end: not the VM's, it fills the word.
    pub ending: u8,
}

unsafe extern "C" {
    /// The VM.
    #[link_name = "VM_STATE"]
    pub static mut VM: State;
    /// The pool.
    #[link_name = "POOL"]
    pub static mut CALLS: [u8; POOL];
}

/// Bytes of the pool: `POOL` to `POOL_END` in `ram.rs`.
pub const POOL: usize = PART.pool[0] as usize;
/// Offset from [`VM`] of the end of the call stack: the cells follow it.
pub const CALLS_END_AT: i16 = core::mem::offset_of!(State, cells) as i16;
/// Nobody needs registers over a call of the core.
pub const SAVES: u16 = 0;
