//! Follows the modal state over the graph: first what each procedure does to it, callees before
//! callers, then what reaches each block.

use super::Blocks;
use super::block::{Block, Motion};
use super::modal::{FEED, Group, State};
use crate::effect::Plane;
use crate::front::check::calls::Calls;
use crate::front::check::graph::{Graph, Node, NodeId, Op, Target};
use crate::front::span::Span;
use std::collections::HashMap;

/// What a procedure does to the state, relative to its entry; None where it never gets there.
#[derive(Clone, Copy, Debug, Default)]
struct Effect {
    /// At RETURN or the end.
    back: Option<State>,
    /// Of GOSUB lines: at EXIT SUB, RETURN value, the end of the SUB around them.
    out: Option<State>,
}

/// Index of a state in a table.
type StateId = u32;

/// Different states, each once: long programs have few.
#[derive(Debug, Default)]
struct Table {
    list: Vec<State>,
    ids: HashMap<State, StateId>,
    /// The one found last: most steps change nothing, and comparing is cheaper than hashing.
    last: StateId,
}

impl Table {
    fn id(&mut self, state: &State) -> StateId {
        if self.list.get(self.last as usize) == Some(state) {
            return self.last;
        }
        self.last = *self.ids.entry(*state).or_insert_with(|| {
            self.list.push(*state);
            self.list.len() as StateId - 1
        });
        self.last
    }
}

/// The state that reaches each block.
#[derive(Debug, Default)]
pub(super) struct Reached {
    table: Vec<State>,
    blocks: Vec<Option<StateId>>,
}

impl Reached {
    /// Before a block, by its number; None where nothing reaches it.
    pub fn state(&self, block: u32) -> Option<State> {
        let id = (*self.blocks.get(block as usize)?)?;
        self.table.get(id as usize).copied()
    }
}

struct Solver<'s> {
    graph: &'s Graph,
    calls: &'s Calls,
    blocks: &'s Blocks<'s>,
    effects: Vec<Effect>,
    table: Table,
    states: Vec<Option<StateId>>,
    touched: Vec<NodeId>,
    work: Vec<NodeId>,
}

/// The state that reaches each block, by its number; None where nothing does.
pub(super) fn solve(
    graph: &Graph,
    calls: &Calls,
    blocks: &Blocks<'_>,
    default_feed: bool,
) -> Reached {
    let mut solver = Solver {
        graph,
        calls,
        blocks,
        effects: vec![Effect::default(); calls.procs.len()],
        table: Table::default(),
        states: vec![None; graph.nodes.len()],
        touched: Vec::new(),
        work: Vec::new(),
    };
    for &proc in &calls.order {
        solver.effect(proc);
    }
    solver.whole(default_feed)
}

impl Solver<'_> {
    fn reach(&mut self, node: NodeId, state: &State) {
        let id = match self.states[node as usize] {
            Some(id) => {
                let mut known = self.table.list[id as usize];
                if !known.join(state) {
                    return;
                }
                self.table.id(&known)
            }
            None => {
                self.touched.push(node);
                self.table.id(state)
            }
        };
        self.states[node as usize] = Some(id);
        self.work.push(node);
    }

    /// Takes the next node that must be looked at, with its state.
    fn next(&mut self) -> Option<(NodeId, State)> {
        while let Some(id) = self.work.pop() {
            if let Some(state) = self.states[id as usize] {
                return Some((id, self.table.list[state as usize]));
            }
        }
        None
    }

    /// What one procedure does.
    fn effect(&mut self, proc: usize) {
        let target = self.calls.procs[proc].target;
        let gosub = matches!(target, Target::Label(_));
        self.reach(self.graph.entry(target), &State::ENTRY);
        let mut effect = Effect::default();
        let add = |slot: &mut Option<State>, state: &State| match slot {
            Some(known) => {
                known.join(state);
            }
            None => *slot = Some(*state),
        };
        while let Some((id, state)) = self.next() {
            let node = self.graph.nodes[id as usize];
            match node.op {
                Op::Return if gosub => add(&mut effect.back, &state),
                Op::Return => add(&mut effect.back, &state),
                Op::Leave if gosub => add(&mut effect.out, &state),
                Op::Leave => add(&mut effect.back, &state),
                _ => {
                    let (after, out) = self.step(&node, &state);
                    if let Some(out) = out {
                        add(if gosub { &mut effect.out } else { &mut effect.back }, &out);
                    }
                    self.flow(&node, after);
                }
            }
        }
        self.effects[proc] = effect;
        for node in self.touched.drain(..) {
            self.states[node as usize] = None;
        }
    }

    /// What reaches each block, over the whole script at once.
    fn whole(mut self, default_feed: bool) -> Reached {
        let graph = self.graph;
        if let Some(&main) = graph.entries.first() {
            self.reach(main, &State::start(default_feed));
        }
        for &(target, span) in &graph.events {
            self.reach(graph.entry(target), &State::handler(span));
        }
        for &(label, span) in &graph.errors {
            self.reach(graph.labels[label.0 as usize], &State::handler(span));
        }
        while let Some((id, state)) = self.next() {
            let node = graph.nodes[id as usize];
            if let Op::Call(routine, _) | Op::Gosub(Target::Routine(routine), _) = node.op {
                self.reach(graph.entries[routine.0 as usize], &state);
            } else if let Op::Gosub(target @ Target::Label(_), _) = node.op {
                self.reach(graph.entry(target), &state);
            }
            let (after, _) = self.step(&node, &state);
            self.flow(&node, after);
        }
        let mut blocks = vec![None; self.blocks.list.len()];
        for (node, state) in graph.nodes.iter().zip(&self.states) {
            if let Op::Gcode(block) = node.op {
                blocks[block as usize] = *state;
            }
        }
        Reached { table: self.table.list, blocks }
    }

    fn flow(&mut self, node: &Node, state: Option<State>) {
        if let Some(state) = state {
            for next in node.next() {
                self.reach(next, &state);
            }
        }
    }

    /// The state behind a node, and the one with which a GOSUB left the routine from inside.
    fn step(&self, node: &Node, state: &State) -> (Option<State>, Option<State>) {
        let mut next = *state;
        match node.op {
            Op::Gcode(block) => {
                self.blocks.apply(block, &self.blocks.list[block as usize], &mut next);
            }
            Op::Plane(plane, span) => next.set(Group::Plane, plane_value(plane), span),
            Op::Moves => next.set(Group::Held, 0, Span::default()),
            Op::Call(routine, _) => return (self.behind(Target::Routine(routine), state).0, None),
            Op::Gosub(target, _) => return self.behind(target, state),
            Op::Nop | Op::Uses(..) | Op::Goto => {}
            Op::Return | Op::Leave | Op::Stop => return (None, None),
        }
        (Some(next), None)
    }

    fn behind(&self, target: Target, state: &State) -> (Option<State>, Option<State>) {
        let effect = self.calls.proc(target).map_or(Effect::default(), |proc| self.effects[proc]);
        (effect.back.map(|e| state.after(&e)), effect.out.map(|e| state.after(&e)))
    }
}

impl Blocks<'_> {
    /// What a block writes.
    pub(super) fn apply(&self, index: u32, block: &Block<'_>, state: &mut State) {
        let span = block.span;
        if let Some(plane) = block.plane {
            state.set(Group::Plane, plane_value(plane), span);
        }
        let flags = [
            (Group::Units, block.inches),
            (Group::Distance, block.relative),
            (Group::Retract, block.retract_r),
            (Group::Exact, block.exact),
        ];
        for (group, flag) in flags {
            if let Some(flag) = flag {
                state.set(group, i32::from(flag), span);
            }
        }
        if let Some(f) = block.f {
            state.set(Group::Feed, FEED, f.span);
        }
        let before = state.motion();
        if let Some(motion) = block.motion {
            state.set(Group::Motion, motion as i32, span);
        }
        let cycle = block.motion.or(before).map(Motion::is_cycle);
        let was_cycle = before.is_none_or(Motion::is_cycle);
        if cycle == Some(false) || !was_cycle {
            for group in [Group::R, Group::Z, Group::P, Group::Q] {
                state.set(group, 0, span);
            }
        }
        if block.special.is_none() && cycle != Some(false) {
            for (group, id) in self.held_words(index) {
                state.set(group, id, span);
            }
        }
        let moves = block.special.is_some() || block.has_axis();
        match cycle {
            Some(true) if block.special.is_none() && moves => state.set(Group::Held, 1, span),
            Some(false) if moves || block.motion == Some(Motion::None) => {
                state.set(Group::Held, 0, span);
            }
            Some(true) if moves => state.set(Group::Held, 0, span),
            None if moves => state.set_either(Group::Held, [0, 1], span),
            _ => {}
        }
    }
}

fn plane_value(plane: Plane) -> i32 {
    plane as i32
}
