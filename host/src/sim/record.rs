//! What a run leaves for plots and for the summary: the path, the edges of inputs and outputs.

use lang::axis::Axis;
use serde::Serialize;

use super::trace::{MoveKind, Status};

/// Segments and edges kept of one run; a longer run goes on, its record does not.
pub const RECORD_LIMIT: usize = 1_000_000;

/// What a segment of the path was for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SegmentKind {
    /// A statement that moves.
    Move(MoveKind),
    /// MoveSpeed, until it rests.
    Speed,
    /// A reference run.
    Home,
    /// A probe move.
    Probe,
}

/// An arc's geometry, machine coordinates, um.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcShape {
    /// Centre; the helix axis has the start's value.
    pub center: [f64; 3],
    /// The plane's first and second axis.
    pub plane: [Axis; 2],
    /// Start angle from the first axis toward the second, radians.
    pub start: f64,
    /// Swept angle, radians; negative is clockwise.
    pub sweep: f64,
}

/// One piece of the path. Positions are machine steps; axes that stand have equal ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// What it was for.
    pub kind: SegmentKind,
    /// Line of the statement.
    pub line: u32,
    /// Where it begins, steps.
    pub from: [i32; 3],
    /// Where it ends, steps.
    pub to: [i32; 3],
    /// The axes that it moves, by index.
    pub axes: [bool; 3],
    /// Geometry of an arc.
    pub arc: Option<ArcShape>,
    /// When it begins, us.
    pub start_us: u64,
    /// When it ends, us.
    pub end_us: u64,
    /// Highest speed reached, steps/s of the fastest axis.
    pub peak_rate: f64,
    /// Speed along the path at its end, um/s, where the planner tells: 0 when it comes to rest.
    pub exit_speed: Option<f64>,
    /// A laser's power, 0 to [`lang::profile::Profile::full_power`]; `None` without a laser, or where the
    /// engine does not know it.
    pub power: Option<i32>,
}

/// A change of an input or an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// When, us.
    pub us: u64,
    /// Number, from 1.
    pub n: i32,
    /// New state.
    pub on: bool,
}

/// A statement begins to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Begun {
    /// When, us.
    pub us: u64,
    /// Its line.
    pub line: u32,
}

/// A line of PRINT.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Printed {
    /// When, us.
    pub us: u64,
    /// Line of the statement.
    pub line: u32,
    /// The text.
    pub text: String,
}

/// A change of a variable, as the device's VM shows it at its effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// When, us.
    pub us: u64,
    /// Its cell.
    pub cell: u8,
    /// New value.
    pub value: i32,
}

/// What an output did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct OutputUse {
    /// Number, from 1.
    pub n: i32,
    /// Times that it went on.
    pub switched_on: u32,
    /// Time that it was on, us.
    pub on_us: u64,
}

/// Why a run was stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// It waits or pauses, and nothing can happen any more.
    Idle,
    /// The simulated time is up.
    Limit,
    /// It has executed as many statements as it may.
    Statements,
    /// Somebody held Stop.
    Button,
    /// Something collided, in a cell with `stop_on`.
    Collision,
    /// The user ended it: Ctrl-C, or nobody reads the output any more.
    Interrupted,
}

impl StopReason {
    /// For people.
    pub fn text(self) -> &'static str {
        match self {
            Self::Idle => {
                "it waits for what never comes (a world, `--world`, presses and switches)"
            }
            Self::Limit => "the simulated time is up (`--limit`)",
            Self::Statements => "no run executes more statements: a loop without an end",
            Self::Button => "Stop was held",
            Self::Collision => "something collided (`stop_on` of the cell)",
            Self::Interrupted => "it was interrupted",
        }
    }
}

/// The run in a few numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// How it ended.
    pub status: Status,
    /// Fault code such as `F07`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
    /// Why it was stopped, where the engine knows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopped: Option<StopReason>,
    /// Line of the end.
    pub line: u32,
    /// The program that this line is of, where RUN has begun another one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub program: Option<String>,
    /// Simulated time from the first statement to the end, us, pauses included.
    pub us: u64,
    /// Statements executed.
    pub statements: u64,
    /// Steps that each axis made, both directions added.
    pub steps: [u64; 3],
    /// Travel of each axis, um.
    pub travel_um: [u64; 3],
    /// Outputs that ever went on, ascending.
    pub outputs: Vec<OutputUse>,
}

/// Path and edges of a run.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Pieces of the path, in order of their beginning.
    pub path: Vec<Segment>,
    /// Edges of inputs as the controller sees them (after polarity and filter).
    pub inputs: Vec<Edge>,
    /// Edges of outputs.
    pub outputs: Vec<Edge>,
    /// Statements with effects as they begin; a line that goes on stands once.
    pub begun: Vec<Begun>,
    /// What the script printed.
    pub printed: Vec<Printed>,
    /// Changes of variables (engine `vm`); all are 0 before.
    pub changes: Vec<Change>,
    /// Something was left out because [`RECORD_LIMIT`] was reached.
    pub truncated: bool,
}

/// A time in which another program ran than the one whose lines a record has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Away {
    /// From here on, us.
    pub from_us: u64,
    /// Up to here, us.
    pub to_us: u64,
    /// Line of the RUN that began it.
    pub line: u32,
}

impl Record {
    /// What other programs did is the doing of the RUN that began them.
    pub fn show(&mut self, aways: &[Away]) {
        for away in aways {
            let during = |us: u64| (away.from_us..away.to_us).contains(&us);
            let segments = self.path.iter_mut().map(|own| (own.start_us, &mut own.line));
            let begun = self.begun.iter_mut().map(|own| (own.us, &mut own.line));
            let printed = self.printed.iter_mut().map(|own| (own.us, &mut own.line));
            for (us, line) in segments.chain(begun).chain(printed) {
                if during(us) {
                    *line = away.line;
                }
            }
        }
        self.begun.dedup_by_key(|own| own.line);
    }
}
