//! The instruction set. [`table`] holds the rows; here is what their columns mean.
//!
//! An operation is a byte. With bit 7 set it is a [`Formula`], whose operand byte names a word; else a
//! number: of a routine in [`table::ROUTINES`], whose addresses the machine keeps, or behind those of an
//! operation of the machine's own in [`table::OWN`].

mod routines;
mod table;

pub use routines::{CALLED, ROUTINES};
pub use table::{FORMULAS, Formula, OWN, Own};

/// Bits of a formula's first byte: it is one; its operand is an offset in the record at r9; with that 16
/// bits of it, else the axis is added; the operand is an integer, made a scaled number first.
pub const FORMULA: u8 = 0x80;
/// See [`FORMULA`].
pub const RECORD: u8 = 0x40;
/// See [`FORMULA`].
pub const AXIS: u8 = 0x20;
/// See [`FORMULA`].
pub const NEW: u8 = 0x10;
/// What `FAULT` adds to its number.
pub const FAULTED: u16 = 0x100;
/// What `NOT_YET_` leaves.
pub const NOT_YET: u16 = 1;
/// Where the words of formulas are counted from: the start of RAM.
pub const WORDS: u16 = 0x0200;

/// What a routine or operation takes of the accumulator r13:r12.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Takes {
    /// Nothing.
    Nothing,
    /// r12.
    Low,
    /// All of it.
    Long,
}

/// What a routine or operation leaves in the accumulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gives {
    /// What was there.
    Kept,
    /// A new r12 beside the old r13.
    Low,
    /// A new r12; r13 is lost.
    Only,
    /// A new value of 32 bits.
    Long,
    /// Nothing that may be used.
    Lost,
}

/// What flags say behind an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flags {
    /// What they said before.
    Kept,
    /// Those of these letters hold, of Z, N, C and V.
    Are(&'static str),
}

/// Flags of which none holds.
pub const LOST: Flags = Flags::Are("");

/// What stands behind an operation's byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operand {
    /// A number from 0 to 255.
    Number,
    /// One modulo 256.
    Wrapped,
    /// A power of two, modulo 256.
    Power,
    /// A word of 16 bits, low byte first.
    Word,
    /// The address of a routine, in the same way.
    Routine,
    /// A byte of RAM, counted from `BYTES`.
    Byte,
    /// Bytes from here to the place to go on at, signed.
    Jump,
    /// One of them for each value of r12; 0 is this very place.
    Places,
    /// Pairs of a register's address and its value; 0 ends them.
    Pairs,
}

/// Where execution goes from an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// To the next one.
    On,
    /// To the next one, or the routine ends with what is in r12.
    OnOrReturn,
    /// To the next one, or to where its operand says with the flags of before.
    If,
    /// To where its operand says.
    Goto,
    /// The routine ends.
    Returns,
    /// Instructions follow.
    Instructions,
}

/// An operation of the machine's own, or a formula's.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Its number in the assembler: `DO_` or, of a formula, `F_` and this.
    pub name: &'static str,
    /// Its notation; `DO name` when there is none.
    pub notation: Option<&'static str>,
    /// The machine's label.
    pub label: &'static str,
    /// What follows it.
    pub operands: &'static [Operand],
    /// What it takes of the accumulator.
    pub takes: Takes,
    /// What it leaves there.
    pub gives: Gives,
    /// What flags say behind it, when it does not jump.
    pub flags: Flags,
    /// Pointers that it uses: `a`, the axis in r8, and `r`, the record in r9.
    pub needs: &'static str,
    /// Pointers that are good behind it.
    pub sets: &'static str,
    /// Where execution goes.
    pub next: Next,
    /// What it does.
    pub means: &'static str,
}

/// A routine, of instructions or of micro-code, as its callers see it.
#[derive(Clone, Copy, Debug)]
pub struct Routine {
    /// Its number in the assembler: `DO_` and this.
    pub name: &'static str,
    /// Its label.
    pub label: &'static str,
    /// What follows its number.
    pub operands: &'static [Operand],
    /// What it takes of the accumulator.
    pub takes: Takes,
    /// What it leaves there.
    pub gives: Gives,
    /// Flags that hold behind it.
    pub flags: &'static str,
    /// Pointers that it uses: see [`Row::needs`].
    pub needs: &'static str,
    /// Pointers that are good behind it.
    pub sets: &'static str,
    /// Pointers that are lost.
    pub loses: &'static str,
    /// Whether it may end its caller, with what is in r12 then.
    pub ends_caller: bool,
    /// Temporary bytes that its caller has written for it.
    pub reads: Scratch,
    /// Temporary bytes that instructions of it write.
    pub writes: Scratch,
    /// Temporary bytes that are its result.
    pub leaves: Scratch,
    /// Numbers of the planner among the temporary bytes that it reads.
    pub planner: Scratch,
    /// Temporary bytes that it reads on those of its ways alone for which its caller has written them.
    pub finds: Scratch,
    /// What it does.
    pub means: &'static str,
}

impl Routine {
    const fn new(name: &'static str, takes: Takes, gives: Gives, flags: &'static str) -> Routine {
        Routine {
            name,
            label: name,
            operands: &[],
            takes,
            gives,
            flags,
            needs: "",
            sets: "",
            loses: "",
            ends_caller: false,
            reads: Scratch(0),
            writes: Scratch(0),
            leaves: Scratch(0),
            planner: Scratch(0),
            finds: Scratch(0),
            means: "",
        }
    }

    const fn at(mut self, label: &'static str) -> Routine {
        self.label = label;
        self
    }
    const fn with(mut self, operands: &'static [Operand]) -> Routine {
        self.operands = operands;
        self
    }
    const fn needs(mut self, pointers: &'static str) -> Routine {
        self.needs = pointers;
        self
    }
    const fn sets(mut self, pointers: &'static str) -> Routine {
        self.sets = pointers;
        self
    }
    const fn loses(mut self, pointers: &'static str) -> Routine {
        self.loses = pointers;
        self
    }
    const fn ends_caller(mut self) -> Routine {
        self.ends_caller = true;
        self
    }
    const fn reads(mut self, scratch: Scratch) -> Routine {
        self.reads = scratch;
        self
    }
    const fn writes(mut self, scratch: Scratch) -> Routine {
        self.writes = scratch;
        self
    }
    const fn leaves(mut self, scratch: Scratch) -> Routine {
        self.leaves = scratch;
        self
    }
    const fn planner(mut self, scratch: Scratch) -> Routine {
        self.planner = scratch;
        self
    }
    const fn finds(mut self, scratch: Scratch) -> Routine {
        self.finds = scratch;
        self
    }
    const fn means(mut self, means: &'static str) -> Routine {
        self.means = means;
        self
    }
}

/// Temporary bytes of RAM, a bit each: those of `TEMP`, of `LOCALS` (`BYTES`), of `V2` and of `LEFT`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Scratch(pub u32);

impl Scratch {
    /// The places in the order of their bits, with their bytes.
    pub const PLACES: [(&'static str, u8); 4] =
        [("TEMP", 12), ("BYTES", 4), ("V2", 4), ("LEFT", 4)];
    /// None.
    pub const NONE: Scratch = Scratch(0);
    /// The pace of a move, or what a routine of the planner keeps in its place.
    pub const TEMP: Scratch = Scratch(0xFFF);
    /// The speed of that pace.
    pub const SPEED: Scratch = Scratch(0xF);
    /// Bytes of a statement or command; while axes move the planner's `TICK`.
    pub const LOCALS: Scratch = Scratch(0xF << 12);
    /// The instruction's flags.
    pub const FLAGS: Scratch = Scratch(1 << 12);
    /// Its second byte of them, or axes that have steps to make.
    pub const RAMPS: Scratch = Scratch(2 << 12);
    /// What `rate` takes, or a level.
    pub const UNIT: Scratch = Scratch(4 << 12);
    /// The unit and frame of a place.
    pub const FRAME_OF: Scratch = Scratch(8 << 12);
    /// `SPARE`; while axes move the planner's `V2`.
    pub const SPARE: Scratch = Scratch(0xF << 16);
    /// `SPARE_TOO`; while axes move the planner's `LEFT`.
    pub const SPARE_TOO: Scratch = Scratch(0xF << 20);
    /// All of them.
    pub const ALL: Scratch = Scratch(0xFF_FFFF);

    /// Those of either.
    #[must_use]
    pub const fn and(self, other: Scratch) -> Scratch {
        Scratch(self.0 | other.0)
    }

    /// Those that are not of the other.
    #[must_use]
    pub const fn less(self, other: Scratch) -> Scratch {
        Scratch(self.0 & !other.0)
    }

    /// Whether there are none.
    #[must_use]
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }
}

/// Numbers below this one are routines'.
#[must_use]
pub fn owns() -> u8 {
    ROUTINES.len() as u8
}

/// From this number on the machine has taken the byte that follows.
#[must_use]
pub fn with_byte() -> u8 {
    owns() + OWN.iter().position(|row| row.name == Own::FIRST_WITH_BYTE).unwrap_or(OWN.len()) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_fit_into_seven_bits() {
        assert!(ROUTINES.len() + OWN.len() <= 0x80);
    }

    #[test]
    fn what_takes_a_byte_stands_last() {
        let first = usize::from(with_byte() - owns());
        assert!(OWN[first..].iter().all(|row| !row.operands.is_empty()));
        assert!(first < OWN.len());
    }

    #[test]
    fn names_are_unique() {
        let names = ROUTINES.iter().map(|row| row.name).chain(OWN.iter().map(|row| row.name));
        let names = names.chain(CALLED.iter().map(|row| row.name)).collect::<Vec<_>>();
        for (n, name) in names.iter().enumerate() {
            assert!(!names[..n].contains(name), "{name}");
        }
    }

    #[test]
    fn a_jump_is_the_last_operand() {
        for row in OWN {
            let jump =
                row.operands.iter().position(|o| matches!(o, Operand::Jump | Operand::Places));
            assert!(jump.is_none_or(|at| at + 1 == row.operands.len()), "{}", row.name);
            let jumps = matches!(row.next, Next::If | Next::Goto);
            assert_eq!(jump.is_some(), jumps, "{}", row.name);
        }
    }
}
