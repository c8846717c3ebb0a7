//! Where the VM's core, which both images share, finds its registers and memory.

pub use crate::CONTROLLER as VM;
pub use crate::chip::PART;
pub use crate::ram::{CALLS, State, VM_AT};
use core::mem::offset_of;

/// Offset in the registers of the end of the call stack.
pub const CALLS_END_AT: i16 = offset_of!(State, calls_end) as i16;
/// Offset in the registers of the word in which the core keeps the machine stack's address.
pub const FRAME_AT: i16 = offset_of!(State, frame) as i16;
/// The core keeps its caller's registers.
pub const SAVES: u16 = 1;
