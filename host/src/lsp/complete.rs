//! Completion: what may be written at a place.

use lang::front::index::Sort;
use lang::front::words::{ArgKind, Class, Func, Kw};
use lang::kind::Kind;
use lang::profile::BUILT_IN;
use lsp_types::{CompletionItem, CompletionItemKind, Documentation, Position};

use super::about;
use super::document::Document;
use super::signature::{Call, Callee};

/// What the text before the caret asks for.
enum Place {
    /// Inside a comment or a text.
    Nothing,
    /// A statement begins.
    Statement,
    /// A value.
    Value,
    /// One of these words.
    Words(Vec<&'static str>),
    /// An axis letter.
    Axis,
    /// A label, or of a GOSUB a SUB as well.
    Target { subs: bool },
    /// A name of one of these sorts.
    Named(&'static [Sort]),
}

/// What may be written at a place.
pub fn complete(document: &Document, position: Position) -> Vec<CompletionItem> {
    if document.imported().is_some() {
        return Vec::new();
    }
    let offset = document.offset(position);
    let (start, _) = document.word(offset);
    match place(document, start) {
        Place::Nothing => Vec::new(),
        Place::Words(words) => words.into_iter().map(plain).collect(),
        Place::Axis => {
            let profile = document.analysis().profile.as_ref();
            let axes = profile.into_iter().flat_map(|profile| profile.axes());
            axes.map(|(axis, _)| plain(&axis.letter().to_string())).collect()
        }
        Place::Target { subs } => {
            names(document, start, |sort| sort == Sort::Label || (subs && sort == Sort::Sub))
        }
        Place::Named(sorts) => names(document, start, |sort| sorts.contains(&sort)),
        Place::Statement => {
            let words = Kw::ALL.iter().filter(|kw| kw.begins_statement());
            let mut items: Vec<_> = words.map(|kw| keyword(*kw)).collect();
            items.extend(names(document, start, |sort| {
                matches!(sort, Sort::Sub | Sort::Variable | Sort::Array | Sort::Parameter)
            }));
            items
        }
        Place::Value => {
            let operators = Kw::ALL.iter().filter(|kw| kw.entry().class == Class::Operator);
            let mut items: Vec<_> = operators.map(|kw| keyword(*kw)).collect();
            items.push(keyword(Kw::On));
            let parts =
                [Kw::Then, Kw::To, Kw::Step, Kw::As, Kw::At, Kw::Until, Kw::While, Kw::Else];
            items.extend(parts.map(keyword));
            items.extend(Func::ALL.iter().map(|func| function(*func)));
            items.extend(ports(document));
            items.extend(names(document, start, |sort| !matches!(sort, Sort::Sub | Sort::Label)));
            items
        }
    }
}

/// Finds out what a word that begins at `start` is to be.
fn place(document: &Document, start: u32) -> Place {
    let before = document.before(start);
    match open_text(before) {
        Some(text) if text.trim().eq_ignore_ascii_case("PROFILE") => {
            return Place::Words(BUILT_IN.iter().map(|(name, _)| *name).collect());
        }
        Some(_) => return Place::Nothing,
        None => {}
    }
    let before = before.trim_end();
    let statement = before.rsplit(':').next().unwrap_or(before);
    let mut words = statement.split_whitespace().map(str::to_ascii_uppercase);
    let words: Vec<String> = words.by_ref().collect();
    let last: Vec<&str> = words.iter().rev().take(2).map(String::as_str).collect();
    match last.as_slice() {
        ["END", ..] => return Place::Words(vec!["IF", "SELECT", "REPEAT", "SUB", "FUNCTION"]),
        ["EXIT", ..] => {
            return Place::Words(vec!["FOR", "WHILE", "DO", "REPEAT", "SUB", "FUNCTION"]);
        }
        ["CONTINUE", ..] => return Place::Words(vec!["FOR", "WHILE", "DO", "REPEAT"]),
        ["SELECT", ..] => return Place::Words(vec!["CASE"]),
        ["RESUME", ..] => return Place::Words(vec!["NEXT"]),
        ["PLANE", ..] => return Place::Words(vec!["XY", "XZ", "YZ"]),
        ["DO" | "LOOP", ..] => return Place::Words(vec!["WHILE", "UNTIL"]),
        ["START"] => return Place::Words(vec!["MoveAxe", "MoveRel"]),
        ["ERROR", "ON"] => return Place::Words(vec!["GOTO", "STOP"]),
        ["EVERY", "ON"] => return Place::Value,
        ["ON"] if words.len() == 1 => return Place::Words(vec!["ERROR", "IN", "EVERY"]),
        ["AS", ..] => return Place::Words(Kind::ALL.iter().map(|kind| kind.name()).collect()),
        ["GOTO", ..] => return Place::Target { subs: false },
        ["GOSUB", ..] => return Place::Target { subs: true },
        ["CALL", ..] => return Place::Named(&[Sort::Sub]),
        ["NEXT", ..] => return Place::Named(&[Sort::Variable, Sort::Parameter]),
        _ => {}
    }
    if begins_statement(before) {
        return Place::Statement;
    }
    let Some(Call { callee, argument }) = Call::around(document, start) else {
        return Place::Value;
    };
    match callee {
        Callee::Builtin(func) => match func.args().get(argument) {
            Some(ArgKind::Axis) => Place::Axis,
            Some(ArgKind::Table) => Place::Named(&[Sort::Table]),
            _ if matches!(func, Func::In) => Place::Named(&[Sort::Input]),
            _ if matches!(func, Func::Out) => Place::Named(&[Sort::Output]),
            _ => Place::Value,
        },
        Callee::Statement(kw) => {
            let first = kw.entry().usage.split(' ').nth(1).unwrap_or("");
            let axis = first.trim_matches(['[', ']', ',']) == "axis";
            if axis && (argument == 0 || kw == Kw::Home) { Place::Axis } else { Place::Value }
        }
        Callee::Routine(_) => Place::Value,
    }
}

/// What stands before a quote that is open, or before a comment's sign.
fn open_text(before: &str) -> Option<&str> {
    let mut quoted = None;
    for (at, c) in before.char_indices() {
        match c {
            '"' if quoted.is_some() => quoted = None,
            '"' => quoted = Some(at),
            '\'' if quoted.is_none() => return Some("'"),
            _ => {}
        }
    }
    quoted.map(|at| &before[..at])
}

fn begins_statement(before: &str) -> bool {
    let last = before.rsplit(|c: char| c.is_whitespace()).next().unwrap_or("");
    before.is_empty()
        || before.ends_with(':')
        || last.eq_ignore_ascii_case("THEN")
        || last.eq_ignore_ascii_case("ELSE")
}

/// The names that can be seen at an offset and are of a wanted sort.
fn names(document: &Document, offset: u32, wanted: impl Fn(Sort) -> bool) -> Vec<CompletionItem> {
    let index = document.index();
    let routine = index.routine_at(document.source().line(offset));
    let seen = index.visible(routine).into_iter().map(|n| &index.symbols()[n]);
    let item = |symbol: &lang::front::index::Symbol| CompletionItem {
        label: symbol.name.text.to_string(),
        kind: Some(item_kind(symbol.sort)),
        detail: Some(about::declaration(document, symbol)),
        ..CompletionItem::default()
    };
    seen.filter(|symbol| wanted(symbol.sort)).map(item).collect()
}

/// Inputs and outputs that the profile names.
fn ports(document: &Document) -> Vec<CompletionItem> {
    let Some(profile) = &document.analysis().profile else { return Vec::new() };
    let inputs = profile.inputs.iter().map(|port| (&port.name, "INPUT", port.n));
    let outputs = profile.outputs.iter().map(|port| (&port.name, "OUTPUT", port.n));
    let item = |(name, what, n): (&Option<String>, &str, i32)| {
        let name = name.as_deref()?;
        Some(item(
            name,
            CompletionItemKind::CONSTANT,
            &format!("{what} {name} = {n}"),
            "by the profile",
        ))
    };
    inputs.chain(outputs).filter_map(item).collect()
}

fn plain(word: &str) -> CompletionItem {
    CompletionItem {
        label: word.to_owned(),
        kind: Some(CompletionItemKind::KEYWORD),
        ..CompletionItem::default()
    }
}

fn keyword(kw: Kw) -> CompletionItem {
    let entry = kw.entry();
    let kind = match entry.class {
        Class::Machine => CompletionItemKind::FUNCTION,
        Class::Operator => CompletionItemKind::OPERATOR,
        _ => CompletionItemKind::KEYWORD,
    };
    item(entry.text, kind, entry.usage, entry.about)
}

fn function(func: Func) -> CompletionItem {
    item(func.text(), CompletionItemKind::FUNCTION, func.usage(), func.about())
}

fn item(label: &str, kind: CompletionItemKind, usage: &str, about: &str) -> CompletionItem {
    CompletionItem {
        label: label.to_owned(),
        kind: Some(kind),
        detail: Some(usage.to_owned()),
        documentation: (!about.is_empty()).then(|| Documentation::String(about.to_owned())),
        ..CompletionItem::default()
    }
}

const fn item_kind(sort: Sort) -> CompletionItemKind {
    match sort {
        Sort::Sub | Sort::Function => CompletionItemKind::FUNCTION,
        Sort::Const | Sort::Input | Sort::Output | Sort::Table => CompletionItemKind::CONSTANT,
        Sort::Label => CompletionItemKind::REFERENCE,
        Sort::Variable | Sort::Array | Sort::Parameter => CompletionItemKind::VARIABLE,
    }
}
