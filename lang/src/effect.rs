//! What a script can do to a machine: the vocabulary between an engine that runs the language
//! and the machine that it drives.
//!
//! Engines evaluate expressions and follow control flow; at a machine statement they hand over one
//! [`Effect`], wait until the machine says that it is done, and go on with its result. The Rhai
//! engine, the VM on the host and the decoder of the board's trace all speak these values, so a
//! difference between engines is a difference between two lists of effects.

use crate::axis::Axis;
use crate::isa::flags;
use crate::plain::{self, Plain};

/// A length in um or a count of motor steps, as the script wrote it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dist {
    /// Micrometres.
    Um(i32),
    /// Motor steps.
    Steps(i32),
}

/// A speed in um/s or steps/s, or an acceleration in um/s2 or steps/s2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rate {
    /// um/s (um/s2).
    Um(i32),
    /// steps/s (steps/s2).
    Steps(i32),
}

/// Where a coordinate counts from; the numbers are those of operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Frame {
    /// Work coordinates: machine position less the axis's work offset. A Steps value in this frame
    /// is a machine position (lang/README.md, The machine).
    Work = 0,
    /// Machine coordinates (G53, G28's second leg).
    Machine = 1,
    /// Relative to the commanded position.
    Relative = 2,
}

/// One axis word of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coord {
    /// The value.
    pub value: Dist,
    /// What it counts from.
    pub frame: Frame,
}

/// Interpolation plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Plane {
    /// G17; the helix axis is Z.
    #[default]
    Xy = 0,
    /// G18; the helix axis is Y. First axis Z, second X, as RS274/NGC 3.5.3 has it.
    Zx = 1,
    /// G19; the helix axis is X.
    Yz = 2,
}

impl Plane {
    /// First and second axis: a counter-clockwise arc turns from the one to the other.
    pub const fn axes(self) -> [Axis; 2] {
        match self {
            Plane::Xy => [Axis::X, Axis::Y],
            Plane::Zx => [Axis::Z, Axis::X],
            Plane::Yz => [Axis::Y, Axis::Z],
        }
    }
}

/// How an arc's centre is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Center {
    /// I J K: offsets from the start point per axis; those outside the plane are 0.
    Offsets([Dist; 3]),
    /// R: positive takes the arc up to 180 degrees, negative the longer one.
    Radius(Dist),
}

/// State for which WaitIn, Probe and ON IN watch an input: bit 0 is the level, bit 1 tells an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Want {
    /// Level off.
    Off = 0,
    /// Level on.
    On = 1,
    /// Edge from on to off.
    Fall = 2,
    /// Edge from off to on.
    Rise = 3,
}

/// What ends a probe move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensor {
    /// The profile's probe input goes on.
    Default,
    /// Input `n` (from 1) takes state `on`.
    Input {
        /// Input number, from 1.
        n: i32,
        /// Wanted state.
        on: bool,
    },
    /// `((INPORT() AND and) XOR xor) <> 0`.
    Mask {
        /// Bits that count.
        and: i32,
        /// Bits to invert.
        xor: i32,
    },
}

/// How far before a place of the path something acts; behind it where it is negative.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lead {
    /// um along the path.
    Way(i32),
    /// ms.
    Time(i32),
}

/// What an output does on the way, without its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActKind {
    /// SetOut
    Set,
    /// Pulse
    Pulse,
    /// SetAout
    Analog,
}

impl ActKind {
    /// With a value: a level, ms, or that of an analog output.
    pub const fn with(self, value: i32) -> Act {
        match self {
            ActKind::Set => Act::Set(value),
            ActKind::Pulse => Act::Pulse(value),
            ActKind::Analog => Act::Analog(value),
        }
    }

    /// As the flags of `sync` have it.
    pub const fn flag(self) -> u8 {
        match self {
            ActKind::Set => 0,
            ActKind::Pulse => flags::SYNC_PULSE,
            ActKind::Analog => flags::SYNC_ANALOG,
        }
    }

    /// What flags of `sync` say. An analog output has no pulses, as on the board.
    pub const fn of(bits: u8) -> ActKind {
        if bits & flags::SYNC_ANALOG != 0 {
            ActKind::Analog
        } else if bits & flags::SYNC_PULSE != 0 {
            ActKind::Pulse
        } else {
            ActKind::Set
        }
    }
}

/// What an output does on the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// It is switched: 0 for off.
    Set(i32),
    /// It is switched on for some ms.
    Pulse(i32),
    /// An analog output gets a value: mV, or steps of a share.
    Analog(i32),
}

impl Act {
    /// What it is, and its value.
    pub const fn parts(self) -> (ActKind, i32) {
        match self {
            Act::Set(value) => (ActKind::Set, value),
            Act::Pulse(value) => (ActKind::Pulse, value),
            Act::Analog(value) => (ActKind::Analog, value),
        }
    }
}

/// An output that acts at a place of the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Action {
    /// Output number, from 1.
    pub n: i32,
    /// What it does.
    pub act: Act,
    /// How far before the place.
    pub lead: Lead,
}

/// One statement's action on the machine, with its arguments evaluated.
///
/// Numbers are the script's own and unchecked: the machine answers a value outside its range with
/// a [`Fault`](crate::fault::Fault).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Arguments, then an opcode, with the values of its arguments and zeros behind them: numbers of outputs
    /// from 1, states with 0 for off, milliseconds, characters.
    Plain(Plain, [i32; plain::MOST]),
    /// `SYNC`: an output acts where the path's next block begins.
    Sync(Action),
    /// `SetAout`
    SetAout {
        /// Number of the analog output, from 1.
        n: i32,
        /// mV, or steps of a share, as the profile says.
        value: i32,
    },
    /// `MoveAxe`, `MoveRel`, with `START` when `wait` is false. `None` is the profile's value.
    MoveAxe {
        /// The axis.
        axis: Axis,
        /// Target or distance.
        to: Coord,
        /// Top speed.
        speed: Option<Rate>,
        /// Ramp up.
        accel: Option<Rate>,
        /// Ramp down; `None`: as `accel`, or the profile's when that is `None` too.
        decel: Option<Rate>,
        /// Return when done, not at once.
        wait: bool,
    },
    /// `MoveSpeed`: run until stopped; the sign is the direction.
    MoveSpeed {
        /// The axis.
        axis: Axis,
        /// Signed speed.
        speed: Rate,
    },
    /// `StopAxe`: ramped stop, returns at rest.
    StopAxe(Axis),
    /// `WaitMove`; `None` is all axes.
    WaitMove(Option<Axis>),
    /// G0 and G1 and the moves of canned cycles. Words that are absent keep the commanded place.
    Linear {
        /// G0: each axis may use its top speed; otherwise the feed holds.
        rapid: bool,
        /// Axis words.
        to: [Option<Coord>; 3],
        /// G61: come to rest at the end.
        exact: bool,
    },
    /// G2 and G3.
    Arc {
        /// G2 (seen from the positive end of the helix axis).
        clockwise: bool,
        /// Plane.
        plane: Plane,
        /// Axis words.
        to: [Option<Coord>; 3],
        /// Centre.
        center: Center,
        /// G61.
        exact: bool,
    },
    /// `F`: the feed of following G1, G2, G3.
    SetFeed(Rate),
    /// `S`: kept; PWM where the profile has it.
    SetSpindle(i32),
    /// `Home axis`, one effect for each axis. `query` is `Home?`.
    Home {
        /// The axis.
        axis: Axis,
        /// Return plainly when the switch is not found.
        query: bool,
    },
    /// `Probe`, `ProbeMask`, G38.2 and G38.3.
    Probe {
        /// The axis.
        axis: Axis,
        /// How far to go.
        limit: Coord,
        /// Speed; `None`: the feed.
        speed: Option<Rate>,
        /// What ends it.
        sensor: Sensor,
        /// Return plainly on a miss.
        query: bool,
    },
    /// `SetPos` and G92: the present place becomes `value` (um, work coordinates).
    SetPos {
        /// The axis.
        axis: Axis,
        /// um.
        value: i32,
    },
    /// `Motors`; `None` is all axes.
    Motors {
        /// Drivers on or off.
        on: bool,
        /// One axis or all.
        axis: Option<Axis>,
    },
    /// `WaitIn`; `query` is `WaitIn?`.
    WaitIn {
        /// Input number, from 1.
        n: i32,
        /// State or edge.
        want: Want,
        /// Milliseconds.
        timeout: Option<i32>,
        /// Return plainly and set TIMEDOUT.
        query: bool,
    },
    /// `WaitChar`.
    WaitChar {
        /// Character, 33..=125.
        c: i32,
        /// Milliseconds.
        timeout: Option<i32>,
        /// Return plainly and set TIMEDOUT.
        query: bool,
    },
    /// A text of a PRINT; its parts come one by one, then [`Effect::PrintEnd`].
    PrintText(
        /// Index of the text in the image's or the program's list of texts.
        u16,
    ),
    /// A value of a PRINT, with the unit that it is written in.
    PrintValue(i32, Unit),
    /// The PRINT's line is complete.
    PrintEnd,
    /// `RUN`: the run ends, and the program of this name begins.
    Run(
        /// Index of the name in the list of texts, as [`Effect::PrintText`]'s.
        u16,
    ),
    /// `ON IN n RISE|FALL GOSUB`: slot 0..=3; edges are remembered once from now on.
    OnInput {
        /// Event slot in order of the ON lines.
        slot: u8,
        /// Input number, from 1.
        n: i32,
        /// Rise or Fall.
        want: Want,
    },
    /// `ON IN n OFF`: forget the slots that watch input `n`.
    OffInput(i32),
    /// `ON EVERY t GOSUB`.
    OnEvery {
        /// Event slot.
        slot: u8,
        /// Milliseconds.
        ms: i32,
    },
    /// `ON EVERY OFF`.
    OffEvery,
    /// A handler begins: the feed of what it interrupts is put aside, none holds.
    EnterHandler,
    /// A handler ended: the feed that was put aside holds again.
    LeaveHandler,
    /// A KEEP variable has a new value.
    Keep {
        /// Which KEEP, 0..=7, in order of declaration.
        index: u8,
        /// Its value.
        value: i32,
    },
    /// A value is asked of the machine; its answer is the effect's result.
    Read(Read),
}

impl Effect {
    /// Whether an event handler may run before the effect is done (lang/README.md, Errors and
    /// events: during waits, never inside a move).
    pub const fn waits(&self) -> bool {
        match self {
            Effect::Plain(plain, _) => plain.waits(),
            Effect::WaitIn { .. } | Effect::WaitChar { .. } | Effect::WaitMove(_) => true,
            _ => false,
        }
    }

    /// The axis words of a move or a probing, as they were written.
    pub fn targets(&self) -> [Option<(Axis, Coord)>; 3] {
        match *self {
            Effect::MoveAxe { axis, to, .. } | Effect::Probe { axis, limit: to, .. } => {
                [Some((axis, to)), None, None]
            }
            Effect::Linear { to, .. } | Effect::Arc { to, .. } => {
                Axis::ALL.map(|axis| Some((axis, to[axis.index()]?)))
            }
            _ => [None; 3],
        }
    }
}

/// Unit suffix of a printed value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Unit {
    /// Plain decimal.
    None = 0,
    /// `um`
    Um = 1,
    /// `st`
    Steps = 2,
    /// `ms`
    Ms = 3,
    /// `um/s`
    UmPerS = 4,
    /// `st/s`
    StepsPerS = 5,
    /// `um/s2`
    UmPerS2 = 6,
    /// `st/s2`
    StepsPerS2 = 7,
    /// `mm`; from here on decimals ([`crate::show`]).
    Mm = 8,
    /// `in`
    Inch = 9,
    /// `s`
    Second = 10,
    /// `min`
    Minute = 11,
    /// `mm/s`
    MmPerS = 12,
    /// `mm/min`
    MmPerMin = 13,
    /// `in/min`
    InchPerMin = 14,
    /// `mm/s2`
    MmPerS2 = 15,
    /// `mdeg`, which is stored
    MilliDeg = 16,
    /// `deg`
    Deg = 17,
    /// `mV`, which is stored
    MilliVolt = 18,
    /// `V`
    Volt = 19,
}

/// Built-in functions that look at the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Read {
    /// `IN(n)`
    In(i32),
    /// `INPORT()`
    InPort,
    /// `OUT(n)`
    Out(i32),
    /// `POS(axis)`: work position, um.
    Pos(Axis),
    /// `POSST(axis)`: machine position, steps.
    PosSteps(Axis),
    /// `PROBED(axis)`: work position, um.
    Probed(Axis),
    /// `PROBEDST(axis)`: machine position, steps.
    ProbedSteps(Axis),
    /// `PROBEOK(axis)`
    ProbeOk(Axis),
    /// `MOVING(axis)`
    Moving(Axis),
    /// `HOMED(axis)`
    Homed(Axis),
    /// `TIMER()`: ms since the run began, pauses left out.
    Timer,
    /// `TIMEDOUT`
    TimedOut,
    /// `CHARIN()`: takes the last character received, 0 for none.
    CharIn,
    /// `AIN(n)`: mV at an analog input, 1 to 4.
    Analog(u8),
}
