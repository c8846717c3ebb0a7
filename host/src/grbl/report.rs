//! The status report that answers `?`.

use lang::wire::RunState;

use super::desk::View;
use super::modal::{INCH, Point, Spindle, point};
use super::session::{Alarm, Session};

/// Reports from one WCO field to the next, idle and busy.
const WCO: [u8; 2] = [10, 30];
/// Reports from one Ov field to the next, idle and busy.
const OVERRIDES: [u8; 2] = [10, 20];

/// When the fields that come now and then are due.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Due {
    /// Reports until WCO.
    pub offset: u8,
    /// Reports until Ov.
    pub overrides: u8,
}

impl Session {
    /// What Grbl would call this state.
    pub fn state(&self, view: &View) -> &'static str {
        let runs = matches!(view.state, Some(RunState::Running | RunState::Stopping));
        if self.sleeping {
            return "Sleep";
        }
        if self.alarm.is_some() {
            return "Alarm";
        }
        if self.check {
            return "Check";
        }
        if self.is_jogging(view) {
            return "Jog";
        }
        if self.is_stopping() {
            return "Hold:1";
        }
        let waits = matches!(view.state, Some(RunState::Paused | RunState::WaitStart));
        if self.door || view.blocked || waits && self.door_is_open(view) {
            return match (self.door_is_open(view), runs) {
                (_, true) => "Door:2",
                (true, false) => "Door:1",
                (false, false) => "Door:0",
            };
        }
        if self.hold || waits || view.state == Some(RunState::Stopping) {
            return if runs { "Hold:1" } else { "Hold:0" };
        }
        if self.is_homing() {
            return "Home";
        }
        let foreign = runs && !view.ours;
        if self.is_busy(view) || foreign { "Run" } else { "Idle" }
    }

    fn door_is_open(&self, view: &View) -> bool {
        self.pins.door != 0 && view.inputs & self.pins.door != 0
    }

    /// The report, which is due for its rarer fields now and then.
    pub fn status(&mut self, view: &View) -> String {
        let state = self.state(view);
        let inches = self.kept.inches;
        let place = self.machine.place(view.steps);
        let work = self.offsets().work(self.modal.wcs);
        let mut text = format!("<{state}");
        if self.kept.report & 1 != 0 {
            text += &format!("|MPos:{}", point(&place, inches));
        } else {
            let own: Point = [0, 1, 2].map(|i| place[i] - work[i]);
            text += &format!("|WPos:{}", point(&own, inches));
        }
        let busy = usize::from(self.is_busy(view));
        if self.kept.report & 2 != 0 {
            let free = 15usize.saturating_sub(self.ahead(view));
            text += &format!("|Bf:{free},128");
        }
        let speed = if inches { view.speed / INCH } else { view.speed };
        let power = if self.modal.spindle == Spindle::Off { 0.0 } else { self.modal.speed };
        text += &format!("|FS:{speed:.0},{power:.0}");
        text += &self.pins_text(view);
        if self.due.offset == 0 {
            self.due.offset = WCO[busy];
            // The overrides come one report later at the earliest.
            self.due.overrides = self.due.overrides.max(1);
            text += &format!("|WCO:{}", point(&work, inches));
        } else if self.due.overrides == 0 {
            self.due.overrides = OVERRIDES[busy];
            let [feed, rapid, speed] = self.overrides;
            text += &format!("|Ov:{feed},{rapid},{speed}");
            let mut on = String::new();
            match self.modal.spindle {
                Spindle::Off => {}
                Spindle::Clockwise => on.push('S'),
                Spindle::CounterClockwise => on.push('C'),
            }
            if self.modal.flood {
                on.push('F');
            }
            if self.modal.mist {
                on.push('M');
            }
            if !on.is_empty() {
                text += &format!("|A:{on}");
            }
        }
        self.due.offset = self.due.offset.saturating_sub(1);
        self.due.overrides = self.due.overrides.saturating_sub(1);
        text + ">\r\n"
    }

    fn pins_text(&self, view: &View) -> String {
        let mut on = String::new();
        for (i, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            if view.limits >> i & 1 != 0 {
                on.push(letter);
            }
        }
        let pins = &self.pins;
        for (mask, letter) in [
            (pins.probe, 'P'),
            (pins.door, 'D'),
            (pins.hold, 'H'),
            (pins.stop, 'R'),
            (pins.start, 'S'),
        ] {
            if view.inputs & mask != 0 {
                on.push(letter);
            }
        }
        if on.is_empty() { on } else { format!("|Pn:{on}") }
    }

    /// The line that tells of an alarm.
    pub(super) fn alarm_text(alarm: Alarm) -> String {
        format!("ALARM:{}", alarm.number)
    }
}
