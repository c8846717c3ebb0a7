//! Semantic tokens, folding and inlay hints of a document.

use lang::front::ast::{Block, Stmt, StmtKind};
use lang::front::index::Sort;
use lang::front::span::Span;
use lang::front::token::Tok;
use lang::front::words::{Class, Func, Kw};
use lang::kind::Kind;
use lsp_types::{
    FoldingRange, FoldingRangeKind, InlayHint, InlayHintKind, InlayHintLabel, Position, Range,
    SemanticToken, SemanticTokenModifier, SemanticTokenType, SemanticTokensLegend,
};

use super::about;
use super::document::Document;

/// Sorts of tokens, in the order of [`Paint`].
const TYPES: [&str; 12] = [
    "keyword",
    "function",
    "variable",
    "parameter",
    "number",
    "string",
    "comment",
    "operator",
    "macro",
    "property",
    "type",
    "label",
];

/// What a token is: an index into [`TYPES`].
#[derive(Clone, Copy)]
enum Paint {
    Keyword,
    Function,
    Variable,
    Parameter,
    Number,
    Text,
    Comment,
    Operator,
    Gcode,
    Port,
    Kind,
    Label,
}

/// Modifiers' bits, in the legend's order.
const DECLARATION: u32 = 1;
const READONLY: u32 = 2;
const BUILT_IN: u32 = 4;

/// The names of token types and modifiers.
pub fn legend() -> SemanticTokensLegend {
    SemanticTokensLegend {
        token_types: TYPES.iter().map(|name| SemanticTokenType::new(name)).collect(),
        token_modifiers: vec![
            SemanticTokenModifier::DECLARATION,
            SemanticTokenModifier::READONLY,
            SemanticTokenModifier::DEFAULT_LIBRARY,
        ],
    }
}

/// Every token that has a colour, each placed relative to the one before, as the protocol wants it.
pub fn tokens(document: &Document) -> Vec<SemanticToken> {
    let mut before = Position::new(0, 0);
    let mut tokens = Vec::new();
    let mut mentions = document.index().mentions().iter().peekable();
    let mut behind_as = false;
    for token in document.tokens() {
        let is_kind = std::mem::replace(&mut behind_as, token.tok == Tok::Kw(Kw::As));
        while mentions.next_if(|m| m.span.start < token.span.start).is_some() {}
        let named = mentions.peek().filter(|m| m.span.start == token.span.start);
        let (paint, modifiers, span) = match named {
            Some(mention) => {
                let symbol = &document.index().symbols()[mention.symbol];
                let declared = u32::from(symbol.name.span == mention.span) * DECLARATION;
                let (paint, modifiers) = of_sort(symbol.sort);
                (paint, modifiers | declared, mention.span)
            }
            // LENGTH and STEPS are functions elsewhere.
            None if is_kind => (Paint::Kind, 0, token.span),
            None => match of_token(token.tok, token.span.of(document.source().text())) {
                Some((paint, modifiers, skip)) => {
                    (paint, modifiers, Span::new(token.span.start + skip, token.span.end))
                }
                None => continue,
            },
        };
        let text = span.of(document.source().text()).trim_end();
        let at = document.position(span.start);
        let same = at.line == before.line;
        tokens.push(SemanticToken {
            delta_line: at.line - before.line,
            delta_start: at.character - if same { before.character } else { 0 },
            length: text.encode_utf16().count() as u32,
            token_type: paint as u32,
            token_modifiers_bitset: modifiers,
        });
        before = at;
    }
    tokens
}

const fn of_sort(sort: Sort) -> (Paint, u32) {
    match sort {
        Sort::Const | Sort::Table => (Paint::Variable, READONLY),
        Sort::Input | Sort::Output => (Paint::Port, READONLY),
        Sort::Variable | Sort::Array => (Paint::Variable, 0),
        Sort::Parameter => (Paint::Parameter, 0),
        Sort::Sub | Sort::Function => (Paint::Function, 0),
        Sort::Label => (Paint::Label, 0),
    }
}

/// Colour of a token that is no name of the script, and the letters before what is coloured.
fn of_token(tok: Tok, text: &str) -> Option<(Paint, u32, u32)> {
    let plain = |paint| Some((paint, 0, 0));
    match tok {
        Tok::Number | Tok::Bit => plain(Paint::Number),
        Tok::Text => plain(Paint::Text),
        Tok::Comment | Tok::GComment => plain(Paint::Comment),
        Tok::Continuation => text.find('\'').map(|at| (Paint::Comment, 0, at as u32)),
        Tok::Kw(kw) | Tok::Quiet(kw) => match kw.entry().class {
            Class::Operator => plain(Paint::Operator),
            Class::Machine => Some((Paint::Function, BUILT_IN, 0)),
            _ if is_kind(kw) => plain(Paint::Kind),
            _ => plain(Paint::Keyword),
        },
        Tok::Func(_) => Some((Paint::Function, BUILT_IN, 0)),
        Tok::GWord | Tok::GLetter => plain(Paint::Gcode),
        // What stands here undeclared is an axis, or a name of the profile.
        Tok::Name if text.len() == 1 && "xyzXYZ".contains(text) => plain(Paint::Gcode),
        Tok::Name if Func::soft(text).is_some() => Some((Paint::Function, BUILT_IN, 0)),
        Tok::Name => Some((Paint::Port, READONLY, 0)),
        Tok::Label | Tok::Sign(_) | Tok::LineEnd | Tok::Bad => None,
    }
}

fn is_kind(kw: Kw) -> bool {
    Kind::from_name(kw.text()).is_some()
}

/// Blocks, routines and runs of comment lines.
pub fn folds(document: &Document) -> Vec<FoldingRange> {
    let mut folds = Vec::new();
    let mut fold = |first: u32, last: u32, kind: Option<FoldingRangeKind>| {
        if first < last {
            folds.push(FoldingRange {
                start_line: first - 1,
                end_line: last - 1,
                kind,
                ..FoldingRange::default()
            });
        }
    };
    let script = &document.analysis().script;
    for_blocks(&script.body, &mut |first, last| fold(first, last, None));
    for routine in &script.routines {
        fold(routine.line, routine.end_line, None);
        for_blocks(&routine.body, &mut |first, last| fold(first, last, None));
    }
    let mut comments: Option<(u32, u32)> = None;
    let mut alone = true;
    for token in document.tokens() {
        match token.tok {
            Tok::Comment if alone => match &mut comments {
                Some((_, last)) if *last + 1 == token.line => *last = token.line,
                _ => {
                    if let Some((first, last)) = comments.replace((token.line, token.line)) {
                        fold(first, last, Some(FoldingRangeKind::Comment));
                    }
                }
            },
            _ => {}
        }
        alone = token.tok == Tok::LineEnd;
    }
    if let Some((first, last)) = comments {
        fold(first, last, Some(FoldingRangeKind::Comment));
    }
    folds
}

fn for_blocks(block: &Block, fold: &mut impl FnMut(u32, u32)) {
    for stmt in block {
        if let Some(last) = last_line(stmt) {
            fold(stmt.line, last);
        }
        stmt.blocks().for_each(|inner| for_blocks(inner, fold));
    }
}

/// The line before the one that closes a block; of an IF or SELECT that of its last statement.
fn last_line(stmt: &Stmt) -> Option<u32> {
    match &stmt.kind {
        StmtKind::For { next_line: end, .. }
        | StmtKind::While { end_line: end, .. }
        | StmtKind::Do { loop_line: end, .. }
        | StmtKind::Repeat { end_line: end, .. } => end.checked_sub(1),
        StmtKind::If { one_line: true, .. } => None,
        _ => stmt
            .blocks()
            .filter_map(|block| block.last())
            .map(|s| last_line(s).map_or(s.line, |l| l + 1))
            .max(),
    }
}

/// Kinds that the script does not write.
pub fn hints(document: &Document, range: Range) -> Vec<InlayHint> {
    let hint = |symbol: &lang::front::index::Symbol| {
        let fact = about::fact(document, symbol).filter(|fact| fact.inferred)?;
        let open =
            matches!(symbol.sort, Sort::Variable | Sort::Array | Sort::Parameter | Sort::Function);
        let kind = fact.kinds.first().filter(|_| open)?;
        let text = document.source().text();
        // Behind the size of an array and the parameters of a FUNCTION.
        let end = symbol.name.span.end as usize;
        let rest = text.get(end..).unwrap_or("");
        let behind = match rest.starts_with('(') {
            true => rest.find(')').map_or(0, |at| at + 1),
            false => 0,
        };
        let position = document.position((end + behind) as u32);
        let inside = (range.start..=range.end).contains(&position);
        inside.then(|| InlayHint {
            position,
            label: InlayHintLabel::String(format!("AS {}", kind.name().to_uppercase())),
            kind: Some(InlayHintKind::TYPE),
            text_edits: None,
            tooltip: None,
            padding_left: Some(true),
            padding_right: None,
            data: None,
        })
    };
    document.index().symbols().iter().filter_map(hint).collect()
}
