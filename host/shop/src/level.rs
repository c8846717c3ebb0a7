//! Uneven surfaces: a map of heights corrects a job of G-code.
//!
//! [`Heights`] is read from what a probing script printed, or from a table; [`probe`] writes that
//! script; [`correct`] lays a job onto the heights. Lengths are in mm, places are work positions.

mod correct;
mod heights;
mod probe;
#[cfg(test)]
mod tests;
mod words;

pub use correct::{Corrected, correct};
pub use heights::Heights;
pub use probe::{Probe, probe};
