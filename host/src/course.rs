//! Slow points: corner speeds that the host computes before the run, for a part without look-ahead
//! ([`lang::image::course`]).
//!
//! A look-ahead planner needs memory for the lines ahead, which the MSP430G2553 with its 512 bytes does not have. So the
//! host does that part of the work when it compiles:
//!
//! 1. [`walk`] runs the program as long as it does not depend on an answer of the machine. It collects the *courses*: series
//!    of G1 with nothing between them that reads the machine or acts on it, except F.
//! 2. [`join`] makes one line of consecutive lines that are too short for the chip to plan one by one.
//! 3. [`bounds`] computes how fast each line may end: the backward and the forward pass of a look-ahead planner.
//! 4. [`window`] limits that to speeds at which the chip has planned the next line in time.
//! 5. [`points`] writes the speeds as entries, in as few bytes as they are worth.
//! 6. [`held`] plays the entries against every course as the chip will, and drops what would let a line end too fast.
//!    A simulated machine takes the same [`LineEnds`].

mod bounds;
pub(crate) mod costs;
mod ends;
mod held;
mod join;
mod points;
#[cfg(test)]
mod tests;
mod walk;
mod window;

use std::collections::BTreeMap;

use lang::back::{self, Compiled, Courses};
use lang::hir::Program;
use lang::image::Image;
use lang::image::course::{Entry, record};
use lang::part::{Part, SHORT_PULSE_US};
use lang::record::MachineRecord;

use firmware::motion::path::geometry::Geometry;

use bounds::{Bounds, number};
pub use ends::LineEnds;
pub use walk::Obstacle;
use walk::{Line, Piece, Walked};
use window::{Way, Work};

use crate::interrupt;

/// How long a part takes for a line of a machine.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pace {
    /// See [`Part::course_us`].
    line_s: [f64; 3],
    /// See [`Part::join_us`].
    join_s: [f64; 3],
    /// A step interrupt, by the axes that may step with it, s.
    event_s: [f64; 3],
}

/// A segment of a line, s: 7000 cycles.
const SEGMENT_S: f64 = 0.45e-3;
/// From the beginning of a line's last segment until the next line's first one is made, s.
pub(crate) const SHAPED_S: f64 = 0.7e-3;
/// Cycles of a step interrupt of one axis, of each other one that steps, and of the second interrupt of a long pulse.
const EVENT_CYCLES: [u32; 3] = [150, 11, 80];

impl Pace {
    /// That of a part which takes slow points, with pulses of this width, us.
    fn of(part: &Part, pulse_us: u8) -> Option<Pace> {
        let s = |us: [u16; 3]| us.map(|us| f64::from(us) * 1e-6);
        let [one, other, second] = EVENT_CYCLES;
        let long = if pulse_us > SHORT_PULSE_US { second } else { 0 };
        let event = |axes: u32| f64::from(one + other * axes + long) / f64::from(part.clock);
        let (line_s, join_s) = (s(part.course_us), s(part.join_us));
        let event_s = [0, 1, 2].map(event);
        (part.course_pool > 0).then_some(Pace { line_s, join_s, event_s })
    }

    /// How long a line is planned, those that are joined to it among it, and all that is executed before it, s.
    fn planned_s(&self, line: &Line) -> f64 {
        let axes = axes_of(line);
        let joined = f64::from(line.joined) * self.join_s[axes];
        self.line_s[axes] + joined + f64::from(line.thought_us) * 1e-6
    }

    /// What the chip does while a line ends, before the next one.
    fn work(&self, line: &Line, next: &Line) -> Work {
        let event = self.event_s[axes_of(line)];
        Work { planned: self.planned_s(next), segment: SEGMENT_S, shaped: SHAPED_S, event }
    }

    /// The speed, um/s, that a line of this shape may have at its beginning and its end so that the next one is planned in time
    /// ([`window`]); 0 for none.
    fn passed(&self, shape: &Geometry, line: &Line, next: &Line) -> f64 {
        let (events, length) = (number(shape.events), number(shape.length));
        let (feed, top) = (number(shape.feed), number(shape.top));
        let way = Way {
            events,
            pitch: length / events,
            start: number(shape.start),
            top: top.min(2.0 * feed),
            accel: number(shape.accel),
            decel: number(shape.decel),
        };
        way.passed(top, &self.work(line, next)).unwrap_or(0.0)
    }
}

/// Axes that have steps to make, but one.
fn axes_of(line: &Line) -> usize {
    line.steps.iter().filter(|steps| **steps != 0).count().max(1) - 1
}

/// Slow points of a program.
#[derive(Clone)]
struct Found {
    walked: Walked,
    /// Lines of each course as the chip makes them.
    made: Vec<Vec<Line>>,
    bounds: Vec<Bounds>,
    /// The entries of each course, by the address of the line that begins it.
    records: BTreeMap<usize, Vec<Entry>>,
}

impl Found {
    /// Those of the program, which is `plain` without them, and what it is with them; `None` where there are none: the
    /// part knows of none or has no room, no line of the program may end at speed, or what it does cannot be known before
    /// the run.
    fn of(program: &Program, plain: &Compiled, part: &Part) -> Option<(Found, Compiled)> {
        let pace = Pace::of(part, program.profile.pulse_us)?;
        let walked = walk::walk(program, plain)?;
        if walked.obstacle.is_some() {
            return None;
        }
        let fits = |way: &Found| {
            way.worth(points::FINEST)?;
            points::worths().take_while(|_| !interrupt::asked()).find_map(|worth| {
                let found = way.worth(worth)?;
                let compiled = found.put_into(program, plain, part)?;
                Some((found, compiled))
            })
        };
        let ways = Found::in_walk(&walked, program, &pace);
        let fit = ways.iter().filter_map(fits);
        fit.min_by(|(a, _), (b, _)| a.seconds().total_cmp(&b.seconds()))
    }

    /// How long the courses of the run last, s, nearly.
    fn seconds(&self) -> f64 {
        let Found { walked, made, bounds, records } = self;
        let each = made.iter().zip(bounds);
        let each: Vec<f64> =
            each.map(|(lines, of)| of.seconds(&held::ends(records, lines, of))).collect();
        let courses = walked.order.iter().map(|piece| match piece {
            Piece::Alone => 0.0,
            Piece::Course(index) => each[*index],
        });
        courses.sum()
    }

    /// Ways to make the lines, without entries yet: short ones joined, if there are any, and each alone.
    fn in_walk(walked: &Walked, program: &Program, pace: &Pace) -> Vec<Found> {
        let machine = MachineRecord::of(&program.profile);
        let joined = |lines: &Vec<Line>| join::join(lines, &machine, pace);
        let mut ways = vec![walked.courses.iter().map(joined).collect(), walked.courses.clone()];
        ways.dedup();
        let found = |made: Vec<Vec<Line>>| {
            let bounds = made.iter().map(|lines| Bounds::of(lines, program, pace)).collect();
            Found { walked: walked.clone(), made, bounds, records: BTreeMap::new() }
        };
        ways.into_iter().map(found).collect()
    }

    /// Whether joined lines stand in courses of which the chip takes the whole record.
    fn is_whole(&self) -> bool {
        let joins = |lines: &Vec<Line>| lines.iter().any(|line| line.joined != 0);
        let mut joined = self.made.iter().filter(|lines| joins(lines));
        joined.all(|lines| self.records.contains_key(&lines[0].pc))
    }

    /// Whether a line could end at speed.
    fn passes(&self) -> bool {
        self.first().is_some()
    }

    /// Address of the first line of a course of which one could.
    fn first(&self) -> Option<usize> {
        let passes = |bounds: &Bounds| bounds.most.iter().any(|most| *most > 0.0);
        let mut courses = self.made.iter().zip(&self.bounds);
        courses.find(|(_, bounds)| passes(bounds)).map(|(lines, _)| lines[0].pc)
    }

    /// With entries of which a byte is worth so many seconds; `None` when all lines would rest, or the chip would not join them
    /// as it should.
    fn worth(&self, worth: f64) -> Option<Found> {
        let Found { walked, made, bounds, .. } = self;
        let mut records = BTreeMap::new();
        let mut refused = Vec::new();
        for (lines, bounds) in made.iter().zip(bounds) {
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
        held::retain(&mut records, made, bounds);
        let found = Found { records, ..self.clone() };
        (!found.records.is_empty() && found.is_whole()).then_some(found)
    }

    /// The program with its slow points, where there is room for them.
    fn put_into(&self, program: &Program, plain: &Compiled, part: &Part) -> Option<Compiled> {
        let compiled = back::compile_with(program, &self.courses(part)).ok()?;
        let lacks = |compiled: &Compiled| {
            let image = Image::new(&compiled.image).ok()?;
            Some(part.all_lacks(&image, (&program.profile).into()).count())
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
    let pace = Pace::of(part, program.profile.pulse_us)?;
    let walked = walk::walk(program, plain)?;
    let ways = Found::in_walk(&walked, program, &pace);
    if let Some(obstacle) = walked.obstacle {
        return ways.iter().any(Found::passes).then_some(obstacle);
    }
    if ways.iter().any(|way| way.worth(points::FINEST).is_some()) {
        return None;
    }
    let first = ways.iter().find_map(Found::first)?;
    Some(Obstacle::Differs(plain.sidecar.at(first).map_or(1, |mark| mark.line)))
}

/// How fast the lines of a program's run end on a part; `None` where all of them rest, or where it looks ahead by itself.
pub fn ends(program: &Program, part: &Part) -> Option<LineEnds> {
    let plain = (part.course_pool > 0).then(|| back::compile(program).ok()).flatten()?;
    Found::of(program, &plain, part).map(|(found, _)| LineEnds::of(&found))
}
