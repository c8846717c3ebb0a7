//! Plays the records as the chip will, course by course.

use std::collections::BTreeMap;

use lang::image::course::Entry;

use super::bounds::Bounds;
use super::points::value;
use super::walk::Line;

/// Takes records away until every line of every course ends no faster than it may, and none is left of a record where its
/// course ends.
pub fn retain(records: &mut BTreeMap<usize, Vec<Entry>>, courses: &[Vec<Line>], bounds: &[Bounds]) {
    let wrong = |records: &BTreeMap<usize, Vec<Entry>>| {
        let mut all = courses.iter().zip(bounds);
        all.find_map(|(lines, bounds)| wrong(records, lines, bounds))
    };
    while let Some(pc) = wrong(records) {
        records.remove(&pc);
    }
}

/// What the ends of a course's lines have by the records, squares of speeds, (um/s)^2: 0 of one that rests, nothing of one
/// that is joined to the next.
pub fn ends(
    records: &BTreeMap<usize, Vec<Entry>>,
    lines: &[Line],
    bounds: &Bounds,
) -> Vec<Option<f64>> {
    let mut ends = Vec::new();
    taken(records, lines, bounds, |n, end, _| {
        ends.extend((0..lines[n].joined).map(|_| None));
        ends.push(Some(if end > bounds.rest { end } else { 0.0 }));
        false
    });
    ends
}

/// The record that lets a line of the course end too fast, joins others than it should, or outlasts the course.
fn wrong(records: &BTreeMap<usize, Vec<Entry>>, lines: &[Line], bounds: &Bounds) -> Option<usize> {
    taken(records, lines, bounds, |n, end, joins| {
        end > bounds.rest && end > bounds.most[n] || joins != bounds.joins[n]
    })
}

/// Hands each line of a course with what its end has by the records, and what is joined behind it, to `is_wrong`. The
/// record by which it said so, or of which lines are left in the end.
fn taken(
    records: &BTreeMap<usize, Vec<Entry>>,
    lines: &[Line],
    bounds: &Bounds,
    mut is_wrong: impl FnMut(usize, f64, u8) -> bool,
) -> Option<usize> {
    let mut open: Option<(usize, Taken<'_>)> = None;
    for (n, line) in lines.iter().enumerate() {
        if open.as_ref().is_none_or(|(_, taken)| taken.is_over()) {
            open = records.get(&line.pc).map(|entries| (line.pc, Taken::new(entries)));
        }
        let (end, joins) = match &mut open {
            Some((_, taken)) => (taken.next(bounds.ramp[n]), taken.joins),
            None => (0.0, 0),
        };
        if is_wrong(n, end, joins) {
            return open.map(|(pc, _)| pc);
        }
    }
    open.filter(|(_, taken)| !taken.is_over()).map(|(pc, _)| pc)
}

/// A record as it is taken line by line.
pub struct Taken<'a> {
    entries: &'a [Entry],
    /// Lines that are left of the first of them.
    left: u8,
    bound: f64,
    /// What the lines behind the last one are joined by.
    pub joins: u8,
}

impl<'a> Taken<'a> {
    /// From its beginning.
    pub fn new(entries: &'a [Entry]) -> Taken<'a> {
        Taken { entries, left: 0, bound: 0.0, joins: 0 }
    }

    /// Whether no line is left.
    pub fn is_over(&self) -> bool {
        self.left == 0 && self.entries.is_empty()
    }

    /// The square of the speed that the end of the next line may have, from which its braking takes so much.
    pub fn next(&mut self, ramp: f64) -> f64 {
        match self.entries.split_first() {
            Some((entry, _)) if self.left == 0 => {
                self.left = entry.lines;
                self.bound = value(entry.bound);
                self.joins = entry.joins;
            }
            Some((entry, _)) if !entry.holds => self.bound = f64::max(self.bound - ramp, 0.0),
            _ => {}
        }
        self.left = self.left.saturating_sub(1);
        if self.left == 0 {
            self.entries = self.entries.get(1..).unwrap_or_default();
        }
        self.bound
    }
}
