//! The machine's statements in the syntax tree.

use super::{AxisRef, Expr, PrintPart};
use crate::effect::{ActKind, Plane, Want};
use crate::plain::Plain;

/// The machine's statements; optional arguments that were left out are None.
#[derive(Clone, Debug, PartialEq)]
pub enum Machine {
    /// Arguments, then an opcode.
    Plain(Plain, Vec<Expr>),
    /// SYNC
    Sync {
        /// SetOut, Pulse or SetAout.
        kind: ActKind,
        /// Its arguments.
        list: Vec<Expr>,
        /// How far before the place.
        lead: Option<Expr>,
    },
    /// SetAout: number and value.
    SetAout(Vec<Expr>),
    /// MoveAxe, MoveRel
    Move {
        /// START stands before it.
        start: bool,
        /// MoveRel.
        relative: bool,
        /// Which axis.
        axis: AxisRef,
        /// Target or distance.
        target: Expr,
        /// Top speed.
        speed: Option<Expr>,
        /// Acceleration.
        accel: Option<Expr>,
        /// Deceleration.
        decel: Option<Expr>,
    },
    /// WaitMove
    WaitMove(Option<AxisRef>),
    /// MoveSpeed
    MoveSpeed(AxisRef, Expr),
    /// StopAxe
    StopAxe(AxisRef),
    /// Home, Home?
    Home {
        /// Written with `?`.
        quiet: bool,
        /// In order; empty is the profile's order.
        axes: Vec<AxisRef>,
    },
    /// Probe, Probe?
    Probe {
        /// Written with `?`.
        quiet: bool,
        /// Which axis.
        axis: AxisRef,
        /// Absolute limit.
        limit: Expr,
        /// Speed.
        speed: Expr,
        /// Input.
        input: Option<Expr>,
        /// State.
        state: Option<Expr>,
    },
    /// ProbeMask, ProbeMask?
    ProbeMask {
        /// Written with `?`.
        quiet: bool,
        /// Which axis.
        axis: AxisRef,
        /// Absolute limit.
        limit: Expr,
        /// Speed.
        speed: Expr,
        /// AND mask.
        and: Expr,
        /// XOR mask.
        xor: Expr,
    },
    /// SetPos
    SetPos(AxisRef, Expr),
    /// Motors
    Motors(Expr, Option<AxisRef>),
    /// WaitIn, WaitIn?
    WaitIn {
        /// Written with `?`.
        quiet: bool,
        /// Input.
        input: Expr,
        /// What it waits for.
        state: InputState,
        /// Timeout.
        timeout: Option<Expr>,
    },
    /// WaitChar, WaitChar?
    WaitChar {
        /// Written with `?`.
        quiet: bool,
        /// Character.
        code: Expr,
        /// Timeout.
        timeout: Option<Expr>,
    },
    /// PRINT
    Print(Vec<PrintPart>),
    /// PLANE
    Plane(Plane),
}

/// What WaitIn waits for.
#[derive(Clone, Debug, PartialEq)]
pub enum InputState {
    /// RISE or FALL.
    Edge(Want),
    /// ON, OFF or an expression of them.
    Level(Expr),
}
