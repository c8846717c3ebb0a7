//! `$J=`: jog moves, which a single byte cancels.

use super::{Error, Session};
use crate::grbl::desk::View;
use crate::grbl::modal::INCH;
use crate::grbl::order::Order;
use crate::grbl::plan::{Refusal, feed, target, um};
use crate::grbl::words::words;

impl Session {
    /// Takes what stands behind `$J=`. Modal words stay as they are.
    pub(super) fn jog(&mut self, text: &str, view: &View) {
        if !matches!(self.state_beside_this_line(view), "Idle" | "Jog") {
            return self.answer(Error::NOT_IDLE);
        }
        match self.jog_to(text, view) {
            Ok((order, to, seconds)) => {
                self.at = to;
                if let Some(order) = order {
                    self.jogging = true;
                    self.order(vec![order], seconds, view);
                }
                self.say("ok");
            }
            // A jog that leads out of the travel is no alarm.
            Err(Refusal::Travel(_)) => self.answer(Error::TRAVEL),
            Err(refusal) => self.refuse(refusal),
        }
    }

    /// The state as if no line waited.
    fn state_beside_this_line(&mut self, view: &View) -> &'static str {
        let lines = std::mem::take(&mut self.lines);
        let state = self.state(view);
        self.lines = lines;
        state
    }

    fn jog_to(&self, text: &str, view: &View) -> Result<(Option<Order>, [f64; 3], f64), Refusal> {
        let (mut axes, mut speed) = ([None; 3], None);
        let (mut inches, mut relative, mut machine) =
            (self.modal.inches, self.modal.relative, false);
        let mut seen = 0u32;
        for (letter, value) in words(text)? {
            let bit = match (letter, value) {
                ('G', 20.0 | 21.0) => {
                    inches = value == 20.0;
                    1
                }
                ('G', 90.0 | 91.0) => {
                    relative = value == 91.0;
                    2
                }
                ('G', 53.0) => {
                    machine = true;
                    4
                }
                ('F', _) => {
                    speed = Some(value);
                    8
                }
                ('X' | 'Y' | 'Z', _) => {
                    let axis = usize::from(letter as u8 - b'X');
                    axes[axis] = Some(value);
                    16 << axis
                }
                ('N', _) => 128,
                _ => return Err(Error::JOG.into()),
            };
            if seen & bit != 0 {
                return Err(Error::REPEATED.into());
            }
            seen |= bit;
        }
        let speed = speed.ok_or(Error::NO_FEED)?;
        if speed < 0.0 {
            return Err(Error::NEGATIVE.into());
        }
        if speed == 0.0 {
            return Err(Error::NO_FEED.into());
        }
        if axes == [None; 3] {
            return Err(Error::NO_AXIS.into());
        }
        let scale = if inches { INCH } else { 1.0 };
        let work = self.offsets.work(self.modal.wcs);
        let mut to = self.at;
        for (i, word) in axes.into_iter().enumerate() {
            let Some(value) = word.map(|value| value * scale) else { continue };
            to[i] = match (machine, relative) {
                (true, _) => value,
                (_, true) => self.at[i] + value,
                (_, false) => value + work[i],
            };
            um(to[i])?;
        }
        let goal = target(&self.here(view), self.at, to)?;
        let feed = feed(speed * scale);
        let way = (0..3).map(|i| (to[i] - self.at[i]).powi(2)).sum::<f64>().sqrt();
        let seconds = way * 1000.0 / f64::from(feed);
        // A laser stays dark.
        let power = self.machine.power.filter(|_| self.machine.laser).map(|_| 0);
        let order = (goal != [None; 3]).then_some(Order::Line { to: goal, feed, power });
        Ok((order, to, seconds))
    }
}
