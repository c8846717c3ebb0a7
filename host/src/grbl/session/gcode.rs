//! Lines of G-code.

use lang::wire::RunState;

use super::{After, Alarm, Session};
use crate::grbl::Error;
use crate::grbl::block::Block;
use crate::grbl::desk::View;
use crate::grbl::modal::length;
use crate::grbl::plan::{Here, Plan, Refusal, Sync, plan};

impl Session {
    pub(super) fn here<'a>(&'a self, view: &View) -> Here<'a> {
        Here {
            machine: &self.machine,
            modal: &self.modal,
            offsets: &self.offsets,
            at: self.at,
            homed: view.homed,
            speed_override: self.overrides[2],
        }
    }

    pub(super) fn gcode(&mut self, clean: &str, view: &View) {
        let block = match Block::read(clean) {
            Ok(block) => block,
            Err(error) => return self.answer(error),
        };
        match plan(&block, &self.here(view)) {
            Ok(plan) => self.carry_out(plan, view),
            Err(refusal) => self.refuse(refusal),
        }
    }

    /// Answers a line that is not done.
    pub(super) fn refuse(&mut self, refusal: Refusal) {
        match refusal {
            Refusal::Error(error) => self.answer(error),
            Refusal::Told(error, words) => {
                self.message(&words);
                self.answer(error);
            }
            // As Grbl: all stops on its ramp, the alarm comes at rest, and the line has no answer.
            Refusal::Travel(_) => self.halt(After::SoftLimit),
        }
    }

    fn carry_out(&mut self, plan: Plan, view: &View) {
        if !plan.orders.is_empty() && !self.check && self.is_taken(view) {
            self.message("a program of the board runs");
            return self.answer(Error::NOT_IDLE);
        }
        let work = self.offsets.work(self.modal.wcs);
        self.modal = plan.modal;
        if let Some(offsets) = plan.offsets {
            self.offsets = *offsets;
            self.kept_changed |= self.kept.note(&self.offsets);
        }
        if self.offsets.work(self.modal.wcs) != work {
            self.due.offset = 0;
        }
        self.at = plan.to;
        if let Some((n, on)) = plan.output {
            let bit = 1 << (n - 1);
            self.outputs = if on { self.outputs | bit } else { self.outputs & !bit };
        }
        if plan.orders.iter().any(|order| {
            matches!(
                order,
                crate::grbl::order::Order::Spindle(..) | crate::grbl::order::Order::Coolant(_)
            )
        }) {
            self.due.overrides = 0;
        }
        self.order(plan.orders, plan.seconds, view);
        if plan.firmware {
            self.say("FIRMWARE_NAME:Grbl FIRMWARE_VERSION:1.1h PROTOCOL_VERSION:1.0");
        }
        match plan.sync {
            // In check mode there is nothing to wait for, nor to probe.
            Some(sync @ (Sync::Place | Sync::Input(_) | Sync::End)) if self.check => {
                self.finish(sync, view);
            }
            Some(sync) if !self.check => self.sync = Some(sync),
            _ => self.say("ok"),
        }
    }

    /// Whether somebody else's run has the board.
    pub(super) fn is_taken(&self, view: &View) -> bool {
        let runs = matches!(
            view.state,
            Some(RunState::Running | RunState::Paused | RunState::Stopping | RunState::WaitStart)
        );
        runs && !view.ours && self.queue.is_empty()
    }

    /// Answers a line that waited for rest.
    pub(super) fn finish(&mut self, sync: Sync, view: &View) {
        let inches = self.kept.inches;
        match sync {
            Sync::Rest => {}
            Sync::End => {
                self.due.overrides = 0;
                self.message("Pgm End");
            }
            Sync::Probe { quiet } => {
                self.at = self.machine.place(view.steps);
                self.offsets.met = view.met;
                self.offsets.probed = self.machine.place(view.probed);
                if !view.met {
                    // As Grbl: where it has come to.
                    self.offsets.probed = self.at;
                }
                let text = self.offsets.probe_text(inches);
                self.say(&text);
                if !view.met && !quiet {
                    self.raise(Alarm { number: 5, critical: false }, "");
                }
            }
            Sync::Home => {
                self.at = self.machine.place(view.steps);
                self.due.offset = 0;
            }
            Sync::Place => {
                let place = self.machine.place(view.steps);
                let work = self.offsets.work(self.modal.wcs);
                let of = |i: usize| length(place[i] - work[i], false);
                let text = format!("X:{} Y:{} Z:{}", of(0), of(1), of(2));
                self.say(&text);
            }
            Sync::Input(n) => {
                let on = view.inputs >> (n - 1) & 1;
                self.say(&format!("[IN:{n}:{on}]"));
            }
        }
        self.say("ok");
    }
}
