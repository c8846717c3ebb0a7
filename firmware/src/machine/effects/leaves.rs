//! State and actions behind the rules of effects ([`crate::rules::effects`]).

use crate::analog::LAST_THRESHOLD;
use crate::machine::chip::Chip;
use crate::machine::controller::{Controller, PULSE_BEGUN};
use crate::rules::effects::Effects;
use lang::fault::Fault;
use lang::isa::flags;
use lang::record::FOLLOWS;
use lang::wire::TraceKind;

/// Of a wait for an input: the level, and that the other one has to come first.
const WANT: u8 = 3;
/// See [`WANT`].
const EDGE: u8 = 2;

impl<C: Chip> Effects for Controller<C> {
    fn operand(&mut self) -> u8 {
        self.vm.operand()
    }
    fn pop(&mut self) -> i32 {
        self.vm.pop()
    }
    #[inline(never)]
    fn pop_number(&mut self, least: u8, most: u8) -> Result<u8, Fault> {
        let n = self.vm.pop_small(most.into()) as u8;
        if n < least || n > most { Err(Fault::ValueRange) } else { Ok(n) }
    }
    fn pop_input(&mut self) -> Result<u8, Fault> {
        let n = self.pop_number(1, LAST_THRESHOLD)?;
        if self.has_input(n) { Ok(n) } else { Err(Fault::ValueRange) }
    }
    fn pop_time(&mut self) -> Result<i32, Fault> {
        let time = self.vm.pop();
        if time < 0 {
            return Err(Fault::ValueRange);
        }
        self.program.effect.left = time;
        Ok(time)
    }
    fn pop_level(&mut self) {
        let state = self.vm.pop();
        self.program.level = u8::from(state != 0);
        self.program.follows = state == FOLLOWS;
    }
    fn push(&mut self, value: u8) {
        self.vm.push(value.into());
    }
    fn is_over(&self) -> bool {
        self.program.effect.left == 0
    }
    fn begin_wait(&mut self) -> Result<(), Fault> {
        self.program.effect.bits = self.vm.operand();
        self.program.effect.left = -1;
        if self.program.effect.bits & flags::TIMEOUT != 0 {
            self.pop_time()?;
        }
        Ok(())
    }
    fn level(&self) -> u8 {
        self.program.level
    }
    fn set_level(&mut self, level: u8) {
        self.program.level = level;
        self.program.follows = false;
    }
    fn number(&self) -> u8 {
        self.program.effect.n
    }
    fn set_number(&mut self, n: u8) {
        self.program.effect.n = n;
    }
    fn next_number(&mut self) {
        self.program.effect.n += 1;
    }
    fn bits(&self) -> u8 {
        self.program.effect.bits
    }
    fn set_bits(&mut self, bits: u8) {
        self.program.effect.bits = bits;
    }
    fn has_level(&self) -> bool {
        self.program.effect.bits & flags::LEVEL != 0
    }
    fn has_input(&self) -> bool {
        self.program.effect.bits & flags::INPUT_ON_STACK != 0
    }
    fn is_query(&self) -> bool {
        self.program.effect.bits & flags::WAIT_QUERY != 0
    }
    fn wants_edge(&self) -> bool {
        self.program.effect.bits & EDGE != 0
    }
    fn forget_edge(&mut self) {
        self.program.effect.bits &= !EDGE;
    }
    fn want_level(&mut self) {
        self.program.effect.bits = self.program.effect.bits & !WANT | self.program.level;
    }
    fn input(&self, n: u8) -> u8 {
        Controller::input(self, n).into()
    }
    fn output(&self, n: u8) -> u8 {
        (self.io.outputs >> (n - 1)) as u8 & 1
    }
    fn drive(&mut self, n: u8) -> bool {
        let there = self.command_output(n.into(), self.program.level & 1 != 0);
        if there && self.motor.pwm.is_switched_by(n.into()) {
            self.motor.follows = self.program.follows;
        }
        there
    }
    fn enable(&self) -> u8 {
        self.record.enable
    }
    fn lamp(&self) -> u8 {
        self.record.lamp
    }
    fn tells(&self) -> bool {
        self.trace.full
    }
    fn was_told(&self) -> bool {
        self.program.effect.phase != PULSE_BEGUN
    }
    fn tell(&mut self, kind: TraceKind, value: i32) {
        self.emit(kind, self.program.effect.n, value);
    }
    fn tell_met(&mut self, kind: TraceKind, value: i32) {
        self.emit_outcome(kind, self.program.effect.n, true, value);
    }
    fn has_timed_out(&self) -> bool {
        self.program.timed_out
    }
    fn set_timed_out(&mut self) {
        self.program.timed_out = true;
    }
    fn set_in_time(&mut self) {
        self.program.timed_out = false;
    }
    fn char_in(&self) -> u8 {
        self.talk.char_in
    }
    fn set_char_in(&mut self, c: u8) {
        self.talk.char_in = c;
    }
    fn send(&mut self, c: u8) {
        self.talk.send(c);
    }
    fn await_start(&mut self) {
        self.session.wait_start();
    }
    fn awaits_start(&mut self) -> bool {
        !self.session.take_start()
    }
}
