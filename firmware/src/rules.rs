//! Rules of the machine that hold on every chip, each written once. rustc compiles them for the host and the larger
//! chip; `firmware/lower` makes micro-code of the same functions for the small one, and its page describes the subset of
//! Rust allowed here. What differs between chips is a *leaf*, a method of [`Machine`] that each chip implements. [`planner`],
//! [`segments`] and [`stops`] run on the small chip only.

pub mod axes;
pub mod commands;
pub mod coords;
pub mod effects;
pub mod handlers;
pub mod home;
pub mod lines;
pub mod moves;
pub mod pace;
pub mod planner;
pub mod probe;
pub mod segments;
pub mod session;
pub mod status;
pub mod stops;
pub mod ticks;

use lang::fault::Fault;
use lang::wire::Exception;

/// What a statement has come to: it is done, or not yet; or its fault.
pub type Progress = Result<bool, Fault>;
/// It is done.
pub const DONE: Progress = Ok(true);
/// It goes on when it is called again.
pub const NOT_YET: Progress = Ok(false);

/// What a request has come to.
pub type Answer = Result<(), Exception>;

/// An axis of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axis(u8);

impl Axis {
    /// All of them, the last one first.
    pub const DOWN: [Axis; 3] = [Axis(2), Axis(1), Axis(0)];
    /// All of them, the first one first.
    pub const UP: [Axis; 3] = [Axis(0), Axis(1), Axis(2)];
    /// Four numbers in a row, counted as axes are, the last one first.
    pub const FOUR: [Axis; 4] = [Axis(3), Axis(2), Axis(1), Axis(0)];

    /// The axis `n`, from 0.
    pub const fn new(n: u8) -> Axis {
        Axis(n)
    }

    /// Its number, from 0.
    pub const fn n(self) -> u8 {
        self.0
    }

    /// The same as an index.
    pub const fn i(self) -> usize {
        self.0 as usize
    }

    /// Its bit.
    pub const fn bit(self) -> u8 {
        1 << self.0
    }
}

/// What a rule looks at. `micro` says what the small chip does for it: a byte; a bit of one; a byte that is a value; code
/// behind which a flag tells.
pub trait Machine {
    /// A run was begun and has not ended.
    #[cfg_attr(any(), micro(any = "RUN, RUN_ACTIVE"))]
    fn is_active(&self) -> bool;
    /// Address of the effect's instruction, or of the next one.
    #[cfg_attr(any(), micro(place = "EFFECT_PC"))]
    fn effect_pc(&self) -> u16;
    /// Address of the instruction of the last fault.
    #[cfg_attr(any(), micro(place = "VM_FAULT_PC"))]
    fn fault_pc(&self) -> u16;
    /// Address of the program's code.
    #[cfg_attr(any(), micro(place = "VM_CODE"))]
    fn code(&self) -> u16;
    /// A host traces.
    #[cfg_attr(any(), micro(any = "TRACING, T_ON", bit = 1))]
    fn traces(&self) -> bool;
    /// The first input that keeps Start or a move from working, from 1, or 0.
    #[cfg_attr(any(), micro(code = "DO blocking"))]
    fn blocking(&self) -> u8;
    /// Level of input 17, 0 or 1.
    #[cfg_attr(any(), micro(code = "LIT 17; DO input"))]
    fn input_17(&self) -> u8;
    /// A fault is latched.
    #[cfg_attr(any(), micro(is = "RUN, RUN_FAULT"))]
    fn is_fault(&self) -> bool;
    /// A run rests in a pause.
    #[cfg_attr(any(), micro(is = "RUN, RUN_PAUSED"))]
    fn is_paused(&self) -> bool;
    /// An axis moves for as long as the host speaks.
    #[cfg_attr(any(), micro(any = "MOTION, M_JOG", bit = 32))]
    fn jogs(&self) -> bool;
    /// No run is active and nothing moves.
    #[cfg_attr(any(), micro(code = "DO idle", holds = "EQUAL"))]
    fn is_idle(&self) -> bool;
    /// An input with the role of a door is on.
    #[cfg_attr(
        any(),
        micro(
            code = "PROFILE B_DOOR; DO input",
            or = "PROFILE B_DOOR+1; DO input",
            holds = "NOT_EQUAL"
        )
    )]
    fn door(&self) -> bool;
    /// An emergency stop is on.
    #[cfg_attr(any(), micro(code = "DO emergency_now", holds = "NOT_EQUAL"))]
    fn emergency(&self) -> bool;
    /// Code of the effect under way, 0 for none.
    #[cfg_attr(any(), micro(place = "EFFECT"))]
    fn effect(&self) -> u8;
    /// The axis of that effect.
    #[cfg_attr(any(), micro(code = "DO axis_n"))]
    fn axis(&self) -> Axis;
    /// Bit per axis: homing by command failed.
    #[cfg_attr(any(), micro(place = "HOMING_ERROR"))]
    fn homing_failed(&self) -> u8;
    /// The axis's reference switch is closed.
    #[cfg_attr(any(), micro(code = "DO reference_at; DO input", holds = "NOT_EQUAL"))]
    fn reference_closed(&self, axis: Axis) -> bool;
    /// That switch is at the positive end.
    #[cfg_attr(
        any(),
        micro(code = "FR word A_FLAGS, SHORT; TESTI AXIS_HOME_POSITIVE", holds = "NOT_EQUAL")
    )]
    fn home_positive(&self, axis: Axis) -> bool;
}
