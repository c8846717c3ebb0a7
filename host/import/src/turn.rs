//! Mirror and shift: a circuit board's bottom side, a file whose zero lies elsewhere.

use lang::axis::Axis;

use super::script::mm;

/// How places of a file become places of the script: first the mirror, then the shift.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Turn {
    /// The axis whose values change their sign: X or Y.
    pub mirror: Option<Axis>,
    /// How far all places go then: X and Y, um.
    pub shift: [i64; 2],
}

impl Turn {
    /// Whether it leaves places where they are.
    pub fn is_none(&self) -> bool {
        *self == Turn::default()
    }

    /// A place, X and Y in um.
    pub(crate) fn place(&self, at: [i64; 2]) -> [i64; 2] {
        let [x, y] = self.way(at);
        [x + self.shift[0], y + self.shift[1]]
    }

    /// A way between two places: it is mirrored only.
    pub(crate) fn way(&self, [x, y]: [i64; 2]) -> [i64; 2] {
        match self.mirror {
            Some(Axis::X) => [-x, y],
            Some(Axis::Y) => [x, -y],
            _ => [x, y],
        }
    }

    /// What it does, in words; nothing where it does nothing.
    pub(crate) fn words(&self) -> Option<String> {
        let mirrored =
            self.mirror.map(|axis| format!("mirrored: {} has the other sign", axis.letter()));
        let [x, y] = self.shift.map(mm);
        let shifted = (self.shift != [0; 2]).then(|| format!("shifted by X {x}, Y {y}"));
        let parts: Vec<String> = mirrored.into_iter().chain(shifted).collect();
        (!parts.is_empty()).then(|| parts.join(", then "))
    }
}
