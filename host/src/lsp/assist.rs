//! Completion, hover and definitions, from the table of words and the names of the script.

use std::collections::HashSet;

use lang::fault::Fault;
use lang::front::words::{Class, Func, Kw, Reserved, lookup};
use lsp_types::{
    CompletionItem, CompletionItemKind, Documentation, Hover, HoverContents, MarkupContent,
    MarkupKind, Position, Range, SymbolKind,
};

use super::document::Document;
use super::symbols::{Symbol, declared};

/// What may be written at a place: statements where one begins, else functions and operators, and
/// the names that can be seen from there.
pub fn complete(document: &Document, position: Position) -> Vec<CompletionItem> {
    let (start, _) = document.word(position);
    let line = document.source().line(start);
    let from = document.source().line_start(line);
    let before = document.source().text().get(from as usize..start as usize).unwrap_or("");
    if inside_text(before) {
        return Vec::new();
    }
    let begins = begins_statement(before);
    let mut items: Vec<CompletionItem> = Kw::ALL
        .iter()
        .filter(|kw| kw.begins_statement() == begins || **kw == Kw::On)
        .map(|kw| keyword(*kw))
        .collect();
    if !begins {
        items.extend(Func::ALL.iter().map(|func| function(*func)));
    }
    let mut seen = HashSet::new();
    for symbol in visible(document, start) {
        if seen.insert(symbol.name.key.clone()) {
            items.push(CompletionItem {
                label: symbol.name.text.to_string(),
                kind: Some(item_kind(symbol.kind)),
                detail: Some(declaration(document, &symbol)),
                ..CompletionItem::default()
            });
        }
    }
    items
}

/// Whether a text is open, or a comment has begun.
fn inside_text(before: &str) -> bool {
    let mut quoted = false;
    for c in before.chars() {
        match c {
            '"' => quoted = !quoted,
            '\'' if !quoted => return true,
            _ => {}
        }
    }
    quoted
}

fn begins_statement(before: &str) -> bool {
    let before = before.trim_end();
    let last = before.rsplit(|c: char| c.is_whitespace()).next().unwrap_or("");
    before.is_empty()
        || before.ends_with(':')
        || last.eq_ignore_ascii_case("THEN")
        || last.eq_ignore_ascii_case("ELSE")
        || last.eq_ignore_ascii_case("START")
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

fn item_kind(kind: SymbolKind) -> CompletionItemKind {
    match kind {
        SymbolKind::FUNCTION => CompletionItemKind::FUNCTION,
        SymbolKind::CONSTANT => CompletionItemKind::CONSTANT,
        SymbolKind::KEY => CompletionItemKind::REFERENCE,
        _ => CompletionItemKind::VARIABLE,
    }
}

/// The names that can be seen at an offset; locals stand before the globals that they hide.
fn visible(document: &Document, offset: u32) -> Vec<Symbol<'_>> {
    let line = document.source().line(offset);
    let inside = |s: &Symbol<'_>| {
        s.local_to.is_none_or(|routine| (routine.line..=routine.end_line).contains(&line))
    };
    let mut symbols = declared(document.script());
    symbols.retain(inside);
    symbols.sort_by_key(|symbol| symbol.local_to.is_none());
    symbols
}

fn declaration(document: &Document, symbol: &Symbol<'_>) -> String {
    let line = document.source().line(symbol.name.span.start);
    document.source().line_text(line).trim().to_owned()
}

fn find<'a>(document: &'a Document, position: Position) -> Option<Symbol<'a>> {
    let (start, word) = document.word(position);
    let key = word.to_ascii_lowercase();
    visible(document, start).into_iter().find(|symbol| *symbol.name.key == *key)
}

/// What the word at a place means.
pub fn hover(document: &Document, position: Position) -> Option<Hover> {
    let (start, word) = document.word(position);
    let end = start + word.len() as u32;
    let (code, about) = match lookup(word) {
        Some(Reserved::Kw(kw)) if !kw.is_soft() => {
            (kw.entry().usage.to_owned(), kw.entry().about.to_owned())
        }
        Some(Reserved::Func(func)) => (func.usage().to_owned(), func.about().to_owned()),
        _ => match find(document, position) {
            Some(symbol) => (declaration(document, &symbol), String::new()),
            None => fault(word)?,
        },
    };
    let value = format!("```basic\n{code}\n```\n{about}");
    Some(Hover {
        contents: HoverContents::Markup(MarkupContent { kind: MarkupKind::Markdown, value }),
        range: Some(document.range(lang::front::span::Span::new(start, end))),
    })
}

/// A fault's code in a comment or a text.
fn fault(word: &str) -> Option<(String, String)> {
    let fault = Fault::ALL.iter().find(|fault| fault.to_string().eq_ignore_ascii_case(word))?;
    Some((format!("{fault} {}", fault.text()), fault.remedy().to_owned()))
}

/// Where the name at a place is declared.
pub fn definition(document: &Document, position: Position) -> Option<Range> {
    find(document, position).map(|symbol| document.range(symbol.name.span))
}
