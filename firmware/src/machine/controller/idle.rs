//! Skipping of milliseconds in which only counters change, for simulations.
//!
//! [`Controller::idle_ms`] returns how many follow at rest, [`Controller::moving_ms`] how many while motors move, and
//! [`Controller::skip`] counts them at once. The result is that of as many calls of [`Controller::ticks`]
//! (tick.rs). The firmware on a chip does not call these.

use super::{Controller, END, Effect, PENDING};
use crate::inputs::Inputs;
use crate::machine::chip::Chip;
use lang::isa::{first, last};
use lang::record::BoardRecord;
use lang::wire::RunState;

/// Milliseconds after reset in which auto-run is looked at.
const BOOT: u16 = 500;

/// Whether an effect does nothing but wait once it has begun, with what it waits for out of sight.
fn waits(effect: &Effect) -> bool {
    let code = effect.code;
    effect.phase != 0
        && matches!(
            code,
            first::Wait | first::WaitIn | first::WaitChar | first::WaitStart | first::Pulse
        )
}

/// Milliseconds that an effect still counts, if it counts any.
fn counts(effect: &Effect) -> Option<u32> {
    let counted = matches!(
        effect.code,
        first::Home
            ..=last::HomeQuery | first::Wait | first::WaitIn | first::WaitChar | first::Pulse
    );
    u32::try_from(effect.left).ok().filter(|left| counted && *left > 0)
}

fn settled(inputs: &Inputs, raw: u16) -> bool {
    inputs.is_settled() && inputs.accepted() == raw
}

impl<C: Chip> Controller<C> {
    /// Milliseconds from now on, at most `most`, in which no input, pin, statement or event changes by itself; the last
    /// of what counts down is left to [`Controller::ticks`].
    pub fn idle_ms(&self, most: u32) -> u32 {
        let (session, program) = (&self.session, &self.program);
        let stands = match session.state {
            _ if session.executes() => waits(&program.effect) && program.late.is_none(),
            state => {
                state == RunState::Empty as u8
                    || state == RunState::Ready as u8
                    || state == RunState::Paused as u8 && program.effect.code != first::Pulse
            }
        };
        let idle = stands && self.motor.settled() && self.is_quiet();
        if idle { self.counted(most) } else { 0 }
    }

    /// The same while a program's axes move: as long as the step engine neither takes nor ends a segment. The last pass
    /// of the main loop has found nothing to do.
    pub fn moving_ms(&self, most: u32) -> u32 {
        let program = &self.program;
        let prints = matches!(
            program.effect.code,
            0 | END | first::PrintNumber..=last::PrintTextFar | first::PrintEnd
        );
        let idle = self.session.executes()
            && program.late.is_none()
            && !prints
            && !self.motor.rests()
            && !self.motor.is_stopping()
            && self.is_quiet();
        if idle { self.counted(most) } else { 0 }
    }

    /// Nothing is on its way through a filter, no hand is at a button, no event or pause is pending.
    fn is_quiet(&self) -> bool {
        let hands = self.io.buttons.accepted() | self.chip.buttons();
        self.clock.spin == 0
            && self.command.hold == 0
            && !self.command.jogs
            && self.motor.actions.is_empty()
            && hands == 0
            && self.record.lamp == 0
            && self.record.select >> 5 != BoardRecord::NEXT
            && self.chip.tripped() == 0
            && self.emergency_now() == 0
            && settled(&self.io.inputs, self.io.raw)
            && self.io.buttons.is_settled()
            && self.analog_is_settled()
            && self.library.shown == 0
            && self.program.events.iter().all(|event| event.kind & PENDING == 0)
    }

    /// Milliseconds, at most `most`, before the last one of anything that is counted down.
    fn counted(&self, most: u32) -> u32 {
        let (program, clock) = (&self.program, &self.clock);
        let mut left = most;
        if !self.reset.booted {
            let boots = u32::from(BOOT).saturating_sub(u32::from(clock.tick) + 2);
            left = left.min(boots);
        }
        if self.session.executes() {
            let effects = [&program.effect, &program.outer].into_iter().filter_map(counts);
            let every = program.events.iter().filter(|event| event.kind & !PENDING == 3);
            let every = every.filter_map(|event| u32::try_from(event.left).ok());
            left = effects.chain(every).fold(left, |left, own| left.min(own.saturating_sub(1)));
            // KEEP values go to flash in time.
            if self.keep_count() != 0 {
                left = left.min(u32::from(super::keep::SECOND.saturating_sub(clock.kept + 1)));
            }
        }
        left
    }

    /// So many milliseconds have passed, no more than [`Controller::idle_ms`] has told.
    pub fn skip(&mut self, ms: u32) {
        let short = u16::try_from(ms).unwrap_or(u16::MAX);
        let clock = &mut self.clock;
        clock.tick = clock.tick.wrapping_add(ms as u16);
        clock.kept = clock.kept.saturating_add(short);
        clock.blink = clock.blink.wrapping_add(ms as u16);
        clock.skip_phase(ms, self.record.filter);
        self.lines.skip(short);
        if self.session.executes() {
            let program = &mut self.program;
            program.timer = program.timer.wrapping_add(ms as i32);
            for effect in [&mut program.effect, &mut program.outer] {
                if counts(effect).is_some() {
                    effect.left -= ms as i32;
                }
            }
            for event in &mut program.events {
                if event.kind & !PENDING == 3 {
                    event.left -= ms as i32;
                }
            }
        }
    }
}
