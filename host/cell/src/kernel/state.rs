//! What the parts of a running cell remember: its tool, its belts, and the faults that strike later. The files that let
//! them act are built on the cell; this one is below it.

use std::collections::{BTreeMap, BTreeSet};

use super::shake::Shake;
use crate::pressure::Pressure;
use crate::scene::{Conveyor, Drive, Scene, V3};
use crate::vary::Deviation;

/// The tool's state.
#[derive(Debug)]
pub(super) struct ToolState {
    /// Whether its output is on.
    pub(super) on: bool,
    pub(super) pressure: Pressure,
    /// Whether the pressure switch is on.
    pub(super) switched: bool,
    pub(super) contact: Option<usize>,
    pub(super) held: Option<usize>,
    /// When the pressure next crosses a level that means something.
    pub(super) due: Option<u64>,
    /// The hole that the drill is in, with its depth.
    pub(super) hole: Option<([f64; 2], f64)>,
    /// Where and when the plunge began that is being measured: height in mm, us.
    pub(super) plunge: Option<(f64, u64)>,
    /// It only touches the stock, which tells that: it does not turn.
    pub(super) probes: bool,
    /// When a drill turns.
    pub(super) turns_at: Option<u64>,
    /// Where and when a bead began, and its way so far.
    pub(super) bead: Option<(V3, u64, f64)>,
    pub(super) last: V3,
    /// Index of the way that it draws.
    pub(super) drawn: usize,
    /// What it knows of the head's acceleration.
    pub(super) shake: Shake,
}

impl ToolState {
    pub(super) fn new() -> Self {
        Self {
            on: false,
            pressure: Pressure::none(),
            switched: false,
            contact: None,
            held: None,
            due: None,
            hole: None,
            plunge: None,
            probes: false,
            turns_at: None,
            bead: None,
            last: [0.0; 3],
            drawn: 0,
            shake: Shake::default(),
        }
    }

    pub(super) fn is_on(&self) -> bool {
        self.on
    }

    pub(super) fn held(&self) -> Option<usize> {
        self.held
    }

    /// The thing that the nozzle touches.
    pub(super) fn touches(&self) -> Option<usize> {
        self.contact
    }

    pub(super) fn due(&self) -> Option<u64> {
        self.due
    }

    pub(super) fn is_working(&self) -> bool {
        self.hole.is_some() || self.bead.is_some()
    }

    /// Whether a drill is in a hole.
    pub(super) fn drills(&self) -> bool {
        self.hole.is_some()
    }

    pub(super) fn vacuum(&self) -> &Pressure {
        &self.pressure
    }
}

/// A belt while the cell runs.
#[derive(Clone, Debug)]
pub(super) struct Belt {
    /// When it last began to run, or the things on it were last moved; `None` while it stands.
    pub(super) runs: Option<u64>,
    /// What is left of the distance to the next part that it feeds, mm.
    pub(super) to_next: f64,
    /// Parts that it has fed.
    pub(super) fed: u32,
}

impl Belt {
    pub(super) fn all(scene: &Scene) -> Vec<Self> {
        let new = |conveyor: &Conveyor| Self {
            runs: matches!(conveyor.drive, Drive::Always).then_some(0),
            to_next: 0.0,
            fed: 0,
        };
        scene.conveyors.iter().map(new).collect()
    }
}

/// What strikes later.
#[derive(Debug, Default)]
pub(super) struct Struck {
    /// Things that stick to the tool after it lets go, us.
    pub(super) stuck: BTreeMap<usize, u64>,
    /// Things under which another one hangs when they are taken, and what hangs under which.
    pub(super) double: BTreeSet<usize>,
    /// See `double`.
    pub(super) twins: BTreeMap<usize, usize>,
    /// Things that fall so long after they were taken, us.
    pub(super) lost: BTreeMap<usize, u64>,
    /// Tools that answer their outputs so much later, us.
    pub(super) slow_us: BTreeMap<usize, u64>,
    /// What strikes a part when its feeder or belt brings it.
    pub(super) coming: Vec<Deviation>,
    /// Inputs that hang in a state.
    pub(super) forced: BTreeMap<u32, bool>,
}
