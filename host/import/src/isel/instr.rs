//! Instructions of the card, read and checked, with their places.

use lang::axis::Axis;

/// Steps and rate (steps/s) of one pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pair {
    pub steps: i64,
    pub rate: i64,
}

/// The pairs of a move; Z has two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Pairs {
    /// X, Y and the first of Z.
    pub axes: [Option<Pair>; 3],
    /// The second of Z.
    pub back: Option<Pair>,
}

/// Where a jump goes: an index into the list, its length being the end.
pub(crate) type Target = usize;

/// One instruction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Op {
    /// `0`, `A`, `a`
    Relative(Pairs),
    /// `m`, `M`
    Absolute(Pairs),
    /// `6`
    UntilImpulse(Pairs),
    /// `1`
    Send(i64),
    /// `2`: goes on with `c`, jumps with `c` + 1.
    WaitChar { c: i64, jump: Option<Target> },
    /// `3 n,-k`; `times` 0 is for ever.
    Loop { times: i64, start: Target },
    /// `3 0,k` forward.
    Jump(Target),
    /// `4`
    Pulse(i64),
    /// `5`, tenths of a second.
    Delay(i64),
    /// `7`, `R`; highest axis first.
    Home(Axes),
    /// `8`: what is sent to another card, and whether its answer is awaited.
    Tell { text: String, wait: bool },
    /// `n`
    Zero(Axes),
    /// `e`: 0 XY, 1 XZ, 2 YZ.
    Plane(u8),
    /// `Z`: all three axes interpolate.
    Solid(bool),
    /// `F`: sense of the circles that follow.
    Clockwise(bool),
    /// `y`: length of the arc in steps, rate, start seen from the centre.
    Arc { length: i64, rate: i64, from: [i64; 2] },
    /// `p`: outputs from `first`; bit 1..8, or all eight.
    Port { first: i64, bit: i64, value: i64 },
    /// `o`: jumps where the input, or all eight, have the value.
    PortTest { bit: i64, value: i64, jump: Target },
}

/// An instruction with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Item {
    pub op: Op,
    /// Line and column in the source.
    pub line: u32,
    pub col: u32,
    /// As it stands there.
    pub text: String,
}

/// A set of axes as the card codes it: X 1, Y 2, Z 4.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Axes(pub u8);

impl Axes {
    /// All three.
    pub const ALL: Axes = Axes(7);

    /// Whether the axis is among them.
    pub const fn has(self, axis: Axis) -> bool {
        self.0 >> (axis as u8) & 1 != 0
    }

    /// Whether each of `other` is among them.
    pub const fn holds(self, other: Axes) -> bool {
        other.0 & !self.0 == 0
    }

    /// In order X, Y, Z.
    pub fn list(self) -> impl DoubleEndedIterator<Item = Axis> {
        Axis::ALL.into_iter().filter(move |axis| self.has(*axis))
    }

    /// Pairs of a move: one for each axis, Z has two.
    pub fn pairs(self) -> usize {
        self.list().count() + usize::from(self.has(Axis::Z))
    }
}

impl Op {
    /// Where the instruction may jump.
    pub fn target(&self) -> Option<Target> {
        match self {
            Op::Loop { start, .. } => Some(*start),
            Op::Jump(target) => Some(*target),
            Op::WaitChar { jump, .. } => *jump,
            Op::PortTest { jump, .. } => Some(*jump),
            _ => None,
        }
    }

    /// Whether the next instruction may follow.
    pub fn falls_through(&self) -> bool {
        !matches!(self, Op::Jump(_) | Op::Loop { times: 0, .. })
    }
}

impl Op {
    fn target_mut(&mut self) -> Option<&mut Target> {
        match self {
            Op::Loop { start: target, .. }
            | Op::Jump(target)
            | Op::WaitChar { jump: Some(target), .. }
            | Op::PortTest { jump: target, .. } => Some(target),
            _ => None,
        }
    }

    /// Moves the target of a jump by the place at which its list was put.
    pub fn shift(&mut self, base: usize) {
        if let Some(target) = self.target_mut() {
            *target += base;
        }
    }

    /// Sets the target of a jump. Backward and without a condition it is an endless loop.
    pub fn aim(&mut self, at: usize, to: Target) {
        if *self == Op::Jump(0) && to < at {
            *self = Op::Loop { times: 0, start: to };
        } else if let Some(target) = self.target_mut() {
            *target = to;
        }
    }
}
