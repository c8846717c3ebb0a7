//! Reference runs.

use crate::controller::Controller;
use crate::vm::{axis, convert, vm};
use firmware::motion::Pace;
use lang::fault::Fault;
use lang::isa::Op;
use lang::record::AxisRecord;
use lang::wire::TraceKind;

/// Phases of homing.
const FAST: u8 = 1;
const REST: u8 = 2;
const PAUSE: u8 = 3;
const SLOW: u8 = 4;
const OPEN: u8 = 5;
const CLEAR: u8 = 6;
/// The plan is made.
pub const BEGIN: u8 = 7;

/// A reference run, in steps.
pub struct Plan {
    /// Input number of the switch.
    pub input: u8,
    /// Its level when closed.
    pub closed: bool,
    /// It lies in positive direction.
    pub positive: bool,
    /// Speed toward it and ramps.
    pub pace: Pace,
    /// Speed off it, steps/s.
    pub slow: u32,
    /// How far to look for it.
    pub stroke: i32,
    /// Rest between the two, ms.
    pub pause: u16,
    /// Position where it opens.
    pub position: i32,
    /// Clearance move, signed.
    pub clearance: i32,
}

impl Controller {
    /// Plans a reference run by the profile.
    ///
    /// # Errors
    /// F01.
    pub fn plan_home(&mut self, n: u8) -> Result<(), Fault> {
        let record = axis(n);
        let positive = record.flags & AxisRecord::HOME_POSITIVE != 0;
        let position = convert(n, record.home_position, true)?;
        let away = if positive { -record.home_clearance } else { record.home_clearance };
        let rest = convert(n, record.home_position.wrapping_add(away), true)?;
        self.plan = Plan {
            input: self.record.reference[usize::from(n)],
            closed: true,
            positive,
            pace: Pace::of(record).with_steps(u32::from(record.home_fast)),
            slow: u32::from(record.home_slow),
            stroke: convert(n, record.home_stroke, true)?,
            pause: record.home_pause,
            position,
            clearance: rest.wrapping_sub(position),
        };
        Ok(())
    }

    fn closed(&self) -> bool {
        self.unfiltered(self.plan.input) == self.plan.closed
    }

    /// Home: fast to the switch, rest, slowly off it, clearance.
    ///
    /// # Errors
    /// F10, F11.
    pub fn home(&mut self, code: u8) -> Result<bool, Fault> {
        if self.effect.phase == 0 {
            self.effect.n = code.wrapping_sub(Op::Home as u8);
            if code == Op::HomeQuery as u8 {
                self.effect.n = vm().operand();
            }
            if axis(self.effect.n).flags & AxisRecord::PRESENT == 0 {
                return Err(Fault::ValueRange);
            }
            self.plan_home(self.effect.n)?;
            self.effect.phase = BEGIN;
        }
        let n = self.effect.n;
        let rests = !self.motor.moves(n);
        match self.effect.phase {
            BEGIN => {
                self.motor.homed &= !(1 << n);
                self.motor.placed &= !(1 << n);
                self.motor.offset[usize::from(n)] = 0;
                self.effect.phase = REST;
                if !self.closed() {
                    self.effect.phase = FAST;
                    self.seek(n, self.plan.positive, self.plan.pace);
                }
            }
            FAST => {
                if self.closed() {
                    self.motor.stop(1 << n);
                    self.effect.phase = REST;
                } else if rests {
                    return self.not_homed(n, Fault::HomeNotFound);
                }
            }
            REST => {
                if rests {
                    self.effect.left = i32::from(self.plan.pause);
                    self.effect.phase = PAUSE;
                }
            }
            PAUSE => {
                if self.effect.left == 0 {
                    let pace = self.plan.pace.with_steps(self.plan.slow);
                    self.seek(n, !self.plan.positive, pace);
                    self.effect.phase = SLOW;
                }
            }
            SLOW => {
                if !self.closed() {
                    self.motor.hit(n, self.motor.position(n));
                    self.effect.phase = OPEN;
                } else if rests {
                    return self.not_homed(n, Fault::HomeStaysClosed);
                }
            }
            OPEN => {
                if rests {
                    self.motor.place(n, self.plan.position);
                    self.motor.homed |= 1 << n;
                    let steps = self.plan.position.wrapping_add(self.plan.clearance);
                    self.motor.settle(n, steps);
                    self.motor.go(n, steps, self.plan.pace, true);
                    self.effect.phase = CLEAR;
                }
            }
            _ => {
                if rests {
                    let position = self.motor.position(n);
                    self.emit_outcome(TraceKind::Home, n, true, position);
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// Whether the effect under way looks for a switch or a probe at this instant.
    pub fn seeks(&self) -> bool {
        const HOME: u8 = Op::Home as u8;
        const HOME_QUERY: u8 = Op::HomeQuery as u8;
        const PROBE: u8 = Op::Probe as u8;
        match self.effect.code {
            HOME..=HOME_QUERY => matches!(self.effect.phase, FAST | SLOW),
            PROBE => self.effect.phase == 1,
            _ => false,
        }
    }

    fn not_homed(&mut self, n: u8, fault: Fault) -> Result<bool, Fault> {
        self.motor.settle_here(n);
        let position = self.motor.position(n);
        self.emit_outcome(TraceKind::Home, n, false, position);
        let query = self.effect.code == Op::HomeQuery as u8;
        if query && fault as u8 == Fault::HomeNotFound as u8 { Ok(true) } else { Err(fault) }
    }

    /// Sends an axis toward or off its reference switch, by the stroke at most.
    fn seek(&mut self, n: u8, positive: bool, pace: Pace) {
        let position = self.motor.position(n);
        let stroke = self.plan.stroke;
        let target =
            if positive { position.wrapping_add(stroke) } else { position.wrapping_sub(stroke) };
        self.motor.go(n, target, pace, true);
    }
}
