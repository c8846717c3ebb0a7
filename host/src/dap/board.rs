//! Debugging on a board, effect by effect, in trace mode: the program halts before its next effect
//! while the host takes no further event.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};
use std::time::Duration;

use lang::axis::Axis;
use lang::image::Image;
use lang::record::BoardRecord;
use lang::wire::{self, Control, RunState};

use super::breaks::Breaks;
use super::program::Loaded;
use super::sim::{Ear, tell};
use super::snapshot::{Frame, Order, Pace, Report, Snapshot, Stand, frames};
use crate::client::aout::AoutValue;
use crate::client::identity::differences;
use crate::client::status::{Status, long};
use crate::helm::follow::{Follow, Halt};
use crate::helm::{Board, Debug, Pace as Steps};
use crate::sim::machine::scaled;
use crate::sim::trace::{Event, Status as End, What};
use crate::sim::view::{AxisView, View};

/// Between two looks for an event.
const LOOK: Duration = Duration::from_millis(1);
/// Between two looks at a halted run: somebody may end it.
const HALTED_LOOK: Duration = Duration::from_millis(100);
/// Registers that one request reads.
const AT_ONCE: u16 = 64;

/// Whether the board's machine is the program's; a program for another one would move it wrongly.
///
/// # Errors
/// It is not; in words.
pub fn fits(board: &mut Board, loaded: &Loaded) -> Result<(), String> {
    let held = board.board_record().map_err(|error| error.to_string())?;
    let profile = &loaded.program.profile;
    let mut differ = differences(&held, &BoardRecord::of(profile, held.sequence));
    differ.retain(|what| *what != "link");
    if differ.is_empty() {
        return Ok(());
    }
    Err(format!(
        "the board's profile is not `{name}`, it differs in {}: `pasapas profile set {name}` brings it",
        differ.join(", "),
        name = profile.name
    ))
}

/// Whether the program is the one that the board holds.
///
/// # Errors
/// It is another, or the board does not answer; in words.
pub fn holds(board: &mut Board, loaded: &Loaded) -> Result<bool, String> {
    let identity = board.identity().map_err(|error| error.to_string())?;
    identity.check()?;
    Ok(identity.holds(&loaded.compiled.image))
}

/// How a session meets the board's program.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// The run that goes on, or the one that begins next, instead of one that is started.
    pub attach: bool,
    /// Halt as soon as it can be.
    pub halts: bool,
    /// Say each effect.
    pub trace: bool,
}

/// Follows runs of the board's program until the session ends it.
pub fn run(mut board: Board, loaded: &Loaded, how: Meeting, orders: Receiver<Order>, ear: &Ear) {
    let cells = Image::new(&loaded.compiled.image).map_or(0, |image| image.header.cells);
    let breaks = Breaks::default();
    let mut eye =
        Eye { loaded, cells, orders, ear, breaks, how, from: (0, 0, 0), last: None, exact: false };
    let mut attach = how.attach;
    let result = loop {
        match eye.follow(&mut board, attach) {
            // Whoever restarts an attached run wants one of its own.
            Ok(true) => attach = false,
            Ok(false) => break Ok(()),
            Err(words) => break Err(words),
        }
    };
    // Nobody takes events any more: the program must not wait for that.
    let quiet = Follow::end(&mut board).map_err(|error| error.to_string());
    if let Err(words) = result.and(quiet) {
        ear(Report::Over(4, format!("{words}\n")));
    }
}

struct Eye<'a> {
    loaded: &'a Loaded,
    cells: u16,
    orders: Receiver<Order>,
    ear: &'a Ear,
    breaks: Breaks,
    how: Meeting,
    /// Where a step began: open calls, line, address; on a board that does not tell, the line alone.
    from: Stand,
    /// Where the run stood last.
    last: Option<Stand>,
    exact: bool,
}

/// What a run is to do.
enum Next {
    Go(Pace),
    Restart,
    End,
    Leave,
}

impl Eye<'_> {
    /// One run; whether there is to be another.
    fn follow(&mut self, board: &mut Board, attach: bool) -> Result<bool, String> {
        let words = |error: crate::client::ClientError| error.to_string();
        let marks = self.loaded.compiled.sidecar.clone();
        let line_of =
            Arc::new(move |pc: u16| marks.at(usize::from(pc)).map_or(0, |mark| mark.line));
        let profile = self.loaded.program.profile.clone();
        self.breaks.forget_hits();
        self.last = None;
        let mut run = if attach {
            if board.holding(wire::TRACE_MODE, 1).map_err(words)?[0] != 0 {
                return Err("another tool follows the board's run, or did up to 2 s ago".to_owned());
            }
            Follow::join(board, profile, line_of).map_err(words)?
        } else {
            Follow::start(board, profile, line_of, BTreeSet::new(), Steps::Step).map_err(words)?
        };
        self.exact = run.is_exact();
        self.explain(&run);
        let mut entry = self.how.halts;
        let mut pausing = false;
        let mut pace = Pace::Go;
        loop {
            match self.orders.try_recv() {
                Ok(Order::Breaks(breaks, _)) => self.breaks.set(breaks),
                Ok(Order::Pause) => pausing = true,
                Ok(Order::Restart) => return self.leave(board, &mut run, Next::Restart),
                Ok(Order::End) => return self.leave(board, &mut run, Next::End),
                Ok(Order::Leave) => return self.leave(board, &mut run, Next::Leave),
                Err(TryRecvError::Disconnected) => return self.leave(board, &mut run, self.gone()),
                Ok(Order::Go(_) | Order::Set(..)) | Err(TryRecvError::Empty) => {}
            }
            let Some(seen) = run.look(board).map_err(words)? else {
                return Err("the run is over, and its end was not told".to_owned());
            };
            for what in seen {
                let event = Event { what, us: None };
                tell(&event, self.how.trace, self.ear);
                if let What::End { status, fault, line, text, .. } = &event.what {
                    let code = if *status == End::Done { 0 } else { 3 };
                    let why = match fault {
                        Some(fault) => format!("{fault} {}", text.as_deref().unwrap_or("")),
                        None => format!("{status:?}").to_lowercase(),
                    };
                    (self.ear)(Report::Over(code, format!("line {line}: {why}\n")));
                    return Ok(false);
                }
            }
            let Some(halt) = run.halt().cloned() else {
                board.link().pause(LOOK);
                continue;
            };
            let hit = self.hit(board, &halt)?;
            let reason = match () {
                () if std::mem::take(&mut entry) => Some("entry"),
                () if std::mem::take(&mut pausing) => Some("pause"),
                () if hit => Some("breakpoint"),
                () => self.stepped(pace, &halt).then_some("step"),
            };
            if let Some(reason) = reason {
                match self.halted(board, &mut run, reason, &halt)? {
                    Next::Go(next) => pace = next,
                    next => return self.leave(board, &mut run, next),
                }
            }
            run.ask(Debug::Pace(Steps::Step));
        }
    }

    /// What a user must know of this board.
    fn explain(&self, run: &Follow) {
        let say = |text: &str| (self.ear)(Report::Said("console", text.to_owned()));
        if run.is_before() {
            say("the program does not run: press Start on the machine, or restart it here\n");
        }
        if !run.is_exact() {
            say(
                "this board's firmware does not tell the open calls: the list of calls ends with the \
                 present routine, a step over or out goes by the lines, and a halt comes behind an effect\n",
            );
        }
    }

    /// The editor has gone without a word.
    const fn gone(&self) -> Next {
        if self.how.attach { Next::Leave } else { Next::End }
    }

    /// Ends the run, the board takes its axes down on their ramps; or leaves it alone. Whether there is
    /// to be another.
    fn leave(&self, board: &mut Board, run: &mut Follow, next: Next) -> Result<bool, String> {
        run.ask(Debug::Leave);
        Follow::end(board).map_err(|error| error.to_string())?;
        if matches!(next, Next::Leave) || run.is_before() && !matches!(next, Next::Restart) {
            return Ok(false);
        }
        board.control(Control::Stop).map_err(|error| error.to_string())?;
        let rest = [RunState::Ready, RunState::Fault, RunState::Empty];
        match board.wait_for(&rest).map_err(|error| error.to_string())? {
            Ok(_) => Ok(matches!(next, Next::Restart)),
            Err(_) => Err("the board does not come to rest behind Stop".to_owned()),
        }
    }

    /// The line of a halt: of the next effect, on a board that does not tell of the one behind.
    fn line(halt: &Halt) -> u32 {
        if halt.standing.is_some() { halt.next } else { halt.behind }
    }

    /// Open calls, line and address of a halt.
    fn stand(halt: &Halt) -> Stand {
        let line = Self::line(halt);
        halt.standing.as_ref().map_or((0, line, 0), |standing| {
            (standing.calls.len() as u8, line, usize::from(standing.place))
        })
    }

    /// Whether the step under way is over here.
    fn stepped(&self, pace: Pace, halt: &Halt) -> bool {
        if self.exact {
            return pace.ends(self.from, Self::stand(halt));
        }
        // By the lines: what the routine of the step's beginning calls is no end of a step over; neither
        // that nor the routine itself one of a step out.
        let (begun, here) = (self.from.1, Self::line(halt));
        let routine = |line| self.loaded.names.routine_at(line);
        let own = routine(begun) == routine(here);
        let called = self.loaded.is_called_from(begun, here);
        match pace {
            Pace::Into => true,
            Pace::Over => own || !called,
            Pace::Out => !own && !called,
            _ => false,
        }
    }

    fn hit(&mut self, board: &mut Board, halt: &Halt) -> Result<bool, String> {
        let here = Self::stand(halt);
        let last = self.last.replace(here);
        // A line's second effect is no new hit.
        let begins = !self.exact || last.is_none_or(|last| Pace::Into.ends(last, here));
        let line = Self::line(halt);
        let Some(n) = self.breaks.at(&[line]).filter(|_| begins) else { return Ok(false) };
        let shown = self.snapshot(board, halt)?;
        let ear = self.ear;
        let mut say = |category, text| ear(Report::Said(category, text));
        Ok(self.breaks.hit(n, line, &self.loaded.names, &shown, &mut say))
    }

    fn halted(
        &mut self,
        board: &mut Board,
        run: &mut Follow,
        reason: &'static str,
        halt: &Halt,
    ) -> Result<Next, String> {
        let words = |error: crate::client::ClientError| error.to_string();
        let text = match halt.behind {
            0 => None,
            behind => Some(format!("behind the effect of line {behind}")),
        };
        let at = Box::new(self.snapshot(board, halt)?);
        (self.ear)(Report::Halted { reason, text, at });
        loop {
            match self.orders.recv_timeout(HALTED_LOOK) {
                Ok(Order::Breaks(breaks, _)) => self.breaks.set(breaks),
                Ok(Order::Set(cell, value)) => {
                    let register = wire::CELLS + 2 * u16::try_from(cell).unwrap_or(0);
                    board
                        .write_all(register, &[value as u16, (value >> 16) as u16])
                        .map_err(words)?;
                }
                Ok(Order::Pause) => {}
                Ok(Order::Go(pace)) => {
                    self.from = Self::stand(halt);
                    return Ok(Next::Go(pace));
                }
                Ok(Order::Restart) => return Ok(Next::Restart),
                Ok(Order::End) => return Ok(Next::End),
                Ok(Order::Leave) => return Ok(Next::Leave),
                Err(RecvTimeoutError::Disconnected) => return Ok(self.gone()),
                Err(RecvTimeoutError::Timeout) => {
                    // It keeps the board's patience, too.
                    run.look(board).map_err(words)?;
                    if run.halt().is_none() {
                        (self.ear)(Report::GoesOn);
                        return Ok(Next::Go(Pace::Go));
                    }
                }
            }
        }
    }

    fn snapshot(&self, board: &mut Board, halt: &Halt) -> Result<Snapshot, String> {
        let words = |error: crate::client::ClientError| error.to_string();
        let mut registers = Vec::new();
        while registers.len() < 2 * usize::from(self.cells) {
            let read = registers.len() as u16;
            let count = (2 * self.cells - read).min(AT_ONCE);
            registers.extend(board.holding(wire::CELLS + read, count).map_err(words)?);
        }
        let cells = registers.chunks_exact(2).map(|pair| long(pair[0], pair[1])).collect();
        let mut status = board.status().map_err(words)?;
        let unit = board.aout_unit().map_err(words)?;
        status.analog_outputs = board.aouts(unit).map_err(words)?;
        let line = |pc: usize| self.loaded.compiled.sidecar.at(pc).map_or(0, |mark| mark.line);
        let (frames, known) = match &halt.standing {
            Some(standing) => {
                let open = standing.calls.iter().map(|call| (call.kind, usize::from(call.address)));
                (frames(halt.next, open, line), true)
            }
            // Of the main program nobody but the machine called.
            None => {
                let line = halt.behind;
                let known = self.loaded.names.routine_at(line).is_none();
                (vec![Frame { line, kind: None }], known)
            }
        };
        Ok(Snapshot { frames, known, cells, view: self.view(&status) })
    }

    fn view(&self, status: &Status) -> View {
        let axis = |axis: Axis| {
            let steps = status.pos.get(axis).unwrap_or(0);
            let own = self.loaded.program.profile.axis(axis)?;
            let um = scaled(steps, own.scale.um, own.scale.steps).unwrap_or_default();
            let (moving, homed) =
                (status.moving.contains(&axis.letter()), status.homed.contains(&axis.letter()));
            Some(AxisView { axis, um, steps, moving, homed })
        };
        let ports = |on: &[u16]| (1..=16).map(|n| (n, on.contains(&(n as u16)))).collect();
        let aout = |own: &AoutValue| (own.n.into(), own.mv.or(own.share).map_or(0, i32::from));
        View {
            timer: None,
            inputs: ports(&status.inputs),
            outputs: ports(&status.outputs),
            aouts: status.analog_outputs.iter().map(aout).collect(),
            axes: Axis::ALL.into_iter().filter_map(axis).collect(),
        }
    }
}
