//! Loops, jumps, and the settings that hold at each instruction.

use super::instr::{Item, Op, Target};

/// A loop instruction at `end` that repeats from `start`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Loop {
    pub start: usize,
    pub end: usize,
    /// It nests with all others and nothing jumps into it: REPEAT or DO can stand for it.
    pub structured: bool,
}

impl Loop {
    /// Whether the instruction belongs to the loop, its own one included.
    pub fn contains(&self, at: usize) -> bool {
        (self.start..=self.end).contains(&at)
    }
}

/// What is known of a list's control flow.
#[derive(Debug, Default)]
pub(crate) struct Flow {
    /// In order of their ends.
    pub loops: Vec<Loop>,
}

impl Flow {
    /// Looks at a list.
    pub fn of(items: &[Item]) -> Flow {
        let edges: Vec<(usize, Target)> = items
            .iter()
            .enumerate()
            .filter_map(|(at, item)| Some((at, item.op.target()?)))
            .collect();
        let loops = items.iter().enumerate().filter_map(|(end, item)| match item.op {
            Op::Loop { start, .. } => Some(Loop { start, end, structured: true }),
            _ => None,
        });
        let mut loops: Vec<Loop> = loops.collect();
        for part in &mut loops {
            // A jump from outside to the first instruction enters at the loop's head; any other
            // would enter the block. Loops that overlap without nesting jump into one another.
            part.structured = edges.iter().all(|&(from, to)| {
                let inside = to > part.start && to <= part.end;
                !inside || part.contains(from)
            });
        }
        Flow { loops }
    }

    /// The structured loops that begin at an instruction, the outermost first.
    pub fn opening(&self, at: usize) -> impl Iterator<Item = &Loop> {
        self.loops.iter().rev().filter(move |part| part.structured && part.start == at)
    }

    /// The loop of a loop instruction.
    pub fn at(&self, end: usize) -> Option<&Loop> {
        let index = self.loops.binary_search_by_key(&end, |part| part.end).ok()?;
        self.loops.get(index)
    }

    /// How many of the loops that begin at `to` hold `from`: a jump goes inside those.
    pub fn depth(&self, from: usize, to: Target) -> usize {
        self.opening(to).filter(|part| part.contains(from)).count()
    }

    /// Counted loops without a block that a jump leaves: their counters start anew.
    pub fn left(&self, from: usize, to: Target) -> impl Iterator<Item = &Loop> {
        self.loops
            .iter()
            .filter(move |part| !part.structured && part.contains(from) && !part.contains(to))
    }

    /// How deep the blocks nest at most.
    pub fn nesting(&self) -> usize {
        let blocks = || self.loops.iter().filter(|part| part.structured);
        let mut edges: Vec<(usize, i32)> =
            blocks().flat_map(|part| [(2 * part.start, 1), (2 * part.end + 1, -1)]).collect();
        edges.sort_unstable();
        let mut depth = 0;
        let mut most = 0;
        for (_, step) in edges {
            depth += step;
            most = most.max(depth);
        }
        usize::try_from(most).unwrap_or(0)
    }
}

/// Settings that hold at an instruction; None where the ways to it bring different ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Settings {
    /// 0 XY, 1 XZ, 2 YZ.
    pub plane: Option<u8>,
    /// All three axes interpolate.
    pub solid: Option<bool>,
    /// Sense of circles.
    pub clockwise: Option<bool>,
}

impl Settings {
    const START: Settings = Settings { plane: Some(0), solid: Some(false), clockwise: Some(true) };

    fn after(mut self, op: &Op) -> Settings {
        match op {
            Op::Plane(plane) => self.plane = Some(*plane),
            Op::Solid(on) => self.solid = Some(*on),
            Op::Clockwise(on) => self.clockwise = Some(*on),
            _ => {}
        }
        self
    }

    fn join(self, other: Settings) -> Settings {
        fn same<T: PartialEq + Copy>(a: Option<T>, b: Option<T>) -> Option<T> {
            a.filter(|_| a == b)
        }
        Settings {
            plane: same(self.plane, other.plane),
            solid: same(self.solid, other.solid),
            clockwise: same(self.clockwise, other.clockwise),
        }
    }
}

/// The settings before each instruction; None where nothing reaches it. Each can change three
/// times at most, so this ends.
pub(crate) fn settings(items: &[Item]) -> Vec<Option<Settings>> {
    let mut found: Vec<Option<Settings>> = vec![None; items.len()];
    let mut work = vec![(0, Settings::START)];
    while let Some((at, brought)) = work.pop() {
        let Some(slot) = found.get_mut(at) else { continue };
        let joined = slot.map_or(brought, |known| known.join(brought));
        if *slot == Some(joined) {
            continue;
        }
        *slot = Some(joined);
        let Some(item) = items.get(at) else { continue };
        let after = joined.after(&item.op);
        work.extend(item.op.target().map(|target| (target, after)));
        if item.op.falls_through() {
            work.push((at + 1, after));
        }
    }
    found
}
