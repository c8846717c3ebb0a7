//! Pieces: single statements, and the opening, middle and closing lines of blocks. The block
//! builder puts them together.

use crate::front::ast::{CaseTest, Enclosing, Expr, KindRef, Name, Param, StmtKind, Test, Text};
use crate::front::span::Span;
use crate::front::words::Kw;

/// A piece at its place.
#[derive(Clone, Debug)]
pub struct Placed {
    /// What it is.
    pub piece: Piece,
    /// Its words.
    pub span: Span,
    /// Line of its first word.
    pub line: u32,
}

/// What one statement of a line is to the block structure.
#[derive(Clone, Debug)]
pub enum Piece {
    /// A statement that is complete.
    Stmt(StmtKind),
    /// A statement that is several: DIM with its values, WAIT UNTIL.
    Several(Vec<StmtKind>),
    /// PROFILE
    Profile(Text),
    /// The opening line of a block.
    Open(Opener),
    /// `ELSEIF c THEN`
    ElseIf(Expr),
    /// `ELSE`
    Else,
    /// `CASE ...`
    Case(Vec<CaseTest>),
    /// `CASE ELSE`
    CaseElse,
    /// The closing line of a block.
    Close(Closer),
}

/// The opening line of a block.
#[derive(Clone, Debug)]
pub enum Opener {
    /// `IF c THEN`
    If(Expr),
    /// `SELECT CASE e`
    Select(Expr),
    /// `FOR v = a TO b STEP s`
    For(Box<ForHead>),
    /// `WHILE c`
    While(Expr),
    /// `DO`, with its test
    Do(Option<Test>),
    /// `REPEAT n`
    Repeat(Expr),
    /// `SUB name(...)`, `FUNCTION name(...) AS kind`
    Routine {
        /// Its name.
        name: Name,
        /// FUNCTION.
        is_function: bool,
        /// Parameters.
        params: Vec<Param>,
        /// Kind of the result.
        result: Option<KindRef>,
    },
    /// The opening line of this word could not be read; it still opens its block.
    Broken(Kw),
}

/// The opening line of a FOR.
#[derive(Clone, Debug)]
pub struct ForHead {
    /// The variable.
    pub var: Name,
    /// First value.
    pub from: Expr,
    /// Limit.
    pub to: Expr,
    /// STEP.
    pub step: Option<Expr>,
}

/// The closing line of a block.
#[derive(Clone, Debug)]
pub enum Closer {
    /// `END IF`
    If,
    /// `END SELECT`
    Select,
    /// `NEXT`
    For(Option<Name>),
    /// `WEND`
    While,
    /// `LOOP`, with its test
    Do(Option<Test>),
    /// `END REPEAT`
    Repeat,
    /// `END SUB`
    Sub,
    /// `END FUNCTION`
    Function,
}

impl Opener {
    /// The word that opens the block.
    pub fn word(&self) -> Kw {
        match self {
            Self::If(_) => Kw::If,
            Self::Select(_) => Kw::Select,
            Self::For(_) => Kw::For,
            Self::While(_) => Kw::While,
            Self::Do(_) => Kw::Do,
            Self::Repeat(_) => Kw::Repeat,
            Self::Routine { is_function: true, .. } => Kw::Function,
            Self::Routine { .. } => Kw::Sub,
            Self::Broken(kw) => *kw,
        }
    }
}

impl Closer {
    /// The word that opens the block that it closes.
    pub fn opener(&self) -> Kw {
        match self {
            Self::If => Kw::If,
            Self::Select => Kw::Select,
            Self::For(_) => Kw::For,
            Self::While => Kw::While,
            Self::Do(_) => Kw::Do,
            Self::Repeat => Kw::Repeat,
            Self::Sub => Kw::Sub,
            Self::Function => Kw::Function,
        }
    }
}

/// How the block that `opener` opens is closed.
pub fn closing_words(opener: Kw) -> &'static str {
    match opener {
        Kw::If => "END IF",
        Kw::Select => "END SELECT",
        Kw::For => "NEXT",
        Kw::While => "WEND",
        Kw::Do => "LOOP",
        Kw::Repeat => "END REPEAT",
        Kw::Function => "END FUNCTION",
        _ => "END SUB",
    }
}

/// What EXIT or CONTINUE names with this word.
pub fn enclosing(kw: Kw) -> Option<Enclosing> {
    Some(match kw {
        Kw::For => Enclosing::For,
        Kw::While => Enclosing::While,
        Kw::Do => Enclosing::Do,
        Kw::Repeat => Enclosing::Repeat,
        Kw::Sub => Enclosing::Sub,
        Kw::Function => Enclosing::Function,
        _ => return None,
    })
}
