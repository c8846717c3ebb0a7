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

/// An end that only jumps come to, and that there is elsewhere, is jumped to there.
pub fn elsewhere(blocks: &Blocks) -> Option<Vec<Line>> {
    let places = blocks.places();
    for at in blocks.ops() {
        let Some(end) = blocks.op(at).filter(|op| op.returns()) else { continue };
        let labels = blocks.labels_of(at);
        let Some(before) = at.checked_sub(labels.len() + 1) else { continue };
        let fallen = blocks.op(before).is_none_or(|op| !op.is_end());
        if labels.is_empty() || fallen || labels.iter().any(|label| blocks.here.contains(*label)) {
            continue;
        }
        let users = blocks.ops().into_iter().filter(|user| {
            let to = blocks.op(*user).and_then(|op| op.to.as_deref());
            to.is_some_and(|to| labels.contains(&to))
        });
        let users = users.collect::<Vec<_>>();
        let near =
            |other: &usize| users.iter().all(|user| places[*user].abs_diff(places[*other]) < REACH);
        let mut others = blocks.ops().into_iter();
        let Some(other) =
            others.find(|other| *other != at && blocks.op(*other) == Some(end) && near(other))
        else {
            continue;
        };
        let label = blocks.label();
        let mut lines = Vec::new();
        for (n, line) in blocks.lines.iter().enumerate() {
            if n == other {
                lines.push(Line::Label(label.clone(), false));
            }
            if n > before && n <= at {
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
