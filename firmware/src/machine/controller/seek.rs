//! Targets of homing and probing moves.

use crate::motion::Pace;

/// One of them is under way at most.
pub struct Seek {
    /// The reference run.
    pub plan: Plan,
    /// What ends a probe move: `(inputs & and) ^ xor` is not 0, input n in bit n - 1.
    pub and: u32,
    /// See `and`.
    pub xor: u32,
}

impl Seek {
    /// Whether these levels end a probe move.
    pub fn probes(&self, inputs: u32) -> bool {
        (inputs & self.and) ^ self.xor != 0
    }
}

/// A reference run, in steps.
pub struct Plan {
    /// Input number of the switch.
    pub input: u8,
    /// Its level when closed.
    pub closed: bool,
    /// It lies in positive direction.
    pub positive: bool,
    /// Speed toward it and ramps.
    pub pace: Pace,
    /// Speed off it, steps/s.
    pub slow: u32,
    /// How far to look for it.
    pub stroke: i32,
    /// Rest between the two, ms.
    pub pause: u16,
    /// Position where it opens.
    pub position: i32,
    /// Clearance move, signed.
    pub clearance: i32,
}
