//! Lines that begin with `$`.

use super::{After, Error, Session};
use crate::grbl::desk::{Deed, View};
use crate::grbl::order::Order;
use crate::grbl::plan::Sync;
use crate::grbl::words::value;

/// The firmware's date in `$I` is that of Grbl 1.1h.
const BUILD: &str = "20190830";
/// V: variable spindle, M: mist coolant; 15 blocks of look-ahead, 128 bytes of serial buffer.
const OPTIONS: &str = "[OPT:VM,15,128]";

impl Session {
    pub(super) fn dollar(&mut self, text: &str, view: &View) {
        let inches = self.kept.inches;
        match text {
            "" => {
                self.say("[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]")
            }
            "$" => {
                for (number, value) in self.machine.settings(self.kept.report, inches) {
                    self.say(&format!("${number}={value}"));
                }
            }
            "#" => {
                let text = self.offsets.text(inches);
                self.out.extend(text.bytes());
            }
            "G" => {
                let text = self.modal.text(inches);
                self.say(&text);
            }
            "I" => {
                self.say(&format!("[VER:1.1h.{BUILD}:Pasapas F5529]"));
                self.say(OPTIONS);
            }
            "N" => {
                self.say("$N0=");
                self.say("$N1=");
            }
            "X" => return self.unlock(view),
            "H" => return self.home(view),
            "C" => return self.toggle_check(view),
            "SLP" => return self.sleep(view),
            _ => return self.written(text, view),
        }
        self.say("ok");
    }

    /// `$X`
    fn unlock(&mut self, view: &View) {
        if let Some(words) = &view.trouble {
            self.message(words);
            return self.answer(Error::LOCKED);
        }
        if self.alarm.take().is_some() {
            self.message("Caution: Unlocked");
            if view.state == Some(lang::wire::RunState::Fault) {
                self.deeds.push(Deed::Acknowledge);
            }
            if std::mem::take(&mut self.undriven) {
                self.order(vec![Order::Motors(true)], 0.0, view);
            }
        }
        self.say("ok");
    }

    /// `$H`
    fn home(&mut self, view: &View) {
        // A jog may be cancelled, a reference run and its answer may not.
        if self.sleeping || self.check || self.hold || self.is_jogging(view) {
            return self.answer(Error::NOT_IDLE);
        }
        if let Some(words) = &view.trouble {
            self.message(words);
            return self.answer(Error::LOCKED);
        }
        if self.is_taken(view) {
            self.message("a program of the board runs");
            return self.answer(Error::NOT_IDLE);
        }
        if self.machine.axes.iter().all(Option::is_none) {
            return self.answer(Error::HOMING_OFF);
        }
        let mut orders = Vec::new();
        if self.alarm.take().is_some() {
            self.deeds.push(Deed::Acknowledge);
        }
        if std::mem::take(&mut self.undriven) {
            orders.push(Order::Motors(true));
        }
        orders.push(Order::Home);
        self.order(orders, 0.0, view);
        self.sync = Some(Sync::Home);
    }

    /// `$C`
    fn toggle_check(&mut self, view: &View) {
        if self.check {
            self.message("Disabled");
            self.say("ok");
            // As Grbl: what the lines would have set is forgotten.
            self.halt(After::Reset);
            return;
        }
        if self.alarm.is_some() || self.is_moving(view) {
            return self.answer(Error::NOT_IDLE);
        }
        self.check = true;
        self.message("Enabled");
        self.say("ok");
    }

    /// `$SLP`
    fn sleep(&mut self, view: &View) {
        if self.is_moving(view) {
            return self.answer(Error::NOT_IDLE);
        }
        self.say("ok");
        self.message("Sleeping");
        // A board with a latched fault takes no order.
        if self.alarm.is_none() {
            self.order(vec![Order::Motors(false)], 0.0, view);
            self.undriven = true;
        }
        self.sleeping = true;
    }

    /// Whether lines are under way or something else runs.
    fn is_moving(&self, view: &View) -> bool {
        self.last != view.done || self.hold || self.is_taken(view)
    }

    /// `$n=`, `$J=`, `$RST=`, `$N0=`
    fn written(&mut self, text: &str, view: &View) {
        let Some((name, new)) = text.split_once('=') else { return self.answer(Error::STATEMENT) };
        match name {
            "J" => return self.jog(new, view),
            "RST" => return self.restore(new),
            "N0" | "N1" if new.is_empty() => return self.say("ok"),
            "N0" | "N1" => {
                self.message("no start-up lines here: let a program of the board do it");
                return self.answer(Error::STATEMENT);
            }
            _ => {}
        }
        let Ok(number) = name.parse::<u16>() else { return self.answer(Error::STATEMENT) };
        let Some(new) = value(new) else { return self.answer(Error::NUMBER) };
        match number {
            10 if new.fract() == 0.0 && (0.0..=255.0).contains(&new) => {
                self.kept_changed |= self.kept.report != new as u8;
                self.kept.report = new as u8;
            }
            13 if new == 0.0 || new == 1.0 => {
                self.kept_changed |= self.kept.inches != (new == 1.0);
                self.kept.inches = new == 1.0;
            }
            10 | 13 if new < 0.0 => return self.answer(Error::NEGATIVE),
            10 | 13 => return self.answer(Error::STATEMENT),
            _ => {
                if let Err((error, words)) = self.machine.write(number, new) {
                    if !words.is_empty() {
                        self.message(&words);
                    }
                    return self.answer(error);
                }
            }
        }
        self.say("ok");
    }

    /// `$RST=`
    fn restore(&mut self, what: &str) {
        if !matches!(what, "$" | "#" | "*") {
            return self.answer(Error::STATEMENT);
        }
        if what != "$" {
            let met = (self.offsets.probed, self.offsets.met);
            self.offsets = crate::grbl::modal::Offsets::default();
            (self.offsets.probed, self.offsets.met) = met;
            self.kept.note(&self.offsets);
            self.due.offset = 0;
        }
        if what != "#" {
            (self.kept.report, self.kept.inches) = (1, false);
        }
        self.kept_changed = true;
        self.message("Restoring defaults");
        self.say("ok");
    }
}
