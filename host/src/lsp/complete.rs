//! Completion at a position.

use lang::effect::Unit;
use lang::front::index::Sort;
use lang::front::token::{Sign, Tok};
use lang::front::words::{ArgKind, Class, Func, Kw};
use lang::kind::Kind;
use lang::profile::BUILT_IN;
use lsp_types::{CompletionItem, CompletionItemKind, Documentation, Position};

use super::about;
use super::document::{Document, MOST};
use super::signature::{Call, Callee};

/// What the text before the caret asks for.
enum Place {
    /// Inside a comment or a text.
    Nothing,
    /// A statement begins.
    Statement,
    /// A value begins; what its place wants comes first.
    Value(Wants),
    /// Behind a value: an operator, or the next part of the statement.
    Behind,
    /// One of these words.
    Words(Vec<&'static str>),
    /// An axis letter.
    Axis,
    /// A label, or of a GOSUB a SUB as well.
    Target { subs: bool },
    /// A name of one of these sorts.
    Named(&'static [Sort]),
}

/// What an argument wants before all other values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Wants {
    #[default]
    Any,
    /// An input's name.
    Input,
    /// An output's name.
    Output,
    /// ON, OFF.
    State,
    /// ON, OFF, RISE, FALL.
    Edge,
}

/// What may be written at a place, in the order in which to show it: editors sort by the labels, unless they are told.
pub fn complete(document: &Document, position: Position) -> Vec<CompletionItem> {
    let mut items = found(document, position);
    for (n, item) in items.iter_mut().enumerate() {
        item.sort_text = Some(format!("{n:05}"));
    }
    items
}

fn found(document: &Document, position: Position) -> Vec<CompletionItem> {
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
        Place::Value(wants) => values(document, start, wants),
        Place::Behind => {
            let operators = Kw::ALL.iter().filter(|kw| is_binary(**kw));
            let mut items: Vec<_> = operators.map(|kw| keyword(*kw)).collect();
            items.extend(PARTS.map(keyword));
            items
        }
    }
}

/// Words that part a statement behind a value.
const PARTS: [Kw; 8] = [Kw::Then, Kw::To, Kw::Step, Kw::As, Kw::At, Kw::Until, Kw::While, Kw::Else];

fn is_binary(kw: Kw) -> bool {
    kw.entry().class == Class::Operator && !matches!(kw, Kw::Not | Kw::True | Kw::False | Kw::Off)
}

/// Values: what the place wants, the script's names, the profile's, constants, functions.
fn values(document: &Document, start: u32, wants: Wants) -> Vec<CompletionItem> {
    let states = [Kw::On, Kw::Off];
    let mut items = Vec::new();
    match wants {
        Wants::Any => {}
        Wants::State => items.extend(states.map(keyword)),
        Wants::Edge => items.extend([Kw::On, Kw::Off, Kw::Rise, Kw::Fall].map(keyword)),
        Wants::Input | Wants::Output => {
            let (sort, output) = match wants {
                Wants::Input => (Sort::Input, false),
                _ => (Sort::Output, true),
            };
            items.extend(names(document, start, |own| own == sort));
            items.extend(ports(document, |own| own == output));
        }
    }
    let mut others = names(document, start, |sort| !matches!(sort, Sort::Sub | Sort::Label));
    others.extend(ports(document, |_| true));
    others.extend([Kw::On, Kw::Off, Kw::True, Kw::False, Kw::Not].map(keyword));
    others.extend(Func::ALL.iter().map(|func| function(*func)));
    others.retain(|item| items.iter().all(|first| first.label != item.label));
    items.extend(others);
    items
}

/// Whether a value stands directly before a place, so that none begins there.
fn value_stands(document: &Document, start: u32) -> bool {
    let tokens = document.tokens();
    let until = tokens.partition_point(|t| t.span.start < start && t.span.end <= start);
    let last = tokens[..until].iter().rev().find(|token| !token.tok.is_trivia());
    last.is_some_and(|token| match token.tok {
        Tok::Number | Tok::Text | Tok::Sign(Sign::Close | Sign::CloseBracket) => true,
        Tok::Kw(Kw::On | Kw::Off | Kw::True | Kw::False) => true,
        Tok::Name => {
            let key = token.span.of(document.source().text()).to_ascii_lowercase();
            let index = document.index();
            let symbol = index.look(index.routine_at(document.source().line(start)), &key);
            symbol.is_none_or(|n| index.symbols()[n].sort != Sort::Sub)
        }
        _ => false,
    })
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
        ["EVERY", "ON"] => return Place::Value(Wants::Any),
        ["ON"] if words.len() == 1 => return Place::Words(vec!["ERROR", "IN", "EVERY"]),
        ["IN", ..] if words[0] == "PRINT" && words.len() > 2 => {
            return Place::Words(Unit::ALL.iter().map(|unit| unit.suffix()).collect());
        }
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
    if value_stands(document, start) {
        return Place::Behind;
    }
    let Some(Call { callee, argument }) = Call::around(document, start) else {
        return Place::Value(Wants::Any);
    };
    match callee {
        Callee::Builtin(func) => match func.args().get(argument) {
            Some(ArgKind::Axis) => Place::Axis,
            Some(ArgKind::Table) => Place::Named(&[Sort::Table]),
            _ if matches!(func, Func::In) => Place::Named(&[Sort::Input]),
            _ if matches!(func, Func::Out) => Place::Named(&[Sort::Output]),
            _ => Place::Value(Wants::Any),
        },
        Callee::Statement(kw) => {
            let first = kw.entry().usage.split(' ').nth(1).unwrap_or("");
            let axis = first.trim_matches(['[', ']', ',']) == "axis";
            if axis && (argument == 0 || kw == Kw::Home) {
                return Place::Axis;
            }
            Place::Value(match (kw, argument) {
                (Kw::SetOut | Kw::Pulse, 0) => Wants::Output,
                (Kw::SetOut, 1) | (Kw::Motors, 0) => Wants::State,
                (Kw::WaitIn, 0) => Wants::Input,
                (Kw::WaitIn, 1) => Wants::Edge,
                _ => Wants::Any,
            })
        }
        Callee::Routine(_) => Place::Value(Wants::Any),
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
    seen.filter(|symbol| wanted(symbol.sort)).take(MOST).map(item).collect()
}

/// Inputs (`false`) and outputs (`true`) that the profile names.
fn ports(document: &Document, wanted: impl Fn(bool) -> bool) -> Vec<CompletionItem> {
    let Some(profile) = &document.analysis().profile else { return Vec::new() };
    let inputs = profile.inputs.iter().map(|port| (&port.name, "INPUT", port.n));
    let outputs = profile.outputs.iter().map(|port| (&port.name, "OUTPUT", port.n));
    let item = |(name, what, n): (&Option<String>, &str, i32)| {
        let name = name.as_deref().filter(|_| wanted(what == "OUTPUT"))?;
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
