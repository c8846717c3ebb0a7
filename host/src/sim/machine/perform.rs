//! What each effect does to the machine.

use lang::axis::Axis;
use lang::effect::{Effect, Rate, Read, Want};
use lang::fault::Fault;
use lang::plain::Plain;

use super::Machine;
use super::events::Slot;
use crate::sim::step::Step;
use crate::sim::trace::What;

impl Machine {
    /// Carries out an effect, or begins the wait that it is.
    ///
    /// # Errors
    /// The fault that it raises.
    pub(super) fn execute(&mut self, effect: &Effect) -> Result<Step, Fault> {
        match *effect {
            Effect::SetFeed(rate) => self.modal.feed = Some(positive(rate)?),
            Effect::SetSpindle(value) => self.set_power(value)?,
            Effect::Keep { .. } => {}
            Effect::Linear { rapid, to, exact } => self.linear(rapid, &to, exact)?,
            // The chip draws none: chords stand in their place.
            Effect::Arc { .. } | Effect::Sync(_) | Effect::SetAout { .. } => {
                return Err(Fault::ImageRefused);
            }
            _ => {
                self.sync_path();
                if self.is_halted() {
                    return Ok(Step::Stop);
                }
                return self.execute_at_rest(effect);
            }
        }
        Ok(Step::Done(0))
    }

    fn execute_at_rest(&mut self, effect: &Effect) -> Result<Step, Fault> {
        match *effect {
            Effect::MoveAxe { axis, to, speed, accel, decel, wait } => {
                self.move_axe(axis, to, [speed, accel, decel], wait)?;
            }
            Effect::MoveSpeed { axis, speed } => self.move_speed(axis, speed)?,
            Effect::StopAxe(axis) => {
                self.stop_axes(&[axis]);
            }
            Effect::Plain(Plain::StopAll, _) => {
                let axes: Vec<Axis> = self.profile.axes().map(|(axis, _)| axis).collect();
                self.stop_axes(&axes);
            }
            Effect::Home { axis, query } => self.home(axis, query)?,
            Effect::Probe { axis, limit, speed, sensor, query } => {
                self.probe(axis, limit, speed, sensor, query)?;
            }
            Effect::SetPos { axis, value } => {
                if self.motion.is_moving(axis) {
                    return Err(Fault::ValueRange);
                }
                let before = self.axes.steps(axis);
                self.axes.set_work(axis, value)?;
                if self.axes.steps(axis) != before {
                    self.renew(axis, before);
                }
            }
            Effect::Plain(Plain::SetOut, [n, on]) => self.set_out(n, on != 0)?,
            Effect::Plain(Plain::SetPort, [value, _]) => self.set_port(value),
            Effect::Motors { on, axis } => {
                let axes = axis.map_or(Axis::ALL.to_vec(), |axis| vec![axis]);
                if !on {
                    axes.iter().for_each(|axis| self.axes.set_homed(*axis, false));
                }
                self.outputs.enable(on);
                self.outputs_changed();
            }
            Effect::WaitMove(_)
            | Effect::WaitIn { .. }
            | Effect::WaitChar { .. }
            | Effect::Plain(Plain::Wait | Plain::WaitStart | Plain::Pulse, _) => {
                return self.begin_wait(effect);
            }
            Effect::Plain(Plain::Send, [c, _]) => {
                if !(33..=125).contains(&c) {
                    return Err(Fault::ValueRange);
                }
                self.write(What::Send { line: self.line, c });
            }
            Effect::PrintText(index) => self.print.text(index),
            Effect::PrintValue(value, unit) => {
                self.print.push(format_args!("{}", unit.show(value)));
            }
            Effect::PrintEnd => {
                let text = self.print.take();
                self.write(What::Print { line: self.line, text });
            }
            Effect::OnInput { slot, n, want } => self.on_input(slot, n, want)?,
            Effect::OffInput(n) => self.events.off_input(n),
            Effect::OnEvery { slot, ms } => self.on_every(slot, ms)?,
            Effect::OffEvery => self.events.off_every(),
            Effect::EnterHandler => self.modal.enter_handler(),
            Effect::LeaveHandler => self.modal.leave_handler(),
            Effect::Read(read) => return self.read(read).map(Step::Done),
            // The engines' own: they have the programs.
            Effect::Run(_) => return Err(Fault::NoProgram),
            Effect::SetFeed(_)
            | Effect::SetSpindle(_)
            | Effect::Keep { .. }
            | Effect::Linear { .. }
            | Effect::Arc { .. }
            | Effect::SetAout { .. }
            | Effect::Sync(_) => {}
        }
        Ok(Step::Done(0))
    }

    /// S.
    pub(super) fn set_power(&mut self, value: i32) -> Result<(), Fault> {
        let graded = self.profile.has_power();
        if graded && !(0..=self.profile.full_power()).contains(&value) {
            return Err(Fault::ValueRange);
        }
        self.modal.power = value;
        Ok(())
    }

    /// SetOut.
    pub(super) fn set_out(&mut self, n: i32, on: bool) -> Result<(), Fault> {
        self.outputs.set(n, on)?;
        self.write(What::Out { line: self.line, n, v: on.into(), sync: false, pos: None });
        self.outputs_changed();
        Ok(())
    }

    /// SetPort.
    pub(super) fn set_port(&mut self, value: i32) {
        for n in self.outputs.port() {
            let on = value >> (n - 1) & 1 != 0;
            if self.outputs.set(n, on).is_ok() {
                self.write(What::Out { line: self.line, n, v: on.into(), sync: false, pos: None });
            }
        }
        self.outputs_changed();
    }

    /// ON IN.
    pub(super) fn on_input(&mut self, slot: u8, n: i32, want: Want) -> Result<(), Fault> {
        self.inputs.read(n)?;
        let input = Some((n, want == Want::Rise));
        self.events.set(slot, Slot { input, tick: None, period_us: 0, pending: false });
        Ok(())
    }

    /// ON EVERY.
    pub(super) fn on_every(&mut self, slot: u8, ms: i32) -> Result<(), Fault> {
        let Ok(period) = u64::try_from(ms) else { return Err(Fault::ValueRange) };
        if period == 0 {
            return Err(Fault::ValueRange);
        }
        let period_us = period * 1_000;
        let tick = Some(self.run_clock() + period_us);
        self.events.set(slot, Slot { input: None, tick, period_us, pending: false });
        Ok(())
    }

    fn read(&mut self, read: Read) -> Result<i32, Fault> {
        Ok(match read {
            Read::In(n) => self.inputs.read(n)?.into(),
            Read::InPort => self.inputs.port(),
            Read::Out(n) => self.outputs.read(n)?.into(),
            Read::Pos(axis) => {
                self.axes.work_at(axis, self.motion.positions(self.clock.now())[axis.index()])?
            }
            Read::PosSteps(axis) => self.motion.positions(self.clock.now())[axis.index()],
            Read::Probed(axis) => self.axes.probed_work(axis)?,
            Read::ProbedSteps(axis) => self.axes.probed_steps(axis),
            Read::ProbeOk(axis) => self.axes.probe_ok(axis).into(),
            Read::Moving(axis) => self.motion.is_moving(axis).into(),
            Read::Homed(axis) => self.axes.is_homed(axis).into(),
            Read::Timer => self.timer(),
            Read::TimedOut => self.waits.timed_out.into(),
            // No program of this part reads one.
            Read::Analog(_) => 0,
            Read::CharIn => std::mem::take(&mut self.waits.char_in),
        })
    }
}

/// The rate, if it is above 0.
pub(super) fn positive(rate: Rate) -> Result<Rate, Fault> {
    let (Rate::Um(value) | Rate::Steps(value)) = rate;
    if value > 0 { Ok(rate) } else { Err(Fault::SpeedRange) }
}
