//! The trace of a real board, played into a cell: what became of the things, and where cell and board disagree.
//!
//! A trace tells where each statement went, not how fast: moves are straight ways at a constant speed, one after the other.
//! So places, collisions, holes and what is held are those of the board, and times are not.

use cell::kernel::{Action, Cell, Frame};
use cell::law::{Law, Rest, Steps, Straight};
use lang::profile::Profile;

use super::{Report, Scene, picture};
use crate::sim::trace::{Event, MoveKind, PerAxis, Status, What};

/// What the cell made of a trace.
#[derive(Debug)]
pub struct Replayed {
    /// The report at the end of the trace.
    pub report: Report,
    /// Where cell and board disagree, a line each.
    pub differences: Vec<String>,
    /// What was not played as it was, a line each.
    pub remarks: Vec<String>,
}

/// Moves take this share of the axis's highest rate.
const PACE: f64 = 0.5;
/// How long the cell may take to give an input that the board had, us.
const PATIENCE_US: u64 = 60_000_000;
/// A wait that timed out is taken to have been so long, us: the trace does not say.
const TIMED_OUT_US: u64 = 1_000_000;
/// An input comes to a script after its filter, us.
const FILTER_US: u64 = 5_000;
/// Between two outputs that follow one another in the trace, a pulse, us.
const PULSE_US: u64 = 100_000;
/// Beyond the place at which a board's probe answered the cell's may still do so, mm.
const PROBE_MM: f64 = 0.2;
/// Calls of a cell within one microsecond: no cell settles so slowly.
const MOST_CALLS: usize = 1_000;

struct Player<'a> {
    profile: &'a Profile,
    cell: Cell,
    now: u64,
    at: Steps,
    laws: u64,
    /// Inputs that are on, input `n` in bit `n - 1`.
    inputs: u64,
    /// Machine position of step 0, steps.
    offset: [i64; 3],
    on: Vec<u32>,
    lines: Vec<(u64, u32)>,
    printed: Vec<String>,
    differences: Vec<String>,
    arcs: usize,
}

/// Plays a trace into a cell around a machine.
#[must_use]
pub fn replay(scene: &Scene, profile: &Profile, events: &[Event]) -> Replayed {
    let (frame, _) = scene.frame(profile, [None; 3]);
    let mut cell = Cell::new(scene.cell.clone(), frame);
    cell.strike(&scene.deviations);
    let Frame { scale, start } = frame;
    let offset = std::array::from_fn(|axis| (start[axis] * scale[axis]).round() as i64);
    let mut player = Player {
        profile,
        cell,
        now: 0,
        at: [0; 4],
        laws: 0,
        inputs: 0,
        offset,
        on: Vec::new(),
        lines: Vec::new(),
        printed: Vec::new(),
        differences: Vec::new(),
        arcs: 0,
    };
    player.wait(0);
    let mut how = "stopped".to_owned();
    let mut last_out = None;
    for (index, event) in events.iter().enumerate() {
        player.lines.push((player.now, event.what.line()));
        // Two outputs of one line are a pulse.
        let out = matches!(event.what, What::Out { .. }).then(|| event.what.line());
        if out.is_some() && out == last_out {
            player.wait(PULSE_US);
        }
        last_out = out;
        if let What::End { status, fault, .. } = &event.what {
            how = match (status, fault) {
                (Status::Fault, fault) => fault.clone().unwrap_or_else(|| "fault".to_owned()),
                (Status::Stopped, _) => "stopped".to_owned(),
                (Status::Done, _) => "done".to_owned(),
            };
        }
        player.event(index + 1, &event.what);
    }
    player.end(scene, how)
}

impl Player<'_> {
    fn event(&mut self, number: usize, what: &What) {
        match what {
            What::Home { axis, pos, .. } => self.single(axis.0.index(), *pos),
            What::Move { kind, to, .. } => {
                self.arcs += usize::from(*kind == MoveKind::Arc);
                self.go(to);
            }
            What::Probe { axis, ok, pos, line } => {
                let before = self.inputs;
                self.single(axis.0.index(), *pos);
                if *ok {
                    self.answers(axis.0.index(), before, *line, number);
                }
            }
            What::Out { n, v, .. } => self.output(*n, *v != 0),
            // Cells know no analog outputs; its time passes.
            What::Aout { .. } => self.wait(0),
            What::Wait { ms, .. } => self.wait(u64::try_from(*ms).unwrap_or(0) * 1_000),
            What::WaitIn { n, v, ok, line } => self.wait_in(*n, *v != 0, *ok, *line, number),
            What::WaitStart { .. } => {
                self.cell.waits_for_start(self.now);
                self.wait(0);
            }
            What::Print { text, .. } => {
                self.printed.push(text.clone());
                self.cell.prints(text, self.now);
                self.wait(0);
            }
            What::Speed { line, axis, .. } => {
                let letter = axis.0.letter();
                self.differ(number, *line, &format!("MoveSpeed {letter} tells no place: what follows is played from where it began"));
            }
            What::End { pos, .. } => self.go(pos),
            What::Send { .. } | What::WaitChar { .. } | What::Stop { .. } | What::Run { .. } => {}
        }
    }

    fn differ(&mut self, number: usize, line: u32, text: &str) {
        self.differences
            .push(format!("line {number} of the trace, line {line} of the script: {text}"));
    }

    fn is_on(&self, n: i32) -> bool {
        u32::try_from(n - 1).is_ok_and(|bit| bit < 64 && self.inputs >> bit & 1 != 0)
    }

    fn take(&mut self, actions: Vec<Action>) {
        for action in actions {
            if let Action::Input(n @ 1..=64, on) = action {
                let bit = 1 << (n - 1);
                self.inputs = if on { self.inputs | bit } else { self.inputs & !bit };
            }
        }
    }

    /// Lets time go on to `until` under a law, or to the first moment at which `done` holds.
    fn play(&mut self, law: &dyn Law, until: u64, done: &dyn Fn(&Self) -> bool) {
        let mut calls = 0;
        while let Some(when) = self.cell.next_us(law, self.now).filter(|&when| when <= until) {
            calls = if when == self.now { calls + 1 } else { 0 };
            self.now = when;
            let actions = self.cell.advance(law, when);
            self.take(actions);
            if done(self) || calls > MOST_CALLS {
                return;
            }
        }
        self.now = until;
        let actions = self.cell.advance(law, until);
        self.take(actions);
    }

    fn wait(&mut self, us: u64) {
        self.play(&Rest(self.at), self.now + us, &|_| false);
    }

    fn output(&mut self, n: i32, on: bool) {
        let Ok(n) = u32::try_from(n) else { return };
        self.on.retain(|own| *own != n);
        if on {
            self.on.push(n);
        }
        self.cell.output(n, on, &Rest(self.at), self.now);
        self.wait(0);
    }

    /// A machine position as steps from power-up.
    fn steps(&self, axis: usize, pos: i32) -> i32 {
        (i64::from(pos) - self.offset[axis]).clamp(i32::MIN.into(), i32::MAX.into()) as i32
    }

    fn single(&mut self, axis: usize, pos: i32) {
        let mut to = self.at;
        to[axis] = self.steps(axis, pos);
        self.straight(to);
    }

    fn go(&mut self, to: &PerAxis) {
        let mut steps = self.at;
        for (axis, pos) in to.values().into_iter().enumerate() {
            if let Some(pos) = pos {
                steps[axis] = self.steps(axis, pos);
            }
        }
        self.straight(steps);
    }

    fn straight(&mut self, to: Steps) {
        let takes = self.profile.axes().map(|(axis, own)| {
            let i = axis.index();
            let way = (f64::from(to[i]) - f64::from(self.at[i])).abs();
            (way / (f64::from(own.top_rate.max(1)) * PACE) * 1e6).ceil() as u64
        });
        let takes = takes.max().unwrap_or(0);
        if takes == 0 {
            return;
        }
        self.laws += 1;
        let law = Straight { id: self.laws, from: self.at, to, begins: self.now, takes };
        self.play(&law, self.now + takes, &|_| false);
        self.at = to;
    }

    /// The board's probe answered at the place where the axis stands: the cell's must do so there, or little further.
    fn answers(&mut self, axis: usize, before: u64, line: u32, number: usize) {
        if self.inputs & !before != 0 {
            return;
        }
        let own = self.profile.axes().find(|(own, _)| own.index() == axis);
        let per_mm =
            own.map_or(1.0, |(_, own)| f64::from(own.scale.steps) * 1e3 / f64::from(own.scale.um));
        let here = self.at;
        for sign in [-1, 1] {
            let mut further = here;
            further[axis] += sign * (PROBE_MM * per_mm).round() as i32;
            self.straight(further);
            let answered = self.inputs & !before != 0;
            self.straight(here);
            if answered {
                return;
            }
        }
        self.differ(
            number,
            line,
            &format!(
                "the board's probe answered here, and within {PROBE_MM} mm nothing in the cell does"
            ),
        );
    }

    fn wait_in(&mut self, n: i32, v: bool, ok: bool, line: u32, number: usize) {
        let until = self.now + if ok { PATIENCE_US } else { TIMED_OUT_US };
        if self.is_on(n) != v {
            self.play(&Rest(self.at), until, &|player| player.is_on(n) == v);
        }
        let came = self.is_on(n) == v;
        if ok {
            self.wait(FILTER_US);
        }
        let state = if v { "on" } else { "off" };
        match (ok, came) {
            (true, false) => self.differ(
                number,
                line,
                &format!("input {n} came {state} on the board, and not in the cell"),
            ),
            (false, true) => self.differ(
                number,
                line,
                &format!("input {n} did not come {state} on the board, and in the cell it did"),
            ),
            _ => {}
        }
    }

    fn end(mut self, scene: &Scene, how: String) -> Replayed {
        self.wait(0);
        self.on.sort_unstable();
        let end = cell::judge::End {
            us: self.now,
            how,
            printed: self.printed,
            on: self.on,
            seen: Vec::new(),
        };
        let lines = self.lines;
        let line_at = |us: u64| {
            let after = lines.partition_point(|(began, _)| *began <= us);
            after.checked_sub(1).and_then(|index| lines.get(index)).map_or(0, |(_, line)| *line)
        };
        let mut report = Report::of(scene, &mut self.cell, end, &line_at);
        report.shapes = picture::shapes(&self.cell, self.now);
        let mut remarks = vec!["times are not the board's: a trace tells places alone".to_owned()];
        if self.arcs > 0 {
            remarks.push(format!("{} arcs were played as straight ways to their ends", self.arcs));
        }
        Replayed { report, differences: self.differences, remarks }
    }
}
