//! The order of blocks: one that a jump goes to stands behind it.

use super::Blocks;
use crate::ops::Line;

/// A block that nothing falls into moves behind a jump to it.
pub fn follow(blocks: &Blocks) -> Option<Vec<Line>> {
    // Blocks end where execution does not go on, and the list of a switch with it.
    let mut parts: Vec<Vec<Line>> = vec![Vec::new()];
    for line in &blocks.lines {
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
        let mut tried = Blocks { lines, here: blocks.here.clone(), file: blocks.file.clone() };
        tried.clean();
        let bytes = tried.bytes();
        if bytes < blocks.bytes() && best.as_ref().is_none_or(|(least, _)| bytes < *least) {
            best = Some((bytes, tried.lines));
        }
    }
    best.map(|(_, lines)| lines)
}
