//! The tasks of each millisecond other than inputs and buttons.
//!
//! [`autorun`] runs on every chip, [`tick`] on the small one only. There an effect and a jog share one timer, and a pulse
//! ends as the effect does. The larger one has timers of their own for effects that a handler interrupts and for the host's
//! silence.
#![cfg_attr(any(), micro(module = "rules.ticks", prefix = "ticks_", section = "ticks"))]

use super::session::{self, Runs};

/// What autorun looks at.
pub trait Starts: Runs {
    /// Half a second has passed since reset.
    #[cfg_attr(any(), micro(any = "RUN_FLAGS, R_BOOTED"))]
    fn has_booted(&self) -> bool;
    /// It has not yet.
    #[cfg_attr(any(), micro(code = "LIT16 499; F cmp MILLIS", holds = "CARRY"))]
    fn boots(&self) -> bool;
    /// It has passed now.
    #[cfg_attr(any(), micro(code = "BITS_ON RUN_FLAGS, R_BOOTED"))]
    fn set_booted(&mut self);
    /// A host has spoken since reset.
    #[cfg_attr(any(), micro(any = "RUN_FLAGS, R_HOST"))]
    fn has_host(&self) -> bool;
    /// The stored program is to start by itself.
    #[cfg_attr(any(), micro(code = "PROFILE B_FLAGS; TESTI BOARD_AUTORUN", holds = "NOT_EQUAL"))]
    fn wants_autorun(&self) -> bool;
    /// The chip came up with its supply: by no contact at RST, watchdog or host.
    #[cfg_attr(any(), micro(is = "CAUSE, 4"))]
    fn was_powered_up(&self) -> bool;
}

/// The small chip's milliseconds.
pub trait Ticks: Starts {
    /// The lamp takes the level that instructions leave.
    #[cfg_attr(any(), micro(code = "PROFILE B_LAMP; CALL set_output"))]
    fn set_lamp(&mut self);
    /// 0 once in a quarter of a second.
    #[cfg_attr(any(), micro(place = "TICKS_DONE"))]
    fn quarter(&self) -> u8;
    /// Trace mode's reader has been there within the last two seconds.
    #[cfg_attr(any(), micro(any = "TRACING, T_HEARD"))]
    fn has_reader(&self) -> bool;
    /// A quarter of a second of them is over.
    #[cfg_attr(any(), micro(code = "GET TRACING; ADDI -T_QUARTER; PUT TRACING"))]
    fn count_quarter(&mut self);
    /// Trace mode ends.
    #[cfg_attr(any(), micro(code = "BITS_OFF TRACING, T_ON|T_FULL"))]
    fn end_trace(&mut self);
    /// What moves for as long as the host speaks does.
    #[cfg_attr(any(), micro(any = "MOTION, M_JOG"))]
    fn is_held(&self) -> bool;
    /// The effect under way has its time counted; what a probe keeps there stays.
    #[cfg_attr(
        any(),
        micro(code = "GET EFFECT; ADDI -OP_HOME; CMPI OP_WAIT-OP_HOME+1", holds = "NO_CARRY")
    )]
    fn counts(&self) -> bool;
    /// It is a pulse, whose time goes on in a pause.
    #[cfg_attr(any(), micro(is = "EFFECT, OP_PULSE"))]
    fn is_pulse(&self) -> bool;
    /// The time that will be left, ms.
    #[cfg_attr(any(), micro(code = "LIT 1; DO negate; F add TIME"))]
    fn time_less_one(&self) -> i32;
    /// The time that is left, ms.
    #[cfg_attr(any(), micro(place = "TIME"))]
    fn set_time(&mut self, ms: i32);
    /// The effect's number.
    #[cfg_attr(any(), micro(place = "N"))]
    fn number(&self) -> u8;
    /// An output is off, in a pause and behind it.
    #[cfg_attr(any(), micro(code = "CALL output_off"))]
    fn end_pulse(&mut self, n: u8);
    /// A millisecond of the ON lines.
    #[cfg_attr(any(), micro(code = "", ends = "br #event_tick", when = "HAS_EVENTS"))]
    fn listen(&mut self);
}

/// Auto-run half a second after power-up, unless a host has spoken or Stop is held. Nothing else may begin a run without
/// somebody at the machine: RST, which a contact may close, least of all, and no fault is acknowledged by itself.
#[cfg_attr(any(), micro(within = 1))]
pub fn autorun(m: &mut impl Starts) {
    if m.has_booted() || m.boots() {
        return;
    }
    m.set_booted();
    if m.has_host() || !m.wants_autorun() || !m.was_powered_up() || !m.is_ready() {
        return;
    }
    session::start(m);
}

/// The rest of a millisecond, behind the level of the lamp.
#[cfg_attr(any(), micro(entry = "ticks_rest"))]
pub fn tick(m: &mut impl Ticks) {
    m.set_lamp();
    patience(m);
    autorun(m);
    // A jog goes on for two seconds after the last request; of what an effect waits for a pulse ends in a pause, too, where
    // waits stand still.
    if m.is_held() || m.counts() && (m.is_pulse() || !m.is_paused()) {
        let left = m.time_less_one();
        if left >= 0 {
            m.set_time(left);
        } else {
            if m.is_held() {
                m.brake_all();
            }
            if m.is_pulse() {
                m.end_pulse(m.number());
            }
        }
    }
    m.listen();
}

/// Trace mode ends two seconds after its reader, counted down in quarters.
#[cfg_attr(any(), micro(within = 1))]
fn patience(m: &mut impl Ticks) {
    if m.quarter() != 0 {
        return;
    }
    if m.has_reader() {
        m.count_quarter();
    } else {
        m.end_trace();
    }
}
