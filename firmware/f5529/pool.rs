//! The memory of what the VM runs: cells, expression stack and call stack, and behind those of a streamed piece
//! the pieces that wait.

use crate::chip::PART;
use core::ptr::{addr_of, addr_of_mut};

/// Words of RAM for cells, expression stack and call stack: the part's pool.
pub const POOL_WORDS: usize = PART.pool[0] as usize / 2;

/// Words of the pool of a streamed piece, which has a cell and no calls. The pieces that wait lie behind it.
pub const PIECE_POOL: usize = 64;
/// Words of those: 2 KB.
pub const WAITING_WORDS: usize = 1008;
/// Words of the last of them, in which a queue of events may be instead.
pub const QUEUE_WORDS: usize = 3 * WAITING_WORDS / 8;
/// Where that begins, in words.
pub const QUEUE: usize = PIECE_POOL + WAITING_WORDS - QUEUE_WORDS;
// A request that brings a program lies between, too.
const _: () = assert!(QUEUE >= POOL_WORDS + 64);
/// Words of the pool, or of that of a piece and those that wait.
const MEMORY_WORDS: usize = PIECE_POOL + WAITING_WORDS;
const _: () = assert!(MEMORY_WORDS >= POOL_WORDS);

/// The pool: call stack from its start upward, cells behind it, the expression stack from its end
/// downward.
pub static mut CALLS: [u16; MEMORY_WORDS] = [0; MEMORY_WORDS];

/// Address of the pool.
pub fn pool() -> u16 {
    addr_of!(CALLS) as u16
}

/// End of the pool of what the VM stands in.
pub fn pool_end() -> u16 {
    let words = if crate::streams() { PIECE_POOL } else { POOL_WORDS };
    pool() + 2 * words as u16
}

/// The memory behind the first `words` of the pool: nobody else uses it meanwhile.
pub fn behind(words: usize) -> &'static mut [u16] {
    // SAFETY: the caller's, who gives this back before the VM runs.
    let memory = unsafe { &mut *addr_of_mut!(CALLS) };
    memory.get_mut(words..).unwrap_or_default()
}

/// The value of a slot of the pool.
pub fn load(address: u16) -> i32 {
    // SAFETY: called for slots of the pool only; they are aligned to words as i32 is here.
    unsafe { (address as *const i32).read() }
}

/// Changes a slot of the pool.
pub fn store(address: u16, value: i32) {
    // SAFETY: as for `load`.
    unsafe { (address as *mut i32).write(value) }
}
