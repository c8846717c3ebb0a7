//! Common words as names of the script's own: a script that declares `count`, or has the label `loop:`, uses that word as
//! a name. Without the declaration nothing changes, and with it the script was wrong before: no script means two things.
//!
//! A word stays what it is where its statement or its call stands: `Home X` and `home = 3mm`, `COUNT(table)` and `count + 1`.

use std::collections::HashSet;

use crate::front::span::Span;
use crate::front::token::{Sign, Tok, Token};
use crate::front::words::Kw;

/// Makes names and labels of the words that the script declares.
pub(super) fn take_names(text: &str, tokens: Vec<Token>) -> Vec<Token> {
    let read: Vec<Token> = tokens.iter().copied().filter(|token| !token.tok.is_trivia()).collect();
    let names = declared(text, &read);
    let targets = jumped_to(text, &read);
    if names.is_empty() && targets.is_empty() {
        return tokens;
    }
    let mut out = Vec::with_capacity(tokens.len());
    let (mut before, mut at) = (None, 0);
    let mut colon = None;
    for mut token in tokens {
        if token.tok.is_trivia() {
            out.push(token);
            continue;
        }
        at += 1;
        if colon.take() == Some(token.span) {
            continue;
        }
        let behind = read.get(at);
        let word = key(text, token);
        if may_be_name(token.tok) {
            let starts_line = matches!(before, None | Some(Tok::LineEnd));
            let label = behind.filter(|next| touches(token, next) && starts_line);
            if let Some(next) = label
                && targets.contains(&word)
            {
                token = Token {
                    tok: Tok::Label,
                    span: Span::new(token.span.start, next.span.end),
                    ..token
                };
                colon = Some(next.span);
            } else if is_jump(before) && targets.contains(&word)
                || names.contains(&word) && is_name(token.tok, before, behind)
            {
                token.tok = Tok::Name;
            }
        }
        before = Some(token.tok);
        out.push(token);
    }
    out
}

fn key(text: &str, token: Token) -> String {
    token.span.of(text).to_ascii_lowercase()
}

fn may_be_name(tok: Tok) -> bool {
    match tok {
        Tok::Kw(kw) => kw.may_be_name(),
        Tok::Func(func) => func.may_be_name(),
        _ => false,
    }
}

/// Whether a colon stands directly after the word.
fn touches(word: Token, next: &Token) -> bool {
    next.tok == Tok::Sign(Sign::Colon) && next.span.start == word.span.end
}

fn is_jump(before: Option<Tok>) -> bool {
    matches!(before, Some(Tok::Kw(Kw::Goto | Kw::Gosub)))
}

fn begins(before: Option<Tok>) -> bool {
    matches!(
        before,
        None | Some(Tok::LineEnd | Tok::Label | Tok::Sign(Sign::Colon))
            | Some(Tok::Kw(Kw::Then | Kw::Else))
    )
}

/// Whether a declared word is the name here, and not its statement or its call.
fn is_name(tok: Tok, before: Option<Tok>, behind: Option<&Token>) -> bool {
    let behind = behind.map(|next| next.tok);
    match tok {
        Tok::Func(_) => behind != Some(Tok::Sign(Sign::Open)),
        _ => !begins(before) || matches!(behind, Some(Tok::Sign(Sign::Eq))),
    }
}

/// Words where a name is declared. Elements of arrays and of a TABLE look like calls, so these are refused as before.
fn declared(text: &str, read: &[Token]) -> HashSet<String> {
    let mut names = HashSet::new();
    // The word that opened the declaration, and the parentheses that are open in it.
    let (mut opener, mut open) = (None, 0_usize);
    let mut before = None;
    for (at, token) in read.iter().enumerate() {
        match token.tok {
            Tok::LineEnd => opener = None,
            Tok::Kw(
                kw @ (Kw::Dim
                | Kw::Keep
                | Kw::Const
                | Kw::Input
                | Kw::Output
                | Kw::For
                | Kw::Sub
                | Kw::Function),
            ) => (opener, open) = (Some(kw), 0),
            Tok::Sign(Sign::Open) => open += 1,
            Tok::Sign(Sign::Close) => open = open.saturating_sub(1),
            Tok::Sign(Sign::Colon) if open == 0 => opener = None,
            tok if may_be_name(tok) => {
                let first = matches!((opener, before), (Some(own), Some(Tok::Kw(kw))) if own == kw);
                let comma = before == Some(Tok::Sign(Sign::Comma));
                let declares = match opener {
                    Some(Kw::Sub | Kw::Function) => {
                        open == 1 && (comma || before == Some(Tok::Sign(Sign::Open)))
                    }
                    Some(Kw::Dim | Kw::Keep) => first || comma && open == 0,
                    Some(_) => first,
                    None => false,
                };
                let array = read.get(at + 1).is_some_and(|n| n.tok == Tok::Sign(Sign::Open));
                if declares && !array {
                    names.insert(key(text, *token));
                }
            }
            _ => {}
        }
        before = Some(token.tok);
    }
    names
}

/// Words after GOTO and GOSUB.
fn jumped_to(text: &str, read: &[Token]) -> HashSet<String> {
    let pairs = read.windows(2);
    let jumps = pairs.filter(|pair| is_jump(Some(pair[0].tok)) && may_be_name(pair[1].tok));
    jumps.map(|pair| key(text, pair[1])).collect()
}
