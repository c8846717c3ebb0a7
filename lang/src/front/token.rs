//! Tokens: what the parser reads, and the two logos lexers that find them.

use super::span::Span;
use super::words::{Func, Kw};
use logos::Logos;

/// A token. Texts and values are taken from the source where they are needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Tok {
    /// A number, with its unit; known to be a good one.
    Number,
    /// `.3` directly behind a name or a parenthesis: a bit.
    Bit,
    /// A quoted text.
    Text,
    /// A word that is not reserved.
    Name,
    /// `name:` at the start of a line; the colon is part of it.
    Label,
    /// A keyword, soft ones included.
    Kw(Kw),
    /// A keyword with its `?`.
    Quiet(Kw),
    /// The name of a built-in function.
    Func(Func),
    /// A sign.
    Sign(Sign),
    /// A G-code word with a number; the whole word.
    GWord,
    /// The letter of a G-code word whose value stands in brackets.
    GLetter,
    /// The end of a line, and of the file.
    LineEnd,
    /// A comment that begins with `'` or REM.
    Comment,
    /// A G-code comment.
    GComment,
    /// Blank, `_`, a comment that may stand there, and the line end that they hide.
    Continuation,
    /// Something that was reported.
    Bad,
}

impl Tok {
    /// Means nothing to the parser.
    pub const fn is_trivia(self) -> bool {
        matches!(self, Self::Comment | Self::GComment | Self::Continuation)
    }
}

/// The signs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sign {
    /// `+`
    Plus,
    /// `-`
    Minus,
    /// `*`
    Star,
    /// `/`
    Slash,
    /// `=`
    Eq,
    /// `<>`
    Ne,
    /// `<`
    Lt,
    /// `<=`
    Le,
    /// `>`
    Gt,
    /// `>=`
    Ge,
    /// `<<`
    Shl,
    /// `>>`
    Shr,
    /// `(`
    Open,
    /// `)`
    Close,
    /// `[`
    OpenBracket,
    /// `]`
    CloseBracket,
    /// `,`
    Comma,
    /// `;`
    Semicolon,
    /// `:`
    Colon,
}

/// A token at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Token {
    /// What it is.
    pub tok: Tok,
    /// Where it is.
    pub span: Span,
    /// Its line, from 1.
    pub line: u32,
}

/// Pieces of a BASIC statement, before words are looked up.
#[derive(Logos, Clone, Copy, Debug, PartialEq, Eq)]
#[logos(skip r"[ \t\x0B\x0C\u{A0}]+")]
pub(super) enum Basic {
    #[regex(r"[0-9][0-9_]*(\.[0-9_]*)?")]
    #[regex(r"\.[0-9][0-9_]*")]
    #[regex(r"&[hHbB][0-9A-Za-z_]*")]
    Number,
    #[regex(r"[A-Za-z][A-Za-z0-9_]*")]
    Word,
    #[regex(r#""[^"\r\n]*""#)]
    Text,
    #[regex(r#""[^"\r\n]*"#)]
    UnclosedText,
    #[regex(r"'[^\r\n]*", allow_greedy = true)]
    Comment,
    #[regex(r"\r\n|\n|\r")]
    LineEnd,
    #[regex(r"_[ \t]*('[^\r\n]*)?(\r\n|\n|\r)")]
    Continuation,
    #[token("?")]
    Question,
    #[token("+", |_| Sign::Plus)]
    #[token("-", |_| Sign::Minus)]
    #[token("*", |_| Sign::Star)]
    #[token("/", |_| Sign::Slash)]
    #[token("=", |_| Sign::Eq)]
    #[token("<>", |_| Sign::Ne)]
    #[token("<", |_| Sign::Lt)]
    #[token("<=", |_| Sign::Le)]
    #[token(">", |_| Sign::Gt)]
    #[token(">=", |_| Sign::Ge)]
    #[token("<<", |_| Sign::Shl)]
    #[token(">>", |_| Sign::Shr)]
    #[token("(", |_| Sign::Open)]
    #[token(")", |_| Sign::Close)]
    #[token("[", |_| Sign::OpenBracket)]
    #[token("]", |_| Sign::CloseBracket)]
    #[token(",", |_| Sign::Comma)]
    #[token(";", |_| Sign::Semicolon)]
    #[token(":", |_| Sign::Colon)]
    Sign(Sign),
    /// Operators of other languages, each with what it means here.
    #[token("==", |_| Foreign::Equal)]
    #[token("=<", |_| Foreign::LessEqual)]
    #[token("=>", |_| Foreign::GreaterEqual)]
    #[token("!=", |_| Foreign::NotEqual)]
    #[token("&&", |_| Foreign::And)]
    #[token("||", |_| Foreign::Or)]
    #[token(":=", |_| Foreign::Assign)]
    #[token("++", |_| Foreign::Increment)]
    #[token("+=", |_| Foreign::AddAssign)]
    #[token("-=", |_| Foreign::SubAssign)]
    #[token("*=", |_| Foreign::OtherAssign)]
    #[token("/=", |_| Foreign::OtherAssign)]
    #[token("**", |_| Foreign::Power)]
    #[token("^", |_| Foreign::Power)]
    #[token("\\", |_| Foreign::Backslash)]
    #[token("!", |_| Foreign::Bang)]
    #[token("~", |_| Foreign::Tilde)]
    #[token("&", |_| Foreign::Ampersand)]
    #[token("|", |_| Foreign::Bar)]
    #[token("%", |_| Foreign::Percent)]
    #[token("{", |_| Foreign::Brace)]
    #[token("}", |_| Foreign::Brace)]
    Foreign(Foreign),
    #[regex(r"//[^\r\n]*", allow_greedy = true)]
    #[regex(r"/\*[^\r\n]*", allow_greedy = true)]
    ForeignComment,
}

/// Signs that other languages have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Foreign {
    Equal,
    LessEqual,
    GreaterEqual,
    NotEqual,
    And,
    Or,
    Assign,
    Increment,
    AddAssign,
    SubAssign,
    OtherAssign,
    Power,
    Backslash,
    Bang,
    Tilde,
    Ampersand,
    Bar,
    Percent,
    Brace,
}

/// Pieces of a G-code block outside brackets.
#[derive(Logos, Clone, Copy, Debug, PartialEq, Eq)]
#[logos(skip r"[ \t\x0B\x0C\u{A0}]+")]
pub(super) enum Gcode {
    #[regex(r"[A-Za-z][+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)")]
    Word,
    #[regex(r"[A-Za-z]\[")]
    Bracket,
    #[regex(r"[A-Za-z]\(")]
    Parenthesis,
    #[regex(r"\([^)\r\n]*\)")]
    #[regex(r";[^\r\n]*", allow_greedy = true)]
    #[regex(r"%[^\r\n]*", allow_greedy = true)]
    Remark,
    #[regex(r"\([^)\r\n]*")]
    UnclosedRemark,
    #[regex(r"'[^\r\n]*", allow_greedy = true)]
    Comment,
    #[regex(r"[A-Za-z][A-Za-z_]*")]
    Letters,
    #[token(":")]
    Colon,
    #[regex(r"\r\n|\n|\r")]
    LineEnd,
    #[regex(r"_[ \t]*('[^\r\n]*)?(\r\n|\n|\r)")]
    Continuation,
}
