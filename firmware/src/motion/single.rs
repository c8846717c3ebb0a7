//! An axis on its own ramp: MoveAxe, MoveRel, START, MoveSpeed, homing and probing.
//!
//! Units are 1/256 step, so that slow speeds keep their precision. The target may change at any
//! time: the axis passes it and turns round on its ramp if it must.

use super::math::mul_div;
use super::ramp::{Ramp, Segment, Stretch};
use lang::record::AxisRecord;

/// 1/256 step is the unit of length.
const UNITS: u32 = 256;

/// Time from a hit to the earliest change of speed: what the engine holds may play 24 ms.
const LATENCY_MS: u32 = 24;

/// Far enough for MoveSpeed without a limit: 2^29 steps are an hour and a half at 100 000/s.
const FAR: u32 = 1 << 29;

/// A speed and the ramps to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
    pub fn of(axis: &AxisRecord) -> Pace {
        Pace { speed: axis.top_rate.saturating_mul(UNITS), accel: axis.accel, decel: axis.decel }
    }

    /// With another speed, um/s, not above the axis's top.
    #[must_use]
    pub fn with_um(mut self, axis: &AxisRecord, um: u32) -> Pace {
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

/// What an axis is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum State {
    /// At rest.
    #[default]
    Idle,
    /// On the way to its target.
    Going,
    /// Braking, the target lies behind.
    Turning,
    /// Braking to rest.
    Stopping,
}

/// The planner of one independent axis.
#[derive(Clone, Copy, Debug, Default)]
pub struct Single {
    ramp: Ramp,
    position: i32,
    target: i32,
    pace: Pace,
    state: State,
    negative: bool,
    paused: bool,
    /// Percent of the commanded speed; 0 stands for 100.
    percent: u8,
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

    /// Where it is going, steps.
    pub fn target(&self) -> i32 {
        self.target
    }

    /// Whether every segment has been handed out and the axis comes to rest with them.
    pub fn is_idle(&self) -> bool {
        self.state == State::Idle
    }

    /// Whether a pause has been reached.
    pub fn is_paused(&self) -> bool {
        self.paused && (self.state == State::Idle || self.ramp.at_rest())
    }

    /// Direction of the segment handed out last.
    pub fn negative(&self) -> bool {
        self.negative
    }

    /// Speed at the end of the segment handed out last, steps/s with sign.
    pub fn velocity(&self) -> i32 {
        let speed = match self.state {
            State::Idle => 0,
            _ => (self.ramp.velocity() / UNITS) as i32,
        };
        if self.negative { -speed } else { speed }
    }

    /// Goes to `target` steps, also from a motion under way.
    pub fn go(&mut self, axis: &AxisRecord, target: i32, pace: Pace) {
        let moving = match self.state {
            State::Idle => None,
            _ => Some(self.ramp.velocity()),
        };
        self.target = target;
        self.pace = pace;
        let distance = target.wrapping_sub(self.position);
        let Some(speed) = moving else {
            self.begin(axis, distance);
            return;
        };
        if distance != 0 && (distance < 0) == self.negative {
            self.ramp = self.stretch(axis, distance.unsigned_abs(), speed);
            if self.ramp.can_stop() {
                self.state = State::Going;
                self.brake();
                return;
            }
        }
        // Too near, or behind: away from here on a ramp, then back.
        self.ramp = self.stretch(axis, FAR, speed);
        self.state = State::Turning;
        self.brake();
    }

    /// Runs at a speed (MoveSpeed) until stopped, at the furthest to `limit` steps, where the axis
    /// comes to rest.
    pub fn run(&mut self, axis: &AxisRecord, negative: bool, limit: Option<i32>, pace: Pace) {
        let far = if negative { -(FAR as i32) } else { FAR as i32 };
        self.go(axis, limit.unwrap_or(self.position.wrapping_add(far)), pace);
    }

    /// Ramps down to rest and forgets the target.
    pub fn stop(&mut self) {
        if self.state != State::Idle {
            self.state = State::Stopping;
            self.brake();
        }
    }

    /// Reacts to a probe or switch that answered at the step to `caught`: an axis no faster than
    /// its start rate stands still there, and `true` says that the engine must drop the rest of
    /// what it holds; a faster one stops on its ramp. Where it rests depends on `caught` and the
    /// pace alone, not on how far ahead the engine was fed.
    pub fn hit(&mut self, axis: &AxisRecord, caught: i32) -> bool {
        let start = u32::from(axis.start_rate) * UNITS;
        if self.pace.speed <= start {
            *self = Single::new(caught);
            return true;
        }
        let steps = self.pace.speed / UNITS;
        let ramp = mul_div(steps, steps, self.pace.decel.saturating_mul(2).max(1));
        let rest = ramp.saturating_add(mul_div(steps, LATENCY_MS, 1000)) as i32 + 1;
        let rest = if self.negative { caught - rest } else { caught + rest };
        let beyond = if self.negative { rest < self.target } else { rest > self.target };
        if !beyond {
            self.go(axis, rest, self.pace);
        }
        false
    }

    /// Stands still at `position` at once (emergency stop, limit switch): the engine has dropped
    /// everything.
    pub fn halt(&mut self, position: i32) {
        *self = Single::new(position);
    }

    /// Ramps down to a pause (`true`), or goes on with the rest.
    pub fn pause(&mut self, on: bool) {
        self.paused = on;
        self.brake();
    }

    /// Speed override, 10 to 200 percent of the commanded speed, never above the axis's top.
    pub fn set_override(&mut self, axis: &AxisRecord, percent: u8) {
        self.percent = percent.clamp(10, 200);
        if self.state != State::Idle {
            self.ramp.nominal(self.nominal(axis));
        }
    }

    /// The next segment; `None` when idle or in a pause.
    pub fn next_segment(&mut self, axis: &AxisRecord) -> Option<Segment> {
        if self.state == State::Idle {
            return None;
        }
        if self.state == State::Turning && self.ramp.at_rest() && !self.paused {
            self.begin(axis, self.target.wrapping_sub(self.position));
        }
        let Some(segment) = self.ramp.next_segment() else {
            if self.state == State::Stopping {
                self.rest();
            }
            return None;
        };
        let steps = i32::from(segment.steps());
        let steps = if self.negative { -steps } else { steps };
        self.position = self.position.wrapping_add(steps);
        if self.state == State::Going && self.ramp.left() == 0 {
            self.state = State::Idle;
        }
        if self.state == State::Stopping && self.ramp.at_rest() {
            self.rest();
        }
        Some(segment)
    }

    /// Comes to rest where the axis is.
    fn rest(&mut self) {
        self.state = State::Idle;
        self.target = self.position;
    }

    /// Starts from rest.
    fn begin(&mut self, axis: &AxisRecord, distance: i32) {
        if distance == 0 {
            self.state = State::Idle;
            return;
        }
        self.negative = distance < 0;
        self.ramp = self.stretch(axis, distance.unsigned_abs(), 0);
        self.state = State::Going;
        self.brake();
    }

    /// Tells the ramp whether to brake.
    fn brake(&mut self) {
        let braking = self.paused || matches!(self.state, State::Turning | State::Stopping);
        self.ramp.brake(braking);
    }

    /// The commanded speed under the override, 1/256 step/s.
    fn nominal(&self, axis: &AxisRecord) -> u32 {
        let percent = if self.percent == 0 { 100 } else { self.percent };
        let speed = mul_div(self.pace.speed, u32::from(percent), 100);
        speed.clamp(1, axis.top_rate.saturating_mul(UNITS))
    }

    /// A ramp over `events` steps, entered at `speed` or from rest.
    fn stretch(&self, axis: &AxisRecord, events: u32, speed: u32) -> Ramp {
        let nominal = self.nominal(axis);
        let start = (u32::from(axis.start_rate) * UNITS).min(nominal);
        Ramp::new(&Stretch {
            events,
            length: UNITS,
            per: 1,
            entry: speed.max(start),
            start,
            nominal,
            top: self.pace.speed.saturating_mul(2).max(speed),
            exit: start,
            accel: self.pace.accel.saturating_mul(UNITS),
            decel: self.pace.decel.saturating_mul(UNITS),
        })
    }
}
