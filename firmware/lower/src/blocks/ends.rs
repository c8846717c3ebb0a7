//! Rules of ends: of two ways that end alike one jumps into the other.

use super::{Blocks, REACH};
use crate::ops::{Line, Op};

/// Of two ways with the same operations up to their ends the one jumps into the other: the longest first.
pub fn merge(blocks: &Blocks) -> Option<Vec<Line>> {
    let places = blocks.places();
    let ops = blocks.ops();
    let op = |n: usize| blocks.op(ops[n]);
    let ends = (0..ops.len())
        .filter(|n| op(*n).is_some_and(|op| op.returns() || op.name == "GOTO" && op.when.is_none()))
        .collect::<Vec<_>>();
    let mut best: Option<(usize, usize, usize, usize)> = None;
    for &x in &ends {
        for &y in &ends {
            if x == y || places[ops[x]].abs_diff(places[ops[y]]) >= REACH {
                continue;
            }
            let (mut length, mut bytes) = (0, 0);
            while length <= x && length <= y && x - length != y {
                let (Some(a), Some(b)) = (op(x - length), op(y - length)) else { break };
                if a != b || a.is_place() || length > 0 && a.is_end() {
                    break;
                }
                bytes += blocks.size(a);
                length += 1;
                // Ways that jump into it end it here.
                if !blocks.labels_of(ops[x + 1 - length]).is_empty() {
                    break;
                }
            }
            if bytes > 2 && best.is_none_or(|(gain, ..)| bytes - 2 > gain) {
                best = Some((bytes - 2, x, y, length));
            }
        }
    }
    let (_, x, y, length) = best?;
    let (from, into) = (ops[x + 1 - length], ops[y + 1 - length]);
    let label = blocks.label();
    let mut lines = Vec::new();
    for (at, line) in blocks.lines.iter().enumerate() {
        if at == into {
            lines.push(Line::Label(label.clone(), false));
        }
        if at == from {
            lines.push(Line::Op(Op::read("GOTO").to(&label)));
        }
        let gone = (from..=ops[x]).contains(&at) && matches!(line, Line::Op(_));
        if !gone {
            lines.push(line.clone());
        }
    }
    Some(lines)
}

/// What stands in front of a GOTO and in front of the place that it goes to stands there alone.
pub fn sink(blocks: &Blocks) -> Option<Vec<Line>> {
    for at in 1..blocks.lines.len() {
        let (Some(goto), Some(before)) = (blocks.op(at), blocks.op(at - 1)) else { continue };
        let Some(label) = goto.to.as_deref().filter(|_| goto.name == "GOTO" && goto.when.is_none())
        else {
            continue;
        };
        let Some(target) = blocks.target(label) else { continue };
        let labels = blocks.labels_of(target).len();
        let Some(place) = target.checked_sub(labels + 1) else { continue };
        if place != at - 1 && place != at && blocks.op(place) == Some(before) && !before.is_end() {
            let label = blocks.label();
            let mut lines = blocks.lines.clone();
            lines[at] = Line::Op(Op::read("GOTO").to(&label));
            lines.insert(place, Line::Label(label, false));
            lines.remove(if place < at { at } else { at - 1 });
            return Some(lines);
        }
    }
    None
}

/// Operations up to an end that only jumps come to, and that there are elsewhere, are jumped to there.
pub fn elsewhere(blocks: &Blocks) -> Option<Vec<Line>> {
    let places = blocks.places();
    for at in blocks.ops() {
        let labels = blocks.labels_of(at);
        let Some(before) = at.checked_sub(labels.len() + 1) else { continue };
        let fallen = blocks.op(before).is_none_or(|op| !op.is_end());
        if labels.is_empty() || fallen || labels.iter().any(|label| blocks.here.contains(*label)) {
            continue;
        }
        let Some(length) = blocks.way(at) else { continue };
        let users = blocks.ops().into_iter().filter(|user| {
            let to = blocks.op(*user).and_then(|op| op.to.as_deref());
            to.is_some_and(|to| labels.contains(&to))
        });
        let users = users.collect::<Vec<_>>();
        let near =
            |other: &usize| users.iter().all(|user| places[*user].abs_diff(places[*other]) < REACH);
        let Some(other) = blocks.same_ways(at, length).into_iter().find(near) else { continue };
        let label = blocks.label();
        let mut lines = Vec::new();
        for (n, line) in blocks.lines.iter().enumerate() {
            if n == other {
                lines.push(Line::Label(label.clone(), false));
            }
            if n > before && n < at + length {
                continue;
            }
            lines.push(match line {
                Line::Op(op) if users.contains(&n) => Line::Op(op.clone().to(&label)),
                line => line.clone(),
            });
        }
        return Some(lines);
    }
    None
}

/// A jump over operations up to an end that there are elsewhere is the inverse jump to them there.
pub fn over(blocks: &Blocks) -> Option<Vec<Line>> {
    let places = blocks.places();
    for at in blocks.ops() {
        let Some(over) = blocks.op(at) else { continue };
        let (Some(inverse), Some(past)) = (crate::ops::inverse(&over.name), &over.to) else {
            continue;
        };
        let Some(length) = blocks.way(at + 1) else { continue };
        if !blocks.may_fall(past, at + 1 + length) {
            continue;
        }
        let near = |other: &usize| places[*other].abs_diff(places[at]);
        let others = blocks.same_ways(at + 1, length).into_iter();
        let Some(other) = others.filter(|other| near(other) < REACH).min_by_key(near) else {
            continue;
        };
        let label = blocks.label();
        let turned = Op { name: inverse.to_owned(), to: Some(label.clone()), ..over.clone() };
        let mut lines = blocks.lines.clone();
        lines[at] = Line::Op(turned);
        lines.insert(other, Line::Label(label, false));
        let first = if other > at { at + 1 } else { at + 2 };
        lines.drain(first..first + length);
        return Some(lines);
    }
    None
}

impl Blocks {
    /// How many operations lead from a line to an end, when no other way comes in between.
    pub(super) fn way(&self, at: usize) -> Option<usize> {
        let mut ops = (1..).map_while(|n| Some((n, self.op(at + n - 1)?.returns())));
        ops.find_map(|(n, returns)| returns.then_some(n))
    }

    /// Other places from which the same operations lead to an end.
    pub(super) fn same_ways(&self, at: usize, length: usize) -> Vec<usize> {
        let ops = self.ops();
        let same = |first: usize, n: usize| {
            ops.get(first + n).and_then(|n| self.op(*n)) == self.op(at + n)
        };
        let alike = |first: &usize| (0..length).all(|n| same(*first, n));
        (0..ops.len()).filter(alike).map(|n| ops[n]).filter(|other| *other != at).collect()
    }
}
