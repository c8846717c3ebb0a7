//! Jobs larger than a board's memory.
//!
//! A board that can stream runs straight-line pieces from RAM: [`feed`] runs the program's control
//! flow on the host, [`job`] writes what it does to the machine into pieces ([`piece`]); [`crate::track`]
//! follows what the job sets, so that it can begin anew in the middle, [`check`] does so for the whole
//! job before the first move; [`pump`] keeps the board supplied. For a board without that, [`cut`] makes
//! programs of their own that are stored one after the other.
//!
//! Handlers of ON IN, ON EVERY and ON ERROR are the host's as all control flow is. The board knows what
//! is armed; when a handler is due it stops where a stored program would, forgets what it has not begun,
//! and calls. The host has kept the program's state at each statement that the board may stand at: it
//! goes back there, enters the handler as the VM does, and feeds on. So there is one meaning of
//! handlers, the VM's, and [`late`] says what it costs in time.

pub mod chain;
pub mod check;
pub mod cut;
pub mod feed;
pub mod job;
pub mod late;
pub mod near;
pub mod piece;
pub mod pump;
pub mod way;

#[cfg(test)]
mod tests;
