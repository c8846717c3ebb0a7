//! Slow points: corner speeds that the host computes before the run, for a part that knows no line ahead
//! ([`lang::image::course`]).
//!
//! [`walk`] follows the program as far as nothing that it does hangs on an answer of the machine, and gives its
//! courses, series of G1 with nothing between them but F that looks at the machine or acts on it. [`bounds`] says how fast each of their
//! lines may end, with all that is behind it; [`points`] puts that into the fewest entries. What is left of them is
//! [`held`] against every course once more, as the chip will take them; a simulated machine takes the same [`LineEnds`].

mod bounds;
mod ends;
mod held;
mod points;
#[cfg(test)]
mod tests;
mod walk;

use std::collections::BTreeMap;

use lang::back::{self, Compiled, Courses};
use lang::hir::Program;
use lang::image::Image;
use lang::image::course::{Entry, record};
use lang::part::Part;

use bounds::Bounds;
pub use ends::LineEnds;
pub use walk::Obstacle;
use walk::Walked;

/// How long a part takes for a line.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pace {
    /// See [`Part::course_us`].
    line_us: [f64; 3],
    /// What each event takes from that planning, us.
    event_us: f64,
}

impl Pace {
    /// That of a part which takes slow points.
    fn of(part: &Part) -> Option<Pace> {
        let line_us = part.course_us.map(f64::from);
        (part.course_pool > 0).then_some(Pace { line_us, event_us: 12.0 })
    }
}

/// Slow points of a program.
struct Found {
    walked: Walked,
    bounds: Vec<Bounds>,
    /// The entries of each course, by the address of the line that begins it.
    records: BTreeMap<usize, Vec<Entry>>,
}

impl Found {
    /// Those of the program, which is `plain` without them, and what it is with them; `None` where there are none: the
    /// part knows of none or has no room, no line of the program may end at speed, or what it does cannot be known before
    /// the run.
    fn of(program: &Program, plain: &Compiled, part: &Part) -> Option<(Found, Compiled)> {
        let pace = Pace::of(part)?;
        let walked = walk::walk(program, plain)?;
        if walked.obstacle.is_some() {
            return None;
        }
        let found = Found::in_walk(walked, program, &pace)?;
        points::worths().find_map(|worth| {
            let found = found.worth(worth);
            let compiled = found.put_into(program, plain, part)?;
            Some((found, compiled))
        })
    }

    /// `None` when every line of the run would rest.
    fn in_walk(walked: Walked, program: &Program, pace: &Pace) -> Option<Found> {
        let of = |lines: &Vec<walk::Line>| Bounds::of(lines, program, pace);
        let bounds: Vec<Bounds> = walked.courses.iter().map(of).collect();
        let found = Found { walked, bounds, records: BTreeMap::new() };
        let found = found.worth(points::FINEST);
        (!found.records.is_empty()).then_some(found)
    }

    /// With entries of which a byte is worth so many seconds.
    fn worth(&self, worth: f64) -> Found {
        let Found { walked, bounds, .. } = self;
        let mut records = BTreeMap::new();
        let mut refused = Vec::new();
        for (lines, bounds) in walked.courses.iter().zip(bounds) {
            let (Some(first), Some(entries)) = (lines.first(), points::entries(bounds, worth))
            else {
                continue;
            };
            // Where the same line begins different courses, its lines rest.
            if records.insert(first.pc, entries.clone()).is_some_and(|before| before != entries) {
                refused.push(first.pc);
            }
        }
        records.retain(|pc, _| !refused.contains(pc) && !walked.barred.contains(pc));
        held::retain(&mut records, &walked.courses, bounds);
        Found { walked: walked.clone(), bounds: bounds.clone(), records }
    }

    /// The program with its slow points, where there is room for them.
    fn put_into(&self, program: &Program, plain: &Compiled, part: &Part) -> Option<Compiled> {
        let compiled = back::compile_with(program, &self.courses(part)).ok()?;
        let lacks = |compiled: &Compiled| {
            let image = Image::new(&compiled.image).ok()?;
            Some(part.all_lacks(&image, program.profile.pulse_us).count())
        };
        (lacks(&compiled)? <= lacks(plain)?).then_some(compiled)
    }

    fn courses(&self, part: &Part) -> Courses {
        let of = |(pc, entries): (&usize, &Vec<Entry>)| (*pc, record(entries));
        Courses { pool: part.course_pool, records: self.records.iter().map(of).collect() }
    }
}

/// A program, compiled as it is, with slow points where the part takes them and has room for them.
pub fn put_into(plain: Compiled, program: &Program, part: &Part) -> Compiled {
    match Found::of(program, &plain, part) {
        Some((_, compiled)) => compiled,
        None => plain,
    }
}

/// Why a part that takes slow points has none for a program that would have some, if what it does were known before
/// the run.
pub fn obstacle(program: &Program, plain: &Compiled, part: &Part) -> Option<Obstacle> {
    let pace = Pace::of(part)?;
    let walked = walk::walk(program, plain)?;
    let obstacle = walked.obstacle?;
    Found::in_walk(walked, program, &pace).map(|_| obstacle)
}

/// How fast the lines of a program's run end on a part; `None` where all of them rest, or where it looks ahead by itself.
pub fn ends(program: &Program, part: &Part) -> Option<LineEnds> {
    let plain = (part.course_pool > 0).then(|| back::compile(program).ok()).flatten()?;
    Found::of(program, &plain, part).map(|(found, _)| LineEnds::of(&found))
}
