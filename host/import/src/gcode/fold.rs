//! Repetition: rows of holes become a table and a loop, equal groups a REPEAT.

use super::read::{Block, Value};

/// Longest group of lines that is looked for.
const MAX_GROUP: usize = 8;
/// Rows from which on a table is shorter than the lines.
const MIN_ROWS: usize = 4;

/// A part of the script.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Blocks `from..to` as they are.
    Plain(usize, usize),
    /// `rows` groups of `len` blocks each from `from`; X and Y of the holes stand in a table.
    Table { from: usize, len: usize, rows: Vec<[i64; 2]> },
    /// `times` equal groups.
    Same { from: usize, len: usize, times: usize },
}

/// Finds the repetition of a program.
pub(super) fn parts(blocks: &[Block<'_>]) -> Vec<Part> {
    let mut out = Vec::new();
    let (mut plain, mut at) = (0, 0);
    while at < blocks.len() {
        let found = (1..=MAX_GROUP)
            .find_map(|len| table(blocks, at, len).or_else(|| same(blocks, at, len)));
        match found {
            Some((part, end)) => {
                if plain < at {
                    out.push(Part::Plain(plain, at));
                }
                out.push(part);
                at = end;
                plain = end;
            }
            None => at += 1,
        }
    }
    if plain < at {
        out.push(Part::Plain(plain, at));
    }
    out
}

/// Whether a block drills or lifts: only groups with such a block are holes.
fn drills(block: &Block<'_>) -> bool {
    (81..=83).contains(&block.motion) || block.words.iter().any(|(letter, _)| *letter == 'Z')
}

fn axis_word(letter: char) -> bool {
    matches!(letter, 'X' | 'Y')
}

/// Whether two blocks are one but for where X and Y go.
fn alike(a: &Block<'_>, b: &Block<'_>) -> bool {
    let clean = |block: &Block<'_>| {
        // A table has no names.
        let named = |(letter, value): &(char, Value<'_>)| {
            axis_word(*letter) && matches!(value, Value::Named { .. })
        };
        block.remark.is_empty()
            && block.message.is_none()
            && block.statement.is_empty()
            && block.sets.is_empty()
            && !block.words.iter().any(named)
    };
    if !clean(a) || !clean(b) || a.motion != b.motion {
        return false;
    }
    let rest = |block: &'_ Block<'_>| -> Vec<(char, String)> {
        let others = block.words.iter().filter(|(letter, _)| !axis_word(*letter));
        others.map(|(letter, value)| (*letter, value.to_string())).collect()
    };
    places(a) == places(b) && rest(a) == rest(b)
}

/// Whether X or Y stands in a block.
fn places(block: &Block<'_>) -> bool {
    block.words.iter().any(|(letter, _)| axis_word(*letter))
}

fn relative(blocks: &[Block<'_>]) -> bool {
    blocks.iter().any(|block| {
        block.words.iter().any(|(letter, value)| {
            *letter == 'G'
                && matches!(value, Value::Text("91" | "90" | "92" | "28" | "53" | "20" | "21"))
        })
    })
}

/// Holes: groups with one block that goes to X and Y, all else being equal.
fn table(blocks: &[Block<'_>], from: usize, len: usize) -> Option<(Part, usize)> {
    let first = blocks.get(from..from + len)?;
    // In a cycle each line is a hole; otherwise the tool goes there, down and up.
    let cycle = first.iter().all(|block| (81..=83).contains(&block.motion));
    let moving: Vec<usize> = (0..len).filter(|i| places(&first[*i])).collect();
    let [mover] = moving[..] else { return None };
    if !(first.iter().any(drills) && (cycle || len >= 3))
        || relative(first)
        || first[mover].words.iter().any(|(l, _)| matches!(l, 'I' | 'J' | 'R') && !cycle)
    {
        return None;
    }
    let mut rows = Vec::new();
    let mut at = from;
    while let Some(group) = blocks.get(at..at + len) {
        let fits = group.iter().zip(first).all(|(a, b)| alike(a, b));
        let ([Some(x), Some(y)], true) = (group[mover].to, fits) else { break };
        rows.push([x, y]);
        at += len;
    }
    if rows.len() < MIN_ROWS {
        return None;
    }
    Some((Part::Table { from, len, rows }, at))
}

/// Groups that are equal word for word.
fn same(blocks: &[Block<'_>], from: usize, len: usize) -> Option<(Part, usize)> {
    let first = blocks.get(from..from + len)?;
    let equal =
        |a: &Block<'_>, b: &Block<'_>| alike(a, b) && a.words == b.words && !a.words.is_empty();
    let mut times = 1;
    while let Some(group) = blocks.get(from + times * len..from + (times + 1) * len) {
        if !group.iter().zip(first).all(|(a, b)| equal(a, b)) {
            break;
        }
        times += 1;
    }
    (times >= 3 && times * len >= 6).then(|| (Part::Same { from, len, times }, from + times * len))
}
