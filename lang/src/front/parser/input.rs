//! The parser's input (a slice of tokens, as nom wants it), its errors and its smallest parsers.

use crate::axis::Axis;
use crate::front::ast::{AxisRef, Expr, Name, Text};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::literal;
use crate::front::span::Span;
use crate::front::token::{Sign, Tok, Token};
use crate::front::words::{Func, Kw};
use core::cell::{Cell, RefCell};
use core::iter::{Copied, Enumerate};
use core::slice::Iter;
use nom::error::{ErrorKind, ParseError};
use nom::{Err, IResult, Input, Needed};
use std::collections::{BTreeSet, HashSet};
use std::rc::Rc;

/// What every parser may look up.
pub struct Context<'a> {
    /// The source.
    pub text: &'a str,
    /// Keys of the names of SUBs and FUNCTIONs anywhere in the script.
    pub routines: BTreeSet<String>,
    /// Names in declarations anywhere in the script, as they are written there.
    pub declared: BTreeSet<&'a str>,
    /// How often a near word was looked for; each time costs a walk over all SUBs.
    pub guesses: Cell<usize>,
    /// TIMEDOUT stands in the script.
    pub reads_timed_out: bool,
    /// A WAIT UNTIL sets it.
    pub timed_waits: Cell<bool>,
    /// Each `RISE(n)` and `FALL(n)`.
    pub edges: RefCell<Vec<Edge>>,
    /// Texts of names, each kept once.
    pub texts: RefCell<HashSet<Rc<str>>>,
}

/// `RISE(n)` or `FALL(n)` in an expression.
#[derive(Clone, Debug)]
pub struct Edge {
    /// FALL.
    pub falls: bool,
    /// The input.
    pub input: Expr,
    /// The whole of it.
    pub span: Span,
    /// Its line.
    pub line: u32,
}

impl Context<'_> {
    /// The one copy of a name's text.
    fn shared(&self, text: &str) -> Rc<str> {
        let mut texts = self.texts.borrow_mut();
        if let Some(known) = texts.get(text) {
            return known.clone();
        }
        let new: Rc<str> = text.into();
        texts.insert(new.clone());
        new
    }
}

/// The tokens that are still to be read, without trivia. The last one is a line end.
#[derive(Clone, Copy)]
pub struct In<'a> {
    /// The tokens.
    pub tokens: &'a [Token],
    /// What may be looked up.
    pub context: &'a Context<'a>,
    /// How many parentheses and one-line IFs are open.
    pub depth: usize,
}

/// What went wrong, and where: either a finished diagnostic or a list of what was expected.
#[derive(Clone, Debug)]
pub struct Failure {
    at: Token,
    expected: Vec<&'static str>,
    diag: Option<Box<Diag>>,
}

/// Result of a parser.
pub type Parsed<'a, T> = IResult<In<'a>, T, Failure>;

const NO_TOKEN: Token = Token { tok: Tok::LineEnd, span: Span::point(0), line: 1 };

impl<'a> In<'a> {
    /// The next token, a line end where none is left.
    pub fn first(self) -> Token {
        self.tokens.first().copied().unwrap_or(NO_TOKEN)
    }

    /// What the next token is.
    pub fn tok(self) -> Tok {
        self.first().tok
    }

    /// The token behind the next one.
    pub fn second(self) -> Token {
        self.tokens.get(1).copied().unwrap_or(NO_TOKEN)
    }

    /// Without the next token.
    pub fn rest(self) -> Self {
        Self { tokens: self.tokens.get(1..).unwrap_or(&[]), ..self }
    }

    /// The next token's text.
    pub fn word(self) -> &'a str {
        self.first().span.of(self.context.text)
    }

    /// Whether a statement ends here.
    pub fn at_end(self) -> bool {
        matches!(self.tok(), Tok::LineEnd | Tok::Sign(Sign::Colon) | Tok::Kw(Kw::Else))
    }

    /// The tokens from here up to `end`, as a place.
    pub fn span_to(self, end: Self) -> Span {
        let first = self.first().span;
        let count = self.tokens.len().saturating_sub(end.tokens.len());
        let last = count.checked_sub(1).and_then(|n| self.tokens.get(n));
        last.map_or(Span::point(first.start), |last| first.to(last.span))
    }

    /// With one more level open; a diagnostic where there are too many.
    pub fn deeper(self) -> Result<Self, Err<Failure>> {
        if self.depth >= crate::front::ast::MAX_BLOCK_DEPTH {
            let message = "this is nested too deeply";
            let diag = Diag::new(Code::TooDeep, self.first().span, message)
                .hint("put parts of it into variables or SUBs");
            return Err(self.fail(diag));
        }
        Ok(Self { depth: self.depth + 1, ..self })
    }

    /// With as many levels open as `outer` has.
    pub fn back_to(self, outer: Self) -> Self {
        Self { depth: outer.depth, ..self }
    }

    /// An error that ends the statement with this diagnostic.
    pub fn fail(self, diag: Diag) -> Err<Failure> {
        Err::Failure(Failure { at: self.first(), expected: Vec::new(), diag: Some(Box::new(diag)) })
    }

    /// An error that another branch may still avert.
    pub fn expected(self, what: &'static str) -> Err<Failure> {
        Err::Error(Failure { at: self.first(), expected: vec![what], diag: None })
    }

    /// The next token in words, for messages.
    pub fn found(self) -> String {
        match self.tok() {
            Tok::LineEnd => "the line ends".to_owned(),
            _ => {
                let shown: String = self.word().chars().take(30).collect();
                format!("found `{shown}`")
            }
        }
    }
}

impl Failure {
    /// The diagnostic; None where the lexer reported the token already. `usage` is the form of the
    /// statement that failed.
    pub fn into_diag(self, text: &str, usage: Option<&str>) -> Option<Diag> {
        if let Some(mut diag) = self.diag {
            if diag.hint.is_none() {
                diag.hint = usage.map(|usage| format!("the form is `{usage}`"));
            }
            return Some(*diag);
        }
        if self.at.tok == Tok::Bad {
            return None;
        }
        let found = match self.at.tok {
            Tok::LineEnd => "before the end of the line".to_owned(),
            _ => format!("before `{}`", self.at.span.of(text).chars().take(30).collect::<String>()),
        };
        let message = format!("expected {} {found}", list(&self.expected));
        let mut diag = Diag::new(Code::Expected, self.at.span, message);
        if self.at.tok != Tok::LineEnd && self.expected.iter().all(|word| *word == "`,`") {
            // It belongs behind the word before.
            let before = text.get(..self.at.span.start as usize).unwrap_or("").trim_end().len();
            diag = diag.fix(Span::point(before as u32), ",");
        }
        Some(match usage {
            Some(usage) => diag.hint(format!("the form is `{usage}`")),
            None => diag,
        })
    }
}

fn list(words: &[&'static str]) -> String {
    let mut unique: Vec<&str> = Vec::new();
    for word in words {
        if !unique.contains(word) {
            unique.push(word);
        }
    }
    match unique.split_last() {
        None => "something else".to_owned(),
        Some((last, [])) => (*last).to_owned(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
    }
}

impl<'a> ParseError<In<'a>> for Failure {
    fn from_error_kind(input: In<'a>, _: ErrorKind) -> Self {
        Self { at: input.first(), expected: Vec::new(), diag: None }
    }

    fn append(_: In<'a>, _: ErrorKind, other: Self) -> Self {
        other
    }

    /// The error that got further explains more.
    fn or(mut self, other: Self) -> Self {
        match self.at.span.start.cmp(&other.at.span.start) {
            core::cmp::Ordering::Less => other,
            core::cmp::Ordering::Greater => self,
            core::cmp::Ordering::Equal => {
                self.expected.extend(other.expected);
                self.diag = self.diag.or(other.diag);
                self
            }
        }
    }
}

impl<'a> Input for In<'a> {
    type Item = Token;
    type Iter = Copied<Iter<'a, Token>>;
    type IterIndices = Enumerate<Copied<Iter<'a, Token>>>;

    fn input_len(&self) -> usize {
        self.tokens.len()
    }

    fn take(&self, index: usize) -> Self {
        Self { tokens: self.tokens.get(..index).unwrap_or(self.tokens), ..*self }
    }

    fn take_from(&self, index: usize) -> Self {
        Self { tokens: self.tokens.get(index..).unwrap_or(&[]), ..*self }
    }

    fn take_split(&self, index: usize) -> (Self, Self) {
        (self.take_from(index), self.take(index))
    }

    fn position<P: Fn(Token) -> bool>(&self, predicate: P) -> Option<usize> {
        self.tokens.iter().position(|&t| predicate(t))
    }

    fn iter_elements(&self) -> Self::Iter {
        self.tokens.iter().copied()
    }

    fn iter_indices(&self) -> Self::IterIndices {
        self.iter_elements().enumerate()
    }

    fn slice_index(&self, count: usize) -> Result<usize, Needed> {
        let missing = count.saturating_sub(self.tokens.len());
        if missing == 0 { Ok(count) } else { Err(Needed::new(missing)) }
    }
}

/// Exactly this token.
pub fn tok<'a>(wanted: Tok, what: &'static str) -> impl Fn(In<'a>) -> Parsed<'a, Token> {
    move |i: In<'a>| {
        if i.tok() == wanted { Ok((i.rest(), i.first())) } else { Err(i.expected(what)) }
    }
}

/// A comma.
pub fn comma(i: In<'_>) -> Parsed<'_, Token> {
    tok(Tok::Sign(Sign::Comma), "`,`")(i)
}

/// This keyword.
pub fn kw<'a>(wanted: Kw) -> impl Fn(In<'a>) -> Parsed<'a, Token> {
    tok(Tok::Kw(wanted), quoted(wanted))
}

/// A keyword in quotes, for messages.
fn quoted(kw: Kw) -> &'static str {
    match kw {
        Kw::Then => "`THEN`",
        Kw::To => "`TO`",
        Kw::Case => "`CASE`",
        Kw::Next => "`NEXT`",
        Kw::Gosub => "`GOSUB`",
        Kw::Goto => "`GOTO`",
        Kw::Error => "`ERROR`",
        _ => kw.text(),
    }
}

/// A quoted text.
pub fn text(i: In<'_>) -> Parsed<'_, Text> {
    let (rest, token) = tok(Tok::Text, "a text in quotes")(i)?;
    let text = i.word().trim_matches('"').to_owned();
    Ok((rest, Text { text, span: token.span }))
}

/// An axis letter.
pub fn axis(i: In<'_>) -> Parsed<'_, AxisRef> {
    let word = i.word();
    let mut letters = word.chars();
    if let (Tok::Name, Some(letter), None) = (i.tok(), letters.next(), letters.next())
        && let Some(axis) = Axis::from_letter(letter)
    {
        return Ok((i.rest(), AxisRef { axis, span: i.first().span }));
    }
    if matches!(i.tok(), Tok::Bad) {
        return Err(i.expected("an axis"));
    }
    let diag =
        Diag::new(Code::NeedsAxis, i.first().span, format!("expected an axis, {}", i.found()));
    let hint = match word {
        "1" => "axis 1 is `X`",
        "2" => "axis 2 is `Y`",
        "3" => "axis 3 is `Z`",
        "(" => "the axis stands without parentheses: X, Y or Z",
        _ => "axes are X, Y and Z",
    };
    let diag = diag.hint(hint);
    let letter = word.parse().ok().and_then(|n: usize| ["X", "Y", "Z"].get(n.checked_sub(1)?));
    Err(i.fail(match letter {
        Some(letter) => diag.fix(i.first().span, *letter),
        None => diag,
    }))
}

/// A word that may be a name.
pub fn name(i: In<'_>) -> Parsed<'_, Name> {
    let span = i.first().span;
    let word = i.word();
    let bad = |message: String, hint: String| {
        Err(i.fail(Diag::new(Code::BadName, span, message).hint(hint)))
    };
    match i.tok() {
        Tok::Name if word.len() == 1 && "xyzXYZ".contains(word) => {
            if let Some(diag) = hyphenated(i) {
                return Err(i.fail(diag));
            }
            bad(format!("`{word}` is an axis and no name"), "choose a longer name".to_owned())
        }
        Tok::Name if crate::front::lexer::begins_gcode(word) => {
            let (letter, number) = word.split_at(1);
            let message = format!("`{word}` looks like a G-code word and can not be a name");
            let instead = format!("{letter}_{number}");
            let diag = Diag::new(Code::BadName, span, message);
            Err(i.fail(diag.hint(format!("write `{instead}`")).fix(span, instead)))
        }
        Tok::Name => Ok((i.rest(), named(i, word, span))),
        Tok::Kw(kw) if kw.is_soft() => Ok((i.rest(), named(i, word, span))),
        Tok::Kw(_) | Tok::Func(_) | Tok::Quiet(_) => {
            let message = format!("`{word}` is a reserved word and can not be a name");
            bad(message, format!("choose another name, as `my_{}`", word.to_ascii_lowercase()))
        }
        Tok::GWord => {
            let message = format!("`{word}` is a G-code word and can not be a name");
            bad(message, "choose a name that is no letter with a number".to_owned())
        }
        _ => Err(i.expected("a name")),
    }
}

/// `Z-depth`, which was meant as one name. `i` stands at its first part.
pub fn hyphenated(i: In<'_>) -> Option<Diag> {
    let [first, sign, last, ..] = i.tokens else { return None };
    let joined = first.span.end == sign.span.start && sign.span.end == last.span.start;
    let signs = (first.tok, sign.tok) == (Tok::Name, Tok::Sign(Sign::Minus));
    if !signs || !joined || !matches!(last.tok, Tok::Name | Tok::Kw(_)) {
        return None;
    }
    let whole = first.span.to(last.span);
    let text = whole.of(i.context.text);
    let name = text.replace('-', "_");
    let diag = Diag::new(Code::BadName, whole, format!("`{text}` is no name"));
    Some(diag.hint(format!("a name has no `-` in it: write `{name}`")).fix(whole, name))
}

/// Makes a name of a word.
pub fn named(i: In<'_>, word: &str, span: Span) -> Name {
    let text = i.context.shared(word);
    let lower = !word.bytes().any(|b| b.is_ascii_uppercase());
    let key = if lower { text.clone() } else { i.context.shared(&word.to_ascii_lowercase()) };
    Name { text, key, span }
}

/// Whether the word is one of the units. MIN is none in front of a value: there it is the limit of a DIM.
pub fn is_unit(i: In<'_>) -> bool {
    let begins =
        |tok| matches!(tok, Tok::Number | Tok::Name | Tok::Func(_) | Tok::Sign(Sign::Minus));
    let limit = i.tok() == Tok::Func(Func::Min) && begins(i.second().tok);
    matches!(i.tok(), Tok::Name | Tok::Func(_)) && literal::is_unit(i.word()) && !limit
}
