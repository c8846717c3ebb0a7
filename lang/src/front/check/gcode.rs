//! G-code blocks: taken apart, followed through the control flow, lowered with their modal state.

mod arc;
mod block;
mod cycle;
mod lower;
mod modal;
mod outputs;
mod solve;
mod word;

use std::collections::HashMap;

use super::Checker;
use super::calls::Calls;
use super::graph::Graph;
use crate::front::ast::{GValue, GWord, Stmt};
use crate::front::literal::Decimal;
use crate::hir::{RoutineId, VarId};
use block::Block;
use modal::Group;

/// A word of a canned cycle that stays for the next ones.
#[derive(Debug)]
struct Held<'a> {
    word: &'a GWord,
    /// The block that it stands in, and the SUB.
    block: u32,
    scope: RoutineId,
    /// Where its value is kept when it is not constant and another block uses it.
    var: Option<VarId>,
    /// Whether another block uses it.
    needed: bool,
}

/// All G-code blocks of a script.
#[derive(Debug, Default)]
pub(super) struct Blocks<'a> {
    list: Vec<Block<'a>>,
    /// By the place of the statement.
    by_place: HashMap<u32, u32>,
    held: Vec<Held<'a>>,
    /// It was told that cycles go the wrong way on this machine.
    downward_told: bool,
    /// Ids of held constants: equal ones from two paths are no conflict.
    constants: HashMap<(char, Decimal), i32>,
    /// Held words of each block.
    words: Vec<Vec<(Group, i32)>>,
    /// The state before each block.
    states: solve::Reached,
    plan: cycle::Plan,
    /// The commanded work position as far as the last blocks tell, um.
    position: [Option<i32>; 3],
    /// The warning of the default feed was given.
    default_feed_told: bool,
}

impl Blocks<'_> {
    fn held_words(&self, block: u32) -> impl Iterator<Item = (Group, i32)> {
        self.words[block as usize].iter().copied()
    }
}

/// Takes a block apart; gives its number, and whether it ends the run.
pub(super) fn add_block<'a>(
    checker: &mut Checker<'a>,
    words: &'a [GWord],
    stmt: &'a Stmt,
) -> (u32, bool) {
    let block = block::take_apart(checker, words, stmt.span);
    let ends = block.ends();
    let index = checker.gcode.list.len() as u32;
    let mut held = Vec::new();
    for (group, word) in
        [(Group::R, block.r), (Group::Z, block.axes[2]), (Group::P, block.p), (Group::Q, block.q)]
    {
        let Some(word) = word else { continue };
        let next = checker.gcode.held.len() as i32 + 1;
        let id = match &word.value {
            GValue::Number(number) => {
                *checker.gcode.constants.entry((word.letter, *number)).or_insert(next)
            }
            GValue::Expr(_) => next,
        };
        if id == next {
            checker.gcode.held.push(Held {
                word,
                block: index,
                scope: checker.scope,
                var: None,
                needed: false,
            });
        }
        held.push((group, id));
    }
    checker.gcode.words.push(held);
    checker.gcode.by_place.insert(stmt.span.start, index);
    checker.gcode.list.push(block);
    (index, ends)
}

/// Finds the modal state before every block.
pub(super) fn analyse(checker: &mut Checker<'_>, graph: &Graph, calls: &Calls) {
    if checker.gcode.list.is_empty() {
        return;
    }
    let default_feed = checker.profile.default_feed_um_s.is_some();
    checker.gcode.states = solve::solve(graph, calls, &checker.gcode, default_feed);
    cycle::plan(checker, graph);
}
