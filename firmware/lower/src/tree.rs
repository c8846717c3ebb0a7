//! Rules as a tree: names are resolved, types known, the result of each way is a statement.

use std::collections::BTreeSet;

use crate::leaf::{Holds, Type};

/// A number: what the assembler is told, and its value where it is written out.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Number {
    /// A number or a constant's name.
    pub text: String,
    /// Its value, unless it is a name.
    pub value: Option<u16>,
    /// It does not fit into a byte.
    pub wide: bool,
}

impl Number {
    /// One that is written out.
    #[must_use]
    pub fn of(value: u16) -> Number {
        Number { text: value.to_string(), value: Some(value), wide: value > 0xFF }
    }
}

/// A variable of a function.
pub type Var = usize;
/// Variables.
pub type Vars = BTreeSet<Var>;

/// A place of the machine.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// Its symbol, or the field of a record.
    pub symbol: String,
    /// Byte, word or long.
    pub size: Size,
    /// The axis that it is of.
    pub axis: Option<Var>,
    /// It is a field: whether 16 bits of it, and of which record, the axis's own for nothing.
    pub record: Option<(bool, Option<String>)>,
    /// What brings it into the accumulator in fewer bytes than a formula.
    pub load: Option<String>,
}

/// Of a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Size {
    /// 8 bits.
    Byte,
    /// 16 bits.
    Word,
    /// 32 bits.
    Long,
}

/// What is called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Call {
    /// The leaf's code, with its numbers; the second one of which a flag tells as well.
    pub code: Vec<String>,
    /// See `code`.
    pub or: Option<Vec<String>>,
    /// The function instead of code.
    pub rule: Option<String>,
    /// The axis and the value that it gets.
    pub axis: Option<Var>,
    /// See `axis`.
    pub value: Option<Box<Expr>>,
    /// Its result.
    pub gives: Type,
    /// The flag of the result.
    pub holds: Option<Holds>,
    /// It changes the machine.
    pub changes: bool,
    /// r12 is 0 behind it.
    pub zero: bool,
    /// It never fails.
    pub sure: bool,
    /// The record that it reads, and that there is behind it.
    pub record: Option<String>,
    /// See `record`.
    pub sets_record: Option<String>,
    /// The symbol of the parts that have it.
    pub when: Option<String>,
    /// Instructions that go on in the function's place.
    pub ends: Option<String>,
}

/// A value of two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pair {
    /// The sum, modulo.
    Add,
    /// The difference, modulo.
    Sub,
    /// Bits of both.
    And,
    /// Shifted right.
    Half,
    /// Of scaled numbers: the sum.
    Plus,
    /// The difference, at least 0.
    Minus,
    /// The product.
    Times,
    /// The quotient.
    Over,
    /// The smaller one.
    Least,
    /// The larger one, of scaled numbers or of integers that are not negative.
    Most,
}

/// A value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Expr {
    /// A number.
    Number(Number),
    /// A variable.
    Var(Var),
    /// A place of the machine.
    Place(Place),
    /// The bit of an axis.
    Bit(Var),
    /// Above every scaled number.
    Most,
    /// A call.
    Call(Call),
    /// A value of two.
    Pair(Pair, Box<Expr>, Box<Expr>),
    /// A routine of one value: `negate`.
    Of(&'static str, Box<Expr>),
    /// A scaled number times this power of two.
    Shifted(Box<Expr>, i8),
    /// A wider type of the same value.
    Wide(Box<Expr>),
    /// The low byte.
    Low(Box<Expr>),
    /// A byte in the high half of a word.
    High(Box<Expr>),
    /// 0 when there is nothing.
    OrZero(Box<Expr>),
    /// The function ends with a fault or exception when there is nothing, or the sum overflows.
    OrFault(Box<Expr>, String),
    /// One of two.
    If(Box<Cond>, Box<Expr>, Box<Expr>),
}

/// What is so or not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cond {
    /// Not.
    Not(Box<Cond>),
    /// Both.
    And(Box<Cond>, Box<Cond>),
    /// One of them.
    Or(Box<Cond>, Box<Cond>),
    /// A bit of a byte is set.
    Any(String, String, Option<u16>),
    /// A byte is a value.
    Is(String, String),
    /// The axis's bit is set in a byte.
    In(String, Var),
    /// A flag behind a call.
    Call(Call),
    /// This is the first call of the effect.
    First,
    /// It is never so.
    Never,
    /// It is never so but on parts with this symbol.
    When(String, Box<Cond>),
    /// Two values are the same.
    Same(Expr, Expr),
    /// A byte is below another; a long below 0; a scaled number below another one.
    Below(Expr, Expr),
    /// A bit of a value is set.
    Bits(Expr, Number),
    /// A value lies from the one to the other.
    Within(Expr, Number, Number),
}

/// How a function ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// Nothing is said.
    Nothing,
    /// `Ok(true)`, `Ok(())`.
    Done,
    /// `Ok(false)`.
    NotYet,
    /// `Err(Fault::..)` or `Err(Exception::..)`, by its symbol.
    Fault(String),
    /// With a value.
    Value(Expr),
    /// With whether something is so.
    Cond(Box<Cond>),
}

/// What becomes of a call's fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tried {
    /// Nothing.
    Never,
    /// It ends the function.
    Ends,
    /// It ends the function as an illegal value.
    Refuses,
}

/// The order of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// `Axis::DOWN`: the last one first.
    Down,
    /// `Axis::UP`: the first one first.
    Up,
    /// `Axis::FOUR`: four numbers in a row, counted as axes are, the last one first.
    Four,
}

/// A statement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stmt {
    /// A variable gets a value.
    Set(Var, Expr),
    /// A word is made, in memory; its first value.
    Word(Var, Expr),
    /// Bits of that word.
    Or(Var, Expr),
    /// A variable is an axis.
    Axis(Var, Expr),
    /// A place gets a value.
    Put(Place, Expr),
    /// The axis's bit of a byte is set or cleared.
    Bit(String, Var, bool),
    /// A call, and what becomes of its fault.
    Call(Call, Tried),
    /// `if`, with `else`.
    If(Cond, Vec<Stmt>, Vec<Stmt>),
    /// For each axis in an order.
    Axes(Order, Var, Vec<Stmt>),
    /// For ever.
    Loop(Vec<Stmt>),
    /// To the next turn.
    Continue,
    /// By a byte's value, and what else it is.
    Match(Expr, Vec<(Number, Vec<Stmt>)>, Vec<Stmt>),
    /// The end.
    Return(End),
}

/// A function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// Its name in Rust.
    pub name: String,
    /// Its label.
    pub label: String,
    /// Its parameters.
    pub takes: Vec<(Var, Type)>,
    /// Its result.
    pub gives: Type,
    /// The flag of its result.
    pub holds: Option<Holds>,
    /// What r9 is at its beginning.
    pub record: Option<String>,
    /// Instructions call it.
    pub entry: bool,
    /// The instruction that it begins with then.
    pub begins: Option<String>,
    /// It leaves r12 = 0.
    pub zero: bool,
    /// Places for longs and bytes that are put by.
    pub longs: Vec<String>,
    /// See `longs`.
    pub bytes: Vec<String>,
    /// The types of its variables.
    pub vars: Vec<Type>,
    /// Its code stands where it is called, in the same file.
    pub within: bool,
    /// Statements.
    pub body: Vec<Stmt>,
    /// Its line.
    pub line: usize,
}

impl Expr {
    /// Its variables.
    pub fn vars(&self, to: &mut Vars) {
        match self {
            Expr::Number(_) | Expr::Most => {}
            Expr::Var(var) | Expr::Bit(var) => {
                to.insert(*var);
            }
            Expr::Place(place) => to.extend(place.axis),
            Expr::Call(call) => call.vars(to),
            Expr::Pair(_, a, b) => {
                a.vars(to);
                b.vars(to);
            }
            Expr::Of(_, a)
            | Expr::Shifted(a, _)
            | Expr::Wide(a)
            | Expr::Low(a)
            | Expr::High(a)
            | Expr::OrZero(a)
            | Expr::OrFault(a, _) => a.vars(to),
            Expr::If(cond, a, b) => {
                cond.vars(to);
                a.vars(to);
                b.vars(to);
            }
        }
    }
}

impl Call {
    /// Its variables.
    pub fn vars(&self, to: &mut Vars) {
        to.extend(self.axis);
        if let Some(value) = &self.value {
            value.vars(to);
        }
    }
}

impl Cond {
    /// Whether it begins with what only parts have.
    #[must_use]
    pub fn is_of_parts(&self) -> bool {
        match self {
            Cond::When(..) => true,
            Cond::And(a, _) => a.is_of_parts(),
            _ => false,
        }
    }

    /// Its variables.
    pub fn vars(&self, to: &mut Vars) {
        match self {
            Cond::Not(a) | Cond::When(_, a) => a.vars(to),
            Cond::And(a, b) | Cond::Or(a, b) => {
                a.vars(to);
                b.vars(to);
            }
            Cond::Any(..) | Cond::Is(..) | Cond::First | Cond::Never => {}
            Cond::In(_, var) => {
                to.insert(*var);
            }
            Cond::Call(call) => call.vars(to),
            Cond::Same(a, b) | Cond::Below(a, b) => {
                a.vars(to);
                b.vars(to);
            }
            Cond::Bits(a, _) | Cond::Within(a, ..) => a.vars(to),
        }
    }
}

/// The variables that statements need, when behind them those of `out` are, and in the next turn of the loop around them
/// those of `turn`.
#[must_use]
pub fn live(stmts: &[Stmt], out: &Vars, turn: &Vars) -> Vars {
    stmts.iter().rev().fold(out.clone(), |out, stmt| stmt.live(out, turn))
}

/// The variables that a loop with this body needs at each of its turns, when behind it those of `out` are.
#[must_use]
pub fn live_in_loop(body: &[Stmt], out: &Vars) -> Vars {
    let with = |turn: &Vars| live(body, turn, turn).union(turn).copied().collect::<Vars>();
    with(&with(out))
}

impl Stmt {
    fn live(&self, mut out: Vars, turn: &Vars) -> Vars {
        match self {
            Stmt::Set(var, value) | Stmt::Word(var, value) | Stmt::Axis(var, value) => {
                out.remove(var);
                value.vars(&mut out);
            }
            Stmt::Or(var, value) => {
                out.insert(*var);
                value.vars(&mut out);
            }
            Stmt::Put(place, value) => {
                out.extend(place.axis);
                value.vars(&mut out);
            }
            Stmt::Bit(_, var, _) => {
                out.insert(*var);
            }
            Stmt::Call(call, _) => call.vars(&mut out),
            Stmt::If(cond, then, other) => {
                let mut both = live(then, &out, turn);
                both.extend(live(other, &out, turn));
                out = both;
                cond.vars(&mut out);
            }
            Stmt::Axes(_, _, body) | Stmt::Loop(body) => out = live_in_loop(body, &out),
            Stmt::Continue => out.clone_from(turn),
            Stmt::Match(value, arms, other) => {
                let mut all = live(other, &out, turn);
                for (_, arm) in arms {
                    all.extend(live(arm, &out, turn));
                }
                out = all;
                value.vars(&mut out);
            }
            Stmt::Return(end) => {
                out.clear();
                match end {
                    End::Value(value) => value.vars(&mut out),
                    End::Cond(cond) => cond.vars(&mut out),
                    _ => {}
                }
            }
        }
        out
    }
}
