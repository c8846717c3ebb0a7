//! Run-time state of a program other than the VM's.

use super::effect::Effect;
use super::events::Event;
use crate::motion::Feed;
use core::ptr::addr_of_mut;
use lang::fault::Fault;

/// The program that runs.
pub struct Program {
    /// The effect that runs and the one that an event handler interrupted.
    pub effect: Effect,
    /// See `effect`.
    pub outer: Effect,
    /// Address of the effect's instruction.
    pub pc: u16,
    /// Address of the outer one's.
    pub outer_pc: u16,
    /// The level that the effect gives: bit 0.
    pub level: u8,
    /// An output that is given it follows the feed's power.
    pub follows: bool,
    /// F.
    pub feed: Feed,
    /// What F was where a handler began: the outer one's, and that of an error handler within an
    /// event handler.
    pub feeds_aside: [Feed; 2],
    /// ON lines.
    pub events: [Event; 4],
    /// Milliseconds of the run.
    pub timer: i32,
    /// TIMEDOUT.
    pub timed_out: bool,
    /// A fault found while a path moved, and where: it is raised at the path's end.
    pub late: Option<(Fault, u16)>,
    /// Input that caused the last fault.
    pub fault_input: u8,
}

/// At reset, where zeroes are not what is meant.
///
/// # Safety
/// As [`crate::machine::Controller::init`].
#[allow(unsafe_code)]
pub unsafe fn init(program: *mut Program) {
    // SAFETY: the caller's.
    unsafe {
        addr_of_mut!((*program).feed).write(Feed::Rapid);
        addr_of_mut!((*program).feeds_aside).write([Feed::Rapid; 2]);
        addr_of_mut!((*program).late).write(None);
    }
}

impl Program {
    /// A run begins, with this F.
    pub fn begin(&mut self, feed: Feed) {
        self.forget();
        self.outer = Effect::NONE;
        self.feed = feed;
        self.late = None;
        for event in &mut self.events {
            event.kind = 0;
        }
        self.timer = 0;
        self.timed_out = false;
        self.fault_input = 0;
    }

    /// No effect is under way any more.
    #[inline(never)]
    pub fn forget(&mut self) {
        self.effect = Effect::NONE;
    }

    /// Whether this is the effect's first call.
    #[inline(never)]
    pub fn first(&mut self) -> bool {
        let first = self.effect.phase == 0;
        if first {
            self.effect.phase = 1;
        }
        first
    }

    /// A handler begins inside `open` others, without F.
    pub fn put_feed_aside(&mut self, open: usize) {
        self.feeds_aside[open & 1] = self.feed;
        self.feed = Feed::Rapid;
    }
}
