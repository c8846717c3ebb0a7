//! The VM's memory: call stack from its start upward, then cells, and the expression stack from its end downward. While a
//! job is streamed the waiting pieces lie after those.

/// Words of the pool of a streamed piece, which has a cell and no calls. The pieces that wait lie after it.
pub const PIECE_POOL: usize = 64;
/// Words of those: 2 KB.
pub const WAITING_WORDS: usize = 1008;
/// Words of the last of them, in which a queue of events may be instead.
pub const QUEUE_WORDS: usize = 3 * WAITING_WORDS / 8;
/// Where that begins, in words.
pub const QUEUE: usize = PIECE_POOL + WAITING_WORDS - QUEUE_WORDS;
/// Words of the pool, or of that of a piece and those that wait.
pub const MEMORY_WORDS: usize = PIECE_POOL + WAITING_WORDS;

/// Words of RAM for cells, expression stack and call stack of a stored program.
pub const fn words(part: &lang::part::Part) -> usize {
    let words = part.pool[0] as usize / 2;
    // A request that brings a program lies between the pool and the queue, too.
    assert!(QUEUE >= words + 64 && MEMORY_WORDS >= words);
    words
}
