//! Dots: how many a pad gets, where they lie, in which order they are given.

use super::outline::Spot;
use super::pads::Pad;

/// Dots of one job: more do not fit the board's memory.
pub const MOST: usize = 6_000;
/// Rounds in which ways are exchanged.
const ROUNDS: usize = 8;

/// A dot.
#[derive(Clone, Debug, PartialEq)]
pub struct Dot {
    /// Where, mm.
    pub at: Spot,
    /// Number of its pad.
    pub pad: usize,
}

/// How many dots of an area, mm2, a pad gets: at least one.
pub fn count(pad: &Pad, area: f64) -> usize {
    pad.area.map_or(1, |own| (own / area).round().max(1.0) as usize)
}

/// Spreads `count` dots over a pad: parts of equal area along its longer side, each parted again
/// across, a dot in the middle of each.
pub fn spread(pad: &Pad, count: usize) -> Vec<Spot> {
    let (along, ratio) = axis(pad);
    let across = [-along[1], along[0]];
    let rows = match count {
        0..=2 => count,
        _ => ((count as f64 * ratio).sqrt().round() as usize).clamp(1, count),
    };
    let mut cells = pad.cells.clone();
    sort(&mut cells, along);
    let mut out = Vec::with_capacity(count);
    let cut = |done: usize| done * cells.len() / count;
    for row in 0..rows {
        let (first, last) = (row * count / rows, (row + 1) * count / rows);
        let mut slice = cells[cut(first)..cut(last)].to_vec();
        sort(&mut slice, across);
        let own = last - first;
        for n in 0..own {
            let part = &slice[n * slice.len() / own..(n + 1) * slice.len() / own];
            out.extend(middle(part));
        }
    }
    out
}

/// Brings cells into the order in which they lie along a direction.
fn sort(cells: &mut [Spot], along: Spot) {
    let far = |cell: &Spot| cell[0] * along[0] + cell[1] * along[1];
    cells.sort_by(|a, b| far(a).total_cmp(&far(b)).then(a[0].total_cmp(&b[0])));
}

/// The middle of some cells, or where that lies beside them the nearest of them.
fn middle(cells: &[Spot]) -> Option<Spot> {
    let count = cells.len() as f64;
    let at = [0, 1].map(|i| cells.iter().map(|cell| cell[i]).sum::<f64>() / count);
    let far = |cell: &Spot| (cell[0] - at[0]).hypot(cell[1] - at[1]);
    let nearest = cells.iter().min_by(|a, b| far(a).total_cmp(&far(b)))?;
    // Half a cell's diagonal and a little.
    Some(if far(nearest) < 0.02 { at } else { *nearest })
}

/// Direction of a pad's longer side, and its length over its width.
pub(super) fn axis(pad: &Pad) -> (Spot, f64) {
    let mut sums = [0.0; 3];
    for cell in &pad.cells {
        let [x, y] = [cell[0] - pad.at[0], cell[1] - pad.at[1]];
        sums = [sums[0] + x * x, sums[1] + x * y, sums[2] + y * y];
    }
    let [xx, xy, yy] = sums;
    let (mean, half) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(xy));
    let (long, short) = (mean + half, mean - half);
    // A square or a circle has no longer side.
    if half < 1e-3 * mean || mean == 0.0 {
        return ([1.0, 0.0], 1.0);
    }
    let angle = (2.0 * xy).atan2(xx - yy) / 2.0;
    ([angle.cos(), angle.sin()], (long / short.max(long * 1e-4)).sqrt())
}

/// Brings dots into an order with a short way: from each to the nearest, then two ways that cross
/// are exchanged while that helps.
pub fn order(mut dots: Vec<Dot>) -> Vec<Dot> {
    let mut at = [0.0; 2];
    let far = |a: Spot, b: Spot| (a[0] - b[0]).hypot(a[1] - b[1]);
    for n in 0..dots.len() {
        let rest = n..dots.len();
        let nearest = rest.min_by(|a, b| far(at, dots[*a].at).total_cmp(&far(at, dots[*b].at)));
        dots.swap(n, nearest.unwrap_or(n));
        at = dots[n].at;
    }
    for _ in 0..ROUNDS {
        let mut better = false;
        for i in 1..dots.len() {
            for j in i + 1..dots.len() {
                let (a, b, c) = (dots[i - 1].at, dots[i].at, dots[j].at);
                let behind = dots.get(j + 1).map(|dot| dot.at);
                let tail = |from: Spot| behind.map_or(0.0, |to| far(from, to));
                if far(a, c) + tail(b) < far(a, b) + tail(c) - 1e-6 {
                    dots[i..=j].reverse();
                    better = true;
                }
            }
        }
        if !better {
            break;
        }
    }
    dots
}

/// The way from dot to dot, mm.
pub fn way(dots: &[Dot]) -> f64 {
    let steps = dots
        .windows(2)
        .map(|pair| (pair[0].at[0] - pair[1].at[0]).hypot(pair[0].at[1] - pair[1].at[1]));
    steps.sum()
}
