//! An axis on its own ramp: MoveAxe, MoveRel, START, MoveSpeed, homing and probing.
//!
//! Units are 1/256 step, so that slow speeds keep their precision. The target may change at any
//! time: the axis turns round on its ramp if it must.

use super::limits::AxisLimits;
use super::math::mul_div;
use super::ramp::{Ramp, Segment, Stretch};

/// 1/256 step is the unit of length.
const UNITS: u32 = 256;

/// A speed or a ramp of one axis, 1/256 step/s or steps/s2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pace {
    /// Speed, 1/256 step/s.
    pub speed: u32,
    /// Ramp up, steps/s2.
    pub accel: u32,
    /// Ramp down, steps/s2.
    pub decel: u32,
}

impl Pace {
    /// The axis's top rate and its ramps.
    pub fn of(axis: &AxisLimits) -> Pace {
        Pace { speed: axis.top.saturating_mul(UNITS), accel: axis.accel, decel: axis.decel }
    }

    /// With another speed, um/s, not above the axis's top.
    #[must_use]
    pub fn with_um(mut self, axis: &AxisLimits, um: u32) -> Pace {
        let units = mul_div(um, u32::from(axis.steps) * UNITS, u32::from(axis.um));
        self.speed = self.speed.min(units.max(1));
        self
    }

    /// With another speed, steps/s, not above the axis's top.
    #[must_use]
    pub fn with_steps(mut self, steps: u32) -> Pace {
        self.speed = self.speed.min(steps.max(1).saturating_mul(UNITS));
        self
    }
}

/// The planner of one independent axis.
#[derive(Clone, Copy, Debug, Default)]
pub struct Single {
    ramp: Ramp,
    /// Where the axis is when every segment handed out has been played, steps.
    position: i32,
    target: i32,
    pace: Option<Pace>,
    negative: bool,
    paused: bool,
}

impl Single {
    /// A resting axis at `position` steps.
    pub fn new(position: i32) -> Single {
        Single { position, target: position, ..Single::default() }
    }

    /// Where the axis is when every segment handed out has been played, steps.
    pub fn position(&self) -> i32 {
        self.position
    }

    /// Whether nothing is left to do.
    pub fn is_idle(&self) -> bool {
        self.pace.is_none()
    }

    /// Whether the last segments move in negative direction.
    pub fn negative(&self) -> bool {
        self.negative
    }

    /// Goes to `target` steps; a moving axis turns toward it on its ramp.
    pub fn go(&mut self, axis: &AxisLimits, target: i32, pace: Pace) {
        self.target = target;
        self.begin(axis, pace);
    }

    /// The next segment; `None` when idle or in a pause.
    pub fn next_segment(&mut self, _axis: &AxisLimits) -> Option<Segment> {
        self.pace?;
        let Some(segment) = self.ramp.next_segment() else {
            if self.ramp.left() == 0 {
                self.pace = None;
            }
            return None;
        };
        let steps = i32::from(segment.steps());
        self.position += if self.negative { -steps } else { steps };
        if self.ramp.left() == 0 {
            self.pace = None;
        }
        Some(segment)
    }

    /// Ramps down to a pause (`true`), or goes on with the rest.
    pub fn pause(&mut self, on: bool) {
        self.paused = on;
        self.ramp.brake(on);
    }

    /// Starts a ramp toward the target from the present speed.
    fn begin(&mut self, axis: &AxisLimits, pace: Pace) {
        let distance = self.target.abs_diff(self.position);
        self.negative = self.target < self.position;
        if distance == 0 {
            self.pace = None;
            return;
        }
        let start = axis.start.saturating_mul(UNITS).min(pace.speed);
        self.ramp = Ramp::new(&Stretch {
            events: distance,
            length: UNITS,
            per: 1,
            entry: start,
            start,
            nominal: pace.speed,
            top: axis.top.saturating_mul(UNITS),
            exit: start,
            accel: pace.accel.saturating_mul(UNITS),
            decel: pace.decel.saturating_mul(UNITS),
        });
        self.ramp.brake(self.paused);
        self.pace = Some(pace);
    }
}
