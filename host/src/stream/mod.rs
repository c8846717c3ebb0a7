//! Jobs larger than a board's memory.
//!
//! A board that can stream runs straight-line pieces from RAM: [`feed`] runs the program's control
//! flow on the host and writes what it does to the machine into pieces ([`piece`]); [`place`]
//! follows what the job sets, so that it can begin anew in the middle; [`pump`] keeps the board
//! supplied. For a board without that,
//! [`cut`] makes programs of their own that are stored one after the other.

pub mod check;
pub mod cut;
pub mod feed;
pub mod job;
pub mod piece;
pub mod place;
pub mod pump;

#[cfg(test)]
mod tests;
