//! The syntax tree: what the parser found, before names and kinds are settled.
//!
//! Every tree is bounded: expressions are at most [`MAX_EXPR_DEPTH`] nodes high and blocks at most
//! [`MAX_BLOCK_DEPTH`] deep, so a walk may recurse.

mod expr;
mod machine;

pub use expr::{BinaryOp, Expr, ExprKind, UnaryOp};
pub use machine::{InputState, Machine};

use super::literal::Decimal;
use super::span::Span;
use crate::axis::Axis;
use crate::effect::{Unit, Want};
use crate::kind::Kind;
use core::fmt;
use std::collections::BTreeSet;
use std::rc::Rc;

/// Height of the highest expression tree that the parser lets through.
pub const MAX_EXPR_DEPTH: usize = 100;
/// Depth to which blocks (and one-line IFs) may nest.
pub const MAX_BLOCK_DEPTH: usize = 64;

/// A script.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Script {
    /// The machine that the script names with PROFILE.
    pub profile: Option<Text>,
    /// The statements outside subs, in text order.
    pub body: Block,
    /// SUBs and FUNCTIONs, in text order.
    pub routines: Vec<Routine>,
    /// Line of the last token, from 1.
    pub last_line: u32,
    /// Keys of names in declarations that could not be read.
    pub lost: BTreeSet<String>,
}

/// Statements in text order.
pub type Block = Vec<Stmt>;

/// A name as written; names are equal when their keys are.
#[derive(Clone, PartialEq, Eq)]
pub struct Name {
    /// As it stands in the script.
    pub text: Rc<str>,
    /// Folded to lower case.
    pub key: Rc<str>,
    /// Where it stands.
    pub span: Span,
}

/// A quoted text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Text {
    /// Without the quotes.
    pub text: String,
    /// With the quotes.
    pub span: Span,
}

/// A kind behind AS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KindRef {
    /// The kind.
    pub kind: Kind,
    /// Where its word stands.
    pub span: Span,
}

/// An axis letter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AxisRef {
    /// Which.
    pub axis: Axis,
    /// Where it stands.
    pub span: Span,
}

/// A SUB or FUNCTION.
#[derive(Clone, Debug, PartialEq)]
pub struct Routine {
    /// Its name.
    pub name: Name,
    /// FUNCTION, not SUB.
    pub is_function: bool,
    /// In order.
    pub params: Vec<Param>,
    /// The AS behind a FUNCTION's parameters.
    pub result: Option<KindRef>,
    /// The statements between its lines.
    pub body: Block,
    /// The opening line's words.
    pub span: Span,
    /// Line of SUB or FUNCTION.
    pub line: u32,
    /// Line of END SUB or END FUNCTION.
    pub end_line: u32,
}

/// A parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Param {
    /// Its name.
    pub name: Name,
    /// Its AS.
    pub kind: Option<KindRef>,
}

/// A statement. A script may have a million of them: what is large in one is boxed.
#[derive(Clone, Debug, PartialEq)]
pub struct Stmt {
    /// What it is.
    pub kind: StmtKind,
    /// Its words; of a block, those of its opening line.
    pub span: Span,
    /// Line of its first word, from 1: what ERL and traces show.
    pub line: u32,
}

impl Stmt {
    /// The blocks inside it, in text order.
    pub fn blocks(&self) -> impl Iterator<Item = &Block> {
        let (arms, cases, last): (&[Arm], &[Case], Option<&Block>) = match &self.kind {
            StmtKind::If { arms, otherwise, .. } => (arms, &[], otherwise.as_ref()),
            StmtKind::Select { cases, otherwise, .. } => (&[], cases, otherwise.as_ref()),
            StmtKind::For { body, .. }
            | StmtKind::While { body, .. }
            | StmtKind::Do { body, .. }
            | StmtKind::Repeat { body, .. } => (&[], &[], Some(body)),
            _ => (&[], &[], None),
        };
        let arms = arms.iter().map(|arm| &arm.body);
        arms.chain(cases.iter().map(|case| &case.body)).chain(last)
    }
}

/// The statements.
#[derive(Clone, Debug, PartialEq)]
pub enum StmtKind {
    /// `name:`
    Label(Name),
    /// `CONST a = e, ...`
    Const(Vec<(Name, Expr)>),
    /// `INPUT part = 3` or `OUTPUT pump = 1`
    Port {
        /// OUTPUT, not INPUT.
        output: bool,
        /// Names and their numbers.
        ports: Vec<(Name, Expr)>,
    },
    /// `ANALOG vacuum = 1`: names and their numbers.
    Analog(Vec<(Name, Expr)>),
    /// `DIM a, b(8) AS LENGTH, c AT 3000 LABEL "Pieces" MIN 1 MAX 500`
    Dim(Vec<Variable>),
    /// `KEEP a AS TIME, b(4)`; what belongs to DIM alone is not refused here.
    Keep(Vec<Variable>),
    /// `TABLE t(2) = 1, 2; 3, 4`, `TABLE t(x, depth) = 1, 2; 3, 4`
    Table {
        /// Its name.
        name: Name,
        /// Columns.
        width: Option<Box<Expr>>,
        /// Their names, in lower case; empty where `width` or nothing says how many there are.
        columns: Vec<Rc<str>>,
        /// Values by `;`.
        rows: Vec<Vec<Expr>>,
    },
    /// `a = e`, `a(i) = e`, `a.3 = e`
    Assign {
        /// What is written.
        target: Name,
        /// What stands in the parentheses; empty without.
        index: Vec<Expr>,
        /// The bit that is written, 0 to 31; None is the whole of it.
        bit: Option<u8>,
        /// The value.
        value: Expr,
    },
    /// `name 1, 2`, `name(1, 2)`, `CALL name(1, 2)`
    Call {
        /// The SUB.
        name: Name,
        /// In order.
        args: Vec<Expr>,
    },
    /// IF in both forms.
    If {
        /// IF, then ELSEIFs.
        arms: Vec<Arm>,
        /// ELSE.
        otherwise: Option<Block>,
        /// The one-line form.
        one_line: bool,
    },
    /// SELECT CASE
    Select {
        /// What is compared.
        value: Expr,
        /// In order.
        cases: Vec<Case>,
        /// CASE ELSE.
        otherwise: Option<Block>,
    },
    /// FOR
    For {
        /// The variable.
        var: Name,
        /// First value.
        from: Box<Expr>,
        /// Limit.
        to: Box<Expr>,
        /// STEP.
        step: Option<Box<Expr>>,
        /// The body.
        body: Block,
        /// Line of NEXT.
        next_line: u32,
        /// The name behind NEXT.
        next: Option<Box<Name>>,
    },
    /// WHILE
    While {
        /// The condition.
        cond: Expr,
        /// The body.
        body: Block,
        /// Line of WEND.
        end_line: u32,
    },
    /// DO
    Do {
        /// The test behind DO.
        before: Option<Box<Test>>,
        /// The body.
        body: Block,
        /// The test behind LOOP.
        after: Option<Box<Test>>,
        /// Line of LOOP.
        loop_line: u32,
    },
    /// REPEAT
    Repeat {
        /// How often.
        count: Expr,
        /// The body.
        body: Block,
        /// Line of END REPEAT.
        end_line: u32,
    },
    /// EXIT
    Exit(Enclosing),
    /// CONTINUE; never SUB or FUNCTION.
    Continue(Enclosing),
    /// GOTO
    Goto(Name),
    /// GOSUB
    Gosub(Name),
    /// RETURN, in a FUNCTION with its value.
    Return(Option<Expr>),
    /// END
    End,
    /// `RUN "name"`
    Run(Text),
    /// `ON ERROR GOTO label`; None is `ON ERROR STOP`.
    OnError(Option<Name>),
    /// `RESUME NEXT`
    ResumeNext,
    /// `RESUME`
    Resume,
    /// `ON IN n RISE|FALL GOSUB sub`, `ON IN n OFF`
    OnIn {
        /// The input.
        input: Expr,
        /// Edge (never a level) and target; None is OFF.
        handler: Option<(Want, Name)>,
    },
    /// `ON EVERY t GOSUB sub`; None is `ON EVERY OFF`.
    OnEvery(Option<(Expr, Name)>),
    /// A statement of the machine.
    Machine(Box<Machine>),
    /// A G-code block.
    Gcode(Vec<GWord>),
}

/// A variable of DIM or KEEP.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Its name.
    pub name: Name,
    /// What stands in its parentheses.
    pub size: Option<Expr>,
    /// Its AS; of a TIMER too, which holds a Time.
    pub kind: Option<KindRef>,
    /// `AS TIMER`
    pub timer: bool,
    /// Its AT.
    pub at: Option<Expr>,
    /// Its LABEL.
    pub label: Option<Text>,
    /// Its MIN.
    pub least: Option<Expr>,
    /// Its MAX.
    pub greatest: Option<Expr>,
}

/// A branch of an IF.
#[derive(Clone, Debug, PartialEq)]
pub struct Arm {
    /// The condition.
    pub cond: Expr,
    /// What runs.
    pub body: Block,
    /// Line of IF or ELSEIF.
    pub line: u32,
}

/// A CASE.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Any of them.
    pub tests: Vec<CaseTest>,
    /// What runs.
    pub body: Block,
    /// Line of CASE.
    pub line: u32,
}

/// One test of a CASE.
#[derive(Clone, Debug, PartialEq)]
pub enum CaseTest {
    /// `CASE 1`
    Value(Expr),
    /// `CASE 5 TO 9`, both ends included
    Range(Expr, Expr),
    /// `CASE IS < 0`
    Is(BinaryOp, Expr),
}

/// A test of DO or LOOP.
#[derive(Clone, Debug, PartialEq)]
pub struct Test {
    /// UNTIL, not WHILE.
    pub until: bool,
    /// The condition.
    pub cond: Expr,
}

/// What EXIT and CONTINUE name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Enclosing {
    /// FOR
    For,
    /// WHILE
    While,
    /// DO
    Do,
    /// REPEAT
    Repeat,
    /// SUB
    Sub,
    /// FUNCTION
    Function,
}

/// A part of a PRINT.
#[derive(Clone, Debug, PartialEq)]
pub enum PrintPart {
    /// A quoted text.
    Text(Text),
    /// A value, with the unit behind its `IN`.
    Value(Expr, Option<ShownIn>),
}

/// `IN unit` of a PRINT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShownIn {
    /// The unit.
    pub unit: Unit,
    /// Its text.
    pub span: Span,
}

/// A word of a G-code block.
#[derive(Clone, Debug, PartialEq)]
pub struct GWord {
    /// An upper-case ASCII letter.
    pub letter: char,
    /// Its value.
    pub value: GValue,
    /// Letter and value.
    pub span: Span,
}

/// The value of a G-code word.
#[derive(Clone, Debug, PartialEq)]
pub enum GValue {
    /// `X-12.5`: exact, with its sign.
    Number(Decimal),
    /// `X[e]`
    Expr(Expr),
}

impl Name {
    /// Whether it is the compiler's own, which no script can write.
    pub fn is_hidden(&self) -> bool {
        self.key.contains(' ')
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}
