//! Drill files of circuit board tools: Excellon, as KiCad, Eagle, Altium, PADS, Allegro and their
//! kin write it.
//!
//! Coordinates with a point are what they say; [`number`] places the point of the others.
//! `R5X2.54` repeats the last hole five times, each time by so much further; `X1Y1G85X3Y1` is a
//! slot, and so is a route of G00, M15, G01, M16, which may have corners and arcs. M25 to M01 is a
//! pattern that each `M02X..Y..` repeats elsewhere.

mod number;
mod read;
mod words;
mod write;

use std::collections::BTreeMap;

use super::Job;
use super::codes::Code;
use super::diag::{Diag, Diags};
use super::pattern::Point;
use super::script::Made;
use super::text::Lines;
use super::turn::Turn;
use lang::axis::Axis;
use read::Reader;

/// A place, X and Y in um.
type Place = [i64; 2];

/// A piece of a routed path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Segment {
    to: Place,
    /// None for a straight one.
    arc: Option<Arc>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Arc {
    clockwise: bool,
    round: Round,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Round {
    /// The radius, um; the arc is at most half a circle.
    Radius(i64),
    /// The centre seen from the arc's start, um.
    Center(Place),
}

/// What a tool does with one plunge.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Cut {
    Hole(Place),
    Slot(Place, Place),
    Route(Place, Vec<Segment>),
}

impl Cut {
    /// Cuts of one kind stand in one table.
    fn kind(&self) -> Kind {
        match self {
            Cut::Hole(_) => Kind::Holes,
            Cut::Slot(..) => Kind::Slots,
            Cut::Route(..) => Kind::Routes,
        }
    }

    /// The cut mirrored and shifted.
    fn turned(&self, turn: Turn) -> Cut {
        match self {
            Cut::Hole(at) => Cut::Hole(turn.place(*at)),
            Cut::Slot(from, to) => Cut::Slot(turn.place(*from), turn.place(*to)),
            Cut::Route(from, list) => {
                let arc = |arc: Arc| Arc {
                    // Seen from behind, the other way round.
                    clockwise: arc.clockwise != turn.mirror.is_some(),
                    round: match arc.round {
                        Round::Center(center) => Round::Center(turn.way(center)),
                        radius => radius,
                    },
                };
                let list = list
                    .iter()
                    .map(|part| Segment { to: turn.place(part.to), arc: part.arc.map(arc) });
                Cut::Route(turn.place(*from), list.collect())
            }
        }
    }

    /// The same cut elsewhere.
    fn moved(&self, by: Place) -> Cut {
        let go = |place: &Place| [place[0] + by[0], place[1] + by[1]];
        match self {
            Cut::Hole(at) => Cut::Hole(go(at)),
            Cut::Slot(from, to) => Cut::Slot(go(from), go(to)),
            Cut::Route(from, list) => {
                let list = list.iter().map(|part| Segment { to: go(&part.to), ..*part });
                Cut::Route(go(from), list.collect())
            }
        }
    }
}

/// A cut of the program.
#[derive(Clone, Debug)]
struct Step {
    tool: u32,
    /// Of the file; where the tool comes up.
    line: u32,
    cut: Cut,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Holes,
    Slots,
    Routes,
}

/// Reads a drill file: what is cut, and the tools' sizes.
fn read(lines: &Lines, diags: &mut Diags) -> (Vec<Step>, BTreeMap<u32, String>) {
    let lines = lines.numbered(diags);
    let mut reader = Reader::new(&lines, diags);
    for (number, line) in &lines {
        reader.line(*number, line);
        if reader.ended || reader.diags.hopeless() {
            break;
        }
    }
    reader.finish()
}

/// The holes of a drill file, each with its tool; slots and routes are told and left out.
pub(crate) fn holes(lines: &Lines, diags: &mut Diags) -> Vec<Point> {
    let (cuts, sizes) = read(lines, diags);
    let mut points = Vec::new();
    for Step { tool, cut, .. } in &cuts {
        if let Cut::Hole(at) = cut {
            let size = sizes.get(tool).map_or(String::new(), |size| format!(", {size}"));
            points.push(Point { name: String::new(), at: *at, group: format!("T{tool}{size}") });
        }
    }
    let left = cuts.len() - points.len();
    if left > 0 {
        let text = format!("{left} slots and routes are left out: only holes are points");
        diags.push(Diag::new(Code::LeftOut, 1, 1, text).warning());
    }
    points
}

/// Makes a script of a drill file.
pub(crate) fn import(job: &Job<'_>, diags: &mut Diags) -> Made {
    let (cuts, sizes) = read(job.lines, diags);
    if let Some(axis) = Axis::ALL.into_iter().find(|axis| job.profile.axis(*axis).is_none()) {
        let text = format!("the machine `{}` has no axis {}", job.profile.name, axis.letter());
        diags.push(Diag::new(Code::WrongAxis, 1, 1, text).hint("choose another with `--profile`"));
    }
    if diags.has_errors() {
        return Made::default();
    }
    let turned = |step: &Step| Step { cut: step.cut.turned(job.options.turn), ..*step };
    let cuts: Vec<Step> = cuts.iter().map(turned).collect();
    write::script(job, &cuts, &sizes, diags)
}
