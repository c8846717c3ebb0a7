//! Micro-code from the rules in `firmware/src/rules`: plain Rust functions that rustc compiles for the host and the
//! larger chip, and this crate for the 16 KB one. README.md has the subset on one page; what is outside of it is
//! refused by name and line.
//!
//! [`leaf`] reads what each chip does its own way, [`front`] makes a [`tree`] of the functions, [`code`] operations of
//! it, whose facts are those of [`ops`], [`blocks`] makes them fewer, [`text`] writes the notation of
//! `firmware/g2553/micro`. The result stands in `firmware/g2553/generated`: the program `lower` writes it, a
//! test compares it.

pub mod blocks;
pub mod code;
pub mod front;
pub mod leaf;
pub mod ops;
pub mod text;
pub mod tree;

use std::fmt;
use std::path::Path;

/// Why a source is refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// Line of the source, from 1.
    pub line: usize,
    /// What is wrong and what may stand there instead.
    pub text: String,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.text)
    }
}

impl std::error::Error for Refused {}

impl Refused {
    fn at(place: &impl syn::spanned::Spanned, text: impl Into<String>) -> Refused {
        Refused { line: place.span().start().line, text: text.into() }
    }
}

impl From<syn::Error> for Refused {
    fn from(error: syn::Error) -> Refused {
        Refused { line: error.span().start().line, text: error.to_string() }
    }
}

/// What is made of a file of rules.
#[derive(Clone, Debug)]
pub struct Made {
    /// The file's name.
    pub name: String,
    /// The assembler's text.
    pub text: String,
    /// Bytes of each function, but for what it shares with others.
    pub bytes: Vec<(String, usize)>,
}

/// Makes micro-code of files of rules, each with its name; those of `traits` have traits of leaves and no rules.
///
/// # Errors
/// Something is not of the subset: the file's name, and what.
pub fn lower(
    traits: &[(&str, &str)],
    files: &[(&str, &str)],
) -> Result<Vec<Made>, (String, Refused)> {
    let at = |name: &str| {
        let name = name.to_owned();
        move |refused: Refused| (name, refused)
    };
    let parse = |text: &str| syn::parse_file(text).map_err(Refused::from);
    let mut leaves = leaf::Leaves::new();
    for (name, text) in traits {
        let file = parse(text).map_err(at(name))?;
        leaf::read(&file, &mut leaves).map_err(at(name))?;
    }
    let mut rules = front::Rules::new();
    let mut parsed = Vec::new();
    for (name, text) in files {
        let file = parse(text).map_err(at(name))?;
        let about = front::about(&file).map_err(at(name))?;
        leaf::read(&file, &mut leaves).map_err(at(name))?;
        front::rules(&file, name, &about, &mut rules).map_err(at(name))?;
        parsed.push((*name, file, about));
    }
    let mut made = Vec::new();
    for (name, file, about) in &parsed {
        let functions = front::read(file, name, &leaves, &rules).map_err(at(name))?;
        let (mut lines, mut labels) = (Vec::new(), 0);
        for function in functions.iter().filter(|function| !function.within) {
            let zero = function.gives == leaf::Type::Word;
            lines.extend(
                code::write(function, &functions, name, &mut labels, zero).map_err(at(name))?,
            );
        }
        let lines = blocks::shorten(lines, name);
        made.push(text::write(&lines, name, about));
    }
    Ok(made)
}

/// The files of rules, in the order of `firmware/src/rules`.
const FILES: [&str; 16] = [
    "status", "coords", "effects", "home", "moves", "pace", "axes", "lines", "probe", "commands",
    "session", "ticks", "handlers", "stops", "planner", "segments",
];
/// Those that have leaves alone.
const TRAITS: [&str; 3] = ["rules", "rules/commands/leaves", "rules/session/leaves"];

/// What the rules in the firmware's directory become.
///
/// # Errors
/// A file cannot be read, or is refused: its path and why.
pub fn of_firmware(firmware: &Path) -> Result<Vec<Made>, Box<dyn std::error::Error>> {
    let read = |path: String| std::fs::read_to_string(firmware.join(path));
    let read = |name: &'static str, path: String| Ok((name, read(path)?));
    let files = |names: &[&'static str], at: &str| {
        let texts = names.iter().map(|name| read(name, format!("src/{at}{name}.rs")));
        texts.collect::<Result<Vec<_>, std::io::Error>>()
    };
    let (traits, files) = (files(&TRAITS, "")?, files(&FILES, "rules/")?);
    let [traits, files] = [&traits, &files]
        .map(|files| files.iter().map(|(name, text)| (*name, text.as_str())).collect::<Vec<_>>());
    let made = lower(&traits, &files);
    Ok(made.map_err(|(name, refused)| format!("{name}.rs: {refused}"))?)
}

#[cfg(test)]
mod tests;
