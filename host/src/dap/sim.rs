//! A script on the simulated machine, statement by statement.
//!
//! A run is deterministic. A step back runs it again from the start, without output, up to the statement before.

use std::cell::Cell;
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError};

use lang::back::{Compiled, MarkKind, Sidecar};
use lang::fault::Fault;
use lang::image::Image;

use super::breaks::Breaks;
use super::names::Names;
use super::program::Loaded;
use super::snapshot::{Order, Pace, Report, Snapshot, Stand, frames};
use crate::sim::trace::{Event, Status, What};
use crate::sim::vm_engine::{self, At, Watcher};
use crate::sim::world::World;
use crate::sim::{Options, Outcome, SimError};

/// Who hears what a run says.
pub type Ear = Arc<dyn Fn(Report) + Send + Sync>;

/// Lines of which something runs, by the address where it begins: the first statement of each line.
pub fn beginnings(sidecar: &Sidecar) -> HashMap<usize, Vec<u32>> {
    let mut first: HashMap<u32, usize> = HashMap::new();
    let counts = |kind| matches!(kind, MarkKind::Statement | MarkKind::LoopEnd);
    for mark in sidecar.marks.iter().filter(|mark| counts(mark.kind)) {
        let start = first.entry(mark.line).or_insert(mark.span.start);
        *start = mark.span.start.min(*start);
    }
    let mut lines: HashMap<usize, Vec<u32>> = HashMap::new();
    for mark in sidecar.marks.iter().filter(|mark| counts(mark.kind)) {
        if first.get(&mark.line) == Some(&mark.span.start) {
            lines.entry(mark.pc).or_default().push(mark.line);
        }
    }
    lines
}

/// Runs until the session ends it. `halts`: before the first statement.
pub fn run(
    loaded: &Loaded,
    world: &World,
    halts: bool,
    trace: bool,
    orders: Receiver<Order>,
    ear: &Ear,
) {
    let quiet = Rc::new(Cell::new(false));
    let mut eye = Eye {
        compiled: &loaded.compiled,
        cells: Image::new(&loaded.compiled.image).map_or(0, |image| image.header.cells),
        names: &loaded.names,
        beginnings: beginnings(&loaded.compiled.sidecar),
        orders,
        ear: ear.clone(),
        quiet: quiet.clone(),
        breaks: Breaks::default(),
        faults: false,
        ordinal: 0,
        pace: Pace::Go,
        from: (0, 0, 0),
        entry: halts,
        pausing: false,
        goal: None,
        scan: None,
        sets: Vec::new(),
        after: After::Over,
    };
    let options = Options { record: false, times: false, ..Options::default() };
    loop {
        (eye.ordinal, eye.after) = (0, After::Over);
        eye.breaks.forget_hits();
        quiet.set(eye.goal.is_some());
        let (silent, told) = (quiet.clone(), ear.clone());
        let sink = Box::new(move |event: &Event| {
            if !silent.get() {
                tell(event, trace, &told);
            }
        });
        let program = &loaded.program;
        let result =
            vm_engine::watched(program, &loaded.compiled, world, &options, sink, Some(&mut eye));
        match eye.after {
            After::Again => {}
            After::Restart => {
                eye.sets.clear();
                (eye.goal, eye.scan, eye.pace, eye.entry) = (None, None, Pace::Go, halts);
            }
            After::End => return,
            After::Over => {
                let (code, text) = ending(&result);
                ear(Report::Over(code, text));
                return;
            }
        }
    }
}

/// What a line of the trace says to the editor.
pub fn tell(event: &Event, trace: bool, ear: &Ear) {
    match &event.what {
        What::Print { text, .. } => ear(Report::Said("stdout", format!("{text}\n"))),
        What::End { .. } => {}
        _ if trace => {
            if let Ok(line) = serde_json::to_string(event) {
                ear(Report::Said("console", format!("{line}\n")));
            }
        }
        _ => {}
    }
}

fn ending(result: &Result<Outcome, SimError>) -> (u8, String) {
    match result {
        Ok(outcome) => {
            let line = outcome.end.line;
            match (outcome.end.status, outcome.end.fault) {
                (Status::Done, _) if outcome.failures.is_empty() => {
                    let onward = outcome.onward.as_ref().map_or_else(String::new, |name| {
                        format!(": RUN \"{name}\" is another program, which is debugged by itself")
                    });
                    (0, format!("done in line {line}{onward}\n"))
                }
                (Status::Done, _) => (3, outcome.failures.join("\n") + "\n"),
                (Status::Fault, Some(fault)) => {
                    (3, format!("line {line}: {fault} {}: {}\n", fault.text(), fault.remedy()))
                }
                _ => (3, format!("stopped in line {line}\n")),
            }
        }
        Err(error) => (1, format!("{error}\n")),
    }
}

/// Why a run was left.
#[derive(Clone, Copy)]
enum After {
    /// It came to its end.
    Over,
    /// To be made anew, up to another statement.
    Again,
    Restart,
    End,
}

struct Eye<'a> {
    compiled: &'a Compiled,
    cells: u16,
    names: &'a Names,
    beginnings: HashMap<usize, Vec<u32>>,
    orders: Receiver<Order>,
    ear: Ear,
    quiet: Rc<Cell<bool>>,
    breaks: Breaks,
    faults: bool,
    /// Statements that have begun.
    ordinal: u64,
    pace: Pace,
    /// Where a step began: depth, line, address.
    from: Stand,
    entry: bool,
    pausing: bool,
    /// The statement up to which the run is made anew.
    goal: Option<u64>,
    /// Going backwards to a breakpoint: the last hit so far.
    scan: Option<Option<u64>>,
    /// Changes by hand: statement, cell, value.
    sets: Vec<(u64, u8, i32)>,
    after: After,
}

impl Watcher for Eye<'_> {
    fn before(&mut self, at: At<'_, '_, '_>) -> bool {
        self.ordinal += 1;
        let own = self.sets.iter().filter(|(n, _, _)| *n == self.ordinal);
        own.for_each(|(_, cell, value)| at.vm.set_cell(*cell, *value));
        let hit = self.hit(&at);
        if let Some(goal) = self.goal {
            if self.ordinal < goal {
                if let (Some(last), Some(_)) = (&mut self.scan, &hit) {
                    *last = Some(self.ordinal);
                }
                return true;
            }
            if let Some(last) = self.scan.take() {
                self.goal = Some(last.unwrap_or(1));
                return self.leave(After::Again);
            }
            self.goal = None;
            self.quiet.set(false);
            return self.halt("step", None, self.ordinal, at);
        }
        if !self.listen() {
            return false;
        }
        let stepped = self.pace.ends(self.from, (at.vm.state.calls, at.line, at.pc));
        let reason = match hit {
            _ if std::mem::take(&mut self.entry) => "entry",
            _ if std::mem::take(&mut self.pausing) => "pause",
            Some(()) => "breakpoint",
            None if stepped => "step",
            None => return true,
        };
        self.halt(reason, None, self.ordinal, at)
    }

    fn failed(&mut self, at: At<'_, '_, '_>, fault: Fault) -> bool {
        if !self.faults || self.goal.is_some() {
            return true;
        }
        let text = format!("{fault} {}: {}", fault.text(), fault.remedy());
        self.halt("exception", Some(text), self.ordinal + 1, at)
    }
}

impl Eye<'_> {
    fn leave(&mut self, after: After) -> bool {
        self.after = after;
        false
    }

    /// What the session said meanwhile; `false` when the run is to end.
    fn listen(&mut self) -> bool {
        loop {
            match self.orders.try_recv() {
                Ok(Order::Breaks(breaks, faults)) => {
                    self.breaks.set(breaks);
                    self.faults = faults;
                }
                Ok(Order::Pause) => self.pausing = true,
                Ok(Order::Restart) => return self.leave(After::Restart),
                Ok(Order::End | Order::Leave) | Err(TryRecvError::Disconnected) => {
                    return self.leave(After::End);
                }
                // A run that goes is not set.
                Ok(Order::Go(_) | Order::Set(..)) => {}
                Err(TryRecvError::Empty) => return true,
            }
        }
    }

    /// Whether a breakpoint halts here. Those that only say something say it.
    fn hit(&mut self, at: &At<'_, '_, '_>) -> Option<()> {
        if self.breaks.is_empty() {
            return None;
        }
        let n = self.breaks.at(self.beginnings.get(&at.pc)?)?;
        let shown = self.snapshot(at);
        let (quiet, ear) = (self.quiet.get(), &self.ear);
        let mut say = |category, text| {
            if !quiet {
                ear(Report::Said(category, text));
            }
        };
        self.breaks.hit(n, at.line, self.names, &shown, &mut say).then_some(())
    }

    fn snapshot(&self, at: &At<'_, '_, '_>) -> Snapshot {
        let line = |pc: usize| self.compiled.sidecar.at(pc).map_or(0, |mark| mark.line);
        let frames = frames(at.line, at.vm.frames(), line);
        let cells = (0..self.cells).map(|n| at.vm.cell(n as u8)).collect();
        Snapshot { frames, known: true, cells, view: at.machine.view() }
    }

    /// Tells how things stand, and does what the session says until the run goes on or ends. `behind`
    /// is the statement before which a step back leads.
    fn halt(
        &mut self,
        reason: &'static str,
        text: Option<String>,
        behind: u64,
        at: At<'_, '_, '_>,
    ) -> bool {
        let told = Box::new(self.snapshot(&at));
        (self.ear)(Report::Halted { reason, text, at: told });
        loop {
            match self.orders.recv() {
                Ok(Order::Breaks(breaks, faults)) => {
                    self.breaks.set(breaks);
                    self.faults = faults;
                }
                Ok(Order::Set(cell, value)) => {
                    if let Ok(cell) = u8::try_from(cell) {
                        at.vm.set_cell(cell, value);
                        self.sets.push((self.ordinal, cell, value));
                    }
                }
                Ok(Order::Pause) => {}
                Ok(Order::Restart) => return self.leave(After::Restart),
                Ok(Order::End | Order::Leave) | Err(_) => return self.leave(After::End),
                Ok(Order::Go(pace @ (Pace::Back | Pace::Reverse))) => {
                    let to = behind.saturating_sub(1).max(1);
                    self.scan = (pace == Pace::Reverse).then_some(None);
                    self.goal = Some(if pace == Pace::Back { to } else { behind });
                    self.sets.retain(|(n, _, _)| *n <= to);
                    self.pace = Pace::Go;
                    return self.leave(After::Again);
                }
                Ok(Order::Go(pace)) => {
                    self.pace = pace;
                    self.from = (at.vm.state.calls, at.line, at.pc);
                    return true;
                }
            }
        }
    }
}
