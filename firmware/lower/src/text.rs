//! The notation of operations.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use crate::Made;
use crate::front::About;
use crate::ops::{Line, Op, TAIL, routine};

/// How far a jump reaches.
const REACH: usize = 120;

/// How an operation is written.
fn notation(op: &Op) -> String {
    match (op.name.as_str(), &op.operands[..]) {
        (TAIL, [call, name]) => format!("    {call} {name}\n    RETURN"),
        _ => format!("    {op}").trim_end().to_owned(),
    }
}

/// Writes the lines of a file.
#[must_use]
pub fn write(lines: &[Line], file: &str, about: &About) -> Made {
    let here = lines.iter().filter_map(|line| match line {
        Line::Label(name, true) => Some(name.as_str()),
        _ => None,
    });
    let here = here.collect::<BTreeSet<_>>();
    let size = |op: &Op| op.size(&|name| here.contains(name));
    let mut places = BTreeMap::new();
    let mut at = 0;
    let mut called = BTreeSet::new();
    for line in lines {
        match line {
            Line::Label(name, _) => {
                places.insert(name.as_str(), at);
            }
            Line::Op(op) => {
                at += size(op);
                if op.name == "CALL" {
                    called.insert(op.first());
                }
            }
            Line::Check(_) => {}
        }
    }
    let mark = format!("module.{}", about.module);
    let parts = about.when.as_ref().map_or(String::new(), |symbol| format!("    .if {symbol}\n"));
    let mut text = format!(
        "/* Made by `cargo run -p lower` of firmware/src/rules/{file}.rs: change that. */\n\n{parts}    \
         .section .text.{},\"axR\",@progbits\n{mark}:\n",
        about.section
    );
    let mut when: Option<&str> = None;
    let mut bytes: Vec<(String, usize)> = Vec::new();
    at = 0;
    for (n, line) in lines.iter().enumerate() {
        // A label is everyone's: others may jump to it.
        let now = match line {
            Line::Op(op) => op.when.as_deref(),
            _ => None,
        };
        if when != now {
            match (when, now) {
                (Some(symbol), Some(others)) if others.strip_prefix('!') == Some(symbol) => {
                    text.push_str("    .else\n");
                }
                (_, now) => {
                    text.push_str(if when.is_some() { "    .endif\n" } else { "" });
                    if let Some(symbol) = now {
                        let _ = writeln!(text, "    .if {symbol}");
                    }
                }
            }
            when = now;
        }
        match line {
            Line::Label(name, true) => {
                bytes.push((name.clone(), 0));
                if matches!(lines.get(n + 1), Some(Line::Check(entry)) if entry.ends_with("MICRO"))
                {
                    let _ = writeln!(text, "    .balign 2, 0\n    .global {name}\n{name}:");
                } else if routine(name).is_some() || called.contains(name.as_str()) {
                    let _ = writeln!(text, "    .global {name}\n    ROUTINE_ODD {name}, {mark}");
                } else {
                    let _ = writeln!(text, "{name}:");
                }
            }
            Line::Label(name, false) => {
                let _ = writeln!(text, "{name}:");
            }
            Line::Check(check) => {
                let _ = writeln!(text, "{check}");
            }
            Line::Op(op) => {
                let from = at;
                let near = |name: &str| {
                    places.get(name).is_some_and(|place: &usize| place.abs_diff(from) < REACH)
                };
                at += size(op);
                if let Some((_, sum)) = bytes.last_mut() {
                    *sum += size(op);
                }
                let _ = match (op.name.as_str(), &op.operands[..]) {
                    (TAIL, [_, name]) if near(name) => writeln!(text, "    GOTO {name}"),
                    _ => writeln!(text, "{}", notation(op)),
                };
            }
        }
    }
    text.push_str(if when.is_some() { "    .endif\n" } else { "" });
    let _ = writeln!(text, "    .balign 2, 0");
    text.push_str(if parts.is_empty() { "" } else { "    .endif\n" });
    Made { name: file.to_owned(), text, bytes }
}
