//! The entries of a course: no more of them than the time that they save is worth.

use lang::image::course::{Entry, MOST};

use super::bounds::Bounds;
use crate::interrupt;

/// What a byte is worth where there is room, s.
pub const FINEST: f64 = 1e-6;

/// What a byte may be worth, s, more and more until what is left of the entries fits.
pub fn worths() -> impl Iterator<Item = f64> {
    (0..13).map(|n| FINEST * 3f64.powi(n))
}

/// Bytes of an entry.
const BYTES: f64 = 3.0;
/// Bytes that say how the lines behind it are joined.
const JOIN_BYTES: f64 = 2.0;

/// The upper half of the number of 24 bits next below.
fn upper(square: f64) -> u16 {
    if square < 1.0 {
        return 0;
    }
    // Infinite where a course is one straight line.
    let square = square.min(1e18);
    let exponent = square.log2().floor() as i32;
    let mantissa = (square / 2f64.powi(exponent) * 128.0).floor() as u16;
    (exponent + 105) as u16 * 256 + mantissa
}

/// What it stands for.
pub fn value(bound: u16) -> f64 {
    let (exponent, mantissa) = (i32::from(bound >> 8), f64::from(bound & 0xFF));
    mantissa / 128.0 * 2f64.powi(exponent - 105)
}

/// The entries of a course, for each of its lines: in a loop a line after the last entry would begin them anew. Of all lists
/// that never let a line end too fast this is the one whose bytes, at `worth` s each, and lost time are the least together.
/// `None` when all of its lines rest, or when somebody has asked for the end.
///
/// Dynamic programming from the last line to the first. `least[n]` is the least cost of the lines from n on; it is that of
/// one entry for the lines n to n + k, tried for each k, plus `least[n + k + 1]`, which is known. Following the first
/// entries from line 0 on gives the list.
pub fn entries(bounds: &Bounds, worth: f64) -> Option<Vec<Entry>> {
    let count = bounds.most.len();
    if bounds.most.iter().all(|most| *most == 0.0) {
        return None;
    }
    // From each line on the least cost, and the entry to begin with.
    let mut least = vec![(0.0, None); count + 1];
    for n in (0..count).rev() {
        if interrupt::asked() {
            return None;
        }
        let before = n.checked_sub(1).map_or(0, |n| bounds.joins[n]);
        let bytes = BYTES + if bounds.joins[n] == before { 0.0 } else { JOIN_BYTES };
        let mut best = (f64::INFINITY, None);
        for holds in [false, true] {
            for (entry, lost) in candidates(bounds, worth, n, holds) {
                let (behind, _) = least[n + usize::from(entry.lines)];
                let cost = worth * bytes + lost + behind;
                if cost < best.0 {
                    best = (cost, Some(entry));
                }
            }
        }
        least[n] = best;
    }
    let mut all = Vec::new();
    let mut n = 0;
    while let Some(entry) = least[n].1 {
        all.push(entry);
        n += usize::from(entry.lines);
    }
    Some(all)
}

/// Entries for the lines from the n-th on, one line longer each, and the time that they lose, s; up to where an entry for each
/// line would lose less.
///
/// An entry has one number for all of its lines. Either each may end at that speed (`holds`), or each may end slower than the
/// one before by what it can brake. In both cases the number is the lowest that one of the lines allows; in the second, `taken`
/// is what the lines from n + 1 on have braked, so the number for the first is what a later one allows plus `taken`.
fn candidates(bounds: &Bounds, worth: f64, n: usize, holds: bool) -> Vec<(Entry, f64)> {
    let mut found: Vec<(Entry, f64)> = Vec::new();
    let (mut most, mut taken, mut lost) = (f64::INFINITY, 0.0, 0.0);
    let joins = bounds.joins[n];
    let alike = bounds.joins[n..].iter().take_while(|own| **own == joins);
    for lines in 1..=alike.take(MOST.into()).count() {
        let at = n + lines - 1;
        if lines > 1 && !holds {
            taken += bounds.ramp[at];
        }
        let own = if bounds.most[at] > 0.0 { bounds.most[at] } else { bounds.rest * 0.99 };
        most = f64::min(most, own + taken);
        let bound = upper(most);
        if found.last().is_some_and(|(entry, _)| entry.bound == bound) {
            lost += bounds.lost(at, value(bound) - taken);
        } else {
            let mut end = value(bound);
            lost = bounds.lost(n, end);
            for line in n + 1..=at {
                end -= if holds { 0.0 } else { bounds.ramp[line] };
                lost += bounds.lost(line, end);
            }
        }
        found.push((Entry { lines: lines as u8, holds, bound, joins }, lost));
        if lost > worth * BYTES * lines as f64 {
            break;
        }
    }
    found
}
