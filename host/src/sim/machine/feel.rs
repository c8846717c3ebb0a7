//! Effects of motion on inputs and outputs: switches, the probe, a laser.

use lang::axis::Axis;
use lang::fault::Fault;

use super::Machine;

impl Machine {
    /// When a moving axis comes to a place where its switch or the plate changes.
    pub(super) fn next_crossing(&self) -> Option<u64> {
        let mut first = None;
        for axis in Axis::ALL {
            if !self.motion.turns(axis) {
                continue;
            }
            for place in self.plant.thresholds(axis, &self.scenario) {
                let at = self.motion.reaches(axis, place, self.clock.now());
                first = first.into_iter().chain(at).min();
            }
        }
        first
    }

    /// Reference switches and probe as they are now.
    pub(super) fn feel_plant(&mut self) {
        let at = self.motion.positions(self.clock.now());
        self.plant.reach(at);
        for axis in Axis::ALL {
            let closed = self.plant.switch_closed(axis, at[axis.index()], &self.scenario);
            self.inputs.sense(self.profile.reference_input(axis), closed, self.clock.now());
        }
        let touches = self.scenario.probe_touches(self.plant.true_positions(at));
        self.inputs.sense(self.profile.probe_input(), touches, self.clock.now());
        self.seek_inputs();
        self.limit_switches();
    }

    /// F06: an axis runs into its closed reference switch outside homing.
    fn limit_switches(&mut self) {
        for axis in Axis::ALL {
            let Some(part) = self.profile.axis(axis) else { continue };
            let toward = part.home.direction.sign();
            if self.search.homing != Some(axis)
                && !self.is_halted()
                && self.motion.direction(axis) == toward
                && self.inputs.raw(self.profile.reference_input(axis))
            {
                self.cut_motion(&[axis], Fault::LimitSwitch);
            }
        }
    }

    /// A laser shines only while an axis turns, and with some power. What the board makes of less
    /// than full power, on and off each millisecond, counts as on here.
    pub(super) fn laser(&mut self) {
        let power = self.pieces.beam.unwrap_or(self.modal.power);
        let turning = power > 0 && Axis::ALL.into_iter().any(|axis| self.motion.turns(axis));
        if self.outputs.shine(turning) {
            self.outputs_changed();
        }
    }

    /// Tells the world and the record which outputs changed.
    pub(super) fn outputs_changed(&mut self) {
        for (n, on) in self.outputs.take_changes() {
            self.log.output(self.clock.now(), n, on);
            self.scenario.output_changed(n, on, self.clock.now());
        }
        self.clock.look_anew();
    }
}
