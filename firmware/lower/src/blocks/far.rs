//! Jumps that reach no further than a byte says go by steps.

use super::flow::parts;
use super::{Blocks, REACH};
use crate::ops::{Line, Op};

/// Puts blocks into an order in which as few jumps as possible do not reach their places.
pub fn order(blocks: &mut Blocks) {
    let mut lost = blocks.lost();
    while lost != (0, 0) {
        let parts = parts(&blocks.lines);
        let mut best = None;
        for x in 1..parts.len() {
            for y in (1..parts.len()).filter(|y| *y != x) {
                let mut order = (0..parts.len()).filter(|n| *n != x).collect::<Vec<_>>();
                order.insert(y, x);
                let lines = order.iter().flat_map(|n| parts[*n].iter().cloned()).collect();
                let tried = blocks.with(lines);
                let now = tried.lost();
                if now < lost {
                    lost = now;
                    best = Some(tried);
                }
            }
        }
        match best {
            Some(tried) => *blocks = tried,
            None => return,
        }
    }
}

/// The lines with a step on the way of the first jump that does not reach its place.
pub fn step(blocks: &Blocks) -> Option<Vec<Line>> {
    let places = blocks.places();
    let place_of = |label: &str| {
        let at = blocks
            .lines
            .iter()
            .position(|line| matches!(line, Line::Label(name, _) if name == label));
        at.map(|at| places[at])
    };
    for at in blocks.ops() {
        let Some(to) = blocks.op(at).and_then(|op| op.to.as_deref()) else { continue };
        let Some(place) = place_of(to).filter(|place| place.abs_diff(places[at]) >= REACH) else {
            continue;
        };
        // The step that is nearest to the place: one that there is already, or one behind an end.
        let nearer = |n: usize| {
            let (way, rest) = (places[n].abs_diff(places[at]), places[n].abs_diff(place));
            way < REACH && rest < place.abs_diff(places[at])
        };
        let there = blocks.ops().into_iter().filter(|n| {
            *n != at
                && blocks.op(*n).is_some_and(|op| {
                    op.name == "GOTO" && op.when.is_none() && op.to.as_deref() == Some(to)
                })
        });
        let new = (1..blocks.lines.len()).filter(|n| blocks.is_behind_end(*n));
        let by_rest = |n: &usize| places[*n].abs_diff(place);
        let mut lines = blocks.lines.clone();
        let label = blocks.label();
        let jump = blocks.op(at)?.clone().to(&label);
        if let Some(n) = there.filter(|n| nearer(*n)).min_by_key(by_rest) {
            lines[at] = Line::Op(jump);
            lines.insert(n, Line::Label(label, false));
        } else {
            let Some(n) = new.filter(|n| nearer(*n)).min_by_key(by_rest) else { continue };
            lines[at] = Line::Op(jump);
            lines.insert(n, Line::Op(Op::read("GOTO").to(to)));
            lines.insert(n, Line::Label(label, false));
        }
        return Some(lines);
    }
    None
}

impl Blocks {
    /// How many jumps do not reach their places, and by how many bytes together.
    fn lost(&self) -> (usize, usize) {
        let places = self.places();
        let labels = self.lines.iter().zip(&places).filter_map(|(line, place)| match line {
            Line::Label(name, _) => Some((name.as_str(), *place)),
            _ => None,
        });
        let labels = labels.collect::<std::collections::BTreeMap<_, _>>();
        let jumps = self.lines.iter().zip(&places).filter_map(|(line, place)| match line {
            Line::Op(op) => Some(labels.get(op.to.as_deref()?)?.abs_diff(*place)),
            _ => None,
        });
        let far = jumps.filter(|way| *way >= REACH);
        far.fold((0, 0), |(count, sum), way| (count + 1, sum + way - REACH))
    }

    /// Whether execution comes to a line by jumps alone, and nothing belongs to what stands before it.
    fn is_behind_end(&self, at: usize) -> bool {
        let last = self.lines[..at].iter().rev().find_map(|line| match line {
            Line::Op(op) => Some(op.is_end()),
            Line::Label(..) => Some(false),
            Line::Check(_) => None,
        });
        let next = self.lines.get(at);
        let listed = matches!(next, Some(Line::Op(op)) if op.is_place());
        last == Some(true) && !listed && !matches!(next, Some(Line::Check(_)))
    }
}
