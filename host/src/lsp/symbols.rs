//! The names that a script declares.

use lang::front::ast::{Block, Name, Routine, Script, StmtKind, Variable};
use lang::front::span::Span;
use lsp_types::{DocumentSymbol, SymbolKind};

use super::document::Document;

/// A declared name.
pub struct Symbol<'a> {
    /// The name at its declaration.
    pub name: &'a Name,
    /// What it is.
    pub kind: SymbolKind,
    /// The words of the declaration.
    pub span: Span,
    /// The SUB or FUNCTION that it is local to.
    pub local_to: Option<&'a Routine>,
}

/// Every declared name in text order of the main program, then of each routine.
pub fn declared(script: &Script) -> Vec<Symbol<'_>> {
    let mut symbols = Vec::new();
    collect(&script.body, None, &mut symbols);
    for routine in &script.routines {
        let (name, span) = (&routine.name, routine.span);
        symbols.push(Symbol { name, kind: SymbolKind::FUNCTION, span, local_to: None });
        for param in &routine.params {
            symbols.push(Symbol {
                name: &param.name,
                kind: SymbolKind::VARIABLE,
                span,
                local_to: Some(routine),
            });
        }
        collect(&routine.body, Some(routine), &mut symbols);
    }
    symbols
}

fn collect<'a>(block: &'a Block, local_to: Option<&'a Routine>, symbols: &mut Vec<Symbol<'a>>) {
    for stmt in block {
        let mut add = |name: &'a Name, kind| {
            symbols.push(Symbol { name, kind, span: stmt.span, local_to });
        };
        let variable = |v: &Variable| {
            if v.size.is_some() { SymbolKind::ARRAY } else { SymbolKind::VARIABLE }
        };
        match &stmt.kind {
            StmtKind::Label(name) => add(name, SymbolKind::KEY),
            StmtKind::Const(list) | StmtKind::Port { ports: list, .. } => {
                list.iter().for_each(|(name, _)| add(name, SymbolKind::CONSTANT));
            }
            StmtKind::Dim(list) | StmtKind::Keep(list) => {
                list.iter().for_each(|v| add(&v.name, variable(v)));
            }
            StmtKind::Table { name, .. } => add(name, SymbolKind::ARRAY),
            StmtKind::If { arms, otherwise, .. } => {
                arms.iter().for_each(|arm| collect(&arm.body, local_to, symbols));
                otherwise.iter().for_each(|body| collect(body, local_to, symbols));
            }
            StmtKind::Select { cases, otherwise, .. } => {
                cases.iter().for_each(|case| collect(&case.body, local_to, symbols));
                otherwise.iter().for_each(|body| collect(body, local_to, symbols));
            }
            StmtKind::For { body, .. }
            | StmtKind::While { body, .. }
            | StmtKind::Do { body, .. }
            | StmtKind::Repeat { body, .. } => collect(body, local_to, symbols),
            _ => {}
        }
    }
}

/// The outline of a document: what the main program declares, and routines with their locals.
pub fn outline(document: &Document) -> Vec<DocumentSymbol> {
    let mut outline: Vec<DocumentSymbol> = Vec::new();
    for symbol in declared(document.script()) {
        let entry = entry(document, &symbol);
        match (symbol.local_to, outline.last_mut()) {
            (Some(_), Some(routine)) => routine.children.get_or_insert_default().push(entry),
            _ => outline.push(entry),
        }
    }
    outline
}

fn entry(document: &Document, symbol: &Symbol<'_>) -> DocumentSymbol {
    #[expect(deprecated, reason = "the protocol's type still has the field")]
    DocumentSymbol {
        name: symbol.name.text.to_string(),
        detail: None,
        kind: symbol.kind,
        tags: None,
        deprecated: None,
        range: document.range(symbol.span.to(symbol.name.span)),
        selection_range: document.range(symbol.name.span),
        children: None,
    }
}
