//! The formatter: canonical case, blanks and indentation. Lines stay lines, since ERL and traces
//! show their numbers; comments stay where they are.

use super::diag::{Diag, Diags};
use super::lexer::lex;
use super::literal;
use super::parser::parse;
use super::token::{Sign, Tok, Token};
use super::words::{Func, Kw};

/// Blanks for one level.
const INDENT: usize = 2;
/// Columns that a continued line stands further in, unless it was written still further in.
const CONTINUED: usize = 4;
/// Longest distance, in columns, of a comment from the code before it, and of a continued line from
/// its statement.
const MAX_DISTANCE: usize = 60;
/// Deepest indentation, in levels; beyond it lines stay below each other.
const MAX_LEVEL: usize = 40;

/// Formats a script; one that does not parse is left alone and its diagnostics come back.
pub fn format(text: &str) -> Result<String, Vec<Diag>> {
    let mut diags = Diags::new();
    parse(text, &mut diags);
    if diags.has_errors() {
        return Err(diags.into_sorted());
    }
    let tokens = lex(text, &mut Diags::new());
    let mut out = String::with_capacity(text.len() + text.len() / 8);
    let mut level = 0usize;
    let mut first = "";
    for line in tokens.split_inclusive(|t| t.tok == Tok::LineEnd) {
        let end = *line.last().unwrap_or(&END);
        let line = line.strip_suffix(&[end]).unwrap_or(line);
        level = write_line(text, line, level, &mut out);
        // Lines end as they did; a last line without an end gets that of the first.
        let own = end.span.of(text);
        if first.is_empty() {
            first = if own.is_empty() { "\n" } else { own };
        }
        out.push_str(if own.is_empty() { first } else { own });
    }
    if text.is_empty() {
        out.clear();
    }
    Ok(out)
}

const END: Token = Token { tok: Tok::LineEnd, span: super::span::Span::point(0), line: 1 };

/// Writes a line without its end; gives the level behind it.
fn write_line(text: &str, line: &[Token], level: usize, out: &mut String) -> usize {
    let shape = Shape::of(line);
    let outdent = usize::from(shape.outdents);
    let column = level.saturating_sub(outdent).min(MAX_LEVEL) * INDENT;
    let mut before: Option<Token> = None;
    for (n, token) in line.iter().enumerate() {
        let before_unary = before.is_some_and(|b| is_unary_minus(line, n - 1, b));
        match before {
            None => out.extend(core::iter::repeat_n(' ', column)),
            Some(b) if b.tok == Tok::Continuation => {
                let first = line.first().map_or(0, |first| original_column(text, *first));
                let further = match original_column(text, *token).saturating_sub(first) {
                    further if further >= INDENT => further.min(MAX_DISTANCE),
                    _ => CONTINUED,
                };
                out.extend(core::iter::repeat_n(' ', column + further));
            }
            Some(_) if before_unary => {}
            Some(b) if token.tok == Tok::Comment => {
                // Comments may stand below each other: their distance is kept.
                let distance = token.span.start.saturating_sub(b.span.end) as usize;
                out.extend(core::iter::repeat_n(' ', distance.clamp(1, MAX_DISTANCE)));
            }
            Some(b) => {
                let called = n == 1 && b.tok == Tok::Name;
                out.push_str(gap(b, *token, called));
            }
        }
        let soft = soft_role(line, n);
        match waits_until(line, n) {
            true => out.push_str("WAIT"),
            false => write_token(text, *token, soft, out),
        }
        if token.tok == Tok::Continuation {
            out.push('\n');
        }
        before = Some(*token);
    }
    (level + shape.opens).saturating_sub(shape.closes)
}

fn starts_statement(tok: Tok, before: bool) -> bool {
    match tok {
        Tok::Label | Tok::Sign(Sign::Colon) | Tok::Kw(Kw::Then | Kw::Else) => true,
        Tok::Comment | Tok::GComment | Tok::Continuation => before,
        _ => false,
    }
}

/// The column in which a token was written, from 0, in bytes.
fn original_column(text: &str, token: Token) -> usize {
    let before = text.get(..token.span.start as usize).unwrap_or("");
    before.len() - before.rfind(['\n', '\r']).map_or(0, |end| end + 1)
}

/// What a line does to the indentation.
#[derive(Default)]
struct Shape {
    opens: usize,
    closes: usize,
    /// The line itself stands one level further out.
    outdents: bool,
}

impl Shape {
    fn of(line: &[Token]) -> Self {
        let words: Vec<Tok> = line.iter().map(|t| t.tok).filter(|t| !t.is_trivia()).collect();
        let mut shape = Self::default();
        let mut start = true;
        let mut first = true;
        for (n, &tok) in words.iter().enumerate() {
            if start {
                let second = words.get(n + 1).copied();
                match tok {
                    Tok::Kw(
                        Kw::For
                        | Kw::While
                        | Kw::Do
                        | Kw::Repeat
                        | Kw::Select
                        | Kw::Sub
                        | Kw::Function,
                    ) => shape.opens += 1,
                    Tok::Kw(Kw::If) if words.last() == Some(&Tok::Kw(Kw::Then)) => shape.opens += 1,
                    Tok::Kw(Kw::If) => return shape,
                    Tok::Kw(Kw::Next | Kw::Wend | Kw::Loop) => shape.close(first),
                    Tok::Kw(Kw::End) if closes_block(second) => shape.close(first),
                    Tok::Kw(Kw::Else | Kw::ElseIf | Kw::Case) => shape.outdents |= first,
                    Tok::Label => shape.outdents |= first,
                    _ => {}
                }
                first = false;
            }
            start = starts_statement(tok, start);
        }
        shape
    }

    fn close(&mut self, first: bool) {
        self.outdents |= first;
        self.closes += 1;
    }
}

fn closes_block(word: Option<Tok>) -> bool {
    matches!(word, Some(Tok::Kw(Kw::If | Kw::Select | Kw::Repeat | Kw::Sub | Kw::Function)))
}

/// Whether the minus at `n` has one operand: no value stands before it.
fn is_unary_minus(line: &[Token], n: usize, token: Token) -> bool {
    if token.tok != Tok::Sign(Sign::Minus) {
        return false;
    }
    let mut words = line.iter().take(n).rev().filter(|t| !t.tok.is_trivia());
    let Some(before) = words.next() else { return true };
    match before.tok {
        // Without a parenthesis they are the limits of a DIM.
        Tok::Func(Func::Min | Func::Max) => true,
        Tok::Number | Tok::Bit | Tok::Text | Tok::Func(_) => false,
        Tok::Sign(sign) => !matches!(sign, Sign::Close | Sign::CloseBracket),
        Tok::Kw(Kw::True | Kw::False | Kw::On | Kw::Off) => false,
        // A statement never begins with an expression: `name -1` is a call.
        Tok::Name => words.next().is_none_or(|t| starts_statement(t.tok, false)),
        Tok::Kw(kw) => !kw.is_soft(),
        _ => true,
    }
}

/// What stands between two tokens. `called` says that the first one begins a line.
fn gap(before: Token, token: Token, called: bool) -> &'static str {
    let signs = |tok: Tok| match tok {
        Tok::Sign(sign) => Some(sign),
        _ => None,
    };
    match (signs(before.tok), signs(token.tok)) {
        (Some(Sign::Open | Sign::OpenBracket), _) => "",
        (_, Some(Sign::Comma | Sign::Semicolon | Sign::Close | Sign::CloseBracket)) => "",
        (_, Some(Sign::OpenBracket)) => "",
        _ if token.tok == Tok::Bit => "",
        (None, Some(Sign::Open)) => match before.tok {
            Tok::Name | Tok::Func(_) => "",
            Tok::Kw(kw) if kw.is_soft() && !called => "",
            _ => " ",
        },
        _ => " ",
    }
}

/// Whether the soft word at `n` plays its part here; otherwise it is a name.
fn soft_role(line: &[Token], n: usize) -> bool {
    let Some(Tok::Kw(kw)) = line.get(n).map(|t| t.tok) else { return false };
    let mut before = line.iter().take(n).rev().map(|t| t.tok).filter(|t| !t.is_trivia());
    let first = before.next();
    match kw {
        Kw::Error | Kw::Every => first == Some(Tok::Kw(Kw::On)),
        Kw::Stop => first == Some(Tok::Kw(Kw::Error)),
        Kw::Xy | Kw::Xz | Kw::Yz => first == Some(Tok::Kw(Kw::Plane)),
        Kw::Rise | Kw::Fall => {
            let starts =
                |tok: &Tok| matches!(tok, Tok::Kw(Kw::On | Kw::WaitIn) | Tok::Quiet(Kw::WaitIn));
            let statement = |tok: &Tok| *tok != Tok::Sign(Sign::Colon);
            let gosub = line.get(n + 1).map(|t| t.tok) == Some(Tok::Kw(Kw::Gosub));
            let comma = first == Some(Tok::Sign(Sign::Comma));
            (gosub || comma) && before.take_while(statement).any(|t| starts(&t))
        }
        Kw::Analog => {
            let begins = matches!(first, None | Some(Tok::Label | Tok::Sign(Sign::Colon)));
            begins && line.get(n + 1).is_some_and(|t| t.tok == Tok::Name)
        }
        _ => first == Some(Tok::Kw(Kw::As)),
    }
}

/// Whether the word at `n` is the WAIT of WAIT UNTIL, which is written like the words of control.
fn waits_until(line: &[Token], n: usize) -> bool {
    let tok = |n: usize| line.get(n).map(|t| t.tok);
    (tok(n), tok(n + 1)) == (Some(Tok::Kw(Kw::Wait)), Some(Tok::Kw(Kw::Until)))
}

/// The `_` and the comment behind it, whose distance is kept.
fn write_continuation(written: &str, out: &mut String) {
    out.push('_');
    if let Some((blanks, _)) = written.split_once('\'') {
        out.extend(core::iter::repeat_n(' ', (blanks.len() - 1).clamp(1, MAX_DISTANCE)));
        out.push_str(written[blanks.len()..].trim_end());
    }
}

fn write_token(text: &str, token: Token, soft_role: bool, out: &mut String) {
    let written = token.span.of(text);
    match token.tok {
        Tok::Kw(kw) if !kw.is_soft() || soft_role => out.push_str(kw.text()),
        Tok::Quiet(kw) => {
            out.push_str(kw.text());
            out.push('?');
        }
        Tok::Func(func) => out.push_str(func.text()),
        // A lone x, y or z is always an axis.
        Tok::Name if written.len() == 1 && "xyz".contains(written) => {
            out.push_str(&written.to_ascii_uppercase());
        }
        Tok::GWord | Tok::GLetter => out.push_str(&written.to_ascii_uppercase()),
        Tok::Number if written.starts_with('&') => out.push_str(&written.to_ascii_uppercase()),
        Tok::Number => out.push_str(&literal::spelled(written)),
        Tok::Continuation => write_continuation(written, out),
        Tok::Comment => {
            let rem = written.get(..3).is_some_and(|w| w.eq_ignore_ascii_case("REM"));
            let written = written.trim_end();
            if rem {
                out.push_str("REM");
                out.push_str(&written[3..]);
            } else {
                out.push_str(written);
            }
        }
        Tok::GComment => out.push_str(written.trim_end()),
        _ => out.push_str(written),
    }
}
