//! The order of blocks: the target of a jump stands after it; what both branches begin with stands in front of the jump.

use micro::isa::{Gives, Takes};

use super::Blocks;
use crate::ops::{Line, Op};

/// A block that nothing falls into moves behind a jump to it.
pub fn follow(blocks: &Blocks) -> Option<Vec<Line>> {
    let parts = parts(&blocks.lines);
    let mut best: Option<(usize, Vec<Line>)> = None;
    for x in 0..parts.len() {
        let Some(Line::Op(last)) = parts[x].last() else { continue };
        let Some(label) = blocks.goes_to(last) else { continue };
        let begins = |part: &Vec<Line>| {
            let mut labels = part.iter().take_while(|line| matches!(line, Line::Label(..)));
            labels.any(|line| matches!(line, Line::Label(name, _) if name == label))
        };
        let Some(y) = (1..parts.len()).find(|y| *y != x && begins(&parts[*y])) else { continue };
        let mut order = (0..parts.len()).filter(|n| *n != y).collect::<Vec<_>>();
        let at = order.iter().position(|n| *n == x).unwrap_or_default();
        order.insert(at + 1, y);
        let lines = order.iter().flat_map(|n| parts[*n].iter().cloned()).collect::<Vec<_>>();
        let mut tried = blocks.with(lines);
        tried.clean();
        let bytes = tried.bytes();
        if bytes < blocks.bytes() && best.as_ref().is_none_or(|(least, _)| bytes < *least) {
            best = Some((bytes, tried.lines));
        }
    }
    best.map(|(_, lines)| lines)
}

/// Blocks end where execution does not go on, and the list of a switch with it.
pub fn parts(lines: &[Line]) -> Vec<Vec<Line>> {
    let mut parts: Vec<Vec<Line>> = vec![Vec::new()];
    for line in lines {
        let ended = parts.last().and_then(|part| {
            part.iter().rev().find_map(|line| match line {
                Line::Op(op) => Some(op.is_end()),
                Line::Label(..) => Some(false),
                Line::Check(_) => None,
            })
        });
        if ended == Some(true) && matches!(line, Line::Label(..)) {
            parts.push(Vec::new());
        }
        if let Some(part) = parts.last_mut() {
            part.push(line.clone());
        }
    }
    parts
}

/// What both ways of a jump begin with, that looks at a byte, stands in front of it.
pub fn hoist(blocks: &Blocks) -> Option<Vec<Line>> {
    for at in blocks.ops() {
        let (Some(jump), Some(next)) = (blocks.op(at), blocks.op(at + 1)) else { continue };
        let there = blocks.only_way(at, jump).filter(|there| blocks.op(*there) == Some(next));
        // A jump that is not taken leaves no flags.
        if let Some(there) = there.filter(|_| next.only_looks() && next.facts().flags.is_empty()) {
            let mut lines = blocks.lines.clone();
            lines.remove(there);
            lines.swap(at, at + 1);
            return Some(lines);
        }
    }
    None
}

/// What one way of a jump begins with stands in front of it, where the other way makes the accumulator anew.
pub fn ahead(blocks: &Blocks) -> Option<Vec<Line>> {
    let anew = |op: &Op| {
        let facts = op.facts();
        facts.takes == Takes::Nothing && facts.gives == Gives::Long
    };
    let moves = |op: &Op| op.only_looks() && op.facts().flags.is_empty();
    for at in blocks.ops() {
        let (Some(jump), Some(next)) = (blocks.op(at), blocks.op(at + 1)) else { continue };
        let Some(target) = looks_at_byte(jump).and_then(|label| blocks.target(label)) else {
            continue;
        };
        let Some(first) = blocks.op(target) else { continue };
        let from = if anew(first) && moves(next) {
            at + 1
        } else if anew(next) && moves(first) && blocks.only_way(at, jump).is_some() {
            target
        } else {
            continue;
        };
        let mut lines = blocks.lines.clone();
        let op = lines.remove(from);
        lines.insert(if from < at { at - 1 } else { at }, op);
        let mut tried = blocks.with(lines);
        tried.clean();
        if let Some(lines) = super::ends::over(&tried) {
            return Some(lines);
        }
        if tried.bytes() < blocks.bytes() {
            return Some(tried.lines);
        }
    }
    None
}

/// Where a jump goes that looks at a byte.
fn looks_at_byte(jump: &Op) -> Option<&str> {
    let looks = matches!(
        jump.name.as_str(),
        "IF_ZERO" | "IF_SET" | "IF_ANY" | "IF_NONE" | "IF_IS" | "IF_IS_NOT"
    );
    jump.to.as_deref().filter(|_| looks)
}

impl Blocks {
    /// Where a jump that looks at a byte goes to, when nothing else comes there.
    fn only_way(&self, at: usize, jump: &Op) -> Option<usize> {
        let label = looks_at_byte(jump)?;
        let there = self.target(label).filter(|there| *there != at)?;
        let ways = |op: &Op| op.to.as_deref() == Some(label);
        let users = self.ops().into_iter().filter(|n| self.op(*n).is_some_and(ways)).count();
        let fallen = self.op(there.checked_sub(2)?).is_none_or(|before| !before.is_end());
        (users == 1 && !fallen && self.labels_of(there).len() == 1).then_some(there)
    }
}
