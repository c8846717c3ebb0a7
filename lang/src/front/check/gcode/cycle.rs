//! G81, G82, G83: words that stay, and the Z that G98 goes back to.

use super::block::{Block, Motion};
use super::modal::{DEFAULT_FEED, Group, State, Value};
use super::word::Context;
use crate::axis::Axis;
use crate::effect::Frame;
use crate::front::ast::{GValue, GWord, Machine};
use crate::front::check::expr::{number, value_of};
use crate::front::check::graph::{Graph, Target, moves};
use crate::front::check::{Checker, range};
use crate::front::codes::Code;
use crate::front::span::Span;
use crate::hir::{
    self, Arm, BinOp, Cycle, CycleKind, Expr, ExprKind, LabelId, Place, ReadKind, RoutineId,
    StmtKind, Storage, VarId, Word,
};
use crate::kind::Kind;
use crate::profile::AxisProfile;

/// In the cell that holds the Z before the first cycle: none is held.
const RELEASED: i32 = i32::MIN;

/// How the Z before the first cycle is kept, for the main program and for handlers: a handler's
/// cycles must not disturb those that it interrupts.
#[derive(Debug, Default)]
pub(super) struct Plan {
    classes: [Class; 2],
    /// Labels and SUBs where handlers begin.
    handlers: Vec<Target>,
    /// Some block goes at the profile's default feed.
    default_feed: bool,
}

#[derive(Debug, Default)]
struct Class {
    var: Option<VarId>,
    /// A cycle under G98 may find a Z that an earlier one took.
    keeps: bool,
    /// Whether one is held differs between the ways to some cycle: the cell tells it at run time.
    at_run_time: bool,
}

/// Main program or handlers.
pub(super) fn class_of(state: &State) -> usize {
    usize::from(state.get(Group::Class).single() == Some(1))
}

/// Looks over all cycles before the first block is lowered.
pub(super) fn plan(checker: &mut Checker<'_>, graph: &Graph) {
    let mut plan = Plan {
        handlers: graph
            .events
            .iter()
            .map(|(target, _)| *target)
            .chain(graph.errors.iter().map(|(label, _)| Target::Label(*label)))
            .collect(),
        ..Plan::default()
    };
    let mut levels: [Vec<Option<i32>>; 2] = Default::default();
    let mut only_g98 = [true; 2];
    let mut needed = Vec::new();
    for (index, block) in checker.gcode.list.iter().enumerate() {
        let Some(before) = checker.gcode.states.state(index as u32) else { continue };
        let feed = before.get(Group::Feed).written;
        let moves = block.special.is_some() || block.has_axis();
        plan.default_feed |= moves
            && block.f.is_none()
            && feed.is_some_and(|both| both.iter().any(|(feed, _)| *feed == DEFAULT_FEED));
        let mut state = before;
        checker.gcode.apply(index as u32, block, &mut state);
        let cycle = state.motion().is_some_and(Motion::is_cycle);
        if !cycle || !block.has_axis() || block.special.is_some() {
            continue;
        }
        let class = class_of(&state);
        let g98 = state.get(Group::Retract).single() == Some(0);
        only_g98[class] &= g98;
        levels[class].push(level(checker, block, &state));
        let held = before.get(Group::Held).single();
        plan.classes[class].keeps |= g98 && held != Some(0);
        plan.classes[class].at_run_time |= held.is_none();
        let words = [
            (Group::R, block.r),
            (Group::Z, block.axes[2]),
            (Group::P, block.p),
            (Group::Q, block.q),
        ];
        for (group, word) in words {
            if word.is_none()
                && let Some(id) = state.get(group).single()
            {
                needed.push(id);
            }
        }
    }
    for (class, part) in plan.classes.iter_mut().enumerate() {
        let mut rest = levels[class].iter();
        let first = rest.next().copied().flatten();
        // With one R for all of them, and G98 throughout, the Z that a cycle leaves takes the next
        // one back to the same place: taking it anew each time needs no memory.
        if only_g98[class] && first.is_some() && rest.all(|level| *level == first) {
            part.keeps = false;
        }
        part.at_run_time &= part.keeps;
    }
    for id in needed {
        if let Some(held) = usize::try_from(id - 1).ok().and_then(|i| checker.gcode.held.get_mut(i))
        {
            held.needed = true;
        }
    }
    checker.gcode.plan = plan;
}

/// The held word of an absolute, constant R; None where it is anything else.
fn level(checker: &Checker<'_>, block: &Block<'_>, state: &State) -> Option<i32> {
    if state.get(Group::Distance).single() != Some(0) {
        return None;
    }
    let word = match block.r {
        Some(word) => word,
        None => {
            checker.gcode.held.get(usize::try_from(state.get(Group::R).single()? - 1).ok()?)?.word
        }
    };
    match word.value {
        GValue::Number(_) => checker.gcode.constants.iter().find_map(|((letter, number), id)| {
            (*letter == 'R' && GValue::Number(*number) == word.value).then_some(*id)
        }),
        GValue::Expr(_) => None,
    }
}

impl<'a> Checker<'a> {
    /// Statements before the main program's first.
    pub(in crate::front::check) fn gcode_prologue(&mut self) -> hir::Block {
        let mut out = Vec::new();
        if let Some(feed) = self.profile.default_feed_um_s
            && self.gcode.plan.default_feed
        {
            out.push(StmtKind::SetFeed(number(feed, Kind::Speed, Span::default())));
        }
        out.extend(self.release(0));
        let place = |kind| hir::Stmt { line: 1, span: 0..0, kind };
        out.into_iter().map(place).collect()
    }

    /// Statements before the first of a SUB that serves events.
    pub(in crate::front::check) fn gcode_sub_prologue(&mut self, id: RoutineId) -> hir::Block {
        if !self.gcode.plan.handlers.contains(&Target::Routine(id)) {
            return Vec::new();
        }
        let Some(routine) = self.routine(id) else { return Vec::new() };
        let place = |kind| hir::Stmt { line: routine.line, span: range(routine.span), kind };
        self.release(1).into_iter().map(place).collect()
    }

    /// Statements behind a label where a handler begins.
    pub(in crate::front::check) fn gcode_label_prologue(
        &mut self,
        label: LabelId,
    ) -> Option<StmtKind> {
        self.gcode.forget_position();
        if self.gcode.plan.handlers.contains(&Target::Label(label)) {
            self.release(1)
        } else {
            None
        }
    }

    /// No Z is held from here on, where that must be known at run time.
    pub(in crate::front::check) fn release(&mut self, class: usize) -> Option<StmtKind> {
        if !self.gcode.plan.classes[class].at_run_time {
            return None;
        }
        let var = self.old_z(class);
        let none = number(RELEASED, Kind::Length, Span::default());
        Some(StmtKind::Assign(Place::Var(var), none))
    }

    /// Motion outside G-code lets go of the held Z.
    pub(in crate::front::check) fn machine_moved(&mut self, machine: &Machine) -> Option<StmtKind> {
        let class = usize::from(self.handler_only(self.scope));
        if moves(machine) { self.release(class) } else { None }
    }

    fn old_z(&mut self, class: usize) -> VarId {
        if let Some(var) = self.gcode.plan.classes[class].var {
            return var;
        }
        let name = if class == 0 { "z before cycles" } else { "z before cycles of handlers" };
        let var = self.add_var(name, Kind::Length, Span::default(), Storage::Global);
        self.gcode.plan.classes[class].var = Some(var);
        var
    }

    /// A word of the cycle: written here, or held from an earlier block.
    fn cycle_word(
        &mut self,
        group: Group,
        word: Option<&'a GWord>,
        context: &Context,
        out: &mut Vec<StmtKind>,
    ) -> Option<Option<Expr>> {
        let value = |checker: &mut Checker<'a>, word: &'a GWord| match group {
            Group::P => checker.seconds_word(word),
            _ => {
                let relative = checker.frame(context)? == Frame::Relative;
                checker.distance_word(word, context, relative && group != Group::Q)
            }
        };
        let id = match word {
            Some(word) => {
                let lowered = value(self, word)?;
                if value_of(&lowered).is_some() {
                    return Some(Some(lowered));
                }
                // Kept where a later block asks for it.
                let Some(index) = self.gcode.held.iter().position(|h| core::ptr::eq(h.word, word))
                else {
                    return Some(Some(lowered));
                };
                if !self.gcode.held[index].needed {
                    return Some(Some(lowered));
                }
                let var = self.held_var(index, lowered.kind, word.span);
                out.push(StmtKind::Assign(Place::Var(var), lowered));
                return Some(Some(self.variable(var, word.span)));
            }
            None => self.modal(context, group)?,
        };
        let Some(index) = usize::try_from(id - 1).ok() else { return Some(None) };
        let Some(held) = self.gcode.held.get(index) else { return Some(None) };
        let held_word = held.word;
        if let GValue::Number(_) = held_word.value {
            return Some(Some(value(self, held_word)?));
        }
        // What its names and units mean where it was written.
        let (block, scope) = (held.block, core::mem::replace(&mut self.scope, held.scope));
        let written = self.written_in(block, context.line);
        let lowered = match group {
            Group::P => self.seconds_word(held_word),
            _ => self.distance_word(held_word, &written, false),
        };
        self.scope = scope;
        let lowered = lowered?;
        if value_of(&lowered).is_some() {
            return Some(Some(lowered));
        }
        let var = self.held_var(index, lowered.kind, held_word.span);
        Some(Some(self.variable(var, context.span)))
    }

    /// The modal state in which a block was written.
    fn written_in(&self, index: u32, line: u32) -> Context {
        let block = &self.gcode.list[index as usize];
        let mut state = self.gcode.states.state(index).unwrap_or_else(|| State::start(true));
        self.gcode.apply(index, block, &mut state);
        Context { state, span: block.span, line }
    }

    fn held_var(&mut self, index: usize, kind: Kind, span: Span) -> VarId {
        if let Some(var) = self.gcode.held[index].var {
            return var;
        }
        let var = self.add_var("cycle word", kind, span, Storage::Global);
        self.gcode.held[index].var = Some(var);
        var
    }

    /// Tells once where cycles go the wrong way.
    fn warn_downward(&mut self, span: Span, motion: Motion) {
        let down = self.profile.z.as_ref().is_some_and(AxisProfile::counts_down);
        if down && !std::mem::replace(&mut self.gcode.downward_told, true) {
            let (word, name) = (motion.word(), &self.profile.name);
            let message = format!(
                "Z of `{name}` counts downward, and {word} takes a greater Z for a higher one"
            );
            let hint = "write the moves: `G0 Z` to above the work, `G1 Z` into it, `G0 Z` back";
            self.error(Code::CycleDownward, span, message, hint);
        }
    }

    pub(super) fn cycle(
        &mut self,
        index: u32,
        block: &Block<'a>,
        context: &Context,
        motion: Motion,
    ) -> Option<Vec<StmtKind>> {
        if !self.has_axis(Axis::Z, block.span) {
            return None;
        }
        let mut out = Vec::new();
        let frame = self.frame(context)?;
        let r = self.cycle_word(Group::R, block.r, context, &mut out)?;
        let z = self.cycle_word(Group::Z, block.axes[2], context, &mut out)?;
        let p = self.cycle_word(Group::P, block.p, context, &mut out)?;
        let q = self.cycle_word(Group::Q, block.q, context, &mut out)?;
        let missing = |value: Option<Expr>, letter: char, checker: &mut Checker<'a>| {
            if value.is_none() {
                let message = format!("{} without {letter}", motion.word());
                let hint = "write `G81 X10 Y10 Z-3 R1`; G82 takes P, G83 takes Q";
                checker.error(Code::GcodeMissing, block.span, message, hint);
            }
            value
        };
        if !block.has_axis() {
            // Words for the blocks that follow.
            return Some(out);
        }
        self.warn_downward(block.span, motion);
        let r = missing(r, 'R', self);
        let z = missing(z, 'Z', self);
        let kind = match motion {
            Motion::Drill => CycleKind::Drill,
            Motion::DrillDwell => CycleKind::Dwell(missing(p, 'P', self)?),
            _ => {
                let depth = missing(q, 'Q', self)?;
                if let Some(word) = block.q {
                    self.positive(&depth, word)?;
                }
                CycleKind::Peck(depth)
            }
        };
        let (r, z) = (r?, z?);
        let mut xy = [None, None];
        for (slot, axis) in xy.iter_mut().zip([Axis::X, Axis::Y]) {
            if let Some(word) = block.axes[axis.index()] {
                *slot = Some(self.axis_word(axis, word, context, false)?);
            }
        }
        let repeats = match block.l {
            Some(word) => {
                let repeats = self.number_word(word)?;
                self.positive(&repeats, word)?;
                Some(repeats)
            }
            None => None,
        };
        out.extend(self.need_feed(context)?);
        self.note_path([Axis::Z], false);
        let g98 = self.modal(context, Group::Retract)? == 0;
        let exact = self.modal(context, Group::Exact)? == 1;
        let (old_z, takes_z) = self.take_z(index, g98, context, &mut out);
        self.gcode.forget_position();
        out.push(StmtKind::Cycle(Box::new(Cycle {
            kind,
            xy,
            r: Word { value: r, frame },
            z: Word { value: z, frame },
            repeats,
            old_z,
            takes_z,
            exact,
        })));
        Some(out)
    }

    /// The variable that G98 goes back to, and whether the cycle itself takes Z into it.
    fn take_z(
        &mut self,
        index: u32,
        g98: bool,
        context: &Context,
        out: &mut Vec<StmtKind>,
    ) -> (Option<VarId>, bool) {
        let (span, line) = (context.span, context.line);
        let before = self.gcode.states.state(index);
        let class = before.as_ref().map_or(0, class_of);
        let part = &self.gcode.plan.classes[class];
        let held = before.as_ref().map(|s| s.get(Group::Held)).and_then(Value::single);
        let (keeps, at_run_time) = (part.keeps, part.at_run_time);
        if !g98 && !keeps {
            return (None, false);
        }
        let var = self.old_z(class);
        let takes = !keeps || held == Some(0);
        if g98 && takes {
            return (Some(var), true);
        }
        let read = Expr {
            kind: Kind::Length,
            span: range(span),
            node: ExprKind::Read(ReadKind::Pos(Axis::Z)),
        };
        let take = StmtKind::Assign(Place::Var(var), read);
        if takes {
            out.push(take);
        } else if held.is_none() && at_run_time {
            let none = Box::new(number(RELEASED, Kind::Length, span));
            let now = Box::new(self.variable(var, span));
            let node = ExprKind::Binary(BinOp::Eq, now, none);
            let condition = Expr { kind: Kind::Truth, span: range(span), node };
            let body = vec![hir::Stmt { line, span: range(span), kind: take }];
            let arms = vec![Arm { line, condition, body }];
            out.push(StmtKind::If { arms, otherwise: Vec::new(), one_line: true });
        }
        (g98.then_some(var), false)
    }
}
