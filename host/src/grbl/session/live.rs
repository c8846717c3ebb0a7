//! Real-time bytes, which act at once, also in the middle of a line.

use lang::wire::RunState;

use super::{After, Session};
use crate::grbl::desk::{Deed, View};
use crate::grbl::modal::Spindle;

impl Session {
    /// A byte of Grbl's; every other one above 7F is ignored. C2 is among those: clients that send
    /// UTF-8 put it before each of these bytes.
    pub(super) fn live(&mut self, byte: u8, view: &View) {
        if self.alarm.is_some_and(|alarm| alarm.critical) || self.is_stopping() {
            return;
        }
        match byte {
            b'!' => self.feed_hold(view, false),
            0x84 => self.feed_hold(view, true),
            b'~' => self.resume(view),
            0x85 if self.is_jogging(view) => self.cancel(),
            0x90..=0x9D => self.change(byte),
            0x9E => self.stop_spindle(view),
            0xA0 | 0xA1 => self.switch_coolant(byte == 0xA0, view),
            _ => {}
        }
    }

    /// A report of now, for a client that reads.
    pub(super) fn report(&mut self, view: &View) {
        if self.there && self.out.len() < super::MOST_UNREAD {
            let report = self.status(view);
            self.out.extend(report.bytes());
        }
    }

    fn feed_hold(&mut self, view: &View, door: bool) {
        if self.alarm.is_some() || self.sleeping || self.check {
            return;
        }
        if self.is_jogging(view) {
            self.cancel();
            if !door {
                return;
            }
        }
        (self.hold, self.door) = (true, self.door || door);
        self.deeds.push(Deed::Hold);
    }

    /// Ends a jog on its ramp; what was typed behind it is answered as if it had been jogged.
    fn cancel(&mut self) {
        self.halt(After::Cancel);
    }

    fn resume(&mut self, view: &View) {
        let waits = matches!(view.state, Some(RunState::Paused | RunState::WaitStart));
        if !self.hold && !self.door && !waits {
            return;
        }
        if std::mem::take(&mut self.spindle_stopped)
            && let Some(n) = self.machine.spindle
        {
            self.switch(n, true);
        }
        (self.hold, self.door) = (false, false);
        self.deeds.push(Deed::Resume);
    }

    fn change(&mut self, byte: u8) {
        let step = |value: u16, by: i16| value.saturating_add_signed(by).clamp(10, 200);
        let [feed, rapid, speed] = self.overrides;
        self.overrides = match byte {
            0x90 => [100, rapid, speed],
            0x91 => [step(feed, 10), rapid, speed],
            0x92 => [step(feed, -10), rapid, speed],
            0x93 => [step(feed, 1), rapid, speed],
            0x94 => [step(feed, -1), rapid, speed],
            0x95 => [feed, 100, speed],
            0x96 => [feed, 50, speed],
            0x97 => [feed, 25, speed],
            0x99 => [feed, rapid, 100],
            0x9A => [feed, rapid, step(speed, 10)],
            0x9B => [feed, rapid, step(speed, -10)],
            0x9C => [feed, rapid, step(speed, 1)],
            0x9D => [feed, rapid, step(speed, -1)],
            _ => self.overrides,
        };
        if self.overrides[0] != feed {
            self.deeds.push(Deed::Feed(self.overrides[0]));
        }
        if self.overrides[1] != rapid {
            self.deeds.push(Deed::Rapid(self.overrides[1]));
        }
        self.due.overrides = 0;
    }

    /// In a hold only: the spindle stops, and again goes on, at the latest with the job.
    fn stop_spindle(&mut self, view: &View) {
        let rests = self.hold && view.state == Some(RunState::Paused);
        let on = self.modal.spindle != Spindle::Off && !self.machine.laser;
        if let Some(n) = self.machine.spindle
            && rests
            && on
        {
            self.spindle_stopped = !self.spindle_stopped;
            self.switch(n, !self.spindle_stopped);
            self.due.overrides = 0;
        }
    }

    fn switch_coolant(&mut self, flood: bool, _view: &View) {
        if self.alarm.is_some() || self.sleeping || self.check {
            return;
        }
        let Some(n) = self.machine.coolant else { return };
        let modal = &mut self.modal;
        let own = if flood { &mut modal.flood } else { &mut modal.mist };
        *own = !*own;
        let on = modal.flood || modal.mist;
        self.switch(n, on);
        self.due.overrides = 0;
    }
}
