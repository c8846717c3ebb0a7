//! An operation of the notation: its bytes, and what the table of `micro` says that it does.

use std::fmt;

use micro::isa::{
    CALLED, FORMULAS, Flags, Gives, Next, OWN, Operand, Own, ROUTINES, Routine, Takes,
};

/// An operation, or the place of a label.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Line {
    /// A label; `true` for a function's, by which others may come.
    Label(String, bool),
    /// An operation.
    Op(Op),
    /// What the assembler is to check: no bytes.
    Check(String),
}

/// An operation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Op {
    /// Its name, with what a formula does: `DO`, `F load`.
    pub name: String,
    /// Its operands but for a jump's.
    pub operands: Vec<String>,
    /// Where it jumps to.
    pub to: Option<String>,
    /// The symbol of the parts that have it.
    pub when: Option<String>,
}

/// The last call of a function: operands are how it is called elsewhere, and the function.
pub const TAIL: &str = "TAIL";
/// Instructions go on in the function's place: each an operand.
pub const LEAVE: &str = "LEAVE";
/// A place of a switch.
pub const PLACE: &str = "TO";
/// A number of a switch that never comes.
pub const HOLE: &str = ".byte";

/// What an operation does to what is known.
#[derive(Clone, Copy, Debug)]
pub struct Facts {
    /// What it takes of the accumulator.
    pub takes: Takes,
    /// What it leaves there.
    pub gives: Gives,
    /// Flags that hold behind it.
    pub flags: &'static str,
    /// Pointers that it uses, gives and loses: see `micro::isa::Row`.
    pub needs: &'static str,
    /// See `needs`.
    pub sets: &'static str,
    /// See `needs`.
    pub loses: &'static str,
    /// It may end the function.
    pub ends_caller: bool,
    /// The next operation is not come to.
    pub is_end: bool,
}

impl Facts {
    /// Of a function of which nothing is known.
    const UNKNOWN: Facts = Facts {
        takes: Takes::Long,
        gives: Gives::Lost,
        flags: "",
        needs: "",
        sets: "",
        loses: "ar",
        ends_caller: false,
        is_end: false,
    };
}

/// The row of a function that has a number or may be called by its address.
#[must_use]
pub fn routine(label: &str) -> Option<&'static Routine> {
    ROUTINES.iter().chain(CALLED).find(|row| row.name == label || row.label == label)
}

/// Whether a function has a number.
#[must_use]
pub fn is_numbered(label: &str) -> bool {
    ROUTINES.iter().any(|row| row.label == label)
}

impl Op {
    /// One that jumps nowhere.
    #[must_use]
    pub fn read(text: &str) -> Op {
        let text = text.trim();
        let (mut name, mut rest) = text.split_once(' ').unwrap_or((text, ""));
        if matches!(name, "F" | "FR") {
            let at = text[name.len() + 1..].find(' ').map(|at| at + name.len() + 1);
            (name, rest) = text.split_at(at.unwrap_or(text.len()));
        }
        let operands = rest.split(',').map(|one| one.trim().to_owned());
        Op {
            name: name.to_owned(),
            operands: operands.filter(|one| !one.is_empty()).collect(),
            to: None,
            when: None,
        }
    }

    /// What ends micro-code: these instructions go on.
    #[must_use]
    pub fn leave(instructions: &str) -> Op {
        let operands = instructions.split(';').map(|one| one.trim().to_owned()).collect();
        Op { name: LEAVE.to_owned(), operands, to: None, when: None }
    }

    /// The same with a place to jump to.
    #[must_use]
    pub fn to(mut self, label: &str) -> Op {
        self.to = Some(label.to_owned());
        self
    }

    /// Its first operand.
    #[must_use]
    pub fn first(&self) -> &str {
        self.operands.first().map_or("", String::as_str)
    }

    /// Its bytes; `here` says whether a function stands in the file.
    #[must_use]
    pub fn size(&self, here: &dyn Fn(&str) -> bool) -> usize {
        match self.name.as_str() {
            "DO" | PLACE | HOLE => 1,
            "LIT" => 1 + usize::from(self.first() != "0"),
            TAIL if self.first() == "DO" || here(&self.operands[1]) => 2,
            TAIL => 4,
            // One and a pad byte, then as long as instructions may be but for what no place of these has.
            LEAVE => 2 + 4 * self.operands.len(),
            name if name.starts_with('F') && name.contains(' ') => 2,
            name => {
                let bytes = |operand: &Operand| match operand {
                    Operand::Word | Operand::Routine => 2,
                    _ => 1,
                };
                let row = OWN.iter().find(|row| row.notation == Some(name));
                let operands = row.map(|row| row.operands);
                let operands = operands.or_else(|| named(name).map(|row| row.operands));
                1 + operands.unwrap_or_default().iter().map(bytes).sum::<usize>()
            }
        }
    }

    /// Whether it makes the accumulator of what is there, and changes nothing else.
    #[must_use]
    pub fn only_looks(&self) -> bool {
        match self.name.as_str() {
            "LIT" | "LIT16" | "GET" | "PROFILE" | "F load" | "F word" | "FR load" | "FR word" => {
                true
            }
            "DO" => matches!(self.first(), "axis_bit" | "here" | "zero" | "scaled_most"),
            _ => false,
        }
    }

    /// Whether it looks at a flag that stands there.
    #[must_use]
    pub fn looks_at_flag(&self) -> bool {
        let name = self.name.as_str();
        let own = Own::ALL.iter().zip(OWN);
        let mut own = own.filter(|(_, row)| {
            row.notation == Some(name) || name == "DO" && row.name == self.first()
        });
        own.next().is_some_and(|(own, _)| own.looks_at().is_some())
    }

    /// Whether it is one of a switch's places.
    #[must_use]
    pub fn is_place(&self) -> bool {
        self.name == PLACE || self.name == HOLE
    }

    /// Whether what follows is not come to.
    #[must_use]
    pub fn is_end(&self) -> bool {
        self.facts().is_end
    }

    /// Whether it ends the function where it stands.
    #[must_use]
    pub fn returns(&self) -> bool {
        self.when.is_none()
            && matches!(
                self.name.as_str(),
                "RETURN" | "DONE_" | "NOT_YET_" | "FAULT" | TAIL | LEAVE
            )
    }

    /// What it does. Behind one that not all parts have execution goes on.
    #[must_use]
    pub fn facts(&self) -> Facts {
        let facts = self.facts_everywhere();
        Facts { is_end: facts.is_end && self.when.is_none(), ..facts }
    }

    fn facts_everywhere(&self) -> Facts {
        let name = self.name.as_str();
        let own = match name {
            "DO" => OWN.iter().find(|row| row.name == self.first()),
            "LIT" => OWN.iter().find(|row| row.name == "micro_literal"),
            "CALL" => None,
            name => OWN.iter().find(|row| row.notation == Some(name)),
        };
        let formula = name.split_once(' ').and_then(|(_, what)| {
            FORMULAS.iter().find(|row| name.starts_with('F') && row.name == what)
        });
        if let Some(row) = own.or(formula) {
            let flags = match row.flags {
                Flags::Kept => "ZNCV",
                Flags::Are(flags) => flags,
            };
            return Facts {
                takes: row.takes,
                gives: row.gives,
                flags,
                needs: row.needs,
                sets: row.sets,
                loses: "",
                ends_caller: row.next == Next::OnOrReturn,
                is_end: !matches!(row.next, Next::On | Next::OnOrReturn | Next::If),
            };
        }
        let row = match name {
            "DO" | "CALL" => routine(self.first()),
            TAIL | LEAVE | PLACE | HOLE => return Facts { is_end: true, ..Facts::UNKNOWN },
            name => named(name),
        };
        let Some(row) = row else { return Facts::UNKNOWN };
        Facts {
            takes: row.takes,
            gives: row.gives,
            flags: row.flags,
            needs: row.needs,
            sets: row.sets,
            loses: row.loses,
            ends_caller: row.ends_caller,
            is_end: false,
        }
    }
}

/// A routine with a notation of its own.
fn named(notation: &str) -> Option<&'static Routine> {
    let rows = ROUTINES.iter().filter(|row| !row.operands.is_empty());
    let mut rows =
        rows.filter(|row| row.name.trim_start_matches("micro_").to_uppercase() == notation);
    rows.next()
}

/// The jump that is taken when this one is not.
#[must_use]
pub fn inverse(name: &str) -> Option<&'static str> {
    const PAIRS: [(&str, &str); 6] = [
        ("IF_EQUAL", "IF_NOT_EQUAL"),
        ("IF_NEGATIVE", "IF_NOT_NEGATIVE"),
        ("CASE", "CASE_NOT"),
        ("IF_ZERO", "IF_SET"),
        ("IF_ANY", "IF_NONE"),
        ("IF_IS", "IF_IS_NOT"),
    ];
    PAIRS.into_iter().find_map(|(a, b)| {
        if a == name {
            Some(b)
        } else if b == name {
            Some(a)
        } else {
            None
        }
    })
}

impl fmt::Display for Op {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.name == LEAVE {
            return write!(f, "END\n    {}", self.operands.join("\n    "));
        }
        let operands = self.operands.iter().chain(&self.to).cloned().collect::<Vec<_>>();
        write!(f, "{} {}", self.name, operands.join(", "))
    }
}
