//! Parameters that keep their name: what `#1 = 5` sets to a plain number and words use as it is
//! becomes a CONST, or a variable where several lines set it.
//!
//! A CONST has a kind, which a parameter of G-code has not: it is a length or a feed, in one unit.
//! Where uses of a parameter are of two kinds or units, or stand in expressions, its values are
//! written instead, at every place.

use core::fmt::Write;
use std::collections::BTreeSet;

use lang::front::words::lookup;

use super::read::{Block, Value};
use crate::script::Script;

/// Parameters that may become variables: each takes one of the few cells of a small board.
const MAX_VARIABLES: usize = 4;
/// Decimals of a Length in mm, which is exact.
const DECIMALS: usize = 3;

/// What the lines of a file say of one parameter.
#[derive(Debug, Default)]
pub(crate) struct Param {
    /// `1`, or `<safe>`.
    pub key: String,
    /// Lines that set it, and the number if it is a plain one.
    pub sets: Vec<(u32, Option<String>)>,
    /// Words that are nothing but it: line, letter, whether a minus stands before it.
    pub uses: Vec<(u32, char, bool)>,
    /// It stands in expressions, too.
    pub mixed: bool,
}

/// A parameter with a name in the script.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Name {
    /// As the script has it.
    pub name: String,
    /// Behind `=` in its CONST; `None` is a variable.
    value: Option<String>,
    /// As the file has it.
    key: String,
}

/// The kind of a word, and whether it is in inches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Length(bool),
    Feed(bool),
}

impl Kind {
    fn of(letter: char, inches: bool) -> Option<Kind> {
        match letter {
            'X' | 'Y' | 'Z' | 'I' | 'J' | 'K' | 'R' | 'Q' => Some(Kind::Length(inches)),
            'F' => Some(Kind::Feed(inches)),
            _ => None,
        }
    }

    /// A number with its unit, as the language takes it; `None` where that would be another value.
    fn literal(self, number: &str) -> Option<String> {
        let (sign, digits) = match number.strip_prefix('-') {
            Some(digits) => ("-", digits),
            None => ("", number),
        };
        let (unit, decimals) = match self {
            Kind::Length(false) => ("mm", DECIMALS),
            Kind::Length(true) => ("in", usize::MAX),
            Kind::Feed(false) => ("mm/min", usize::MAX),
            Kind::Feed(true) => ("in/min", usize::MAX),
        };
        let digits = digits.trim_end_matches('.');
        let zero = if digits.starts_with('.') { "0" } else { "" };
        let behind = digits.split_once('.').map_or(0, |(_, part)| part.len());
        (behind <= decimals).then(|| format!("{sign}{zero}{digits}{unit}"))
    }
}

/// Gives the words of the blocks their names back; a file that draws arcs keeps its variables' values,
/// since chips without arcs want them before the run.
pub(super) fn name(blocks: &mut [Block<'_>], params: &[Param]) -> Vec<Name> {
    let mut inches = Vec::with_capacity(blocks.len());
    let mut own = false;
    for block in blocks.iter() {
        for (letter, value) in &block.words {
            match (letter, value) {
                ('G', Value::Text("20")) => own = true,
                ('G', Value::Text("21")) => own = false,
                _ => {}
            }
        }
        inches.push(own);
    }
    let arcs = blocks.iter().any(|block| matches!(block.motion, 2 | 3));
    let mut names: Vec<Name> = Vec::new();
    let mut taken = BTreeSet::new();
    let mut variables = 0;
    for param in params.iter().filter(|param| !param.mixed && !param.uses.is_empty()) {
        let constant = param.sets.len() == 1;
        if !constant && (arcs || variables == MAX_VARIABLES) {
            continue;
        }
        let Some((words, values)) = places(param, blocks, &inches) else { continue };
        let index = names.len() as u16;
        for (block, word, minus) in words {
            blocks[block].words[word].1 = Value::Named { index, minus };
        }
        let value = if constant { values.first().map(|(_, value)| value.clone()) } else { None };
        if !constant {
            variables += 1;
            for (block, value) in values {
                blocks[block].sets.push((index, value));
            }
        }
        names.push(Name {
            name: script_name(&param.key, &mut taken),
            value,
            key: param.key.clone(),
        });
    }
    names
}

/// Block and word of each use with its sign.
type Uses = Vec<(usize, usize, bool)>;
/// The block behind which it is set, and to what.
type Sets = Vec<(usize, String)>;

/// The words and the settings of a parameter in the blocks; `None` where one of them is not there as
/// it stood, or they are of two kinds.
fn places(param: &Param, blocks: &[Block<'_>], inches: &[bool]) -> Option<(Uses, Sets)> {
    let at = |line: u32| {
        let found = blocks.partition_point(|block| block.line < line);
        blocks.get(found).filter(|block| block.line == line).map(|_| found)
    };
    let mut kind = None;
    let mut words = Vec::with_capacity(param.uses.len());
    for &(line, letter, minus) in &param.uses {
        let block = at(line)?;
        let mut found =
            blocks[block].words.iter().enumerate().filter(|(_, (own, _))| *own == letter);
        let ((word, (_, Value::Text(_))), None) = (found.next()?, found.next()) else {
            return None;
        };
        let own = Kind::of(letter, inches[block])?;
        if *kind.get_or_insert(own) != own {
            return None;
        }
        words.push((block, word, minus));
    }
    let kind = kind?;
    let mut sets = Vec::with_capacity(param.sets.len());
    for (line, number) in &param.sets {
        sets.push((at(*line)?, kind.literal(number.as_deref()?)?));
    }
    Some((words, sets))
}

/// A name of the language for a parameter: `p1`, `safe`.
fn script_name(key: &str, taken: &mut BTreeSet<String>) -> String {
    let letters = key.trim_matches(['<', '>']);
    let clean = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
    let mut name: String = letters.chars().map(clean).collect();
    if !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        name.insert(0, 'p');
    }
    // Short ones may begin a block of G-code, as `x1` does, or be the loops' own `i`.
    let is_word = name.len() < 4 && !name.starts_with('p') || name.starts_with("holes");
    if is_word || lookup(&name).is_some() {
        name.insert_str(0, "p_");
    }
    let mut own = name.clone();
    let mut n = 1;
    while !taken.insert(own.clone()) {
        n += 1;
        own = format!("{name}_{n}");
    }
    own
}

/// The declarations.
pub(super) fn declare(script: &mut Script, names: &[Name]) {
    for own in names {
        let remark = format!("#{}", own.key);
        match &own.value {
            Some(value) => script.remarked(&format!("CONST {} = {value}", own.name), &remark),
            None => script.remarked(&format!("DIM {}", own.name), &remark),
        }
    }
}

/// A word whose value has a name.
pub(super) fn word(text: &mut String, letter: char, names: &[Name], index: u16, minus: bool) {
    let name = names.get(usize::from(index)).map_or("", |own| &own.name);
    // Writing to a String does not fail.
    let _ = write!(text, "{letter}[{}{name}]", if minus { "-" } else { "" });
}
