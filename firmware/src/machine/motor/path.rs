//! The path: its blocks on their way to the step engine.

use super::{AXES, Motor, clock};
use crate::machine::chip::Chip;
use crate::motion::actions::{Action, UNIT};
use crate::motion::path::FOLLOWS;
use crate::motion::{Arc, Block, Feed, Manner, Single, queue};
use lang::wire::TraceKind;

/// What a block of the path is known by: the event that its beginning is, 0 for none, and where its statement
/// stands in the program's code.
pub fn tag(kind: Option<TraceKind>, pc: u16) -> u32 {
    u32::from(kind.map_or(0, |kind| kind as u8)) << 16 | u32::from(pc)
}

impl<C: Chip> Motor<C> {
    /// Whether the path would take another block, `soon`: one of which it wants to know already.
    pub fn path_has_room(&self, soon: bool) -> bool {
        self.path.has_room() && !(soon && self.path.knows_next())
    }

    /// Whether nothing is left of the path.
    pub fn path_rests(&self) -> bool {
        self.path_axes == 0
    }

    /// Moves rapidly from rest; the ways of the axes `second`, bit per axis, are another leg behind the others.
    pub fn rapid(&mut self, mut steps: [i32; 3], second: u8, tag: u32) {
        let mut n = AXES;
        while n != 0 {
            n -= 1;
            let i = usize::from(n);
            if second >> n & 1 != 0 {
                self.leg[i] = core::mem::take(&mut steps[i]);
            }
        }
        self.line(steps, [0; 3], Feed::Rapid, true, tag);
    }

    /// Appends a line to the path, which has room; `um` as [`Block::um`], `tag` as of [`tag`].
    pub fn line(&mut self, steps: [i32; 3], um: [i32; 3], feed: Feed, exact: bool, tag: u32) {
        if self.path_axes == 0 {
            let mut start = self.steps;
            for (start, way) in start.iter_mut().zip(&steps) {
                *start = start.wrapping_sub(*way);
            }
            self.begin_path(start, tag);
        }
        let mut n = AXES;
        while n != 0 {
            n -= 1;
            let way = steps[usize::from(n)];
            if way != 0 {
                if self.path_axes >> n & 1 == 0 {
                    self.set_negative(n, way < 0);
                }
                self.path_axes |= 1 << n;
            }
        }
        // A rapid move is dark.
        let power = if let Feed::Rapid = feed { 0 } else { self.beam() };
        self.path.push(
            &self.machine.axes,
            &Block { steps, um, manner: Manner { feed, exact, power, tag } },
        );
    }

    /// Appends an arc to the path, which has room.
    pub fn arc(&mut self, arc: &Arc, feed: Feed, exact: bool, tag: u32) {
        if self.path_axes == 0 {
            self.begin_path(arc.start, tag);
        }
        self.path_axes |= 0b111;
        self.path.push_arc(
            &self.machine.axes,
            arc,
            &Manner { feed, exact, power: self.beam(), tag },
        );
    }

    /// An action that comes `lead` um before the end of the newest block, behind it where that is negative; there is room.
    pub fn act(&mut self, action: Action, lead: i32) {
        if self.actions.is_empty() {
            self.actions.begin(self.chip.ahead(), self.chip.now());
        }
        self.path.measure();
        // Nothing comes before the motion that is to follow.
        let lead = if self.path_axes == 0 { lead.min(0) } else { lead };
        let place = self.path.end().wrapping_sub(lead as u32);
        let beyond = self.path.place().wrapping_sub(place).cast_signed();
        let gone = (beyond > 0).then(|| {
            // At rest it was at the end of what was handed out.
            let per_s = const { C::RATE / UNIT as u32 };
            match self.path.velocity() {
                0 => 0,
                speed => C::mul_div(beyond.unsigned_abs(), per_s, speed).min(30_000) as u16,
            }
        });
        self.actions.add(action, place, gone.filter(|_| self.path_axes != 0));
    }

    /// Where the newest block ends, um along the path ([`crate::motion::path::Path::end`]).
    pub fn path_end(&self) -> u32 {
        self.path.end()
    }

    /// How far the step engine is is known from now on, for what is due.
    pub fn follow_actions(&mut self) {
        let per_unit = const { (UNIT as u32 * C::PER_MS as u32 / (C::RATE / 1000)) as u16 };
        let runs = self.chip.is_running();
        self.actions.follow(self.chip.ahead(), runs, self.chip.now(), per_unit);
    }

    /// The next action that is due, if any.
    pub fn due_action(&mut self) -> Option<Action> {
        self.actions.take_due(const { (C::RATE / 1000 / UNIT as u32) as u16 })
    }

    /// Time that the engine is to hold behind the playing segment: more for actions that come before their places.
    fn wanted(&self) -> u16 {
        let wanted = queue::wanted(&self.path, C::RATE);
        if self.actions.is_empty() {
            return wanted;
        }
        let lead = self.actions.longest_lead();
        wanted + lead * const { (C::RATE / 1000 / UNIT as u32) as u16 }
    }

    /// Power of a laser in the next block.
    fn beam(&self) -> u16 {
        self.power | if self.follows { FOLLOWS } else { 0 }
    }

    /// A path begins where the axes rest, with the block of this tag.
    fn begin_path(&mut self, start: [i32; 3], tag: u32) {
        self.chip.clear();
        self.block_end = start;
        self.block_pc = tag as u16;
    }

    /// Where the statement of the path's block stands that plays, or that a stop or fault has cut.
    pub fn block_pc(&self) -> Option<u16> {
        (self.cut || self.path_axes != 0).then_some(self.block_pc)
    }

    /// Power of a laser for what moves at this instant.
    pub fn shine(&self) -> u16 {
        if self.path_axes != 0 { self.chip.power() } else { self.power }
    }

    /// Whether there is time for the program. There is none while the engine could run dry before the program has brought
    /// its next block: the axes would stop dead at full speed. Without such time the path knows less and less of what
    /// comes, and slows down on its ramps. A path that comes to rest for a pause, or rests, takes no more time.
    pub fn has_enough(&self) -> bool {
        self.path_axes == 0
            || self.path.is_paused()
            || !self.chip.is_running()
            || !self.path.knows_next()
            || !self.chip.path_has_room()
            || self.chip.ahead() >= queue::low(C::RATE)
    }

    pub(super) fn poll_path(&mut self, hold: bool) {
        if self.stopped & self.path_axes != 0 && self.path.is_paused() && !self.chip.is_running() {
            self.path.clear();
            self.cut = true;
            self.leg = [0; 3];
        }
        if self.leg[0] | self.leg[1] | self.leg[2] != 0 && self.path.has_room() {
            let leg = core::mem::take(&mut self.leg);
            self.line(leg, [0; 3], Feed::Rapid, true, u32::from(self.block_pc));
        }
        let mut fetches = queue::FETCHES;
        while fetches != 0 && self.chip.ahead() < self.wanted() && self.chip.path_has_room() {
            let acts = !self.actions.is_empty();
            let from = if acts { self.path.place() } else { 0 };
            if !self.path.next_segment(&self.machine.axes, &mut self.segment) {
                break;
            }
            if acts {
                let time = queue::time(&self.segment.ramp);
                self.actions.hand_out(from, self.path.place(), time, C::mul_div);
            }
            fetches -= 1;
            let mut power = self.segment.power;
            if self.pwm.is_laser() {
                power = self.pwm.compare(power);
            }
            self.chip.put_path(&self.segment, power);
            if self.segment.begin && !self.segment.within {
                self.block_begins();
            }
            // As long as there is time, the link and the program come between two segments.
            if self.chip.ahead() >= queue::low(C::RATE) {
                break;
            }
        }
        let settles = !hold || self.stopped == 0;
        if settles && self.path.is_idle() && !self.chip.is_running() {
            let mut n = AXES;
            while n != 0 {
                n -= 1;
                let i = usize::from(n);
                if self.path_axes >> n & 1 != 0 {
                    self.single[i] = Single::new(self.actual[i], const { clock::<C>() });
                }
                if self.stopped >> n & 1 != 0 {
                    self.settle_here(n);
                }
            }
            self.path_axes = 0;
            self.stopped = 0;
            self.chip.clear();
        }
    }

    /// The first segment of a block has been handed out.
    fn block_begins(&mut self) {
        let segment = &self.segment;
        for (end, way) in self.block_end.iter_mut().zip(&segment.way) {
            *end = end.wrapping_add(*way);
        }
        self.block_pc = segment.tag as u16;
        let kind = (segment.tag >> 16) as u8;
        if kind != 0 {
            self.chip.event(kind, 0, 0, &self.block_end, self.block_pc);
        }
    }
}
