//! One run of the board: lines become pieces of a stream, and real-time commands are handled meanwhile.

use std::cell::{Cell, RefCell};
use std::time::{Duration, Instant};

use lang::back::Compiled;
use lang::profile::Profile;
use lang::wire::{Control, RunState};

use super::{BATCH, Drive, IDLE, compiled, now};
use crate::client::stream::{Slots, Standing};
use crate::client::{Client, ClientError};
use crate::grbl::order::{Order, Writer};
use crate::link::Link;
use crate::stream::chain::Chain;
use crate::stream::feed::Feed;
use crate::stream::job::{Job, More};
use crate::stream::pump::{self, PumpError};

/// Longest wait for a line while the board runs.
const SOON: Duration = Duration::from_millis(4);

/// A probe: its axis, whether it met something, and the place in steps.
type Probed = (usize, bool, i32);

/// A run of the board.
pub(super) struct Run<'a, L: Link> {
    pub drive: RefCell<&'a mut Drive<L>>,
    /// Since when all that came is done.
    pub rests: Cell<Option<Instant>>,
    pub handed: &'a Cell<u32>,
    /// Probes that were handed on, and those of which the result came.
    pub probes: [Cell<usize>; 2],
    /// What is printed, and the newest probe.
    pub printed: RefCell<(Vec<u8>, Option<Probed>)>,
    /// Why lines could not be made a program; none of them can be wrong, so this is a defect.
    pub broken: RefCell<Option<String>>,
}

impl<L: Link> Run<'_, L> {
    pub fn pump(
        &self,
        client: &mut Client<L>,
        slots: Slots,
        lines: &[(u32, Vec<Order>)],
    ) -> Result<(), PumpError> {
        let profile = self.drive.borrow().profile.clone();
        let desk = self.drive.borrow().desk.clone();
        let stops = self.drive.borrow().stops;
        let broke = |words: String| *self.broken.borrow_mut() = Some(words);
        self.count_probes(lines);
        let first = match made(lines, &profile) {
            Ok(compiled) => Chain::new(compiled),
            Err(words) => {
                broke(words);
                return Ok(());
            }
        };
        let feed = match Feed::new(first.compiled()) {
            Ok(feed) => feed,
            Err(flaw) => {
                broke(flaw.text);
                return Ok(());
            }
        };
        let (source, profile, broke) = (&desk, &profile, &broke);
        let mut end = &first;
        let mut job = Job::new(feed, slots.bytes.into());
        job.follow_with(Box::new(move || {
            let wants = source.wants();
            if wants.stops != stops || wants.closing || self.broken.borrow().is_some() {
                return More::Over;
            }
            // A hold begins at once: what has not gone to the board yet stays here.
            if wants.hold {
                std::thread::sleep(SOON);
                return More::Wait;
            }
            let lines = source.lines(BATCH, stops, SOON);
            let Some((newest, _)) = lines.last() else {
                let rested = self.rests.get().is_some_and(|since| since.elapsed() > IDLE);
                return if rested && !wants.stay { More::Over } else { More::Wait };
            };
            self.rests.set(None);
            self.handed.set(*newest);
            self.count_probes(&lines);
            let compiled = match made(&lines, profile) {
                Ok(compiled) => compiled,
                Err(words) => {
                    broke(words);
                    return More::Over;
                }
            };
            end = end.push(compiled);
            match Feed::new(end.compiled()) {
                Ok(feed) => More::Feed(feed),
                Err(flaw) => {
                    broke(flaw.text);
                    More::Over
                }
            }
        }));
        let mut watch = |progress: &pump::Progress| {
            let wants = desk.wants();
            let state = progress.state;
            if wants.closing || wants.stops != stops || self.broken.borrow().is_some() {
                return Some(Control::Stop);
            }
            if wants.resume {
                let control = match state {
                    Some(RunState::Paused) => Some(Control::Resume),
                    Some(RunState::WaitStart) => Some(Control::Start),
                    _ => None,
                };
                // While it still ramps down the wish stays.
                if state != Some(RunState::Stopping) {
                    desk.settle(|wants| wants.resume = false);
                }
                return control;
            }
            // Said until it holds: before the first piece has begun a board does not hear it.
            (wants.hold && state == Some(RunState::Running)).then_some(Control::Pause)
        };
        let mut observe = |client: &mut Client<L>, standing: &Standing, at: &pump::Progress| {
            now(client, &desk.wants(), &desk)?;
            self.observe(client, standing, at)
        };
        let mut print = |bytes: &[u8]| self.print(bytes);
        pump::run_observed(client, &mut job, slots, &mut watch, Some(&mut print), &mut observe)
            .map(drop)
    }

    fn count_probes(&self, lines: &[(u32, Vec<Order>)]) {
        let orders = lines.iter().flat_map(|(_, orders)| orders);
        let count = orders.filter(|order| matches!(order, Order::Probe { .. })).count();
        self.probes[0].set(self.probes[0].get() + count);
    }

    /// Takes what the job prints: a line for each probe.
    fn print(&self, bytes: &[u8]) {
        let mut printed = self.printed.borrow_mut();
        printed.0.extend(bytes);
        while let Some(end) = printed.0.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = printed.0.drain(..=end).collect();
            let text = String::from_utf8_lossy(&line);
            let words: Vec<i32> = text.split_whitespace().flat_map(str::parse).collect();
            if let [axis @ 0..=2, met, steps] = words[..] {
                printed.1 = Some((axis.unsigned_abs() as usize, met != 0, steps));
                self.probes[1].set(self.probes[1].get() + 1);
            }
        }
    }

    fn observe(
        &self,
        client: &mut Client<L>,
        standing: &Standing,
        at: &pump::Progress,
    ) -> Result<(), ClientError> {
        let mut drive = self.drive.borrow_mut();
        drive.looks.inputs(client)?;
        let told = self.probes[0].get() == self.probes[1].get();
        let mut rests = at.dry && told && standing.commanded == standing.steps;
        if at.dry && told && !rests {
            // Behind a probe or a correction the two may differ for good.
            let moved = drive.looks.moving;
            drive.looks.inputs_now(client)?;
            rests =
                !moved && !drive.looks.moving && drive.looks.stands(standing.steps, &drive.machine);
        }
        let handed = self.handed.get();
        let mut probed = None;
        if rests && self.rests.get().is_none() {
            self.rests.set(Some(Instant::now()));
            drive.looks.speed = 0.0;
            probed = self.printed.borrow_mut().1.take();
        }
        let begun = if standing.begun > 0 { at.line } else { 0 };
        drive.show(standing, true, |view| {
            view.begun = view.begun.max(begun.min(handed));
            if rests {
                (view.begun, view.done) = (handed, handed);
            }
            if let Some((axis, met, steps)) = probed {
                (view.probed, view.met) = (standing.steps, met);
                view.probed[axis] = steps;
            }
        });
        Ok(())
    }
}

/// Makes a program of lines; its statements have the numbers of the client's lines.
fn made(lines: &[(u32, Vec<Order>)], profile: &Profile) -> Result<Compiled, String> {
    let mut writer = Writer::new();
    for (number, orders) in lines {
        for order in orders {
            writer.put(*number, order);
        }
    }
    let (text, numbers) = writer.finish();
    let mut compiled = compiled(&text, profile)?;
    for mark in &mut compiled.sidecar.marks {
        let line = usize::try_from(mark.line).unwrap_or(0).saturating_sub(1);
        mark.line = numbers.get(line).copied().unwrap_or(0);
    }
    Ok(compiled)
}
