//! Lines that the chip joins, because planning one takes longer than the line lasts.

use lang::record::MachineRecord;

use super::Pace;
use super::bounds::{number, shape};
use super::walk::Line;
use super::window::LINK;

/// The least time of a line's last two segments where they are not the whole line, s ([`super::window`]).
const WINDOW_S: f64 = 0.0051;

/// How far a place may lie beside the way that is made instead, steps: axes stand at whole ones.
const BESIDE: f64 = 0.5;

/// Lines are joined where planning each would take so many times as long as they last: what joins them takes bytes.
const SLOWED: f64 = 1.15;

/// The lines of a course as the chip makes them: a line that is over before the next one can be planned is joined to the
/// next, as long as all stay on one straight way. The first line is made as it is.
///
/// Greedy, from the first line to the last: the last line made takes the next one in if it is too short for its own planning
/// ([`SLOWED`] times its time at first, as joining costs bytes), if both together are still planned within the last two
/// segments of a line, and if no commanded point lies more than half a step beside the joined line.
pub fn join(lines: &[Line], machine: &MachineRecord, pace: &Pace) -> Vec<Line> {
    let mut made: Vec<Line> = Vec::new();
    // The first of those that the last one made is of.
    let mut first = 0;
    for (n, line) in lines.iter().enumerate() {
        if made.len() > 1
            && let Some(open) = made.last_mut()
            && lasts_s(open, machine) * slowed(open) < pace.needs_s(open, machine)
            && pace.is_short(&sum(open, line), machine)
            && is_one(&lines[first..=n], machine)
        {
            *open = sum(open, line);
        } else {
            first = n;
            made.push(line.clone());
        }
    }
    made
}

impl Pace {
    /// How long the chip takes for a line while one like it is played, s: the work over the part of the processor that
    /// step interrupts and the link leave.
    fn needs_s(&self, line: &Line, machine: &MachineRecord) -> f64 {
        let g = shape(line, machine);
        let event_s = self.work(line, line).event * number(g.events) / lasts_s(line, machine);
        let work = self.planned_s(line) + super::SHAPED_S;
        work * (1.0 - LINK) / (1.0 - LINK - event_s).max(LINK)
    }

    /// It takes no longer than the last two segments of a line.
    fn is_short(&self, line: &Line, machine: &MachineRecord) -> bool {
        self.needs_s(line, machine) <= WINDOW_S
    }
}

/// What a line's time is compared with: once some are joined, all that it takes.
fn slowed(open: &Line) -> f64 {
    if open.joined == 0 { SLOWED } else { 1.0 }
}

/// The lines name the same axes, have one feed, and go straight on; there are steps to make.
///
/// `way` is the sum of all; the distance of each line's end from it, axis by axis, is that of a point from a straight line:
/// its place less its projection.
fn is_one(lines: &[Line], machine: &MachineRecord) -> bool {
    let way: [f64; 3] = [0, 1, 2].map(|n| lines.iter().map(|line| f64::from(line.um[n])).sum());
    let along = |to: [f64; 3]| (0..3).map(|n| to[n] * way[n]).sum::<f64>() / dot(way);
    let mut at = [0.0; 3];
    let whole = lines[1..].iter().fold(lines[0].clone(), |whole, line| sum(&whole, line));
    whole.steps != [0; 3]
        && lines.iter().all(|line| {
            let um = line.um.map(f64::from);
            at = [0, 1, 2].map(|n: usize| at[n] + um[n]);
            let beside = |n: usize| (at[n] - along(at) * way[n]).abs();
            let step = |n: usize| f64::from(machine.axes[n].um) / f64::from(machine.axes[n].steps);
            let moves = |n: &usize| lines.iter().any(|line| line.steps[*n] != 0);
            line.named != 0
                && (line.named, line.feed) == (lines[0].named, lines[0].feed)
                && along(um) > 0.0
                && (0..3).filter(moves).all(|n| beside(n) <= BESIDE * step(n))
        })
}

fn dot(way: [f64; 3]) -> f64 {
    way.iter().map(|um| um * um).sum()
}

/// Both as one.
fn sum(line: &Line, next: &Line) -> Line {
    let of = |a: [i32; 3], b: [i32; 3]| [0, 1, 2].map(|n: usize| a[n].wrapping_add(b[n]));
    Line {
        steps: of(line.steps, next.steps),
        um: of(line.um, next.um),
        joined: line.joined + 1,
        thought_us: line.thought_us.saturating_add(next.thought_us),
        ..line.clone()
    }
}

/// How long the line lasts without ramps, s.
fn lasts_s(line: &Line, machine: &MachineRecord) -> f64 {
    let g = shape(line, machine);
    number(g.length) / f64::min(number(g.feed), number(g.top))
}
