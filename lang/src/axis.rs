//! The three axes of a machine.

/// One axis; the discriminant is its index in every table, image and register.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Axis {
    /// First axis.
    X = 0,
    /// Second axis.
    Y = 1,
    /// Third axis, usually the spindle's; canned cycles and rapid lifts use it.
    Z = 2,
}

impl Axis {
    /// All axes in index order.
    pub const ALL: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

    /// Index 0..=2.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The axis with this index, if there is one.
    pub const fn from_index(index: usize) -> Option<Axis> {
        match index {
            0 => Some(Axis::X),
            1 => Some(Axis::Y),
            2 => Some(Axis::Z),
            _ => None,
        }
    }

    /// `X`, `Y` or `Z`.
    pub const fn letter(self) -> char {
        match self {
            Axis::X => 'X',
            Axis::Y => 'Y',
            Axis::Z => 'Z',
        }
    }

    /// The axis of a letter in either case.
    pub const fn from_letter(letter: char) -> Option<Axis> {
        match letter {
            'X' | 'x' => Some(Axis::X),
            'Y' | 'y' => Some(Axis::Y),
            'Z' | 'z' => Some(Axis::Z),
            _ => None,
        }
    }
}

/// A set of axes, bit n for axis n.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AxisSet(pub u8);

impl AxisSet {
    /// Whether `axis` is in the set.
    pub const fn contains(self, axis: Axis) -> bool {
        self.0 >> (axis as u8) & 1 != 0
    }

    /// The set with `axis` added.
    #[must_use]
    pub const fn with(self, axis: Axis) -> AxisSet {
        AxisSet(self.0 | 1 << (axis as u8))
    }
}
