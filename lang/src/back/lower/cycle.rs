//! Canned cycles (RS274/NGC 3.5.16): each becomes the moves that it stands for.
//!
//! The R plane stays on the stack meanwhile, a Z that is not simple below it, the depth of a G83
//! above it. As the stack is not empty between the moves, no event handler comes between them.
//! Machine steps and work um do not compare without the work offset, which only the machine knows:
//! where both come together, the axis is asked for its place at R in the other unit.

use super::Lower;
use super::machine::steps;
use crate::axis::Axis;
use crate::back::ir::{Cond, Item};
use crate::effect::Frame;
use crate::hir::{Cycle, CycleKind, Expr, UnOp, Word};
use crate::isa::{Look, Op};

/// How far above the last depth the rapid of a G83 ends, um (lang/README.md, G-code).
const PECK_CLEARANCE: i32 = 250;

const fn z_look(in_steps: bool) -> Look {
    if in_steps { Look::PosSteps } else { Look::Pos }
}

/// A Z word alone, its value on the stack.
const fn z_word(in_steps: bool) -> [Option<(bool, Frame)>; 3] {
    [None, None, Some((in_steps, Frame::Work))]
}

/// Units and frames of words whose values are on the stack.
fn kinds_of(words: [Option<&Word>; 3]) -> [Option<(bool, Frame)>; 3] {
    words.map(|word| word.map(|word| (steps(&word.value), word.frame)))
}

impl Lower<'_> {
    pub(super) fn cycle(&mut self, cycle: &Cycle) {
        if let (Some(old_z), true) = (cycle.old_z, cycle.takes_z) {
            self.look(Look::Pos, Axis::Z as u8);
            self.push(Item::Store(old_z));
        }
        if !cycle.z.value.is_simple() {
            self.expr(&cycle.z.value);
        }
        if let CycleKind::Peck(depth) = &cycle.kind
            && depth.constant().is_none()
        {
            // A depth that is not positive never arrives: F20, as the root of -1 or -2.
            self.expr(depth);
            self.unary(UnOp::Sgn);
            self.push(Item::Const(1));
            self.plain(Op::Sub);
            self.plain(Op::Sqr);
            self.plain(Op::Drop);
        }
        self.level(cycle);
        match &cycle.repeats {
            Some(repeats) if repeats.constant() != Some(1) => {
                let (top, exit) = (self.fresh(), self.fresh());
                self.expr(repeats);
                self.plain(Op::Dup);
                self.push(Item::Const(0));
                self.push(Item::Branch(Cond::Le, exit));
                self.push(Item::Label(top));
                self.plain(Op::Over);
                self.hole(cycle);
                self.push(Item::Const(1));
                self.plain(Op::Sub);
                self.plain(Op::Dup);
                self.push(Item::Branch(Cond::Nonzero, top));
                self.push(Item::Label(exit));
                self.plain(Op::Drop);
                self.plain(Op::Drop);
            }
            _ => self.hole(cycle),
        }
        if !cycle.z.value.is_simple() {
            self.plain(Op::Drop);
        }
    }

    /// Pushes the R plane, while Z is where it was before the cycle.
    fn level(&mut self, cycle: &Cycle) {
        self.expr(&cycle.r.value);
        if cycle.r.frame == Frame::Relative {
            self.look(z_look(steps(&cycle.r.value)), Axis::Z as u8);
            self.plain(Op::Add);
        }
    }

    /// One hole; takes R from the stack.
    fn hole(&mut self, cycle: &Cycle) {
        let z = Axis::Z as u8;
        let mut in_steps = steps(&cycle.r.value);
        let words = [cycle.xy[0].as_ref(), cycle.xy[1].as_ref(), None];
        let moves = words.iter().any(Option::is_some);
        // Where X or Y may fail they are evaluated before the first move.
        let early = words.iter().flatten().any(|word| !word.value.is_simple());
        if early {
            words.iter().flatten().for_each(|word| self.expr(&word.value));
            match words.iter().flatten().count() {
                1 => self.plain(Op::Over),
                _ => self.level(cycle),
            }
        } else {
            self.plain(Op::Dup);
        }
        // Up to R if below it.
        self.look(z_look(in_steps), z);
        self.plain(Op::Max);
        self.linear_on_stack(true, z_word(in_steps), false);
        if early {
            self.linear_on_stack(true, kinds_of(words), false);
        } else if moves {
            self.linear(true, words, false);
        }
        self.plain(Op::Dup);
        self.linear_on_stack(true, z_word(in_steps), false);
        if cycle.old_z.is_some() && in_steps {
            self.plain(Op::Drop);
            self.look(Look::Pos, z);
            in_steps = false;
        }
        match &cycle.kind {
            CycleKind::Drill => self.down(cycle),
            CycleKind::Dwell(time) => {
                self.down(cycle);
                self.expr(time);
                self.plain(Op::Wait);
            }
            CycleKind::Peck(depth) => self.peck(cycle, depth, in_steps),
        }
        if let Some(old_z) = cycle.old_z {
            self.push(Item::Load(old_z));
            self.plain(Op::Max);
        }
        self.linear_on_stack(true, z_word(in_steps), false);
    }

    /// To the bottom, which counts from R when it is relative; the axis is at R.
    fn down(&mut self, cycle: &Cycle) {
        if cycle.z.value.is_simple() {
            return self.linear(false, [None, None, Some(&cycle.z)], cycle.exact);
        }
        self.plain(Op::Over);
        self.linear_on_stack(false, kinds_of([None, None, Some(&cycle.z)]), cycle.exact);
    }

    /// G83, in the unit of Z. On the stack: R and above it the depth that was reached, as Z counts:
    /// from R when it is relative. An R in the other unit lies below those.
    fn peck(&mut self, cycle: &Cycle, depth: &Expr, r_in_steps: bool) {
        let relative = cycle.z.frame == Frame::Relative;
        let in_steps = steps(&cycle.z.value);
        let mixed = in_steps != r_in_steps;
        let (top, done) = (self.fresh(), self.fresh());
        if mixed {
            self.look(z_look(in_steps), Axis::Z as u8);
        }
        match relative {
            true => self.push(Item::Const(0)),
            false => self.plain(Op::Dup),
        }
        self.push(Item::Label(top));
        self.in_unit(depth, in_steps);
        self.plain(Op::Sub);
        self.expr(&cycle.z.value);
        self.plain(Op::Max);
        self.reached(relative);
        self.linear_on_stack(false, z_word(in_steps), cycle.exact);
        self.plain(Op::Dup);
        self.expr(&cycle.z.value);
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
        if mixed {
            self.plain(Op::Drop);
        }
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
        let value_in_steps = steps(value);
        if in_steps != value_in_steps {
            let op = if in_steps { Op::ToSteps } else { Op::ToLength };
            self.flags(op, [Axis::Z as u8, 0, 0]);
        }
    }
}
