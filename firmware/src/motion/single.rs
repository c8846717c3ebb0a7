//! An axis on its own ramp: MoveAxe, MoveRel, START, MoveSpeed, homing and probing.
//!
//! The unit is the step: speeds are steps/s, ramps steps/s2. The target may change at any time: the axis passes it and
//! turns round on its ramp if it must.
//!
//! The planner keeps the squared speed and the steps left, and asks the ramp generator ([`super::ramp`]) for a segment at
//! a time. A new target only changes the steps left, so the speed never jumps, whatever is commanded on the way.

use super::math::size;
use super::ramp::{Limits, Run, Segment};
use super::scaled::Scaled;
use lang::record::AxisRecord;

/// Time from a hit to the earliest change of speed, ms: what the engine holds and the main loop's
/// round.
const LATENCY_MS: u32 = 24;

/// So far before it, or half as far, lies the target of MoveSpeed without a limit, which moves along with the axis.
const FAR: i32 = 1 << 29;

/// A speed and the ramps to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pace {
    /// Speed, steps/s.
    pub speed: Scaled,
    /// Ramp up, steps/s2.
    pub accel: Scaled,
    /// Ramp down, steps/s2.
    pub decel: Scaled,
}

impl Pace {
    /// The axis's top rate and its ramps.
    pub fn of(axis: &AxisRecord) -> Pace {
        Pace {
            speed: Scaled::new(axis.top_rate),
            accel: Scaled::new(axis.accel),
            decel: Scaled::new(axis.decel),
        }
    }

    /// With another speed, steps/s, not above the axis's top.
    #[must_use]
    pub fn with_steps(mut self, steps: u32) -> Pace {
        self.speed = self.speed.least(Scaled::new(steps.max(1)));
        self
    }

    /// With another speed, um/s, not above the axis's top.
    #[must_use]
    pub fn with_um(mut self, axis: &AxisRecord, um: u32) -> Pace {
        self.speed = self.speed.least(steps_of(axis, um));
        self
    }

    /// With other ramps, steps/s2, not above the axis's.
    #[must_use]
    pub fn with_ramps(mut self, accel: Scaled, decel: Scaled) -> Pace {
        self.accel = self.accel.least(accel);
        self.decel = self.decel.least(decel);
        self
    }
}

/// um (um/s, um/s2), at least 1, as steps (steps/s, steps/s2), with fractions.
pub fn steps_of(axis: &AxisRecord, um: u32) -> Scaled {
    let um = Scaled::new(um.max(1)).times(Scaled::new(axis.steps.into()));
    um.over(Scaled::new(axis.um.into()))
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
#[derive(Clone, Copy, Debug)]
pub struct Single {
    run: Run,
    /// What pace and override allow.
    limits: Limits,
    position: i32,
    target: i32,
    /// Rate of the step timer, Hz.
    clock: Scaled,
    pace: Pace,
    state: State,
    negative: bool,
    paused: bool,
    /// MoveSpeed without a limit: the target moves along.
    endless: bool,
    /// Speed override for the next [`Single::go`], percent; 0 stands for 100. While the axis moves:
    /// [`Single::set_override`].
    pub percent: u8,
}

impl Single {
    /// A resting axis at `position` steps, for a step timer of `clock` Hz.
    pub const fn new(position: i32, clock: Scaled) -> Single {
        Single {
            run: Run::NONE,
            limits: Limits::NONE,
            position,
            target: position,
            clock,
            pace: Pace { speed: Scaled::ZERO, accel: Scaled::ZERO, decel: Scaled::ZERO },
            state: State::Idle,
            negative: false,
            paused: false,
            endless: false,
            percent: 0,
        }
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
        self.paused && (self.is_idle() || self.run.v2 <= self.limits.start2)
    }

    /// Direction of the segment handed out last.
    pub fn negative(&self) -> bool {
        self.negative
    }

    /// Speed at the end of the segment handed out last, steps/s with sign.
    pub fn velocity(&self) -> i32 {
        if self.is_idle() {
            return 0;
        }
        let speed = self.run.v2.root().floor() as i32;
        if self.negative { -speed } else { speed }
    }

    /// Speed that it has or is to have on its way, steps/s with the sign of that way: 0 when idle or on the way to rest.
    pub fn wanted_velocity(&self) -> i32 {
        if self.is_idle() || self.state == State::Stopping || self.paused {
            return 0;
        }
        let speed = self.limits.nominal2.root().floor() as i32;
        if self.target.wrapping_sub(self.position) < 0 { -speed } else { speed }
    }

    /// Goes to `target` steps, also from a motion under way.
    ///
    /// A moving axis keeps its speed and gets a new number of steps to go. It cannot get there directly when the target
    /// lies behind it or nearer than its braking distance, `v^2 > exit^2 + 2 d left`. It then brakes to its start
    /// rate, however far that takes it (`Turning`), and [`Single::next_segment`] sets off anew toward the target.
    pub fn go(&mut self, axis: &AxisRecord, target: i32, pace: Pace) {
        self.target = target;
        self.endless = false;
        self.pace = pace;
        self.set_limits(axis);
        if self.is_idle() {
            self.begin();
            return;
        }
        let distance = target.wrapping_sub(self.position);
        self.run.left = size(distance);
        self.state = State::Going;
        let away = distance == 0 || (distance < 0) != self.negative;
        if away || !self.run.can_stop(&self.limits) {
            // Too near, or behind: away from here on a ramp, then back.
            self.run.left = FAR as u32;
            self.state = State::Turning;
        }
    }

    /// Runs at a speed (MoveSpeed) until stopped, at the furthest to `limit` steps, where the axis
    /// comes to rest. Without a limit it runs for ever, while its position comes round after 2^32 steps.
    pub fn run(&mut self, axis: &AxisRecord, negative: bool, limit: Option<i32>, pace: Pace) {
        let far = if negative { -FAR } else { FAR };
        self.go(axis, limit.unwrap_or(self.position.wrapping_add(far)), pace);
        self.endless = limit.is_none();
    }

    /// Ramps down to rest and forgets the target.
    pub fn stop(&mut self) {
        if !self.is_idle() {
            self.run.left = FAR as u32;
            self.state = State::Stopping;
        }
    }

    /// Reacts to a probe or switch that answered at the step to `caught`: an axis no faster than
    /// its start rate stands still there, and `true` says that the engine must drop the rest of
    /// what it holds; a faster one stops on its ramp. Where it rests depends on `caught` and the
    /// pace alone, not on how far ahead the engine was fed.
    ///
    /// The place of rest is `caught + v^2 / (2 d) + v * LATENCY_MS` at the commanded speed `v`: the braking distance,
    /// and the way that the segments already handed to the engine may go. Without the second term the axis could stand beyond
    /// the place of rest when the hit is seen, and would turn back. A target that is nearer stays the target.
    pub fn hit(&mut self, axis: &AxisRecord, caught: i32) -> bool {
        let speed = self.pace.speed;
        if speed <= Scaled::new(axis.start_rate.into()) {
            self.halt(caught);
            return true;
        }
        let ramp = speed.times(speed).over(self.pace.decel).shifted(-1);
        // A ms is taken for 1/1024 s.
        let latency = speed.times(Scaled::new(LATENCY_MS)).shifted(-10);
        let rest = ramp.plus(latency).floor().min(FAR as u32) as i32 + 1;
        let room = self.target.abs_diff(caught);
        if (rest as u32) < room {
            let rest = if self.negative { -rest } else { rest };
            self.go(axis, caught.wrapping_add(rest), self.pace);
        }
        false
    }

    /// Stands still at `position` at once (emergency stop, limit switch): the engine has dropped
    /// everything.
    pub fn halt(&mut self, position: i32) {
        self.position = position;
        self.rest();
    }

    /// Ramps down to a pause (`true`), or goes on with the rest.
    pub fn pause(&mut self, on: bool) {
        self.paused = on;
    }

    /// Speed override, 10 to 200 percent of the commanded speed, never above the axis's top.
    pub fn set_override(&mut self, axis: &AxisRecord, percent: u8) {
        self.percent = percent.clamp(10, 200);
        self.set_limits(axis);
    }

    /// The next segment; `false` when idle or in a pause.
    ///
    /// The ramp generator has no segment while it brakes at the start rate or below: then an axis that turns sets off toward
    /// its target, one that stops is at rest, and a paused one waits. MoveSpeed without a limit keeps its target at
    /// least `FAR / 2` steps ahead, so the brake never begins, and positions wrap at 2^32 steps.
    pub fn next_segment(&mut self, out: &mut Segment) -> bool {
        if self.is_idle() {
            return false;
        }
        let braking = self.paused || self.state != State::Going;
        if self.endless && !braking && self.run.left < FAR as u32 / 2 {
            let more = FAR / 2;
            self.run.left += more as u32;
            self.target = self.target.wrapping_add(if self.negative { -more } else { more });
        }
        let left = self.run.left;
        if !self.run.segment(&self.limits, braking, out) {
            match self.state {
                State::Turning if !self.paused => {
                    self.begin();
                    return self.next_segment(out);
                }
                State::Stopping => self.rest(),
                _ => {}
            }
            return false;
        }
        let steps = left.wrapping_sub(self.run.left) as i32;
        let steps = if self.negative { -steps } else { steps };
        self.position = self.position.wrapping_add(steps);
        if self.run.left == 0 || self.state == State::Stopping && self.run.v2 <= self.limits.start2
        {
            self.rest();
        }
        true
    }

    /// Comes to rest where the axis is.
    fn rest(&mut self) {
        self.state = State::Idle;
        self.target = self.position;
    }

    /// Starts from rest toward the target.
    fn begin(&mut self) {
        let distance = self.target.wrapping_sub(self.position);
        if distance == 0 {
            self.state = State::Idle;
            return;
        }
        self.negative = distance < 0;
        self.run.left = size(distance);
        self.run.v2 = self.limits.start2;
        self.state = State::Going;
    }

    /// Finds what the pace and the override allow.
    fn set_limits(&mut self, axis: &AxisRecord) {
        let mut speed = self.pace.speed;
        if self.percent != 0 {
            let percent = Scaled::new(self.percent.into()).over(HUNDRED);
            speed = speed.times(percent).least(Scaled::new(axis.top_rate));
        }
        let start = Scaled::new(axis.start_rate.max(1).into()).least(speed);
        self.limits.set_pitch(ONE, self.pace.accel, self.pace.decel, self.clock);
        self.limits.nominal2 = speed.times(speed);
        self.limits.start2 = start.times(start);
        self.limits.exit2 = self.limits.start2;
    }
}

/// 1
const ONE: Scaled = Scaled::constant(1);
/// 100
const HUNDRED: Scaled = Scaled::constant(100);
