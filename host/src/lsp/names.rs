//! Outline, definition, references, highlight and rename.

use lang::front::index::{Mention, Sort};
use lang::front::span::Span;
use lsp_types::{
    DocumentHighlight, DocumentHighlightKind, DocumentSymbol, Location, Position,
    PrepareRenameResponse, Range, SymbolKind, TextEdit, WorkspaceEdit,
};

use super::diagnostics::edits;
use super::document::{Document, MOST};

fn at(document: &Document, position: Position) -> Option<Mention> {
    document.index().at(document.offset(position)).copied()
}

/// Where the name at a place is declared.
pub fn definition(document: &Document, position: Position) -> Option<Location> {
    let mention = at(document, position)?;
    let range = document.range(document.index().symbols()[mention.symbol].name.span);
    Some(Location { uri: document.uri().clone(), range })
}

/// Every place that names the same, with or without its declaration.
pub fn references(
    document: &Document,
    position: Position,
    declaration: bool,
) -> Option<Vec<Location>> {
    let mention = at(document, position)?;
    let declared = document.index().symbols()[mention.symbol].name.span;
    let places = document.index().mentions_of(mention.symbol);
    let places = places.filter(|m| declaration || m.span != declared);
    let location =
        |m: &Mention| Location { uri: document.uri().clone(), range: document.range(m.span) };
    Some(places.take(MOST).map(location).collect())
}

/// The same for the marks in the text, which tell reading from writing.
pub fn highlight(document: &Document, position: Position) -> Option<Vec<DocumentHighlight>> {
    let mention = at(document, position)?;
    let mark = |m: &Mention| DocumentHighlight {
        range: document.range(m.span),
        kind: Some(if m.writes {
            DocumentHighlightKind::WRITE
        } else {
            DocumentHighlightKind::READ
        }),
    };
    Some(document.index().mentions_of(mention.symbol).take(MOST).map(mark).collect())
}

/// The name that a rename at a place would change.
pub fn prepare_rename(document: &Document, position: Position) -> Option<PrepareRenameResponse> {
    let mention = at(document, position)?;
    let placeholder = mention.span.of(document.source().text()).to_owned();
    let range = document.range(mention.span);
    Some(PrepareRenameResponse::RangeWithPlaceholder { range, placeholder })
}

/// Gives the name at a place, everywhere, another one.
///
/// # Errors
/// There is no name, or the other one cannot be had; in words.
pub fn rename(document: &Document, position: Position, to: &str) -> Result<WorkspaceEdit, String> {
    let mention = at(document, position)
        .ok_or_else(|| "nothing here has a name of the script's own".to_owned())?;
    document.index().may_rename(mention.symbol, to)?;
    if document.index().mentions_of(mention.symbol).nth(MOST).is_some() {
        return Err(format!("the name stands at more than {MOST} places: replace it by a search"));
    }
    let edit = |m: &Mention| TextEdit { range: document.range(m.span), new_text: to.to_owned() };
    Ok(edits(document, document.index().mentions_of(mention.symbol).map(edit).collect()))
}

/// The outline of a document: what the main program declares, and routines with their locals.
pub fn outline(document: &Document) -> Vec<DocumentSymbol> {
    let index = document.index();
    let entry = |n: usize| {
        let symbol = &index.symbols()[n];
        let span = symbol.span.to(symbol.name.span);
        entry(document, &symbol.name.text, kind(symbol.sort), span, symbol.name.span)
    };
    let of = |local_to: Option<usize>| {
        let own = index.symbols().iter().enumerate().filter(move |(_, s)| s.local_to == local_to);
        own.map(|(n, _)| n)
    };
    let routine = |s: Sort| matches!(s, Sort::Sub | Sort::Function);
    let mut outline: Vec<DocumentSymbol> =
        of(None).filter(|&n| !routine(index.symbols()[n].sort)).take(MOST).map(entry).collect();
    for (n, routine) in document.analysis().script.routines.iter().enumerate().take(MOST) {
        let text = document.source();
        let end = text.line_start(routine.end_line.max(routine.line).saturating_add(1));
        let span = routine.span.to(Span::point(end.saturating_sub(1).max(routine.span.end)));
        let name = &routine.name;
        let mut whole = self::entry(document, &name.text, SymbolKind::FUNCTION, span, name.span);
        whole.children = Some(of(Some(n)).take(MOST).map(entry).collect());
        outline.push(whole);
    }
    outline
}

fn entry(
    document: &Document,
    name: &str,
    kind: SymbolKind,
    span: Span,
    own: Span,
) -> DocumentSymbol {
    let range: Range = document.range(span);
    #[expect(deprecated, reason = "the protocol's type still has the field")]
    DocumentSymbol {
        name: name.to_owned(),
        detail: None,
        kind,
        tags: None,
        deprecated: None,
        range,
        selection_range: document.range(own),
        children: None,
    }
}

const fn kind(sort: Sort) -> SymbolKind {
    match sort {
        Sort::Const | Sort::Input | Sort::Output => SymbolKind::CONSTANT,
        Sort::Variable | Sort::Parameter => SymbolKind::VARIABLE,
        Sort::Array | Sort::Table => SymbolKind::ARRAY,
        Sort::Sub | Sort::Function => SymbolKind::FUNCTION,
        Sort::Label => SymbolKind::KEY,
    }
}
