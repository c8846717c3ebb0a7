//! Grbl's protocol for one client, without input or output.
//!
//! Bytes go in by [`Session::take`]; replies and commands for the machine come out by
//! [`Session::outgoing`] and [`Session::deeds`]. [`Session::tick`] answers what had to wait: a line is
//! answered once there is room for it in the machine's queue, and some lines only when the machine rests.

mod course;
mod dollar;
mod gcode;
mod jog;
mod live;

use std::collections::VecDeque;
use std::sync::Arc;

use lang::profile::{InputRole, Profile};

use super::Error;
use super::desk::{Deed, View};
use super::keep::Kept;
use super::modal::{Modal, Offsets, Point};
use super::order::Order;
use super::plan::Sync;
use super::report::Due;
use super::settings::Machine;
use super::words::LONGEST;

/// What a client sees first.
pub const WELCOME: &str = "\r\nGrbl 1.1h ['$' for help]\r\n";
/// Lines ahead of the machine, however long they take.
const AHEAD: usize = 100;
/// Lines ahead of the machine that take no longer than [`AHEAD_SECONDS`].
const MOST_AHEAD: usize = 2_000;
/// See [`MOST_AHEAD`]: a second of a picture.
const AHEAD_SECONDS: f64 = 1.0;
/// Lines that wait to be looked at. A client that counts characters has never more than a few.
const MOST_WAITING: usize = 256;
/// Bytes of answers that a client has not taken; status reports are left out above it.
const MOST_UNREAD: usize = 8_192;

/// An alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Alarm {
    /// As Grbl numbers it; 0 for a lock without an alarm of its own.
    pub number: u8,
    /// Only a reset is heard until it comes.
    pub critical: bool,
}

/// Inputs with a meaning, bit n - 1.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pins {
    pub probe: u32,
    pub door: u32,
    pub hold: u32,
    pub stop: u32,
    pub start: u32,
}

/// What a line is that waits.
#[derive(Clone, Debug, PartialEq)]
enum Waiting {
    Text(String),
    /// So many lines that are refused with this answer.
    Bad(Error, usize),
}

/// What a stop was for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum After {
    /// A jog was cancelled.
    Cancel,
    /// 0x18.
    Reset,
    /// A soft limit: the alarm is raised at rest.
    SoftLimit,
    /// The client is gone.
    Gone,
}

/// See the module.
pub struct Session {
    pub(super) machine: Arc<Machine>,
    pub(super) pins: Pins,
    pub(super) modal: Modal,
    offsets: Offsets,
    pub(super) kept: Kept,
    kept_changed: bool,
    /// Where the lines so far lead to, machine frame.
    at: Point,
    out: Vec<u8>,
    deeds: Vec<Deed>,
    half: Vec<u8>,
    too_long: bool,
    /// The last byte was a carriage return, which a line feed may follow.
    returned: bool,
    lines: VecDeque<Waiting>,
    /// The line that is done when all is at rest.
    sync: Option<Sync>,
    /// Number of the last line with orders.
    last: u32,
    /// Lines with orders that have not begun: number and seconds.
    queue: VecDeque<(u32, f64)>,
    stop: Option<(u32, After)>,
    stops: u32,
    faults: u32,
    pub(super) alarm: Option<Alarm>,
    pub(super) hold: bool,
    pub(super) door: bool,
    pub(super) check: bool,
    pub(super) sleeping: bool,
    /// The drivers were switched off, and are to be on again before anything moves.
    undriven: bool,
    pub(super) jogging: bool,
    /// Feed, rapid and spindle override, per cent.
    pub(super) overrides: [u16; 3],
    /// The spindle was stopped by hand in a hold.
    spindle_stopped: bool,
    /// Outputs that M42 switched on, bit n - 1.
    outputs: u32,
    /// Outputs that a byte switched on at once, bit n - 1: the end of a run need not switch them off.
    switched: u32,
    stays: bool,
    /// A report was asked for during a reset: it comes after the welcome.
    asked: bool,
    pub(super) due: Due,
    told_trouble: bool,
    there: bool,
}

impl Session {
    /// For the machine of a profile, with what was kept.
    pub fn new(profile: &Profile, kept: Kept) -> Session {
        let of = |role| {
            let list = profile.inputs.iter().filter(|input| input.role == Some(role));
            list.fold(0u32, |all, input| all | 1 << (input.n - 1))
        };
        let probe = u32::try_from(profile.probe_input() - 1).map_or(0, |n| 1 << n);
        Session {
            machine: Arc::new(Machine::of(profile)),
            pins: Pins {
                probe,
                door: of(InputRole::Door),
                hold: of(InputRole::Hold),
                stop: of(InputRole::Stop),
                start: of(InputRole::Start),
            },
            modal: Modal::default(),
            offsets: kept.offsets(),
            kept,
            kept_changed: false,
            at: [0.0; 3],
            out: Vec::new(),
            deeds: Vec::new(),
            half: Vec::new(),
            too_long: false,
            returned: false,
            lines: VecDeque::new(),
            sync: None,
            last: 0,
            queue: VecDeque::new(),
            stop: None,
            stops: 0,
            faults: 0,
            alarm: None,
            hold: false,
            door: false,
            check: false,
            sleeping: false,
            undriven: false,
            jogging: false,
            overrides: [100; 3],
            spindle_stopped: false,
            outputs: 0,
            switched: 0,
            stays: false,
            asked: false,
            due: Due::default(),
            told_trouble: false,
            there: false,
        }
    }

    /// A client came: it gets the welcome, and the machine is as after a reset.
    pub fn open(&mut self, view: &View) {
        self.there = true;
        self.out.clear();
        self.faults = view.faults;
        if self.last != view.done && self.stop.is_none() {
            self.halt(After::Reset);
            return;
        }
        if self.stop.is_none() {
            self.restart(view);
        } else {
            // What the client before left behind still comes to rest.
            self.stop = self.stop.map(|(count, _)| (count, After::Reset));
        }
    }

    /// The client is gone: what it moved ends as by a stop, outputs in their end states.
    pub fn gone(&mut self, view: &View) {
        (self.there, self.asked) = (false, false);
        self.out.clear();
        self.lines.clear();
        self.half.clear();
        (self.too_long, self.returned, self.sync) = (false, false, None);
        if self.is_busy(view) || self.stays || self.switched != 0 || self.hold || view.ours {
            self.halt(After::Gone);
        }
    }

    /// Whether a client is there.
    pub fn is_open(&self) -> bool {
        self.there
    }

    /// What is to be sent.
    pub fn outgoing(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    /// What the machine is to do.
    pub fn deeds(&mut self) -> Vec<Deed> {
        std::mem::take(&mut self.deeds)
    }

    /// What is to be kept over power-off, if it has changed since the last call.
    pub fn changed(&mut self) -> Option<&Kept> {
        std::mem::take(&mut self.kept_changed).then_some(&self.kept)
    }

    /// What to tell people of who left: whether something ran, and how many lines had not begun.
    pub fn left_over(&self, view: &View) -> Option<usize> {
        self.is_busy(view).then(|| self.ahead(view) + self.lines.len())
    }

    pub(super) fn offsets(&self) -> &Offsets {
        &self.offsets
    }

    /// Bytes of the client.
    pub fn take(&mut self, bytes: &[u8], view: &View) {
        for byte in bytes {
            self.byte(*byte, view);
        }
        self.tick(view);
    }

    fn byte(&mut self, byte: u8, view: &View) {
        // A byte that acts at once stands in no line: it may come between the two bytes of a line's end.
        let at_once = matches!(byte, b'?' | b'!' | b'~' | 0x18 | 0x80..);
        let after_return = !at_once && std::mem::take(&mut self.returned);
        match byte {
            0x18 => self.reset(view),
            b'?' if self.is_resetting() => self.asked = true,
            b'?' => self.report(view),
            b'!' | b'~' | 0x80.. => self.live(byte, view),
            b'\n' if after_return => {}
            b'\r' | b'\n' => {
                self.returned = byte == b'\r';
                self.end_of_line();
            }
            _ if self.half.len() >= LONGEST => self.too_long = true,
            _ => self.half.push(byte),
        }
    }

    fn end_of_line(&mut self) {
        let half = std::mem::take(&mut self.half);
        let too_long = std::mem::take(&mut self.too_long);
        if self.alarm.is_some_and(|alarm| alarm.critical) && !self.is_resetting() {
            return;
        }
        // Once a line was lost, none counts until all that waits is answered: the client has not
        // counted, and a job must not go on with a line missing.
        let lost = self.lines.len() >= MOST_WAITING
            || matches!(self.lines.back(), Some(Waiting::Bad(Error::OVERFLOW, _)));
        let waiting = if too_long || lost {
            Waiting::Bad(Error::OVERFLOW, 1)
        } else {
            match String::from_utf8(half) {
                Ok(text) => Waiting::Text(text),
                Err(_) => Waiting::Bad(Error::LETTER, 1),
            }
        };
        match (self.lines.back_mut(), &waiting) {
            (Some(Waiting::Bad(before, count)), Waiting::Bad(error, _)) if before == error => {
                *count += 1;
            }
            _ => self.lines.push_back(waiting),
        }
    }

    /// Answers what can be answered now, and sees what has become of the machine.
    pub fn tick(&mut self, view: &View) {
        while self.queue.front().is_some_and(|(number, _)| *number <= view.begun) {
            self.queue.pop_front();
        }
        self.look(view);
        // Lines that wait are no jogs: they begin after it.
        self.jogging = self.is_jogging(view);
        loop {
            if self.stop.is_some() || !self.there {
                break;
            }
            if let Some(sync) = self.sync {
                if view.done != self.last || self.alarm.is_some() {
                    break;
                }
                self.sync = None;
                self.finish(sync, view);
                continue;
            }
            if !self.next_line(view) {
                break;
            }
        }
        self.stay();
    }

    /// 0x18
    fn reset(&mut self, view: &View) {
        self.lines.clear();
        self.half.clear();
        self.asked = false;
        (self.too_long, self.returned, self.sync) = (false, false, None);
        self.halt(After::Reset);
        self.tick(view);
    }

    /// Ends what the machine does.
    fn halt(&mut self, after: After) {
        if self.stop.is_none() {
            self.stops += 1;
            self.deeds.push(Deed::Stop);
        } else if self.hold {
            // It came after the stop that is under way (a door opened during a jog).
            self.deeds.push(Deed::Unhold);
        }
        self.switch_off();
        self.stop = Some((self.stops, after));
        self.hold = false;
        self.queue.clear();
        (self.stays, self.outputs) = (false, 0);
        self.deeds.push(Deed::Stay(false));
    }

    /// Switches an output at once.
    fn switch(&mut self, n: u16, on: bool) {
        let bit = 1 << (n - 1);
        self.switched = if on { self.switched | bit } else { self.switched & !bit };
        self.deeds.push(Deed::Coil(n, on));
    }

    /// Switches off what bytes switched on at once. Without a run nothing else does.
    fn switch_off(&mut self) {
        for n in 1..=u32::BITS as u16 {
            if self.switched >> (n - 1) & 1 != 0 {
                self.switch(n, false);
            }
        }
    }

    /// Keeps the run open while something is on.
    fn stay(&mut self) {
        let modal = &self.modal;
        let on = modal.spindle != super::modal::Spindle::Off
            || modal.flood
            || modal.mist
            || self.outputs != 0;
        if on != self.stays {
            self.stays = on;
            self.deeds.push(Deed::Stay(on));
        }
    }

    /// Carries out the next line; whether there was one and room for it.
    fn next_line(&mut self, view: &View) -> bool {
        let Some(first) = self.lines.front() else { return false };
        if let Waiting::Text(_) = first
            && self.is_full(view)
        {
            return false;
        }
        match self.lines.pop_front() {
            Some(Waiting::Text(text)) => self.line(&text, view),
            Some(Waiting::Bad(error, count)) => {
                if count > 1 {
                    self.lines.push_front(Waiting::Bad(error, count - 1));
                }
                self.answer(error);
            }
            None => return false,
        }
        true
    }

    fn line(&mut self, text: &str, view: &View) {
        let clean = super::words::clean(text);
        if clean.is_empty() {
            self.say("ok");
        } else if let Some(rest) = clean.strip_prefix('$') {
            self.dollar(rest, view);
        } else if self.alarm.is_some() || self.sleeping || self.is_jogging(view) {
            self.answer(Error::LOCKED);
        } else {
            self.gcode(&clean, view);
        }
    }

    /// Hands orders to the machine; none in check mode.
    fn order(&mut self, orders: Vec<Order>, seconds: f64, view: &View) {
        if orders.is_empty() || self.check {
            return;
        }
        self.last += 1;
        self.queue.push_back((self.last, seconds));
        self.deeds.push(Deed::Line { number: self.last, epoch: view.epoch, orders });
    }

    /// Lines with orders that have not begun.
    pub(super) fn ahead(&self, view: &View) -> usize {
        self.queue.iter().filter(|(number, _)| *number > view.begun).count()
    }

    fn is_full(&self, view: &View) -> bool {
        let ahead = self.ahead(view);
        let seconds = || self.queue.iter().map(|(_, seconds)| seconds).sum::<f64>();
        ahead >= MOST_AHEAD || ahead >= AHEAD && seconds() > AHEAD_SECONDS
    }

    /// Whether something is under way or waits to be.
    pub(super) fn is_busy(&self, view: &View) -> bool {
        self.last != view.done || self.sync.is_some() || !self.lines.is_empty()
    }

    /// Whether a jog has not come to rest.
    pub(super) fn is_jogging(&self, view: &View) -> bool {
        self.jogging && self.last != view.done
    }

    pub(super) fn is_stopping(&self) -> bool {
        self.stop.is_some()
    }

    fn is_resetting(&self) -> bool {
        matches!(self.stop, Some((_, After::Reset)))
    }

    pub(super) fn is_homing(&self) -> bool {
        self.sync == Some(Sync::Home)
    }

    /// Sends a line.
    fn say(&mut self, text: &str) {
        if self.there {
            self.out.extend(text.bytes());
            self.out.extend(b"\r\n");
        }
    }

    fn answer(&mut self, error: Error) {
        self.say(&format!("error:{}", error.0));
    }

    /// Sends a message. No client may take it for an answer: some look for "ok" and "error" anywhere in
    /// a line.
    fn message(&mut self, text: &str) {
        self.say(&format!("[MSG:{}]", harmless(text)));
    }
}

/// A text without `ok`, `error`, brackets and line ends.
pub(super) fn harmless(text: &str) -> String {
    let mut out: String = text
        .chars()
        .map(|c| match c {
            '[' | '<' => '(',
            ']' | '>' => ')',
            c if c.is_control() || !c.is_ascii() => ' ',
            c => c,
        })
        .collect();
    for word in ["ok", "error"] {
        // Offsets of the small letters are those of the text, which is ASCII.
        while let Some(at) = out.to_ascii_lowercase().find(word) {
            out.insert(at + 1, '-');
        }
    }
    out
}
