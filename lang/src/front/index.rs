//! The names of a script: where each is declared, and where it is mentioned.
//!
//! It follows the syntax tree alone, so editors have it for a script with errors too, as far as that
//! could be read. Names are bound as the checker binds them: a declaration's own expressions see what
//! stands before it, everything else the whole scope.

mod walk;

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use super::ast::{Name, Script};
use super::span::Span;

/// What a declared name stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sort {
    /// CONST
    Const,
    /// INPUT
    Input,
    /// OUTPUT
    Output,
    /// DIM or KEEP without a size.
    Variable,
    /// DIM with a size.
    Array,
    /// A parameter.
    Parameter,
    /// TABLE
    Table,
    /// SUB
    Sub,
    /// FUNCTION
    Function,
    /// `name:`
    Label,
}

/// A declared name.
#[derive(Clone, Debug)]
pub struct Symbol {
    /// The name at its declaration.
    pub name: Name,
    /// What it stands for.
    pub sort: Sort,
    /// The words of the declaring statement.
    pub span: Span,
    /// The SUB or FUNCTION that it is local to, as index of [`Script::routines`].
    pub local_to: Option<usize>,
}

/// A place where a name stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mention {
    /// The name's letters.
    pub span: Span,
    /// Index of [`Index::symbols`].
    pub symbol: usize,
    /// It is declared, assigned to or counted by a FOR there.
    pub writes: bool,
}

/// Every declared name of a script and every mention of one.
#[derive(Clone, Debug, Default)]
pub struct Index {
    symbols: Vec<Symbol>,
    mentions: Vec<Mention>,
    /// Names by scope: 0 is the main program's, n + 1 that of routine n.
    names: Vec<HashMap<Rc<str>, usize>>,
    labels: Vec<HashMap<Rc<str>, usize>>,
    /// First and last line of each routine.
    lines: Vec<(u32, u32)>,
    /// Names in the text that nothing here declares: those of the profile, and wrong ones.
    free: HashSet<Rc<str>>,
}

impl Index {
    /// Looks a script through.
    pub fn new(script: &Script) -> Index {
        walk::index(script)
    }

    /// Every declared name, in the order in which the checker declares them.
    pub fn symbols(&self) -> &[Symbol] {
        &self.symbols
    }

    /// Every mention, in text order, declarations included.
    pub fn mentions(&self) -> &[Mention] {
        &self.mentions
    }

    /// The mention that covers an offset or ends there.
    pub fn at(&self, offset: u32) -> Option<&Mention> {
        let behind = self.mentions.partition_point(|m| m.span.start <= offset);
        self.mentions[..behind].last().filter(|m| offset <= m.span.end)
    }

    /// The mentions of one name.
    pub fn mentions_of(&self, symbol: usize) -> impl Iterator<Item = &Mention> {
        self.mentions.iter().filter(move |m| m.symbol == symbol)
    }

    /// The routine that a line belongs to, as index of [`Script::routines`]; None in the main program.
    pub fn routine_at(&self, line: u32) -> Option<usize> {
        self.lines.iter().position(|&(first, last)| (first..=last).contains(&line))
    }

    /// What a name, labels apart, stands for in a routine or (None) in the main program.
    pub fn look(&self, routine: Option<usize>, key: &str) -> Option<usize> {
        let own = self.names.get(scope(routine))?.get(key);
        own.or_else(|| self.names.first()?.get(key)).copied()
    }

    /// What can be named in a routine or in the main program, labels included; locals first. Names
    /// that a local hides are left out.
    pub fn visible(&self, routine: Option<usize>) -> Vec<usize> {
        let own = scope(routine);
        let mut seen: Vec<usize> = self.names[own].values().copied().collect();
        seen.extend(self.labels[own].values());
        if own != 0 {
            let hidden = &self.names[own];
            let outer = self.names[0].iter().filter(|(key, _)| !hidden.contains_key(*key));
            seen.extend(outer.map(|(_, &symbol)| symbol));
        }
        // Hash order differs between runs.
        seen.sort_by_key(|&n| (self.symbols[n].local_to.is_none(), n));
        seen
    }

    /// Whether a symbol may get this name: it is one, and no mention of it or of another symbol
    /// would then mean something else. If not, why.
    ///
    /// # Errors
    /// What stands against it, in one line.
    pub fn may_rename(&self, symbol: usize, to: &str) -> Result<(), String> {
        let own = &self.symbols[symbol];
        let key = to.to_ascii_lowercase();
        if !super::parser::is_name(to) {
            return Err(format!(
                "`{to}` can not be a name: names are a letter, then letters, digits, _; reserved words, axis letters and what looks like a G-code word are none"
            ));
        }
        if *key == *own.name.key {
            return Ok(());
        }
        let clash = |other: &&Symbol| {
            let labels = (own.sort == Sort::Label, other.sort == Sort::Label);
            let meets = match labels {
                (true, true) => own.local_to == other.local_to,
                (false, false) => {
                    // A local that hides, or is hidden: where both stand in one scope.
                    own.local_to == other.local_to
                        || own.local_to.is_none()
                        || other.local_to.is_none()
                }
                // A SUB's name calls it, at the start of a line too.
                _ => {
                    matches!(own.sort, Sort::Sub | Sort::Function)
                        || matches!(other.sort, Sort::Sub | Sort::Function)
                }
            };
            *other.name.key == *key && meets
        };
        if self.free.contains(key.as_str()) {
            return Err(format!("`{to}` means something already: choose another name"));
        }
        match self.symbols.iter().find(clash) {
            Some(_) => Err(format!("`{to}` is declared already: choose another name")),
            None => Ok(()),
        }
    }
}

/// Index of a scope.
fn scope(routine: Option<usize>) -> usize {
    routine.map_or(0, |n| n + 1)
}
