//! Events of the machine: stops at rest, faults, a lost board.

use lang::fault::Fault;
use lang::wire::RunState;

use super::{After, Alarm, Session, WELCOME};
use crate::grbl::desk::{Deed, View};
use crate::grbl::modal::{Modal, Spindle};
use crate::grbl::plan::Sync;
use crate::grbl::report::Due;

impl Session {
    /// Takes up what the machine has come to by itself.
    pub(super) fn look(&mut self, view: &View) {
        if let Some((count, after)) = self.stop
            && view.stops >= count
        {
            self.stop = None;
            self.drop_lines(view);
            match after {
                After::Cancel | After::Gone => {}
                After::Reset => {
                    self.faults = view.faults;
                    self.restart(view);
                    if std::mem::take(&mut self.asked) {
                        self.report(view);
                    }
                }
                After::SoftLimit => self.raise(Alarm { number: 2, critical: true }, ""),
            }
        }
        if view.faults != self.faults && self.stop.is_none() {
            self.faults = view.faults;
            self.fault(view);
        }
        let trouble = view.trouble.is_some();
        if let Some(words) = &view.trouble
            && !self.told_trouble
        {
            self.drop_lines(view);
            self.message(words);
            self.raise(Alarm { number: 3, critical: true }, "");
        }
        self.told_trouble = trouble;
    }

    /// The machine has ended what it did with a fault.
    fn fault(&mut self, view: &View) {
        let sync = self.sync.take();
        self.drop_lines(view);
        // Without a fault of the board, somebody else has stopped the run or has taken the board.
        let Some(fault) = view.fault else {
            return self.raise(
                Alarm { number: 3, critical: true },
                "the run was ended by somebody else, or the board is taken",
            );
        };
        let (number, critical) = match fault {
            Fault::LimitSwitch => (1, true),
            Fault::SoftLimit => (2, true),
            Fault::InputActive => (4, false),
            Fault::ProbeMissed => (5, false),
            Fault::HomeStaysClosed => (8, false),
            Fault::HomeNotFound => (9, false),
            _ => (3, true),
        };
        let words = if matches!(number, 1 | 2 | 4 | 5 | 8 | 9) {
            String::new()
        } else {
            format!("{fault} {}", fault.text())
        };
        self.raise(Alarm { number, critical }, &words);
        match sync {
            Some(Sync::Probe { .. }) if !critical => self.say("ok"),
            Some(_) if !critical => self.say("error:9"),
            _ => {}
        }
    }

    pub(super) fn raise(&mut self, alarm: Alarm, words: &str) {
        if self.alarm.is_some_and(|before| before.critical) {
            return;
        }
        if !self.there {
            self.alarm = Some(alarm);
            return;
        }
        self.alarm = Some(alarm);
        if self.hold {
            self.deeds.push(Deed::Unhold);
        }
        (self.hold, self.door, self.jogging) = (false, false, false);
        let text = Session::alarm_text(alarm);
        self.say(&text);
        if !words.is_empty() {
            self.message(words);
        }
        if alarm.critical {
            self.lines.clear();
            self.message("Reset to continue");
        }
    }

    /// What was under way is over: the place is where the axes rest.
    fn drop_lines(&mut self, view: &View) {
        // Lines that were dropped have no number: the next one has it.
        self.last = view.done;
        self.queue.clear();
        self.sync = None;
        self.jogging = false;
        self.at = self.machine.place(view.steps);
        (self.outputs, self.spindle_stopped) = (0, false);
        // The run has ended with its outputs in their end states. There may have been none.
        self.switch_off();
        self.modal.spindle = Spindle::Off;
        (self.modal.flood, self.modal.mist) = (false, false);
    }

    /// As after power-up, with the welcome.
    pub(super) fn restart(&mut self, view: &View) {
        self.modal = Modal::default();
        (self.offsets.g92, self.offsets.tool) = ([0.0; 3], 0.0);
        self.at = self.machine.place(view.steps);
        (self.hold, self.door, self.jogging) = (false, false, false);
        self.check = false;
        if self.overrides != [100; 3] {
            self.overrides = [100; 3];
            self.deeds.extend([Deed::Feed(100), Deed::Rapid(100)]);
        }
        self.due = Due::default();
        let asleep = std::mem::take(&mut self.sleeping);
        self.out.extend(WELCOME.bytes());
        let latched = view.state == Some(RunState::Fault);
        let lost = self.machine.require_homing
            && (0..3).any(|i| self.machine.axes[i].is_some() && !view.homed[i]);
        let locked = self.alarm.is_some() || latched || lost || asleep || view.trouble.is_some();
        self.alarm = locked.then_some(Alarm { number: 0, critical: false });
        if locked {
            self.message("'$H'|'$X' to unlock");
        }
    }
}
