//! Step pulses at the pins, held to what drivers and motors can follow.

use emulator::plant::motor::DriverLimits;
use emulator::{Edge, Plant, Signal};
use firmware::motion::physics::{Count, Machine, Step};
use lang::axis::Axis;
use lang::profile::Profile;
use lang::record::MachineRecord;

use super::rig::TICKS_PER_US;

/// Steps that are kept; a longer run is judged up to here.
const MOST: usize = 8 << 20;

/// Collects the steps of a run.
#[derive(Clone, Debug)]
pub struct Judge {
    machine: Machine,
    inverted: [bool; 3],
    negative: [bool; 3],
    steps: Vec<Step>,
}

/// Steepest ramps that are judged, steps/s2. Above that a segment may be shorter than its planning,
/// and steps come late (the firmware's README, Motion); starts and top rates are judged all the same.
const STEEPEST: f64 = 100_000.0;

/// What the drivers of a profile ask of their signals.
pub fn driver_limits(profile: &Profile) -> DriverLimits {
    let usual = DriverLimits::default();
    let ticks = |us: u8| u64::from(us) * TICKS_PER_US;
    DriverLimits { pulse: ticks(profile.pulse_us), setup: ticks(profile.dir_setup_us), ..usual }
}

impl Judge {
    /// Begins with the axes as they are.
    pub fn new(profile: &Profile, plant: &Plant) -> Judge {
        let record = MachineRecord::of(profile);
        let mut machine = Machine::of(&record.axes, record.corner);
        for axis in &mut machine.axes {
            for ramp in [&mut axis.accel, &mut axis.decel] {
                if *ramp > STEEPEST {
                    *ramp = f64::INFINITY;
                }
            }
        }
        Judge {
            machine,
            inverted: Axis::ALL.map(|axis| profile.axis(axis).is_some_and(|own| own.invert)),
            negative: plant.motors.each_ref().map(|motor| motor.is_negative()),
            steps: Vec::new(),
        }
    }

    /// Takes the edges that came since the last call, in order.
    pub fn take(&mut self, edges: &[Edge]) {
        for edge in edges {
            match edge.signal {
                Signal::Dir(axis) => {
                    let i = usize::from(axis);
                    self.negative[i] = edge.level == self.inverted[i];
                }
                Signal::Step(axis) if edge.level && self.steps.len() < MOST => {
                    let i = usize::from(axis);
                    if self.steps.last().is_none_or(|step| step.at != edge.cycle) {
                        self.steps.push(Step { at: edge.cycle, by: [0; 3] });
                    }
                    if let Some(step) = self.steps.last_mut() {
                        step.by[i] = if self.negative[i] { -1 } else { 1 };
                    }
                }
                _ => {}
            }
        }
    }

    /// Takes steps that were made behind those taken so far.
    pub fn add(&mut self, steps: &[Step]) {
        self.steps.extend_from_slice(steps);
    }

    /// Every step so far.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Holds the steps to the profile's start rates, top rates and ramps, and all pulses that the
    /// plant has seen to its drivers' limits; `abrupt`: the last motion was stopped at once.
    ///
    /// # Errors
    /// The first violation, in words.
    pub fn judge(&self, plant: &Plant, abrupt: bool) -> Result<Count, String> {
        if let Some(first) = plant.violations().first() {
            let count = plant.violation_count;
            return Err(format!(
                "{count} pulses break a limit of the drivers, the first: {first:?}"
            ));
        }
        self.machine.check(&self.steps, abrupt).map_err(|violation| {
            let at = self.steps.get(violation.step).map_or(0, |step| step.at);
            format!("no motor follows the step at tick {at}: {violation:?}")
        })
    }
}
