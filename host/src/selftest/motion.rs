//! Steps without motors: places, rates, and what comes to rest when.

use std::time::Duration;

use lang::axis::Axis;
use lang::fault::Fault;
use lang::record::BoardRecord;
use lang::wire::{self, Control, command};

use super::{Bench, Trouble};
use crate::client::orders::words;
use crate::client::status::long;
use crate::link::Link;

/// Steps a second, and a second squared.
const SPEED: i64 = 2_000;
const RAMP: i64 = 20_000;
/// Steps of the ramp down from there.
const BRAKE: f64 = (SPEED * SPEED) as f64 / (2.0 * RAMP as f64);
/// What the planner may have ahead (firmware/README.md, Motion), and the exchange's own place in the
/// millisecond.
const AHEAD: Duration = Duration::from_millis(26);
/// An emergency stop is looked at once in a millisecond, and on the G2553 behind the segment that it plans.
const AT_ONCE: Duration = Duration::from_millis(3);
/// How far a rate may be off against the link's clock, beside the chip's clock.
const RATE: f64 = 0.005;
/// Longest wait for an axis to rest.
const PATIENCE: Duration = Duration::from_secs(30);

impl<L: Link> Bench<'_, L> {
    pub(super) fn motion(&mut self) -> Result<(), Trouble> {
        if !self.plan.unplugged {
            self.left_out("motion", "--unplugged says that no motor is there");
            return Ok(());
        }
        if self.plan.jumpers {
            // Limit switches that a wire closes would keep the axes from moving.
            self.open_limits()?;
        }
        for axis in Axis::ALL {
            self.there_and_back(axis)?;
        }
        self.rate()?;
        self.brake()?;
        self.emergency()?;
        if self.plan.jumpers {
            self.emergency_by_contact()?;
        }
        Ok(())
    }

    fn order(&mut self, axis: Axis, distance: i64) -> Result<(), Trouble> {
        let mut order = vec![command::MOVE_BY, axis.index() as u16 + 1];
        for value in [RAMP, SPEED, RAMP, distance] {
            order.extend(words(value));
        }
        let wrong = || "it refuses a move by hand".to_owned();
        self.board.order(&order, wrong).map_err(Trouble::Words)
    }

    pub(super) fn place(&mut self, axis: Axis) -> Result<i64, Trouble> {
        let register = wire::MACHINE_POSITIONS + 2 * axis.index() as u16;
        let words = self.board.holding(register, 2)?;
        Ok(long(words[0], words[1]).into())
    }

    /// Waits until nothing moves; the time from now until then.
    fn rest(&mut self) -> Result<Duration, Trouble> {
        let begun = self.board.link().now();
        loop {
            let moving = self.board.input(wire::MOVING, 1)?[0] & 0xFF;
            let passed = self.board.link().now() - begun;
            if moving == 0 && passed > Duration::from_millis(30) {
                return Ok(passed);
            }
            if passed > PATIENCE {
                let _ = self.board.write_all(wire::COMMAND, &[command::STOP_AXES, 0b111]);
                return Err(Trouble::Words("an axis does not come to rest".to_owned()));
            }
        }
    }

    fn there_and_back(&mut self, axis: Axis) -> Result<(), Trouble> {
        let from = self.place(axis)?;
        let mut found = Vec::new();
        for distance in [500, -500] {
            self.order(axis, distance)?;
            self.rest()?;
            found.push(self.place(axis)? - from);
        }
        let check = format!("{} by 500 steps and back", axis.letter());
        self.row(check, "[500, 0]", format!("{found:?}"), found == [500, 0]);
        Ok(())
    }

    /// Two ways at one speed: their ramps are alike, so the difference is at the speed alone.
    fn rate(&mut self) -> Result<(), Trouble> {
        let mut times = Vec::new();
        for distance in [500, 5_500] {
            self.order(Axis::X, distance)?;
            times.push(self.rest()?.as_secs_f64());
        }
        self.order(Axis::X, -6_000)?;
        self.rest()?;
        let rate = 5_000.0 / (times[1] - times[0]);
        let most = SPEED as f64 * (RATE + if self.has_crystal() { 0.005 } else { 0.03 });
        let expected = format!("{SPEED} steps/s, {most:.0} more or less");
        let good = (rate - SPEED as f64).abs() <= most;
        self.row("step rate", expected, format!("{rate:.1} steps/s"), good);
        Ok(())
    }

    /// Steps from a place read while it moves to its rest, and the time that what is done meanwhile took.
    fn overrun(
        &mut self,
        stop: impl FnOnce(&mut Self) -> Result<(), Trouble>,
    ) -> Result<(f64, Duration), Trouble> {
        self.order(Axis::X, 20_000)?;
        self.board.link().pause(Duration::from_millis(600));
        let asked = self.board.link().now();
        let from = self.place(Axis::X)?;
        stop(self)?;
        let took = self.board.link().now() - asked;
        self.rest()?;
        Ok(((self.place(Axis::X)? - from) as f64, took))
    }

    fn brake(&mut self) -> Result<(), Trouble> {
        let (steps, took) = self.overrun(|bench| {
            Ok(bench.board.write_all(wire::COMMAND, &[command::STOP_AXIS, 1])?)
        })?;
        let most = BRAKE + SPEED as f64 * (took + AHEAD).as_secs_f64();
        let expected = format!("{BRAKE:.0} to {most:.0} steps");
        let good = (BRAKE * 0.9..=most).contains(&steps);
        self.row("stop on a ramp", expected, format!("{steps:.0} steps"), good);
        Ok(())
    }

    fn emergency(&mut self) -> Result<(), Trouble> {
        let (steps, took) =
            self.overrun(|bench| Ok(bench.board.control(Control::EmergencyStop)?))?;
        self.stopped_at_once("emergency stop by register", steps, took)?;
        Ok(self.board.control(Control::Acknowledge)?)
    }

    fn stopped_at_once(&mut self, check: &str, steps: f64, took: Duration) -> Result<(), Trouble> {
        let most = SPEED as f64 * (took + AT_ONCE).as_secs_f64() + 1.0;
        let fault = self.board.holding(wire::FAULT, 1)?[0];
        let wanted = Fault::EmergencyStop as u16;
        let good = steps <= most && fault == wanted;
        let expected = format!("at most {most:.0} steps, fault {wanted}");
        self.row(check, expected, format!("{steps:.0} steps, fault {fault}"), good);
        Ok(())
    }

    /// Outputs at the level at which their wires leave the limit switches open.
    fn open_limits(&mut self) -> Result<(), Trouble> {
        for n in self.record.reference.into_iter().filter(|n| *n != 0) {
            let coil = wire::COILS + u16::from(n) - 1;
            let input = wire::INPUT_BITS + u16::from(n) - 1;
            if self.board.inputs(input, 1)?[0] && self.record.flags & BoardRecord::CHAIN != 0 {
                self.board.set_coil(coil, true)?;
                self.board.link().pause(Duration::from_millis(60));
            }
        }
        Ok(())
    }

    /// Output 1 presses an emergency stop at input 1.
    fn emergency_by_contact(&mut self) -> Result<(), Trouble> {
        const CHECK: &str = "emergency stop by a contact";
        let usual = self.record;
        let resting = self.board.inputs(wire::INPUT_BITS, 1)?[0];
        let input_invert = usual.input_invert | u16::from(resting);
        let emergency = [1, 0, 0, 0];
        let chained = usual.flags & BoardRecord::CHAIN != 0;
        // On a bare LaunchPad input 1 is a reference switch otherwise.
        let reference = if chained { usual.reference } else { [0; 3] };
        self.set_record(BoardRecord { emergency, input_invert, reference, ..usual })?;
        self.open_limits()?;
        let (steps, took) = self.overrun(|bench| Ok(bench.board.set_coil(wire::COILS, true)?))?;
        self.stopped_at_once(CHECK, steps, took)?;
        self.board.set_coil(wire::COILS, false)?;
        self.board.link().pause(Duration::from_millis(60));
        self.board.control(Control::Acknowledge)?;
        self.set_record(BoardRecord { sequence: self.record.sequence, ..usual })
    }
}
