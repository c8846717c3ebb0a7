//! Operations from bytes.

use std::fmt;

use crate::isa::{self, FORMULAS, Formula, OWN, Operand, Own, ROUTINES, Row};

/// An image: its bytes and its symbols.
pub trait Code {
    /// The byte at an address.
    fn byte(&self, at: u16) -> u8;
    /// The address of a symbol.
    fn symbol(&self, name: &str) -> Option<u16>;
    /// The end of the list of a switch that begins at `at`: its label `micro.places` with a number.
    fn places_end(&self, at: u16) -> Option<u16>;
    /// The word at an address.
    fn word(&self, at: u16) -> u16 {
        u16::from_le_bytes([self.byte(at), self.byte(at.wrapping_add(1))])
    }
}

/// What an operation is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A formula with the word that it names.
    Formula(Formula, Place),
    /// A routine, by its place in [`ROUTINES`].
    Routine(usize),
    /// One of the machine's own.
    Own(Own),
}

/// What a formula names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// The address of a word of RAM, or the offset in the record at r9.
    pub at: u16,
    /// It is that offset.
    pub record: bool,
    /// r8 is added.
    pub axis: bool,
    /// Only 16 bits of the record are read.
    pub short: bool,
    /// What is read is made a scaled number.
    pub new: bool,
}

/// An operation and where it stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Op {
    /// Its address.
    pub at: u16,
    /// Its bytes.
    pub size: u16,
    /// What it is.
    pub kind: Kind,
    /// Its operands but jumps: numbers, words, addresses of bytes.
    pub operands: Vec<u16>,
    /// Where it may jump to.
    pub targets: Vec<u16>,
}

impl Op {
    /// Where the next one stands.
    #[must_use]
    pub fn end(&self) -> u16 {
        self.at.wrapping_add(self.size)
    }

    /// Its row, unless it is a routine's number.
    #[must_use]
    pub fn row(&self) -> Option<&'static Row> {
        match self.kind {
            Kind::Formula(op, _) => FORMULAS.get(op as usize),
            Kind::Own(op) => OWN.get(op as usize),
            Kind::Routine(_) => None,
        }
    }
}

/// Why bytes are no operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrong {
    /// No operation has this number.
    Number(u8),
    /// The formula cannot have its operand.
    Operand,
    /// Nothing says where the list of a switch ends.
    List,
}

impl fmt::Display for Wrong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Wrong::Number(n) => write!(f, "no operation has the number {n:#x}"),
            Wrong::Operand => f.write_str("this formula cannot have this operand"),
            Wrong::List => f.write_str("nothing says where the list of places ends"),
        }
    }
}

/// The operation at an address.
///
/// # Errors
/// There is none.
pub fn decode(code: &(impl Code + ?Sized), at: u16) -> Result<Op, Wrong> {
    let number = code.byte(at);
    if number & isa::FORMULA != 0 {
        return formula(code, at, number);
    }
    let n = usize::from(number);
    let (kind, operands) = match ROUTINES.get(n) {
        Some(routine) => (Kind::Routine(n), routine.operands),
        None => {
            let n = n - ROUTINES.len();
            let own = *Own::ALL.get(n).ok_or(Wrong::Number(number))?;
            (Kind::Own(own), OWN[n].operands)
        }
    };
    let mut op = Op { at, size: 1, kind, operands: Vec::new(), targets: Vec::new() };
    for operand in operands {
        take(code, &mut op, *operand)?;
    }
    Ok(op)
}

fn formula(code: &(impl Code + ?Sized), at: u16, number: u8) -> Result<Op, Wrong> {
    let op = Formula::ALL[usize::from(number & 15)];
    let operand = u16::from(code.byte(at.wrapping_add(1)));
    let [record, axis, new] = [isa::RECORD, isa::AXIS, isa::NEW].map(|bit| number & bit != 0);
    if new && !op.takes_new() || record && op.writes() {
        return Err(Wrong::Operand);
    }
    let place = Place {
        at: if record { operand } else { isa::WORDS + 2 * operand },
        record,
        axis: axis && !record,
        short: axis && record,
        new,
    };
    let kind = Kind::Formula(op, place);
    Ok(Op { at, size: 2, kind, operands: Vec::new(), targets: Vec::new() })
}

fn take(code: &(impl Code + ?Sized), op: &mut Op, operand: Operand) -> Result<(), Wrong> {
    let at = op.end();
    let byte = code.byte(at);
    let target = |at: u16| at.wrapping_add_signed(i16::from(code.byte(at).cast_signed()));
    match operand {
        Operand::Number | Operand::Wrapped | Operand::Power => op.operands.push(byte.into()),
        Operand::Byte => {
            op.operands.push(code.symbol("BYTES").unwrap_or_default() + u16::from(byte));
        }
        Operand::Word | Operand::Routine => {
            op.operands.push(code.word(at));
            op.size += 1;
        }
        Operand::Jump => op.targets.push(target(at)),
        Operand::Places => {
            let end = code.places_end(at).filter(|end| end.wrapping_sub(at) < 32);
            let end = end.ok_or(Wrong::List)?;
            // An offset of 0 stands for a number that never comes.
            op.targets.extend((at..end).filter(|at| code.byte(*at) != 0).map(target));
            op.size += end - at - 1;
        }
        Operand::Pairs => {
            let mut end = at;
            while code.byte(end) != 0 {
                end = end.wrapping_add(2);
            }
            op.size += end - at;
        }
    }
    op.size += 1;
    Ok(())
}
