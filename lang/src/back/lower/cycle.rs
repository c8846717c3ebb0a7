//! Canned cycles (RS274/NGC 3.5.16): each becomes the moves that it stands for.
//!
//! The R plane stays on the stack meanwhile, the depth of a G83 above it. As the stack is not
//! empty between the moves, no event handler comes between them.

use super::Lower;
use crate::axis::Axis;
use crate::back::ir::{Cond, Item};
use crate::effect::Frame;
use crate::hir::{Cycle, CycleKind, Expr, ExprKind};
use crate::isa::{Look, Op};

/// How far above the last depth the rapid of a G83 ends, um (language.md, G-code lines).
const PECK_CLEARANCE: i32 = 250;

const fn z_look(in_steps: bool) -> Look {
    if in_steps { Look::PosSteps } else { Look::Pos }
}

/// A Z word alone, its value on the stack.
const fn z_word(in_steps: bool) -> [Option<(bool, Frame)>; 3] {
    [None, None, Some((in_steps, Frame::Work))]
}

impl Lower<'_> {
    pub(super) fn cycle(&mut self, cycle: &Cycle) {
        if let (Some(old_z), true) = (cycle.old_z, cycle.takes_z) {
            self.look(Look::Pos, Axis::Z as u8);
            self.push(Item::Store(old_z));
        }
        let in_steps = super::machine::steps(&cycle.r.value);
        self.expr(&cycle.r.value);
        if cycle.r.frame == Frame::Relative {
            self.look(z_look(in_steps), Axis::Z as u8);
            self.plain(Op::Add);
        }
        match &cycle.repeats {
            Some(repeats) if !matches!(repeats.node, ExprKind::Const(1)) => {
                let (top, exit) = (self.fresh(), self.fresh());
                self.expr(repeats);
                self.plain(Op::Dup);
                self.push(Item::Const(0));
                self.push(Item::Branch(Cond::Le, exit));
                self.push(Item::Label(top));
                self.plain(Op::Over);
                self.hole(cycle, in_steps);
                self.push(Item::Const(1));
                self.plain(Op::Sub);
                self.plain(Op::Dup);
                self.push(Item::Branch(Cond::Nonzero, top));
                self.push(Item::Label(exit));
                self.plain(Op::Drop);
                self.plain(Op::Drop);
            }
            _ => self.hole(cycle, in_steps),
        }
    }

    /// One hole; takes R from the stack. Its unit is that of every Z there.
    fn hole(&mut self, cycle: &Cycle, in_steps: bool) {
        let z = Axis::Z as u8;
        // Up to R if below it.
        self.plain(Op::Dup);
        self.look(z_look(in_steps), z);
        self.plain(Op::Max);
        self.linear_on_stack(true, z_word(in_steps), false);
        let [x, y] = &cycle.xy;
        if x.is_some() || y.is_some() {
            self.linear(true, [x.as_ref(), y.as_ref(), None], false);
        }
        self.plain(Op::Dup);
        self.linear_on_stack(true, z_word(in_steps), false);
        match &cycle.kind {
            CycleKind::Drill => self.down(cycle),
            CycleKind::Dwell(time) => {
                self.down(cycle);
                self.expr(time);
                self.plain(Op::Wait);
            }
            CycleKind::Peck(depth) => self.peck(cycle, depth, in_steps),
        }
        match cycle.old_z {
            Some(old_z) if in_steps => {
                // Work um and machine steps do not compare: choose after the move to R.
                self.linear_on_stack(true, z_word(true), false);
                self.look(Look::Pos, z);
                self.push(Item::Load(old_z));
                self.plain(Op::Max);
                self.linear_on_stack(true, z_word(false), false);
            }
            Some(old_z) => {
                self.push(Item::Load(old_z));
                self.plain(Op::Max);
                self.linear_on_stack(true, z_word(false), false);
            }
            None => self.linear_on_stack(true, z_word(in_steps), false),
        }
    }

    /// To the bottom, which counts from R when it is relative; the axis is at R.
    fn down(&mut self, cycle: &Cycle) {
        self.linear(false, [None, None, Some(&cycle.z)], cycle.exact);
    }

    /// G83. On the stack: R and above it the depth that was reached, as Z counts: from R when it
    /// is relative.
    fn peck(&mut self, cycle: &Cycle, depth: &Expr, in_steps: bool) {
        let relative = cycle.z.frame == Frame::Relative;
        let (top, done) = (self.fresh(), self.fresh());
        match relative {
            true => self.push(Item::Const(0)),
            false => self.plain(Op::Dup),
        }
        self.push(Item::Label(top));
        self.in_unit(depth, in_steps);
        self.plain(Op::Sub);
        self.in_unit(&cycle.z.value, in_steps);
        self.plain(Op::Max);
        self.reached(relative);
        self.linear_on_stack(false, z_word(in_steps), cycle.exact);
        self.plain(Op::Dup);
        self.in_unit(&cycle.z.value, in_steps);
        self.push(Item::Branch(Cond::Le, done));
        self.plain(Op::Over);
        self.linear_on_stack(true, z_word(in_steps), false);
        self.reached(relative);
        self.push(Item::Const(PECK_CLEARANCE));
        if in_steps {
            self.flags(Op::ToSteps, [Axis::Z as u8, 0, 0]);
        }
        self.plain(Op::Add);
        self.linear_on_stack(true, z_word(in_steps), false);
        // Behind an unconditional jump the stack is empty by rule, and here it is not.
        self.push(Item::Const(0));
        self.push(Item::Branch(Cond::Zero, top));
        self.push(Item::Label(done));
        self.plain(Op::Drop);
    }

    /// Pushes the place that was reached.
    fn reached(&mut self, relative: bool) {
        if relative {
            self.plain(Op::Over);
            self.plain(Op::Over);
            self.plain(Op::Add);
        } else {
            self.plain(Op::Dup);
        }
    }

    fn in_unit(&mut self, value: &Expr, in_steps: bool) {
        self.expr(value);
        let value_in_steps = super::machine::steps(value);
        if in_steps != value_in_steps {
            let op = if in_steps { Op::ToSteps } else { Op::ToLength };
            self.flags(op, [Axis::Z as u8, 0, 0]);
        }
    }
}
