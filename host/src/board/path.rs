//! The path that the step pulses make, sampled while the board runs.

use super::hardware::Hardware;
use super::rig::Rig;
use crate::sim::record::{Begun, Edge, Printed, RECORD_LIMIT, Record, Segment, SegmentKind};
use crate::sim::trace::{MoveKind, Status, What};

/// Two samples are one segment while their speeds differ by less than this part.
const SAME_SPEED: f64 = 0.03;

/// Collects samples of the motors' positions into segments.
#[derive(Debug)]
pub struct PathRecorder {
    path: Vec<Segment>,
    /// Motors' positions at the last look, steps.
    last: [i64; 3],
    last_us: u64,
    first_pulses: [u64; 3],
    kind: SegmentKind,
    line: u32,
    /// Where the path stood when the machine first rested after the last event: what moves from
    /// there on belongs to a statement that reports at its end.
    rested: Option<usize>,
    truncated: bool,
    begun: Vec<Begun>,
    printed: Vec<Printed>,
    /// When the statement that reported last was over, as far as it tells, us.
    free_us: u64,
}

impl Default for PathRecorder {
    fn default() -> PathRecorder {
        PathRecorder {
            path: Vec::new(),
            last: [0; 3],
            last_us: 0,
            first_pulses: [0; 3],
            kind: SegmentKind::Move(MoveKind::Axe),
            line: 1,
            // A run that begins with a reference run tells it at its end.
            rested: Some(0),
            truncated: false,
            begun: Vec::new(),
            printed: Vec::new(),
            free_us: 0,
        }
    }
}

impl PathRecorder {
    /// The run begins with the machine where it is.
    pub fn start<B: Hardware>(&mut self, rig: &Rig<B>) {
        self.last = rig.motors();
        self.last_us = rig.us();
        self.first_pulses = rig.pulses();
    }

    /// An event came: what it says of the motion before or after it.
    pub fn event(&mut self, what: &What) {
        self.statement(what);
        match *what {
            What::Move { line, kind, .. } => self.begin(SegmentKind::Move(kind), line),
            What::Speed { line, .. } => self.begin(SegmentKind::Speed, line),
            What::Home { line, .. } => self.relabel(SegmentKind::Home, line),
            What::Probe { line, .. } => self.relabel(SegmentKind::Probe, line),
            _ => {}
        }
    }

    /// Most statements report as they begin; those that wait for something report when it has come,
    /// and have run since the one before was over.
    fn statement(&mut self, what: &What) {
        let now = self.last_us;
        let moved = self.path.last().map_or(0, |segment| segment.end_us);
        let waited = match what {
            What::Home { .. }
            | What::Probe { .. }
            | What::WaitIn { .. }
            | What::WaitChar { .. }
            | What::WaitStart { .. } => true,
            What::End { status, .. } => *status != Status::Done,
            _ => false,
        };
        let since = match what {
            What::Home { .. } | What::Probe { .. } => self.free_us,
            _ if waited => self.free_us.max(moved),
            _ => now,
        };
        let begun = Begun { us: since.min(now), line: what.line() };
        let room = self.begun.len() < RECORD_LIMIT;
        match self.begun.last_mut() {
            Some(last) if last.line == begun.line => {}
            Some(last) if last.us >= begun.us => last.line = begun.line,
            _ if room => self.begun.push(begun),
            _ => self.truncated = true,
        }
        self.free_us = match what {
            What::Wait { ms, .. } => now + u64::try_from(*ms).unwrap_or(0) * 1000,
            _ => now,
        };
        if let What::Print { line, text } = what
            && self.printed.len() < RECORD_LIMIT
        {
            self.printed.push(Printed { us: now, line: *line, text: text.clone() });
        }
    }

    fn begin(&mut self, kind: SegmentKind, line: u32) {
        self.kind = kind;
        self.line = line;
        self.rested = None;
    }

    /// The statement that reports now made the moves since the last rest.
    fn relabel(&mut self, kind: SegmentKind, line: u32) {
        let from = self.rested.unwrap_or(self.path.len()).min(self.path.len());
        for segment in &mut self.path[from..] {
            segment.kind = kind;
            segment.line = line;
        }
        self.rested = Some(self.path.len());
    }

    /// Takes the motors' positions.
    pub fn sample<B: Hardware>(&mut self, rig: &Rig<B>) {
        let (now, us) = (rig.motors(), rig.us());
        let before = std::mem::replace(&mut self.last, now);
        let before_us = std::mem::replace(&mut self.last_us, us);
        if us == before_us {
            return;
        }
        if now == before {
            self.rested = self.rested.or(Some(self.path.len()));
            return;
        }
        let most = (0..3).map(|i| now[i].abs_diff(before[i])).max().unwrap_or(0);
        // Both in machine positions as they count now: where homing sets them no step was made.
        let offset = rig.offset();
        let place = |motors: [i64; 3]| {
            [0, 1, 2].map(|i| i32::try_from(motors[i] + offset[i]).unwrap_or(i32::MAX))
        };
        let segment = Segment {
            kind: self.kind,
            line: self.line,
            from: place(before),
            to: place(now),
            axes: [0, 1, 2].map(|i| now[i] != before[i]),
            arc: None,
            start_us: before_us,
            end_us: us,
            peak_rate: most as f64 * 1e6 / (us - before_us).max(LOOK_US) as f64,
            exit_speed: None,
            power: None,
        };
        let full = self.path.len() >= RECORD_LIMIT;
        match self.path.last_mut() {
            Some(last) if continues(last, &segment) => {
                last.to = segment.to;
                last.end_us = segment.end_us;
            }
            _ if full => self.truncated = true,
            _ => self.path.push(segment),
        }
    }

    /// Step pulses of each axis in this run.
    pub fn pulses<B: Hardware>(&self, rig: &Rig<B>) -> [u64; 3] {
        let now = rig.pulses();
        [0, 1, 2].map(|i| now[i] - self.first_pulses[i])
    }

    /// The record of the run.
    pub fn record(self, inputs: Vec<Edge>, outputs: Vec<Edge>) -> Record {
        let PathRecorder { path, begun, printed, truncated, .. } = self;
        Record { path, inputs, outputs, begun, printed, truncated, ..Record::default() }
    }
}

/// Rates are told over looks of at least this, us: in a shorter one, as between two effects, one step
/// would be a leap.
const LOOK_US: u64 = 1_000;

/// Whether `next` goes on like `last`: same statement, same direction and speed.
fn continues(last: &Segment, next: &Segment) -> bool {
    if last.kind != next.kind || last.line != next.line || last.end_us != next.start_us {
        return false;
    }
    let speed = |segment: &Segment, i: usize| {
        let time = (segment.end_us - segment.start_us).max(1) as f64;
        f64::from(segment.to[i] - segment.from[i]) * 1e6 / time
    };
    let fastest = last.peak_rate.max(next.peak_rate);
    (0..3).all(|i| (speed(last, i) - speed(next, i)).abs() <= SAME_SPEED * fastest)
}
