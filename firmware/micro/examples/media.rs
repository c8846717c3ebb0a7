//! What the firmware is written in, by medium: `cargo run -p micro --example media [CHECKOUT]`. Another checkout's
//! figures tell what has changed.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// What a line says.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Medium {
    /// A statement or item of Rust, or a part of one.
    Rust,
    /// An instruction of the assembler.
    Instruction,
    /// An operation of micro-code.
    Operation,
    /// Comments, directives, labels, nothing.
    None,
}

/// Operations by hand in `firmware/g2553/micro/notation.s`, beside those of the table.
const BY_HAND: [&str; 5] = ["DO", "F", "FR", "LIT", "TO"];

/// The medium of a line of a file that ends so.
fn medium(line: &str, rust: bool, operations: &BTreeSet<&str>) -> Medium {
    let line = line.trim();
    if rust {
        return if line.is_empty() || line.starts_with("//") { Medium::None } else { Medium::Rust };
    }
    // A label may stand in front.
    let code = match line.split_once(':') {
        Some((label, code)) if !label.contains(char::is_whitespace) => code.trim(),
        _ => line,
    };
    let word = code.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).next();
    let word = word.unwrap_or_default();
    if operations.contains(word) {
        Medium::Operation
    } else if word.starts_with(|c: char| c.is_ascii_lowercase()) {
        Medium::Instruction
    } else {
        Medium::None
    }
}

/// The text without comments between `/*` and `*/`.
fn code(text: &str) -> String {
    let mut rest = text;
    let mut left = String::new();
    while let Some((before, comment)) = rest.split_once("/*") {
        left += before;
        rest = comment.split_once("*/").map_or("", |(_, behind)| behind);
    }
    left + rest
}

/// Every source below a folder, but for tests.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.file_stem().is_some_and(|name| name == "tests") {
            continue;
        }
        if path.is_dir() {
            sources(&path, found)?;
        } else if path.extension().is_some_and(|kind| kind == "rs" || kind == "s") {
            found.push(path);
        }
    }
    Ok(())
}

fn main() -> std::io::Result<()> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let root = std::env::args().nth(1).map_or(here, PathBuf::from);
    let notation = micro::asm::notation();
    let table = notation.lines().filter_map(|line| line.trim().strip_prefix(".macro "));
    let table = table.filter_map(|line| line.split_whitespace().next());
    let operations = table.chain(BY_HAND).collect::<BTreeSet<_>>();
    let mut found = Vec::new();
    sources(&root.join("firmware/src"), &mut found)?;
    let (mut rules, mut rust, mut assembly, mut hand, mut made) = (0, 0, 0, 0, 0);
    for path in found {
        let text = std::fs::read_to_string(&path)?;
        let is_rust = path.extension().is_some_and(|kind| kind == "rs");
        let text = if is_rust { text } else { code(&text) };
        let within = |folder: &str| path.iter().any(|part| part == folder);
        for line in text.lines() {
            match medium(line, is_rust, &operations) {
                Medium::Rust if within("rules") => rules += 1,
                Medium::Rust => rust += 1,
                Medium::Instruction => assembly += 1,
                Medium::Operation if within("made") => made += 1,
                Medium::Operation => hand += 1,
                Medium::None => {}
            }
        }
    }
    println!("Rust: {rust} lines");
    println!("rules in Rust, for both chips: {rules} lines");
    println!("assembly: {assembly} instructions");
    println!("micro-code by hand: {hand} operations");
    println!("micro-code made of the rules: {made} operations");
    Ok(())
}
