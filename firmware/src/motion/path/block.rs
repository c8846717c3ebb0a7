//! The blocks of a path as the caller gives them.

/// How fast a block may go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feed {
    /// As fast as every axis can.
    Rapid,
    /// um/s along the path.
    Um(u32),
    /// steps/s along the path.
    Steps(u32),
}

/// An interpolated move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// Distance of each axis, steps.
    pub steps: [i32; 3],
    /// The same in um as it was commanded, from which its direction follows: whole steps would turn the
    /// chords of a curve to and fro. All 0: from the steps.
    pub um: [i32; 3],
    /// How it runs.
    pub manner: Manner,
}

/// [`Manner::power`]: the power is 0 to [`FULL`] and follows the speed.
pub const FOLLOWS: u16 = 1 << 15;
/// The most that such a power comes to, when an override makes the speed higher than what was programmed.
pub const FULL: u16 = 1 << 14;

/// How a block runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Manner {
    /// Its speed.
    pub feed: Feed,
    /// Come to rest at the end (G61).
    pub exact: bool,
    /// Power of a laser on its way, below [`FOLLOWS`], which may be added.
    pub power: u16,
    /// What the caller knows it by, 20 bits: comes back with its first segment.
    pub tag: u32,
}

impl Manner {
    /// Dark.
    pub const fn new(feed: Feed, exact: bool) -> Manner {
        Manner { feed, exact, power: 0, tag: 0 }
    }
}
