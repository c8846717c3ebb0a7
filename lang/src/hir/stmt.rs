//! Statements of the checked program.

use super::{BinOp, Expr, LabelId, RoutineId, Span, VarId};
use crate::axis::Axis;
use crate::effect::{ActKind, Frame, Plane, Unit, Want};
use crate::plain::Plain;

/// Statements in order.
pub type Block = Vec<Stmt>;

/// One statement. A G-code block may become several, all with the block's line. A program may have
/// a million of them: what is large in one is boxed.
#[derive(Clone, Debug)]
pub struct Stmt {
    /// Line of its first word, from 1: the `line` of traces, faults and ERL.
    pub line: u32,
    /// Its text.
    pub span: Span,
    /// What it does.
    pub kind: StmtKind,
}

/// What a variable or an array element is assigned through.
#[derive(Clone, Debug)]
pub enum Place {
    /// A scalar.
    Var(VarId),
    /// An element of an array; F03 outside.
    Elem(VarId, Box<Expr>),
}

/// Kinds of loops, for EXIT and CONTINUE.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoopKind {
    /// FOR
    For,
    /// WHILE
    While,
    /// DO
    Do,
    /// REPEAT
    Repeat,
}

/// Target of GOSUB, ON IN and ON EVERY.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GosubTarget {
    /// A label of the same routine (of the main program for events).
    Label(LabelId),
    /// A SUB without parameters.
    Sub(RoutineId),
}

/// One CASE test.
#[derive(Clone, Debug)]
pub enum CaseTest {
    /// `CASE 3`
    Equal(Expr),
    /// `CASE 5 TO 9`
    Range(Expr, Expr),
    /// `CASE IS < 0`; the operator is a comparison.
    Is(BinOp, Expr),
}

/// One arm of an IF.
#[derive(Clone, Debug)]
pub struct Arm {
    /// Line of the IF or ELSEIF.
    pub line: u32,
    /// A Truth or a Number.
    pub condition: Expr,
    /// What runs when it is not 0.
    pub body: Block,
}

/// One CASE of a SELECT.
#[derive(Clone, Debug)]
pub struct Case {
    /// Line of the CASE.
    pub line: u32,
    /// Tests in order.
    pub tests: Vec<CaseTest>,
    /// What runs when one holds.
    pub body: Block,
}

/// Pre- or post-condition of DO.
#[derive(Clone, Debug)]
pub struct DoTest {
    /// Line of the DO or LOOP that carries it.
    pub line: u32,
    /// UNTIL, not WHILE.
    pub until: bool,
    /// The condition.
    pub condition: Expr,
}

/// What a probe move watches.
#[derive(Clone, Debug)]
pub enum ProbeSensor {
    /// The profile's probe input, ON.
    Default,
    /// `input [, state]`; state is a Truth or a Number.
    Input(Expr, Expr),
    /// ProbeMask.
    Mask(Expr, Expr),
}

/// What WaitIn watches.
#[derive(Clone, Debug)]
pub enum InWant {
    /// A level given by a Truth or a Number.
    Level(Box<Expr>),
    /// `RISE` or `FALL`.
    Edge(Want),
}

/// An axis word; the kind of `value` (Length or Steps) says its unit.
#[derive(Clone, Debug)]
pub struct Word {
    /// Length in um or Steps.
    pub value: Expr,
    /// What it counts from.
    pub frame: Frame,
}

/// Centre words of an arc; kinds Length or Steps.
#[derive(Clone, Debug)]
pub enum ArcCenter {
    /// I, J, K as far as given.
    Offsets(Box<[Option<Expr>; 3]>),
    /// R.
    Radius(Box<Expr>),
}

/// A part of a PRINT.
#[derive(Clone, Debug)]
pub enum PrintPart {
    /// A text.
    Text(String),
    /// A value and the unit that it is written in.
    Value(Expr, Unit),
}

/// Which canned cycle.
#[derive(Clone, Debug)]
pub enum CycleKind {
    /// G81
    Drill,
    /// G82 with its dwell in ms.
    Dwell(Expr),
    /// G83 with its peck depth (Length or Steps, positive).
    Peck(Expr),
}

/// One block that runs a canned cycle. Words that stay from an earlier block were filled in by the
/// checker: a constant as such, anything else through a hidden variable. So are values that are
/// used more than once: R, dwell and peck depth are always simple ([`Expr::is_simple`]), Z in a
/// G83, X, Y and Z where the cycle is repeated. What is not simple is evaluated before the first
/// move: Z, `repeats`, X, Y.
#[derive(Clone, Debug)]
pub struct Cycle {
    /// Which.
    pub kind: CycleKind,
    /// X and Y words; each repeat moves by them again when they are relative.
    pub xy: [Option<Word>; 2],
    /// R plane; relative to the Z before the cycle when its frame is Relative.
    pub r: Word,
    /// Bottom; relative to R when its frame is Relative.
    pub z: Word,
    /// L: runs in all, a Number; `None` is 1.
    pub repeats: Option<Expr>,
    /// G98: retract to the Z before the first cycle if that lies above R. `None` is G99.
    /// The variable holds that Z (work position, um).
    pub old_z: Option<VarId>,
    /// Take the present Z into `old_z` first (no earlier cycle holds one).
    pub takes_z: bool,
    /// G61.
    pub exact: bool,
}

/// An output that acts where the path's next block begins.
#[derive(Clone, Debug)]
pub struct Sync {
    /// Its number, from 1.
    pub n: Expr,
    /// Its level, of a pulse the Time, of an analog output the value.
    pub value: Expr,
    /// Which of these it is.
    pub kind: ActKind,
    /// A Time or a Length before the place, behind it where it is negative.
    pub lead: Expr,
}

/// What a statement does.
#[derive(Clone, Debug)]
pub enum StmtKind {
    /// Arguments, then an opcode; the spindle's and coolant's M words, G4, M0 and M6 among them.
    Plain(Plain, Vec<Expr>),
    /// SYNC, and M62, M63 and M67.
    Sync(Box<Sync>),
    /// SetAout and M68: number and value.
    SetAout(Expr, Expr),
    /// `place = value`
    Assign(Place, Expr),
    /// IF, in both forms.
    If {
        /// IF and ELSEIF in order.
        arms: Vec<Arm>,
        /// ELSE.
        otherwise: Block,
        /// Written on one line: a fault in its condition goes on with the next line.
        one_line: bool,
    },
    /// SELECT CASE; `value` goes into `temp` once.
    Select {
        /// The value.
        value: Box<Expr>,
        /// Hidden variable that holds it.
        temp: VarId,
        /// Cases in order.
        cases: Vec<Case>,
        /// CASE ELSE.
        otherwise: Block,
    },
    /// FOR. `limit` and `step` that are not constants go into hidden variables once.
    For {
        /// The variable, a scalar.
        var: VarId,
        /// Start.
        from: Box<Expr>,
        /// Limit.
        to: Box<Expr>,
        /// Step.
        step: Box<Expr>,
        /// Hidden variable for a limit that is not constant.
        to_temp: Option<VarId>,
        /// Hidden variable for a step that is not constant.
        step_temp: Option<VarId>,
        /// Body.
        body: Block,
        /// Line of the NEXT: a fault there is its.
        next_line: u32,
    },
    /// WHILE
    While {
        /// The condition.
        condition: Expr,
        /// Body.
        body: Block,
    },
    /// DO ... LOOP
    Do {
        /// Test before each pass.
        before: Option<Box<DoTest>>,
        /// Body.
        body: Block,
        /// Test after each pass.
        after: Option<Box<DoTest>>,
    },
    /// REPEAT
    Repeat {
        /// Runs in all.
        count: Expr,
        /// Hidden variable that counts down.
        temp: VarId,
        /// Body.
        body: Block,
    },
    /// EXIT of the innermost enclosing loop of that kind.
    Exit(LoopKind),
    /// CONTINUE of the innermost enclosing loop of that kind.
    Continue(LoopKind),
    /// A label stands here.
    Label(LabelId),
    /// GOTO
    Goto(LabelId),
    /// GOSUB
    Gosub(GosubTarget),
    /// RETURN without a value: of an open GOSUB of this routine, else of the SUB.
    Return,
    /// `RETURN e` of a FUNCTION.
    ReturnValue(Expr),
    /// EXIT SUB, EXIT FUNCTION: leaves the routine; a FUNCTION's result is 0.
    ExitRoutine,
    /// Call of a SUB, or of a FUNCTION whose result is dropped.
    Call(RoutineId, Vec<Expr>),
    /// END, M2, M30.
    End,
    /// RUN, with the name of the program that begins.
    Run(String),
    /// ON ERROR GOTO, or STOP for `None`.
    OnError(Option<LabelId>),
    /// RESUME NEXT
    ResumeNext,
    /// RESUME
    Resume,
    /// ON IN n RISE|FALL GOSUB; `slot` in text order of the ON lines, 0..=3.
    OnInput {
        /// Event slot.
        slot: u8,
        /// Input number.
        n: Expr,
        /// Rise or Fall.
        want: Want,
        /// Handler.
        target: GosubTarget,
    },
    /// ON IN n OFF
    OffInput(Expr),
    /// ON EVERY t GOSUB
    OnEvery {
        /// Event slot.
        slot: u8,
        /// Time.
        every: Expr,
        /// Handler.
        target: GosubTarget,
    },
    /// ON EVERY OFF
    OffEvery,
    /// MoveAxe and MoveRel.
    MoveAxe {
        /// The axis.
        axis: Axis,
        /// Target or distance: Length or Steps.
        target: Expr,
        /// MoveRel.
        relative: bool,
        /// START.
        start: bool,
        /// Speed or StepRate.
        speed: Option<Box<Expr>>,
        /// Accel or StepAccel.
        accel: Option<Box<Expr>>,
        /// Accel or StepAccel.
        decel: Option<Box<Expr>>,
    },
    /// MoveSpeed
    MoveSpeed {
        /// The axis.
        axis: Axis,
        /// Speed or StepRate, signed.
        speed: Expr,
    },
    /// StopAxe
    StopAxe(Axis),
    /// WaitMove
    WaitMove(Option<Axis>),
    /// Home; a bare `Home` has the profile's order here.
    Home {
        /// In the order of execution.
        axes: Vec<Axis>,
        /// `Home?`
        query: bool,
    },
    /// Probe, ProbeMask, G38.2, G38.3.
    Probe {
        /// The axis.
        axis: Axis,
        /// Limit.
        limit: Box<Word>,
        /// Speed or StepRate; `None` is the feed.
        speed: Option<Box<Expr>>,
        /// What ends it.
        sensor: Box<ProbeSensor>,
        /// `Probe?`, G38.3.
        query: bool,
    },
    /// SetPos and one word of G92.
    SetPos {
        /// The axis.
        axis: Axis,
        /// Length.
        value: Expr,
    },
    /// Motors
    Motors {
        /// Truth or Number.
        on: Expr,
        /// One axis or all.
        axis: Option<Axis>,
    },
    /// WaitIn
    WaitIn {
        /// Input number.
        n: Expr,
        /// State or edge.
        want: InWant,
        /// Time.
        timeout: Option<Box<Expr>>,
        /// `WaitIn?`
        query: bool,
    },
    /// WaitChar
    WaitChar {
        /// Character.
        c: Expr,
        /// Time.
        timeout: Option<Box<Expr>>,
        /// `WaitChar?`
        query: bool,
    },
    /// PRINT
    Print(Vec<PrintPart>),
    /// F: Speed or StepRate.
    SetFeed(Expr),
    /// S
    SetSpindle(Expr),
    /// G0 and G1. A block that moves by G28 is two of these.
    Linear {
        /// G0
        rapid: bool,
        /// Axis words.
        to: Box<[Option<Word>; 3]>,
        /// G61
        exact: bool,
    },
    /// G2 and G3.
    Arc {
        /// G2
        clockwise: bool,
        /// Plane.
        plane: Plane,
        /// Axis words.
        to: Box<[Option<Word>; 3]>,
        /// Centre.
        center: ArcCenter,
        /// G61
        exact: bool,
    },
    /// G81, G82, G83.
    Cycle(Box<Cycle>),
}
