//! Placement files become jobs that pick parts from feeders and place them, without a computer beside
//! the machine.
//!
//! [`import::placement`] reads the files; here parts are turned and shifted onto the machine
//! ([`onto`](frame::onto)), each gets a feeder ([`feeders`]), and a script is written ([`job`]) that a
//! person would go on editing.

pub mod feeders;
pub mod frame;
pub mod job;
#[cfg(test)]
mod tests;

/// A part as it is to be placed.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// Its reference.
    pub name: String,
    /// Value and package, for people.
    pub what: String,
    /// Machine X and Y, um.
    pub at: [i64; 2],
    /// How it lies on the machine, degrees, counter-clockwise.
    pub turned: f64,
    /// Number of its feeder in the file.
    pub feeder: usize,
}
