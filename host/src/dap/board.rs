//! A program on a board, effect by effect, in trace mode: a host that takes no further event halts
//! the program before its next effect.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError};
use std::time::Duration;

use lang::axis::Axis;
use lang::image::{Image, crc_in};
use lang::record::BoardRecord;
use lang::wire::{self, Control};

use super::eval::eval;
use super::program::Loaded;
use super::sim::{Ear, tell};
use super::snapshot::{Break, Frame, Order, Pace, Report, Snapshot};
use crate::client::identity::differences;
use crate::client::status::{Status, long};
use crate::helm::follow::Follow;
use crate::helm::{Board, Debug, Pace as Steps};
use crate::sim::machine::{AxisView, View, scaled};
use crate::sim::trace::{Event, Status as End, What};

/// Between two looks for an event.
const LOOK: Duration = Duration::from_millis(1);
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
    let image = &loaded.compiled.image;
    Ok((usize::from(identity.program_bytes), identity.program_crc) == (image.len(), crc_in(image)))
}

/// Follows runs of the board's program until the session ends it. `halts`: before Start.
pub fn run(
    mut board: Board,
    loaded: &Loaded,
    halts: bool,
    trace: bool,
    orders: Receiver<Order>,
    ear: &Ear,
) {
    let cells = Image::new(&loaded.compiled.image).map_or(0, |image| image.header.cells.into());
    let mut eye = Eye { loaded, cells, orders, ear, breaks: Vec::new(), trace };
    let result = loop {
        match eye.follow(&mut board, halts) {
            Ok(true) => {}
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
    breaks: Vec<Break>,
    trace: bool,
}

/// What a halted run is to do.
enum Next {
    Go(Pace),
    Restart,
    End,
}

impl Eye<'_> {
    /// One run; whether there is to be another.
    fn follow(&mut self, board: &mut Board, halts: bool) -> Result<bool, String> {
        let words = |error: crate::client::ClientError| error.to_string();
        let mut pace = Pace::Go;
        if halts {
            let first = self.loaded.lines.first().copied().unwrap_or(1);
            match self.halted(board, "entry", None, first)? {
                Next::Go(next) => pace = next,
                Next::Restart => return Ok(true),
                Next::End => return Ok(false),
            }
        }
        let marks = self.loaded.compiled.sidecar.clone();
        let line_of =
            Arc::new(move |pc: u16| marks.at(usize::from(pc)).map_or(0, |mark| mark.line));
        let profile = self.loaded.program.profile.clone();
        let mut run =
            Follow::start(board, profile, line_of, BTreeSet::new(), Steps::Step).map_err(words)?;
        let mut pausing = false;
        loop {
            match self.orders.try_recv() {
                Ok(Order::Breaks(breaks, _)) => self.breaks = breaks,
                Ok(Order::Pause) => pausing = true,
                Ok(Order::Restart) => return self.ended(board, &mut run, true),
                Ok(Order::End) | Err(TryRecvError::Disconnected) => {
                    return self.ended(board, &mut run, false);
                }
                Ok(Order::Go(_) | Order::Set(..)) => {}
                Err(TryRecvError::Empty) => {}
            }
            let Some(seen) = run.look(board).map_err(words)? else {
                return Err("the run is over, and its end was not told".to_owned());
            };
            for what in seen {
                let event = Event { what, us: None };
                tell(&event, self.trace, self.ear);
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
            let reason = match pace {
                _ if std::mem::take(&mut pausing) => Some("pause"),
                Pace::Go => self.hit(board, halt.next)?.then_some("breakpoint"),
                _ => Some("step"),
            };
            if let Some(reason) = reason {
                let text = format!("behind the effect of line {}", halt.behind);
                match self.halted(board, reason, Some(text), halt.next)? {
                    Next::Go(next) => pace = next,
                    Next::Restart => return self.ended(board, &mut run, true),
                    Next::End => return self.ended(board, &mut run, false),
                }
            }
            run.ask(Debug::Pace(Steps::Step));
        }
    }

    /// Stops the run; the board takes its axes down on their ramps.
    fn ended(&self, board: &mut Board, run: &mut Follow, again: bool) -> Result<bool, String> {
        run.ask(Debug::Leave);
        Follow::end(board).map_err(|error| error.to_string())?;
        board.control(Control::Stop).map_err(|error| error.to_string())?;
        Ok(again)
    }

    fn hit(&self, board: &mut Board, line: u32) -> Result<bool, String> {
        let Some(wanted) = self.breaks.iter().find(|wanted| wanted.line == line) else {
            return Ok(false);
        };
        let Some(condition) = &wanted.condition else { return Ok(true) };
        let shown = self.snapshot(board, line)?;
        Ok(eval(condition, line, &self.loaded.names, &shown).map_or(true, |(_, value)| value != 0))
    }

    fn halted(
        &mut self,
        board: &mut Board,
        reason: &'static str,
        text: Option<String>,
        line: u32,
    ) -> Result<Next, String> {
        let at = Box::new(self.snapshot(board, line)?);
        (self.ear)(Report::Halted { reason, text, at });
        loop {
            match self.orders.recv() {
                Ok(Order::Breaks(breaks, _)) => self.breaks = breaks,
                Ok(Order::Set(cell, value)) => {
                    let register = wire::CELLS + 2 * u16::try_from(cell).unwrap_or(0);
                    board
                        .write_all(register, &[value as u16, (value >> 16) as u16])
                        .map_err(|error| error.to_string())?;
                }
                Ok(Order::Pause) => {}
                Ok(Order::Go(pace)) => return Ok(Next::Go(pace)),
                Ok(Order::Restart) => return Ok(Next::Restart),
                Ok(Order::End) | Err(_) => return Ok(Next::End),
            }
        }
    }

    fn snapshot(&self, board: &mut Board, line: u32) -> Result<Snapshot, String> {
        let words = |error: crate::client::ClientError| error.to_string();
        let mut registers = Vec::new();
        while registers.len() < 2 * usize::from(self.cells) {
            let read = registers.len() as u16;
            let count = (2 * self.cells - read).min(AT_ONCE);
            registers.extend(board.holding(wire::CELLS + read, count).map_err(words)?);
        }
        let cells = registers.chunks_exact(2).map(|pair| long(pair[0], pair[1])).collect();
        let status = board.status().map_err(words)?;
        // No register tells the open calls: the routine is that of the line.
        let frames = vec![Frame { line, kind: None }];
        Ok(Snapshot { frames, cells, view: self.view(&status) })
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
        View {
            us: 0,
            inputs: ports(&status.inputs),
            outputs: ports(&status.outputs),
            axes: Axis::ALL.into_iter().filter_map(axis).collect(),
        }
    }
}
