//! RAM of programs and streamed pieces, and the addresses at which the VM's core finds it and its registers.

use crate::port::F5529;
use core::mem::offset_of;
use core::ptr::addr_of;
use firmware::machine::Controller;
use firmware::machine::pool::MEMORY_WORDS;
use firmware::machine::stream::FRAME_WORDS;
use firmware::machine::vm::Vm;
use lang::isa::Op;

/// Call stack, cells, expression stack; after those of a streamed piece the pieces that wait.
pub static mut CALLS: [u16; MEMORY_WORDS] = [0; MEMORY_WORDS];
/// The image of the streamed piece that runs.
static mut FRAME: [u16; FRAME_WORDS] = [0; FRAME_WORDS];
/// What the VM stands at while it waits for a handler.
static NOTHING: u8 = Op::End as u8;

/// Address of the pool.
#[inline(always)]
pub fn pool() -> u16 {
    addr_of!(CALLS) as u16
}

/// Address of the frame.
#[inline(always)]
pub fn frame() -> u16 {
    addr_of!(FRAME) as u16
}

/// Address of an END.
#[inline(always)]
pub fn nothing() -> u16 {
    addr_of!(NOTHING) as u16
}

/// Registers of the VM.
pub type State = Vm<F5529>;
/// Where they lie in the controller.
pub const VM_AT: usize = offset_of!(Controller<F5529>, vm);
