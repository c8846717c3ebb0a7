//! Steps as counts instead of edges, while the pins are not observed and no contact is met.

use super::{Contact, Plant};

impl Contact {
    /// Narrows the least and the greatest place of its motor to those at which it stays as it is.
    fn narrow(&self, [least, greatest]: &mut [i64; 2], at: i64) {
        // It changes between this place and the next one.
        let below = if self.above { self.position - 1 } else { self.position };
        if at <= below {
            *greatest = below.min(*greatest);
        } else {
            *least = (below + 1).max(*least);
        }
    }
}

impl Plant {
    /// Whether somebody takes note of single edges at the pins.
    #[must_use]
    #[inline]
    pub fn is_observed(&self) -> bool {
        self.recorder.active() || !self.jumpers.is_empty()
    }

    /// The steps that each motor may make in its direction before an input can change, or before somebody around the
    /// machine is to be asked. None while a pulse may break the set-up time of DIR.
    #[must_use]
    #[inline]
    pub fn free_steps(&self) -> [u64; 3] {
        let mut quiet = self.around.quiet();
        for contact in self.switches.iter().chain(&self.probes).flatten() {
            if let Some(motor) = self.motors.get(contact.axis) {
                contact.narrow(&mut quiet[contact.axis], motor.position);
            }
        }
        let free = |axis: usize| {
            let (motor, [least, greatest]) = (&self.motors[axis], quiet[axis]);
            if motor.has_turned() {
                return 0;
            }
            let end = if motor.is_negative() { least } else { greatest };
            end.abs_diff(motor.position)
        };
        [0, 1, 2].map(free)
    }

    /// Motors make so many steps, no more than [`Plant::free_steps`], by pulses as the drivers want them. They have ended.
    #[inline]
    pub fn travel(&mut self, steps: [u32; 3]) {
        for (motor, steps) in self.motors.iter_mut().zip(steps) {
            motor.travel(steps.into());
        }
    }

    /// Inputs that are on, input `n` in bit `n - 1`, and above them Start and Stop.
    #[must_use]
    pub fn contacts(&self) -> u32 {
        let [start, stop] = self.around.buttons();
        self.on() | u32::from(self.start || start) << 30 | u32::from(self.stop || stop) << 31
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::Wiring;

    /// A plant with a switch at 5 of X and one at -3 of Y, and the levels that hold its motors in a direction.
    fn plant(negative: bool) -> (Plant, u64) {
        let mut plant = Plant::new(Wiring::Chain);
        plant.switches[0] = Some(Contact { axis: 0, position: 5, above: true });
        plant.switches[1] = Some(Contact { axis: 1, position: -3, above: false });
        let dirs = plant.board().dir.iter().fold(0, |pins, pin| pins | 1 << pin);
        (plant, if negative { 0 } else { dirs })
    }

    fn step(plant: &mut Plant, dirs: u64, at: u64) {
        let steps = plant.board().step.iter().fold(0, |pins, pin| pins | 1 << pin);
        plant.pins(at, dirs);
        plant.pins(at + 100, dirs | steps);
        plant.pins(at + 200, dirs);
    }

    #[test]
    fn steps_in_numbers_end_before_the_step_that_meets_a_contact() {
        for (negative, axis, before) in [(false, 0, 4), (true, 1, -2)] {
            let (mut plant, dirs) = plant(negative);
            step(&mut plant, dirs, 1_000);
            let free = plant.free_steps()[axis];
            let mut steps = [0; 3];
            steps[axis] = free as u32;
            plant.travel(steps);
            assert_eq!(plant.motors[axis].position, before);
            assert_eq!(plant.motors[axis].pulses, 1 + free);
            assert_eq!((plant.contacts(), plant.free_steps()[axis]), (0, 0));
            step(&mut plant, dirs, 2_000);
            assert_eq!(plant.contacts(), 1 << (plant.reference_input(axis) - 1));
            assert!(plant.free_steps()[axis] > 1_000_000, "beyond a switch lies no other");
        }
    }

    #[test]
    fn a_motor_that_has_turned_makes_its_first_step_by_edges() {
        let (mut plant, dirs) = plant(true);
        step(&mut plant, dirs, 1_000);
        let turned = 1 << plant.board().dir[0];
        plant.pins(2_000, turned);
        assert_eq!(plant.free_steps()[0], 0);
        step(&mut plant, turned, 3_000);
        assert_ne!(plant.free_steps()[0], 0);
    }

    #[test]
    fn stalled_steps_are_lost_in_numbers_too() {
        let (mut plant, dirs) = plant(true);
        step(&mut plant, dirs, 1_000);
        plant.stall(2, 3);
        plant.travel([0, 0, 10]);
        assert_eq!((plant.motors[2].position, plant.motors[2].pulses), (-8, 11));
    }
}
