//! Effects: the statements that act on the machine. The main loop polls each until it is done.
//!
//! In phase 0 the operands and arguments are taken; later phases wait. Each call writes at most one
//! trace event: the caller makes sure that the slot is free.

mod leaves;
mod looks;
mod print;

use crate::analog::LAST_THRESHOLD;
use crate::machine::chip::Chip;
use crate::machine::controller::{Controller, END, Event, PENDING};
use crate::machine::motor::AXES;
use crate::rules::{Progress, axes, effects, moves, probe, session};
use lang::fault::Fault;
use lang::isa::{first, flags, last};

/// What the effect of a code has come to, if it is one of these rules.
macro_rules! by_rule {
    ($module:ident { $($first:ident $last:ident $rule:ident($($with:ident)*);)* }) => {
        #[inline(always)]
        fn $module<C: Chip>(controller: &mut Controller<C>, code: u8) -> Option<Progress> {
            Some(match code {
                $(first::$first..=last::$last => {
                    by_rule!(@ controller code $module $rule $($with)*)
                })*
                _ => return None,
            })
        }
    };
    (@ $m:ident $code:ident $module:ident $rule:ident) => { $module::$rule($m) };
    (@ $m:ident $code:ident $module:ident $rule:ident code) => { $module::$rule($m, $code) };
    (@ $m:ident $code:ident $module:ident $rule:ident first) => {{
        let first = $m.program.first();
        $module::$rule($m, first)
    }};
    (@ $m:ident $code:ident $module:ident $rule:ident code first) => {{
        let first = $m.program.first();
        $module::$rule($m, $code, first)
    }};
}
crate::effect_rows!(by_rule);
crate::move_rows!(by_rule);
crate::probe_rows!(by_rule);
crate::axis_rows!(by_rule);

impl<C: Chip> Controller<C> {
    /// Goes on with the effect; `true` when it is done.
    ///
    /// # Errors
    /// The fault that the statement ends with.
    pub fn perform(&mut self) -> Result<bool, Fault> {
        let code = self.program.effect.code;
        // Whatever looks at or acts on the machine waits for the path's end first.
        if !(first::Linear..=last::Line).contains(&code)
            && !(first::Feed..=last::Spindle).contains(&code)
            && !(first::Arc..=last::ArcBy).contains(&code)
            && code != first::Sync
            && self.program.effect.phase == 0
        {
            if !self.motor.path_rests() {
                return Ok(false);
            }
            // What a fault or a stop brakes is not sent on before it stands: its commanded place follows only then. Lines
            // and arcs wait for all axes anyway.
            let sends =
                (first::Linear..=last::MoveRamp).contains(&code) || code == first::MoveSpeed;
            if sends && self.motor.is_stopping() {
                return Ok(false);
            }
            if !self.motor.actions.is_empty() {
                self.flush_actions(None);
            }
        }
        if code == first::Read && self.look_at_analog() {
            return Ok(true);
        }
        if let Some(progress) = moves(self, code) {
            return progress;
        }
        if let Some(progress) = effects(self, code) {
            return progress;
        }
        if let Some(progress) = probe(self, code) {
            return progress;
        }
        if let Some(progress) = axes(self, code) {
            return progress;
        }
        match code {
            first::Linear..=last::Line => return self.linear(code),
            first::Arc..=last::ArcBy => return self.arc(code),
            first::Home..=last::HomeQuery => return self.home(code),
            first::MoveSpeed => return self.move_speed(),
            first::Motors => return self.motors(),
            first::PrintText => return Ok(self.print_text(false)),
            first::PrintTextFar => return Ok(self.print_text(true)),
            first::PrintNumber => return Ok(self.print_number()),
            first::PrintEnd => return Ok(self.print_end()),
            END => return session::end(self),
            first::Run => {
                if self.come_to_rest() {
                    self.run_other()?;
                }
                return Ok(false);
            }
            first::Event => self.event()?,
            first::Sync => return self.sync(),
            first::SetAout => self.take_aout()?,
            _ => return Err(Fault::ValueRange),
        }
        Ok(true)
    }

    /// STARTed moves finish, MoveSpeed axes ramp down, and outputs have acted that do so on the way; whether all rest.
    pub fn come_to_rest(&mut self) -> bool {
        let running = self.motor.running();
        if running != 0 {
            self.motor.stop(running);
        }
        self.motor.moving() == 0 && self.motor.actions.is_empty()
    }

    fn motors(&mut self) -> Result<bool, Fault> {
        let n = self.vm.operand();
        let on = self.vm.pop() != 0;
        if !on {
            let others = if n < AXES { !(1 << n) } else { 0 };
            self.motor.homed &= others;
            self.motor.placed &= others;
        }
        if self.record.enable != 0 {
            self.set_output(u16::from(self.record.enable), on);
        }
        Ok(true)
    }

    fn event(&mut self) -> Result<(), Fault> {
        let bits = self.vm.operand();
        let slot = usize::from(bits & 3);
        let kind = bits & flags::EVENT_KIND;
        let value = if bits & flags::EVENT_ARGUMENT != 0 { self.vm.pop() } else { 0 };
        match kind {
            flags::ON_EVERY => {
                if value <= 0 {
                    return Err(Fault::ValueRange);
                }
                self.program.events[slot] = Event { kind: 3, n: 1, period: value, left: value };
            }
            flags::ON_RISE | flags::ON_FALL => {
                if !(1..=i32::from(LAST_THRESHOLD)).contains(&value) || !self.has_input(value as u8)
                {
                    return Err(Fault::ValueRange);
                }
                let kind = if kind == flags::ON_RISE { 1 } else { 2 };
                self.program.events[slot] = Event { kind, n: value as u8, period: 0, left: 0 };
            }
            _ => {
                let every = kind != flags::OFF_INPUT;
                for event in &mut self.program.events {
                    let is_every = event.kind & !PENDING == 3;
                    if is_every == every && (every || i32::from(event.n) == value) {
                        event.kind = 0;
                    }
                }
            }
        }
        Ok(())
    }
}
