//! Moves that end at an input: Home and Probe.

use lang::axis::Axis;
use lang::effect::{Coord, Rate, Sensor};
use lang::fault::Fault;
use lang::place::Place;

use super::Machine;
use super::axes::scaled;
use super::search::{Seek, Target};
use crate::sim::record::SegmentKind;
use crate::sim::trace::{AxisLetter, What};

/// The board looks at a switch once in a millisecond; what the axis does next may be fetched by then.
const LOOK_US: u64 = 1_000;

impl Machine {
    /// An input may have changed: a move that looks for it reacts.
    pub(super) fn seek_inputs(&mut self) {
        let Some(seek) = self.search.seek.filter(|seek| seek.caught.is_none()) else { return };
        if self.satisfied(&seek) {
            let caught = self.motion.positions(self.clock.now())[seek.axis.index()];
            self.search.seek = Some(Seek { caught: Some(caught), ..seek });
            // Only where the switch opens counts: on the fast way to it the axis just ramps down.
            if matches!(seek.target, Target::Reference(true)) {
                self.motion.stop(seek.axis, self.clock.now() + LOOK_US);
            } else {
                self.motion.hit(seek.axis, self.clock.now());
            }
            self.log_milestones();
            self.clock.look_anew();
        }
    }

    fn satisfied(&self, seek: &Seek) -> bool {
        match seek.target {
            Target::Reference(on) => self.inputs.raw(self.profile.reference_input(seek.axis)) == on,
            Target::Sensor(Sensor::Default) => self.inputs.raw(self.profile.probe_input()),
            Target::Sensor(Sensor::Input { n, on }) => self.inputs.raw(n) == on,
            Target::Sensor(Sensor::Mask { and, xor }) => (self.inputs.raw_port() & and) ^ xor != 0,
        }
    }

    /// Moves toward `to` until `target` holds; where it did.
    fn seek(
        &mut self,
        axis: Axis,
        target: Target,
        to: i32,
        speed: Rate,
        kind: SegmentKind,
    ) -> Result<Option<i32>, Fault> {
        let pace = self.pace(axis, [Some(speed), None, None])?;
        self.search.seek = Some(Seek { axis, target, caught: None });
        self.begin_solo(axis, kind, to);
        self.motion.go(axis, to, pace, self.clock.now());
        self.log_milestones();
        self.rest_solo(axis);
        let caught = self.search.seek.take().and_then(|seek| seek.caught);
        self.adopt(axis);
        Ok(caught)
    }

    fn rest_before(&mut self, axis: Axis) -> Result<(), Fault> {
        if !self.axes.is_present(axis) || self.axes.is_running(axis) {
            return Err(Fault::ValueRange);
        }
        self.rest_solo(axis);
        Ok(())
    }

    /// Home.
    pub(super) fn home(&mut self, axis: Axis, query: bool) -> Result<(), Fault> {
        self.rest_before(axis)?;
        self.axes.set_homed(axis, false);
        self.search.homing = Some(axis);
        let outcome = self.reference_run(axis);
        self.search.homing = None;
        self.search.seek = None;
        if self.is_halted() {
            return Ok(());
        }
        let pos = self.motion.positions(self.clock.now())[axis.index()];
        let ok = outcome.is_ok();
        self.write(What::Home { line: self.line, axis: AxisLetter(axis), ok, pos });
        match outcome {
            Ok(()) => {
                self.axes.set_homed(axis, true);
                Ok(())
            }
            Err(Fault::HomeNotFound) if query => Ok(()),
            Err(fault) => Err(fault),
        }
    }

    /// Fast to the switch, pause, slow back until it opens, clearance (InterpCNC command 106).
    fn reference_run(&mut self, axis: Axis) -> Result<(), Fault> {
        let Some(part) = self.profile.axis(axis) else { return Err(Fault::ValueRange) };
        let home = part.home.clone();
        let toward = home.direction.sign();
        let kind = SegmentKind::Home;
        self.plant.put_switch(axis);
        let input = self.profile.reference_input(axis);
        let stroke = self.axes.to_steps(axis, home.stroke_um)?;
        let reach = |from: i32, steps: i32| from.checked_add(steps).ok_or(Fault::Overflow);
        if !self.inputs.raw(input) {
            let here = self.motion.positions(self.clock.now())[axis.index()];
            let to = reach(here, stroke.saturating_mul(toward))?;
            let fast = Rate::Steps(home.fast_rate);
            let found = self.seek(axis, Target::Reference(true), to, fast, kind)?;
            if self.is_halted() {
                return Ok(());
            }
            if found.is_none() {
                return Err(Fault::HomeNotFound);
            }
        }
        let until = self.run_clock() + u64::from(home.pause_ms) * 1_000;
        self.clock.look_anew();
        while !self.is_halted() && (self.pause.is_on() || self.run_clock() < until) {
            let deadline = (!self.pause.is_on()).then(|| self.pause.at_run_clock(until));
            self.tick(deadline);
        }
        let here = self.motion.positions(self.clock.now())[axis.index()];
        let to = reach(here, stroke.saturating_mul(-toward))?;
        let slow = Rate::Steps(home.slow_rate);
        let opened = self.seek(axis, Target::Reference(false), to, slow, kind)?;
        if self.is_halted() {
            return Ok(());
        }
        let Some(opened) = opened else { return Err(Fault::HomeStaysClosed) };
        let rest = self.motion.positions(self.clock.now())[axis.index()];
        let zero = self.axes.to_steps(axis, home.position_um)?;
        let now_at = zero + (rest - opened);
        self.plant.rename(axis, rest, now_at);
        self.motion.set_position(axis, now_at);
        self.axes.adopt(axis, now_at);
        self.axes.clear_offset(axis);
        let um = home.position_um - toward * home.clearance_um;
        let place = Place { um, steps: self.axes.to_steps(axis, um)? };
        if place.steps != now_at {
            let pace = self.pace(axis, [Some(Rate::Steps(home.fast_rate)), None, None])?;
            self.begin_solo(axis, kind, place.steps);
            self.motion.go(axis, place.steps, pace, self.clock.now());
            self.log_milestones();
            self.rest_solo(axis);
        }
        if !self.is_halted() {
            self.axes.adopt(axis, place.steps);
        }
        Ok(())
    }

    /// Probe, ProbeMask, G38.2, G38.3.
    pub(super) fn probe(
        &mut self,
        axis: Axis,
        limit: Coord,
        speed: Option<Rate>,
        sensor: Sensor,
        query: bool,
    ) -> Result<(), Fault> {
        self.rest_before(axis)?;
        if self.is_halted() {
            return Ok(());
        }
        if let Sensor::Input { n, .. } = sensor {
            self.inputs.read(n)?;
        }
        let speed = match speed.or(self.modal.feed) {
            Some(speed) => super::perform::positive(speed)?,
            None => Rate::Um(self.profile.default_feed_um_s.ok_or(Fault::SpeedRange)?),
        };
        let to = self.axes.aim(axis, limit, self.axes.place(axis))?;
        self.axes.set_probed(axis, None);
        let line = self.line;
        let letter = AxisLetter(axis);
        let seek = Seek { axis, target: Target::Sensor(sensor), caught: None };
        if self.satisfied(&seek) {
            let pos = self.axes.steps(axis);
            self.write(What::Probe { line, axis: letter, ok: false, pos });
            return Err(Fault::InputActive);
        }
        let speed = match speed {
            Rate::Um(um) => {
                let record = self.motion.record(axis);
                Rate::Steps(scaled(um, record.steps, record.um).unwrap_or(i32::MAX).max(1))
            }
            steps @ Rate::Steps(_) => steps,
        };
        let caught = self.seek(axis, seek.target, to.steps, speed, SegmentKind::Probe)?;
        if self.is_halted() {
            return Ok(());
        }
        let pos = caught.unwrap_or(self.motion.positions(self.clock.now())[axis.index()]);
        self.axes.set_probed(axis, caught);
        self.write(What::Probe { line, axis: letter, ok: caught.is_some(), pos });
        if caught.is_none() && !query {
            return Err(Fault::ProbeMissed);
        }
        Ok(())
    }
}
