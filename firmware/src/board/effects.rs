//! Effects: what the VM leaves with, polled from the main loop until it is done.
//!
//! In phase 0 the operands and arguments are taken; later phases wait. Trace events are written
//! one for each call at most: the caller sees to it that the slot is free.

mod leaves;
mod looks;
mod print;

use crate::controller::{Controller, END, Event, PENDING};
use crate::motor::AXES;
use crate::vm::vm;
use firmware::rules::{effects as rules, moves};
use lang::fault::Fault;
use lang::isa::{Op, flags};
use lang::wire::TraceKind;

impl Controller {
    /// Goes on with the effect; `true` when it is done.
    ///
    /// # Errors
    /// The fault that the statement ends with.
    pub fn perform(&mut self) -> Result<bool, Fault> {
        const OUT: u8 = Op::OutShort as u8;
        const OUT_LAST: u8 = OUT + 15;
        const MOVE_TO: u8 = Op::MoveTo as u8;
        const MOVE_RAMP: u8 = Op::MoveRamp as u8;
        const LINE_LAST: u8 = Op::Line as u8 + 4;
        const LINEAR: u8 = Op::Linear as u8;
        const ARC: u8 = Op::Arc as u8;
        const ARC_BY: u8 = Op::ArcBy as u8;
        const FEED: u8 = Op::Feed as u8;
        const SPINDLE: u8 = Op::Spindle as u8;
        const HOME: u8 = Op::Home as u8;
        const HOME_QUERY: u8 = Op::HomeQuery as u8;
        const PROBE: u8 = Op::Probe as u8;
        const MOVE_SPEED: u8 = Op::MoveSpeed as u8;
        const SET_POS: u8 = Op::SetPos as u8;
        const SET_POS_ZERO: u8 = Op::SetPosZero as u8;
        const SET_POS_ZERO_LAST: u8 = SET_POS_ZERO + 2;
        const IN_SHORT: u8 = Op::InShort as u8;
        const IN_SHORT_LAST: u8 = IN_SHORT + 3;
        const TIMED_OUT: u8 = Op::TimedOut as u8;
        const STOP_AXE: u8 = Op::StopAxe as u8;
        const STOP_ALL: u8 = Op::StopAll as u8;
        const WAIT_MOVE: u8 = Op::WaitMove as u8;
        const SET_OUT: u8 = Op::SetOut as u8;
        const PULSE: u8 = Op::Pulse as u8;
        const SET_PORT: u8 = Op::SetPort as u8;
        const MOTORS: u8 = Op::Motors as u8;
        const WAIT: u8 = Op::Wait as u8;
        const WAIT_IN: u8 = Op::WaitIn as u8;
        const WAIT_START: u8 = Op::WaitStart as u8;
        const SEND: u8 = Op::Send as u8;
        const WAIT_CHAR: u8 = Op::WaitChar as u8;
        const PRINT_TEXT: u8 = Op::PrintText as u8;
        const PRINT_TEXT_FAR: u8 = Op::PrintTextFar as u8;
        const PRINT_NUMBER: u8 = Op::PrintNumber as u8;
        const PRINT_END: u8 = Op::PrintEnd as u8;
        const EVENT: u8 = Op::Event as u8;
        const IN: u8 = Op::In as u8;
        const OUT_STATE: u8 = Op::Out as u8;
        const READ: u8 = Op::Read as u8;
        const RUN: u8 = Op::Run as u8;
        let code = self.program.effect.code;
        // Whatever looks at or acts on the machine waits for the path's end first.
        if !(LINEAR..=LINE_LAST).contains(&code)
            && !(FEED..=SPINDLE).contains(&code)
            && !(ARC..=ARC_BY).contains(&code)
            && self.program.effect.phase == 0
            && !self.motor.path_rests()
        {
            return Ok(false);
        }
        match code {
            OUT..=OUT_LAST => return rules::out_short(self, code),
            MOVE_TO..=MOVE_RAMP => return self.move_axe(code),
            LINEAR..=LINE_LAST => return self.linear(code),
            ARC..=ARC_BY => return self.arc(code),
            FEED..=SPINDLE => return moves::feed(self, code),
            HOME..=HOME_QUERY => return self.home(code),
            PROBE => return self.probe(),
            MOVE_SPEED => return self.move_speed(),
            SET_POS => return moves::set_pos(self),
            SET_POS_ZERO..=SET_POS_ZERO_LAST => return moves::set_pos_zero(self, code),
            STOP_AXE => {
                if self.program.first() {
                    self.program.effect.n = vm().operand();
                    self.motor.stop(1 << self.program.effect.n);
                    self.emit(TraceKind::Stop, self.program.effect.n, 0);
                }
                return Ok(!self.motor.moves(self.program.effect.n));
            }
            STOP_ALL => {
                if self.program.first() {
                    self.motor.stop(0b111);
                }
                // One event for each axis: the next one waits until a host that traces has this one.
                while self.program.effect.n < AXES {
                    self.emit(TraceKind::Stop, self.program.effect.n, 0);
                    self.program.effect.n += 1;
                    if self.trace.full {
                        return Ok(false);
                    }
                }
                return Ok(self.motor.moving() == 0);
            }
            WAIT_MOVE => {
                if self.program.first() {
                    let n = vm().operand();
                    self.program.effect.n = if n < AXES { 1 << n } else { 0b111 };
                    if self.motor.running() & self.program.effect.n != 0 {
                        return Err(Fault::ValueRange);
                    }
                }
                return Ok(self.motor.moving() & self.program.effect.n == 0);
            }
            SET_OUT => return rules::set_out(self),
            PULSE => {
                let first = self.program.first();
                return rules::pulse(self, first);
            }
            SET_PORT => {
                let first = self.program.first();
                return rules::set_port(self, first);
            }
            MOTORS => return self.motors(),
            WAIT => {
                let first = self.program.first();
                return rules::wait(self, first);
            }
            WAIT_IN => {
                let first = self.program.first();
                return rules::wait_in(self, first);
            }
            WAIT_START => {
                let first = self.program.first();
                return rules::wait_start(self, first);
            }
            SEND => return rules::send(self),
            WAIT_CHAR => {
                let first = self.program.first();
                return rules::wait_char(self, first);
            }
            PRINT_TEXT | PRINT_TEXT_FAR => return Ok(self.print_text(code == PRINT_TEXT_FAR)),
            PRINT_NUMBER => return Ok(self.print_number()),
            PRINT_END => return Ok(self.print_end()),
            END => {
                if self.come_to_rest() {
                    let order = self.session.end(None);
                    self.obey(order);
                }
                return Ok(false);
            }
            RUN => {
                if self.come_to_rest() {
                    self.run_other()?;
                }
                return Ok(false);
            }
            EVENT => self.event()?,
            IN_SHORT..=IN_SHORT_LAST => return rules::in_short(self, code),
            TIMED_OUT => return rules::timed_out(self),
            IN => return rules::input(self),
            OUT_STATE => return rules::out_state(self),
            READ => return moves::read(self),
            _ => return Err(Fault::ValueRange),
        }
        Ok(true)
    }

    /// STARTed moves finish, MoveSpeed axes ramp down; whether all rest.
    fn come_to_rest(&mut self) -> bool {
        let running = self.motor.running();
        if running != 0 {
            self.motor.stop(running);
        }
        self.motor.moving() == 0
    }

    fn motors(&mut self) -> Result<bool, Fault> {
        let n = vm().operand();
        let on = vm().pop() != 0;
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
        let bits = vm().operand();
        let slot = usize::from(bits & 3);
        let kind = bits & flags::EVENT_KIND;
        let value = if bits & flags::EVENT_ARGUMENT != 0 { vm().pop() } else { 0 };
        match kind {
            flags::ON_EVERY => {
                if value <= 0 {
                    return Err(Fault::ValueRange);
                }
                self.program.events[slot] = Event { kind: 3, n: 1, period: value, left: value };
            }
            flags::ON_RISE | flags::ON_FALL => {
                if !(1..=17).contains(&value) {
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
