//! Checks step pulses at the pins against the limits of drivers and motors.

use emulator::plant::motor::{DriverLimits, ViolationKind};
use emulator::{Edge, Plant, Signal};
use firmware::motion::physics::{
    Count, HALF_WINDOW, Machine, Step, TICKS_PER_SECOND, Violation, What,
};
use lang::axis::Axis;
use lang::profile::Profile;
use lang::record::MachineRecord;

/// Steps that are kept; a longer run is judged up to here.
const MOST: usize = 8 << 20;

/// Collects the steps of a run.
#[derive(Clone, Debug)]
pub struct Judge {
    machine: Machine,
    inverted: [bool; 3],
    negative: [bool; 3],
    steps: Vec<Step>,
    /// Lines of statements that move, with the ticks at which they began.
    lines: Vec<(u64, u32)>,
    /// Ramps as the profile has them.
    own: Machine,
    /// The board's ticks in one of physics.
    unit: u64,
}

/// Steepest ramps that are judged, steps/s2. Above that a segment may be shorter than its planning,
/// and steps come late (the firmware's README, Motion); starts and top rates are judged all the same.
const STEEPEST: f64 = 100_000.0;

/// What the drivers of a profile ask of their signals.
pub fn driver_limits(profile: &Profile, ticks_per_second: u64) -> DriverLimits {
    let usual = DriverLimits::usual(ticks_per_second);
    let ticks = |us: u8| u64::from(us) * (ticks_per_second / 1_000_000);
    DriverLimits { pulse: ticks(profile.pulse_us), setup: ticks(profile.dir_setup_us), ..usual }
}

impl Judge {
    /// Begins with the axes as they are.
    pub fn new(profile: &Profile, plant: &Plant) -> Judge {
        let record = MachineRecord::of(profile);
        let own = Machine::of(&record.axes, record.corner);
        let mut machine = own;
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
            lines: Vec::new(),
            own,
            unit: plant.ticks_per_second() / u64::from(TICKS_PER_SECOND),
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
                    let at = edge.cycle / self.unit;
                    if self.steps.last().is_none_or(|step| step.at != at) {
                        self.steps.push(Step { at, by: [0; 3] });
                    }
                    if let Some(step) = self.steps.last_mut() {
                        step.by[i] = if self.negative[i] { -1 } else { 1 };
                    }
                }
                _ => {}
            }
        }
    }

    /// A statement of `line` that moves begins at `tick`.
    pub fn line(&mut self, tick: u64, line: u32) {
        if self.lines.len() < MOST {
            self.lines.push((tick / self.unit, line));
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
            let letter = ["X", "Y", "Z"].get(first.axis).unwrap_or(&"?");
            let place = self.place(first.cycle / self.unit);
            let what = match first.kind {
                ViolationKind::PulseHigh => "STEP was high",
                ViolationKind::PulseLow => "STEP was low",
                ViolationKind::DirSetup => "DIR had stood",
                ViolationKind::DirHold => "DIR changed when STEP had been low",
            };
            let us = first.ticks as f64 * 1e6 / plant.ticks_per_second() as f64;
            return Err(format!(
                "{count} pulses are too short for the profile's drivers, the first of {letter}{place}: \
                 {what} for {us:.2} us only"
            ));
        }
        self.machine.check(&self.steps, abrupt).map_err(|violation| self.describe(&violation))
    }

    /// The violation in words: axis, line, by how much.
    fn describe(&self, violation: &Violation) -> String {
        let at = self.steps.get(violation.step).map_or(0, |step| step.at);
        let place = self.place(at);
        let axis = self.busiest(violation.step);
        let letter = Axis::ALL[axis].letter();
        let own = &self.own.axes[axis];
        let found = violation.found.round();
        let (does, ramp) = match violation.what {
            What::Top => {
                let top = own.top;
                return format!("{letter} makes {found} steps/s{place}; its top rate is {top}");
            }
            What::Start => {
                let (start, most) = (own.start, violation.bound.round());
                return format!(
                    "{letter} leaves or reaches rest with {found} steps/s{place}; with its start \
                     rate of {start} and its ramps {most} is the most"
                );
            }
            What::Bend => {
                let most = violation.bound.round();
                return format!(
                    "{letter} changes its speed by {found} steps/s{place}, where its ramps and one \
                     corner allow {most}"
                );
            }
            What::Accel => ("speeds up", own.accel),
            What::Decel => ("brakes", own.decel),
        };
        let percent = (100.0 * (violation.found / ramp - 1.0)).round();
        format!(
            "{letter} {does} with {found} steps/s2{place}: its ramp is {percent} % steeper than the \
             profile's of {ramp}"
        )
    }

    /// ` in line 4`: of the statement that moved at that tick; nothing where none had begun.
    fn place(&self, tick: u64) -> String {
        let begun = self.lines.partition_point(|(begins, _)| *begins <= tick);
        let line = begun.checked_sub(1).map(|n| format!(" in line {}", self.lines[n].1));
        line.unwrap_or_default()
    }

    /// The axis that makes most of the steps around one of them.
    fn busiest(&self, step: usize) -> usize {
        let last = self.steps.len().min(step + HALF_WINDOW);
        let around = &self.steps[step.saturating_sub(HALF_WINDOW).min(last)..last];
        let made = |axis: &usize| around.iter().filter(|step| step.by[*axis] != 0).count();
        (0..3).rev().max_by_key(made).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use emulator::Board;

    use super::{Judge, Step};
    use crate::board::G2553;
    use lang::profile::Profile;

    /// Steps of X from rest at a constant rate, that of `every` ticks.
    fn judged(every: u64) -> String {
        let board = Board::new(G2553.chip.clone(), &G2553.image().unwrap());
        let mut judge = Judge::new(&Profile::built_in("mill").unwrap(), board.plant());
        judge.line(0, 3);
        judge.line(1_000, 4);
        let steps: Vec<Step> =
            (0..200).map(|n| Step { at: 2_000 + n * every, by: [1, 0, 0] }).collect();
        judge.add(&steps);
        judge.judge(board.plant(), false).map_or_else(|text| text, |_| String::new())
    }

    #[test]
    fn it_names_axis_line_and_measure() {
        assert_eq!(judged(16_000_000 / 400), "");
        let start = judged(16_000_000 / 4_000);
        assert!(
            // An instant is a whole tick: the rate is one over 4000 ticks and one more.
            start.starts_with("X leaves or reaches rest with 3999 steps/s in line 4"),
            "{start}"
        );
        let top = judged(16_000_000 / 10_000);
        assert_eq!(top, "X makes 9994 steps/s in line 4; its top rate is 8000");
    }

    #[test]
    fn a_steep_ramp_is_told_in_percent() {
        let board = Board::new(G2553.chip.clone(), &G2553.image().unwrap());
        let mut judge = Judge::new(&Profile::built_in("mill").unwrap(), board.plant());
        judge.line(0, 7);
        // From the start rate with twice the ramp of 25 000 steps/s2.
        let (mut at, mut rate) = (0.0, 400.0);
        let mut steps = Vec::new();
        for _ in 0..200 {
            steps.push(Step { at: at as u64, by: [0, 0, 1] });
            at += 16_000_000.0 / rate;
            rate += 50_000.0 / rate;
        }
        // Down to rest by the ramp that it has.
        while rate > 400.0 {
            steps.push(Step { at: at as u64, by: [0, 0, 1] });
            at += 16_000_000.0 / rate;
            rate -= 24_000.0 / rate;
        }
        judge.add(&steps);
        let text = judge.judge(board.plant(), false).unwrap_err();
        assert!(
            text.starts_with("Z speeds up with ") && text.contains("steps/s2 in line 7"),
            "{text}"
        );
        assert!(text.ends_with("% steeper than the profile's of 25000"), "{text}");
    }
}
