//! The pads that a layer covers: what is drawn is laid on a fine grid, clusters of what touches are
//! pads.

use super::Layer;
use super::outline::{Bounds, Piece, Spot, Thing, bounds};
use crate::Wrong;

/// Finest cell, mm.
const FINE: f64 = 0.01;
/// Cells along a cluster's longer side.
const MOST_ALONG: f64 = 1500.0;
/// Cells that are looked at in all.
const MOST_CELLS: u64 = 600_000_000;

/// A pad: its cells, of equal area.
#[derive(Clone, Debug)]
pub struct Pad {
    /// The part that it belongs to; empty when the file does not tell.
    pub name: String,
    /// Line of the file.
    pub line: u32,
    /// Middle of its area, mm.
    pub at: Spot,
    /// mm2; none for a place that gets one dot.
    pub area: Option<f64>,
    /// Middles of its cells, mm.
    pub cells: Vec<Spot>,
}

/// Finds the pads, in the order in which they were drawn.
///
/// # Errors
/// There is too much to look at.
pub fn pads(layer: &Layer) -> Result<Vec<Pad>, Wrong> {
    let boxes: Vec<Option<Bounds>> = layer.things.iter().map(Thing::bounds).collect();
    let mut work = 0;
    let mut out = Vec::new();
    for cluster in clusters(layer, &boxes) {
        let held = cluster.iter().filter(|n| layer.things[**n].dark);
        let corners = held.filter_map(|n| boxes[*n]).flatten().collect::<Vec<_>>();
        let Some(held) = bounds(corners.iter()) else { continue };
        let mut grid = Grid::new(held);
        for n in cluster {
            work += grid.paint(&layer.things[n], n);
            if work > MOST_CELLS {
                let words = "too much is drawn over each other to tell the pads";
                let hint = "let the board tool flash the pads instead of filling them with strokes";
                return Err(Wrong::new(layer.things[n].line, words, hint));
            }
        }
        out.extend(grid.pads(layer));
    }
    let single = layer.points.iter().map(|(name, at, line)| Pad {
        name: name.clone(),
        line: *line,
        at: *at,
        area: None,
        cells: vec![*at],
    });
    out.extend(single);
    out.sort_by_key(|pad| pad.line);
    Ok(out)
}

/// Numbers of the dark things whose boxes touch, with what clears some of them, each in the file's
/// order.
fn clusters(layer: &Layer, boxes: &[Option<Bounds>]) -> Vec<Vec<usize>> {
    let touch = |a: &Bounds, b: &Bounds| {
        (0..2).all(|i| a[0][i] <= b[1][i] + FINE && b[0][i] <= a[1][i] + FINE)
    };
    let mut dark: Vec<(usize, Bounds)> = Vec::new();
    let mut clear: Vec<(usize, Bounds)> = Vec::new();
    for (n, held) in boxes.iter().enumerate() {
        if let Some(held) = held {
            let list = if layer.things[n].dark { &mut dark } else { &mut clear };
            list.push((n, *held));
        }
    }
    dark.sort_by(|a, b| a.1[0][0].total_cmp(&b.1[0][0]));
    // Which cluster each belongs to: the root of a forest.
    let mut roots: Vec<usize> = (0..dark.len()).collect();
    let mut live: Vec<usize> = Vec::new();
    for n in 0..dark.len() {
        let held = dark[n].1;
        live.retain(|m| dark[*m].1[1][0] + FINE >= held[0][0]);
        for m in &live {
            if touch(&held, &dark[*m].1) {
                let (a, b) = (root(&mut roots, n), root(&mut roots, *m));
                roots[a] = b;
            }
        }
        live.push(n);
    }
    let mut found: std::collections::BTreeMap<usize, (Bounds, Vec<usize>)> = Default::default();
    for (n, &(number, held)) in dark.iter().enumerate() {
        let entry = found.entry(root(&mut roots, n)).or_insert((held, Vec::new()));
        entry.0 = bounds(entry.0.iter().chain(&held)).unwrap_or(held);
        entry.1.push(number);
    }
    let mut out: Vec<Vec<usize>> = Vec::new();
    for (held, mut numbers) in found.into_values() {
        numbers.extend(clear.iter().filter(|(_, c)| touch(&held, c)).map(|(n, _)| *n));
        numbers.sort_unstable();
        out.push(numbers);
    }
    out
}

fn root(roots: &mut [usize], mut n: usize) -> usize {
    while roots[n] != n {
        roots[n] = roots[roots[n]];
        n = roots[n];
    }
    n
}

/// Cells of a cluster.
struct Grid {
    low: Spot,
    cell: Spot,
    count: [usize; 2],
    /// The thing that covers a cell, from 1; 0 for none.
    cover: Vec<u32>,
}

impl Grid {
    fn new(held: Bounds) -> Grid {
        let size = [0, 1].map(|i| held[1][i] - held[0][i]);
        let cell = FINE.max(size[0].max(size[1]) / MOST_ALONG);
        // Whole cells, so that a rectangle's area is right.
        let count = size.map(|size| ((size / cell).ceil() as usize).max(1));
        let cell = [0, 1].map(|i| (size[i] / count[i] as f64).max(1e-6));
        Grid { low: held[0], cell, count, cover: vec![0; count[0] * count[1]] }
    }

    /// Lays a thing onto it; how many cells were looked at.
    fn paint(&mut self, thing: &Thing, number: usize) -> u64 {
        let owner = if thing.dark { u32::try_from(number + 1).unwrap_or(u32::MAX) } else { 0 };
        if let [Piece { add: true, ring }] = &thing.pieces[..] {
            return self.spans(ring, |cover, span| cover[span].fill(owner));
        }
        // What takes away takes from this thing only, not from those below it.
        let mut work = self.cover.len() as u64 / 8;
        let mut mask = vec![false; self.cover.len()];
        for piece in &thing.pieces {
            work += self.spans(&piece.ring, |_, span| mask[span].fill(piece.add));
        }
        for (cell, covered) in self.cover.iter_mut().zip(&mask) {
            if *covered {
                *cell = owner;
            }
        }
        work
    }

    /// Runs of cells whose middles lie inside of a ring; how much was looked at.
    fn spans(
        &mut self,
        ring: &[Spot],
        mut each: impl FnMut(&mut [u32], std::ops::Range<usize>),
    ) -> u64 {
        let Some([low, high]) = bounds(ring.iter()) else { return 0 };
        let mut work = 0;
        let [columns, rows] = self.count;
        let index = |at: f64, i: usize| ((at - self.low[i]) / self.cell[i] - 0.5).ceil();
        let from = index(low[1], 1).clamp(0.0, rows as f64) as usize;
        let to = (index(high[1], 1) + 1.0).clamp(0.0, rows as f64) as usize;
        let mut crossings: Vec<f64> = Vec::new();
        for row in from..to {
            let y = self.low[1] + (row as f64 + 0.5) * self.cell[1];
            crossings.clear();
            work += ring.len() as u64 / 4 + 1;
            let next = ring.iter().cycle().skip(1);
            for (a, b) in ring.iter().zip(next) {
                if (a[1] <= y) != (b[1] <= y) {
                    crossings.push(a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]));
                }
            }
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                let [a, b] = [0, 1].map(|n| index(pair[n], 0).clamp(0.0, columns as f64) as usize);
                if a < b {
                    work += (b - a) as u64;
                    each(&mut self.cover, row * columns + a..row * columns + b);
                }
            }
        }
        work
    }

    /// What hangs together.
    fn pads(mut self, layer: &Layer) -> Vec<Pad> {
        let [columns, _] = self.count;
        let mut out = Vec::new();
        for start in 0..self.cover.len() {
            let owner = self.cover[start] as usize;
            if owner == 0 {
                continue;
            }
            let mut first = owner;
            let mut open = vec![start];
            self.cover[start] = 0;
            let mut cells = Vec::new();
            while let Some(n) = open.pop() {
                let (row, column) = (n / columns, n % columns);
                cells.push([
                    self.low[0] + (column as f64 + 0.5) * self.cell[0],
                    self.low[1] + (row as f64 + 0.5) * self.cell[1],
                ]);
                let beside = [
                    (column > 0).then(|| n - 1),
                    (column + 1 < columns).then_some(n + 1),
                    n.checked_sub(columns),
                    Some(n + columns).filter(|n| *n < self.cover.len()),
                ];
                for n in beside.into_iter().flatten() {
                    if self.cover[n] != 0 {
                        first = first.min(self.cover[n] as usize);
                        self.cover[n] = 0;
                        open.push(n);
                    }
                }
            }
            let count = cells.len() as f64;
            let at = [0, 1].map(|i| cells.iter().map(|cell| cell[i]).sum::<f64>() / count);
            let area = count * self.cell[0] * self.cell[1];
            let thing = &layer.things[first - 1];
            let (name, line) = (thing.name.clone(), thing.line);
            out.push(Pad { name, line, at, area: Some(area), cells });
        }
        out
    }
}
