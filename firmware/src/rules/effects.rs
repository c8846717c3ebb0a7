//! Statements that move nothing: outputs, pulses, waits for inputs, characters and Start, and reading of inputs
//! and outputs. A statement is called until it is done. Between calls the effect keeps its state: a number, flags, the
//! time left.
#![cfg_attr(any(), micro(module = "rules.effects", prefix = "fx_"))]

use super::{DONE, NOT_YET, Progress};
use lang::fault::Fault;
use lang::isa::Op;
use lang::wire::TraceKind;

/// See [`Op::OutShort`]; the outputs follow, each off and on.
#[cfg_attr(any(), micro("OP_OUT_SHORT"))]
const OUT_SHORT: u8 = Op::OutShort as u8;
/// See [`Op::InShort`]; the inputs follow.
#[cfg_attr(any(), micro("OP_IN_SHORT"))]
const IN_SHORT: u8 = Op::InShort as u8;

/// Hands the effects among these rules to a macro: first and last instruction, the rule, and what it takes beside the
/// machine. Both chips find their rule by it, and the test that proves them.
#[macro_export]
macro_rules! effect_rows {
    ($consumer:ident) => {
        $consumer! {
            effects {
                OutShort OutShort out_short(code);
                SetOut SetOut set_out();
                Pulse Pulse pulse(first);
                SetPort SetPort set_port(first);
                Wait Wait wait(first);
                WaitIn WaitIn wait_in(first);
                WaitChar WaitChar wait_char(first);
                WaitStart WaitStart wait_start(first);
                Send Send send();
                InShort InShort in_short(code);
                In In input();
                Out Out out_state();
                TimedOut TimedOut timed_out();
            }
        }
    };
}

/// What these rules look at and change.
pub trait Effects {
    /// The statement's next operand byte.
    #[cfg_attr(any(), micro(code = "DO operand_byte"))]
    fn operand(&mut self) -> u8;
    /// The top of the stack, taken.
    #[cfg_attr(any(), micro(code = "DO pop_value"))]
    fn pop(&mut self) -> i32;
    /// The same; F20 unless it lies within.
    ///
    /// # Errors
    /// F20.
    #[cfg_attr(any(), micro(code = "POP_NUMBER {least}, {most}"))]
    fn pop_number(&mut self, least: u8, most: u8) -> Result<u8, Fault>;
    /// The same of an input's number.
    ///
    /// # Errors
    /// F20.
    #[cfg_attr(any(), micro(code = "POP_NUMBER 1, 17"))]
    fn pop_input(&mut self) -> Result<u8, Fault>;
    /// The top, taken, is the time that is left, ms.
    ///
    /// # Errors
    /// F20 when it is negative.
    #[cfg_attr(any(), micro(code = "DO pop_time"))]
    fn pop_time(&mut self) -> Result<i32, Fault>;
    /// The level is that of the top, taken: 1 when it is not 0.
    #[cfg_attr(any(), micro(code = "DO pop_level"))]
    fn pop_level(&mut self);
    /// Puts a number on the stack.
    #[cfg_attr(any(), micro(code = "CALL push_small"))]
    fn push(&mut self, value: u8);
    /// No time is left.
    #[cfg_attr(any(), micro(code = "DO time_up", holds = "EQUAL"))]
    fn is_over(&self) -> bool;
    /// A wait begins: its flags, and the time that is left, for ever without a timeout.
    ///
    /// # Errors
    /// F20 when that is negative.
    #[cfg_attr(any(), micro(code = "DO wait_begin"))]
    fn begin_wait(&mut self) -> Result<(), Fault>;
    /// The level that a statement gives or wants: bit 0.
    #[cfg_attr(any(), micro(place = "UNIT"))]
    fn level(&self) -> u8;
    /// See [`Effects::level`].
    #[cfg_attr(any(), micro(place = "UNIT"))]
    fn set_level(&mut self, level: u8);
    /// The effect's number: of an input or output, or a character.
    #[cfg_attr(any(), micro(place = "N"))]
    fn number(&self) -> u8;
    /// See [`Effects::number`].
    #[cfg_attr(any(), micro(place = "N"))]
    fn set_number(&mut self, n: u8);
    /// The next number.
    #[cfg_attr(any(), micro(code = "UP N"))]
    fn next_number(&mut self);
    /// The effect's flags.
    #[cfg_attr(any(), micro(place = "BITS"))]
    fn bits(&self) -> u8;
    /// See [`Effects::bits`].
    #[cfg_attr(any(), micro(place = "BITS"))]
    fn set_bits(&mut self, bits: u8);
    /// Flags: the level is on the stack.
    #[cfg_attr(any(), micro(any = "BITS, FLAG_LEVEL"))]
    fn has_level(&self) -> bool;
    /// Flags: the input is on the stack.
    #[cfg_attr(any(), micro(any = "BITS, FLAG_INPUT_ON_STACK"))]
    fn has_input(&self) -> bool;
    /// Flags: a wait that tells whether it has timed out.
    #[cfg_attr(any(), micro(any = "BITS, FLAG_WAIT_QUERY"))]
    fn is_query(&self) -> bool;
    /// Flags: the other level has to come first.
    #[cfg_attr(any(), micro(any = "BITS, 2"))]
    fn wants_edge(&self) -> bool;
    /// It has come.
    #[cfg_attr(any(), micro(code = "BITS_OFF BITS, 2"))]
    fn forget_edge(&mut self);
    /// The level is what is wanted.
    #[cfg_attr(any(), micro(code = "BITS_OFF BITS, 3; GET UNIT; AXIS_ON BITS"))]
    fn want_level(&mut self);
    /// Level of an input from 1, 0 or 1.
    #[cfg_attr(any(), micro(code = "DO input"))]
    fn input(&self, n: u8) -> u8;
    /// Level of an output from 1, 0 or 1.
    #[cfg_attr(any(), micro(code = "DO output"))]
    fn output(&self, n: u8) -> u8;
    /// An output takes the level; whether it exists.
    #[cfg_attr(any(), micro(code = "DO output_unit", holds = "NOT_EQUAL"))]
    fn drive(&mut self, n: u8) -> bool;
    /// The output that enables the motors, 0 for none.
    #[cfg_attr(any(), micro(code = "PROFILE B_ENABLE"))]
    fn enable(&self) -> u8;
    /// That of the lamp, 0 for none.
    #[cfg_attr(any(), micro(code = "PROFILE B_LAMP"))]
    fn lamp(&self) -> u8;
    /// A host that traces has yet to take an event.
    #[cfg_attr(any(), micro(any = "TRACING, T_FULL"))]
    fn tells(&self) -> bool;
    /// The end of a pulse came within a handler and was told there: on the small chip the effect is over then.
    #[cfg_attr(any(), micro(never = 1))]
    fn was_told(&self) -> bool;
    /// Tells a host that traces, with the effect's number.
    #[cfg_attr(any(), micro(code = "EVENT {kind}", leaves = 0))]
    fn tell(&mut self, kind: TraceKind, value: i32);
    /// The same of what has come out well.
    #[cfg_attr(any(), micro(code = "EVENT_OK {kind}", leaves = 0))]
    fn tell_met(&mut self, kind: TraceKind, value: i32);
    /// The last wait that tells has timed out.
    #[cfg_attr(any(), micro(any = "RUN_FLAGS, R_TIMED_OUT"))]
    fn has_timed_out(&self) -> bool;
    /// It has.
    #[cfg_attr(any(), micro(code = "BITS_ON RUN_FLAGS, R_TIMED_OUT"))]
    fn set_timed_out(&mut self);
    /// It has not.
    #[cfg_attr(any(), micro(code = "BITS_OFF RUN_FLAGS, R_TIMED_OUT"))]
    fn set_in_time(&mut self);
    /// The character that a host has sent, 0 for none.
    #[cfg_attr(any(), micro(place = "CHAR_IN"))]
    fn char_in(&self) -> u8;
    /// See [`Effects::char_in`].
    #[cfg_attr(any(), micro(place = "CHAR_IN"))]
    fn set_char_in(&mut self, c: u8);
    /// Sends a character.
    #[cfg_attr(any(), micro(code = "PUT CHAR_OUT; UP CHAR_OUT+1"))]
    fn send(&mut self, c: u8);
    /// The program waits for Start from now on.
    #[cfg_attr(any(), micro(code = "BITS_ON RUN_FLAGS, R_WAITING"))]
    fn await_start(&mut self);
    /// It still does.
    #[cfg_attr(any(), micro(any = "RUN_FLAGS, R_WAITING"))]
    fn awaits_start(&mut self) -> bool;
}

/// Short Out: bit 0 of the code says on or off.
pub fn out_short(m: &mut impl Effects, code: u8) -> Progress {
    let twice = code.wrapping_sub(OUT_SHORT - 2);
    m.set_level(twice);
    output(m, twice >> 1)?;
    DONE
}

/// SetOut.
pub fn set_out(m: &mut impl Effects) -> Progress {
    m.pop_level();
    let n = m.pop_number(1, 16)?;
    output(m, n)?;
    DONE
}

/// An output takes the level, traced.
///
/// # Errors
/// F20 beyond those there are, and for the enable and the lamp: they are the controller's.
pub fn output(m: &mut impl Effects, n: u8) -> Result<(), Fault> {
    m.set_number(n);
    if m.enable() == m.number() || m.lamp() == m.number() || !m.drive(m.number()) {
        return Err(Fault::ValueRange);
    }
    m.tell(TraceKind::Out, i32::from(m.level() & 1));
    Ok(())
}

/// Pulse.
pub fn pulse(m: &mut impl Effects, first: bool) -> Progress {
    if first {
        m.pop_time()?;
        let n = m.pop_number(1, 16)?;
        m.set_level(1);
        output(m, n)?;
        return NOT_YET;
    }
    if !m.is_over() {
        return NOT_YET;
    }
    if m.was_told() {
        return DONE;
    }
    m.set_level(0);
    output(m, m.number())?;
    DONE
}

/// SetPort: the flags are the outputs that remain.
pub fn set_port(m: &mut impl Effects, first: bool) -> Progress {
    if first {
        let levels = m.pop();
        m.set_bits(levels as u8);
    }
    loop {
        m.next_number();
        m.set_level(m.bits());
        m.set_bits(m.bits() >> 1);
        if m.number() >= 9 {
            return DONE;
        }
        // One that the wiring lacks is left out, and one that is the controller's.
        let _ = output(m, m.number());
        // They change together, unless a host that traces must hear of each first.
        if m.tells() {
            return NOT_YET;
        }
    }
}

/// Wait.
pub fn wait(m: &mut impl Effects, first: bool) -> Progress {
    if first {
        let time = m.pop_time()?;
        m.tell(TraceKind::Wait, time);
    }
    if !m.is_over() {
        return NOT_YET;
    }
    DONE
}

/// WaitIn: the level that is wanted is bit 0 of the flags, the other one has to come first when bit 1 says so, the
/// input is in the two top bits.
pub fn wait_in(m: &mut impl Effects, first: bool) -> Progress {
    if first {
        m.begin_wait()?;
        if m.has_level() {
            m.pop_level();
            m.want_level();
        }
        let mut n = (m.bits() >> 6) + 1;
        if m.has_input() {
            n = m.pop_input()?;
        }
        m.set_number(n);
    }
    m.set_level(m.input(m.number()));
    let wanted = m.bits() & 1;
    if wanted == m.level() {
        if !m.wants_edge() {
            m.tell_met(TraceKind::WaitIn, i32::from(wanted));
            return met(m);
        }
    } else {
        m.forget_edge();
    }
    if !m.is_over() {
        return NOT_YET;
    }
    m.tell(TraceKind::WaitIn, i32::from(wanted));
    missed(m)
}

/// WaitChar.
pub fn wait_char(m: &mut impl Effects, first: bool) -> Progress {
    if first {
        m.begin_wait()?;
        let c = m.pop_number(33, 125)?;
        m.set_number(c);
    }
    let c = m.number();
    if c == m.char_in() {
        m.set_char_in(0);
        m.tell_met(TraceKind::WaitChar, i32::from(c));
        return met(m);
    }
    if !m.is_over() {
        return NOT_YET;
    }
    m.tell(TraceKind::WaitChar, i32::from(c));
    missed(m)
}

/// A wait that was met.
pub fn met(m: &mut impl Effects) -> Progress {
    if m.is_query() {
        m.set_in_time();
    }
    DONE
}

/// One that has timed out.
pub fn missed(m: &mut impl Effects) -> Progress {
    if !m.is_query() {
        return Err(Fault::TimedOut);
    }
    m.set_timed_out();
    DONE
}

/// Send.
pub fn send(m: &mut impl Effects) -> Progress {
    let c = m.pop_number(33, 125)?;
    m.send(c);
    m.tell(TraceKind::Send, i32::from(c));
    DONE
}

/// WaitStart.
pub fn wait_start(m: &mut impl Effects, first: bool) -> Progress {
    if first {
        m.await_start();
    }
    if m.awaits_start() {
        return NOT_YET;
    }
    m.tell_met(TraceKind::WaitStart, 0);
    DONE
}

/// Short IN.
pub fn in_short(m: &mut impl Effects, code: u8) -> Progress {
    m.push(m.input(code.wrapping_sub(IN_SHORT - 1)));
    DONE
}

/// IN.
pub fn input(m: &mut impl Effects) -> Progress {
    let n = m.pop_input()?;
    m.push(m.input(n));
    DONE
}

/// OUT.
pub fn out_state(m: &mut impl Effects) -> Progress {
    let n = m.pop_number(1, 16)?;
    m.push(m.output(n));
    DONE
}

/// TIMEDOUT.
pub fn timed_out(m: &mut impl Effects) -> Progress {
    m.push(if m.has_timed_out() { 1 } else { 0 });
    DONE
}
