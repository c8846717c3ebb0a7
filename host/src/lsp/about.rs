//! Information on a name: its declaration, kind, value and registers.

use lang::fault::Fault;
use lang::front::facts::Fact;
use lang::front::index::{Sort, Symbol};
use lang::front::words::{Func, Reserved, lookup};
use lang::hir::Storage;
use lang::kind::Kind;
use lang::wire;
use lsp_types::{Hover, HoverContents, MarkupContent, MarkupKind, Position};

use super::document::Document;

/// What the word at a place means.
pub fn hover(document: &Document, position: Position) -> Option<Hover> {
    if document.imported().is_some() {
        return None;
    }
    let offset = document.offset(position);
    let (start, word) = document.word(offset);
    let end = start + word.len() as u32;
    let own = document.index().at(offset).map(|m| &document.index().symbols()[m.symbol]);
    let (code, about) = match (own, lookup(word)) {
        (Some(symbol), _) => (declaration(document, symbol), told(document, symbol).join("  \n")),
        (None, Some(Reserved::Kw(kw))) => {
            (kw.entry().usage.to_owned(), kw.entry().about.to_owned())
        }
        (None, Some(Reserved::Func(func))) => (func.usage().to_owned(), func.about().to_owned()),
        (None, None) if Func::soft(word).is_some() => {
            let func = Func::soft(word)?;
            (func.usage().to_owned(), func.about().to_owned())
        }
        (None, None) => port_of_profile(document, word).or_else(|| fault(word))?,
    };
    let value = format!("```pasapas\n{code}\n```\n{about}");
    Some(Hover {
        contents: HoverContents::Markup(MarkupContent { kind: MarkupKind::Markdown, value }),
        range: Some(document.range(lang::front::span::Span::new(start, end))),
    })
}

/// Characters of a declaration that are shown.
const SHOWN: usize = 300;

/// The line that declares a name, or its beginning.
pub fn declaration(document: &Document, symbol: &Symbol) -> String {
    let line = document.line_of(symbol.name.span.start);
    match line.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}...", &line[..end]),
        None => line.to_owned(),
    }
}

/// A name's facts.
pub fn fact<'d>(document: &'d Document, symbol: &Symbol) -> Option<&'d Fact> {
    document.analysis().facts.get(&symbol.name.span.start)
}

/// Kind, value and place of a name, a line each.
fn told(document: &Document, symbol: &Symbol) -> Vec<String> {
    let Some(fact) = fact(document, symbol) else { return Vec::new() };
    let mut lines = Vec::new();
    let kinds: Vec<&str> = fact.kinds.iter().map(|kind| kind.name()).collect();
    match (symbol.sort, fact.value) {
        (Sort::Const, Some(value)) => {
            lines.push(format!("{}: {}", kinds.join(", "), quantity(fact.kinds[0], value)));
        }
        (Sort::Input, Some(n)) => lines.push(format!("input {n}")),
        (Sort::Output, Some(n)) => lines.push(format!("output {n}")),
        (Sort::Table, Some(rows)) => lines.push(format!("{rows} rows of {}", kinds.join(", "))),
        (Sort::Array, Some(len)) => {
            lines.push(format!("{len} values of kind {}, 0 to {}", kinds.join(", "), len - 1));
        }
        (Sort::Function, _) => lines.push(format!("gives a {}", kinds.join(", "))),
        _ if !kinds.is_empty() => {
            let unit = fact.kinds[0].unit().suffix();
            let unit = if unit.is_empty() { String::new() } else { format!(", stored in {unit}") };
            lines.push(format!("{}{unit}", kinds.join(", ")));
        }
        _ => {}
    }
    if let Some(registers) = registers(document, symbol, fact) {
        lines.push(registers);
    }
    lines
}

/// A value with its unit.
pub fn quantity(kind: Kind, value: i32) -> String {
    match kind {
        Kind::Length => {
            let sign = if value < 0 { "-" } else { "" };
            let um = value.unsigned_abs();
            let digits = format!("{:03}", um % 1000);
            let digits = digits.trim_end_matches('0');
            let point = if digits.is_empty() { "" } else { "." };
            format!("{sign}{}{point}{digits}mm", um / 1000)
        }
        _ => format!("{value}{}", kind.unit().suffix()),
    }
}

/// Where a variable is seen over the link.
fn registers(document: &Document, symbol: &Symbol, fact: &Fact) -> Option<String> {
    let storage = fact.storage?;
    let first = |first: u16, what: &str| {
        let last = if symbol.sort == Sort::Array { "on, two each" } else { "" };
        Some(match last {
            "" => format!("{what}holding registers {first} and {}, low word first", first + 1),
            last => format!("{what}holding registers from {first} {last}, low word first"),
        })
    };
    if let Storage::Keep(n) = storage {
        return first(wire::KEEPS + 2 * u16::from(n), "kept through power loss; ");
    }
    if let Storage::At(register) = storage {
        return first(register, "");
    }
    let program = document.analysis().program.as_ref()?;
    let name = symbol.name.span.start as usize;
    let place = document.places().iter().find(|place| program.var(place.var).span.start == name)?;
    let register = wire::CELLS + u16::try_from(2 * place.cell).ok()?;
    let local = matches!(storage, Storage::Local(_));
    first(register, if local { "local, cell shared with other SUBs'; " } else { "" })
}

/// An input or output that the profile names.
fn port_of_profile(document: &Document, word: &str) -> Option<(String, String)> {
    let profile = document.analysis().profile.as_ref()?;
    let named =
        |name: &Option<String>| name.as_ref().is_some_and(|name| name.eq_ignore_ascii_case(word));
    let input = profile.inputs.iter().find(|port| named(&port.name));
    let output = profile.outputs.iter().find(|port| named(&port.name));
    let (what, n) = match (input, output) {
        (Some(port), _) => ("INPUT", port.n),
        (None, Some(port)) => ("OUTPUT", port.n),
        (None, None) => return None,
    };
    Some((format!("{what} {word} = {n}"), format!("named by the profile `{}`", profile.name)))
}

/// A fault's code in a comment or a text.
fn fault(word: &str) -> Option<(String, String)> {
    let fault = Fault::ALL.iter().find(|fault| fault.to_string().eq_ignore_ascii_case(word))?;
    Some((format!("{fault} {}", fault.text()), fault.remedy().to_owned()))
}
