//! Arcs as chords, for parts that have no arcs: G2 and G3 with constant words become G1 when a
//! program is compiled. All engines run the result, so their traces contain each chord.
//!
//! [`curve`] makes the chords of one arc, within the profile's tolerance; [`known`] finds where the
//! arc begins. An arc whose beginning is not known before the run is refused with a [`Why`].

mod curve;
mod known;
#[cfg(test)]
mod tests;

use std::fmt;

use lang::axis::{Axis, AxisSet};
use lang::effect::{Frame, Plane};
use lang::fault::Fault;
use lang::hir::{ArcCenter, Block, Expr, ExprKind, Program, Span, Stmt, StmtKind, Word};
use lang::kind::Kind;
use lang::profile::Profile;

pub use curve::tolerance_um;
use curve::{Center, Shape};
use known::{Known, Movers, length};

/// Chords of a whole program: some 60 MB here. A part's flash holds a few hundred; a job that is stored
/// piece by piece may have more.
const MOST: usize = 200_000;

/// What became of a program's arcs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// G2 and G3 of the text.
    pub arcs: usize,
    /// Moves that they are now.
    pub chords: usize,
    /// How far a chord may leave its arc, um.
    pub tolerance_um: f64,
    /// Line of the first arc.
    pub line: u32,
}

/// An arc that stays one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// Its line.
    pub line: u32,
    /// Its text.
    pub span: Span,
    /// The reason.
    pub why: Why,
}

/// Why an arc cannot become chords before the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// A word is not a constant Length: an axis, I, J, K or R.
    Word(char),
    /// It is not known where this axis begins.
    Start(Axis),
    /// A handler moves one of its axes between the chords.
    Handler(Axis),
    /// F09.
    Circle,
    /// More than [`MOST`] chords.
    Many,
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Why::Word(letter) => write!(f, "{letter} is only known while it runs"),
            Why::Start(axis) => {
                write!(f, "where {} is when it begins is only known while it runs", axis.letter())
            }
            Why::Handler(axis) => write!(f, "a handler may move {} meanwhile", axis.letter()),
            Why::Circle => write!(f, "{}", Fault::Arc.cause()),
            Why::Many => write!(f, "the program would have more than {MOST} chords"),
        }
    }
}

impl Why {
    /// What to write instead.
    pub fn remedy(self) -> String {
        match self {
            Why::Word(_) => {
                "write the word in numbers, CONSTs and units, in mm or inches; or relative, in st"
                    .to_owned()
            }
            Why::Start(axis) => format!(
                "write a G0 or G1 with a number for {} in front of it, in the same SUB and loop; or \
                 relative words under G91",
                axis.letter()
            ),
            Why::Handler(_) => "let the handler set outputs and variables only".to_owned(),
            Why::Circle => Fault::Arc.remedy().to_owned(),
            Why::Many => "a larger corner_um in the profile makes fewer chords".to_owned(),
        }
    }
}

/// The program with chords instead of arcs.
///
/// # Errors
/// The arcs that cannot become chords, in the order of the text.
pub fn drawn(program: &Program) -> Result<(Program, Cost), Vec<Refused>> {
    let movers = Movers::of(program);
    let mut program = program.clone();
    let mut routines = std::mem::take(&mut program.routines);
    let mut pen = Pen { program: &program, movers, cost: Cost::default(), refused: Vec::new() };
    for routine in routines.iter_mut().filter(|routine| routine.reachable) {
        pen.block(&mut routine.body, &mut Known::default());
    }
    let Pen { cost, mut refused, .. } = pen;
    if refused.is_empty() {
        program.routines = routines;
        return Ok((program, cost));
    }
    refused.sort_by_key(|refused| refused.line);
    Err(refused)
}

/// Goes through a program and draws.
struct Pen<'a> {
    /// Without its routines.
    program: &'a Program,
    movers: Movers,
    cost: Cost,
    refused: Vec<Refused>,
}

/// An arc's words.
struct Words<'a> {
    clockwise: bool,
    plane: Plane,
    to: &'a [Option<Word>; 3],
    center: &'a ArcCenter,
    exact: bool,
}

impl Pen<'_> {
    /// Draws the arcs of a block that begins with the axes at `at`, which is where they are behind it
    /// afterwards.
    fn block(&mut self, block: &mut Block, at: &mut Known) {
        let has_arc = |stmt: &Stmt| matches!(stmt.kind, StmtKind::Arc { .. });
        let mut out = Vec::new();
        if block.iter().any(has_arc) {
            out.reserve(block.len());
        }
        for mut stmt in std::mem::take(block) {
            let loops = matches!(
                stmt.kind,
                StmtKind::For { .. }
                    | StmtKind::While { .. }
                    | StmtKind::Do { .. }
                    | StmtKind::Repeat { .. }
            );
            let mut blocks = stmt.kind.blocks_mut();
            if blocks.is_empty() {
                let before = *at;
                at.pass(&stmt.kind, &self.movers);
                self.stmt(stmt, &before, &mut out);
                continue;
            }
            if loops {
                // A pass begins where the one before ended.
                let moved = blocks.iter().map(|inner| self.movers.moved_in(inner));
                let moved = moved.fold(AxisSet::default(), known::join);
                at.forget(moved);
                for inner in blocks {
                    self.block(inner, &mut at.clone());
                }
            } else {
                let before = *at;
                let mut behind: Option<Known> = None;
                for inner in blocks.iter_mut() {
                    let mut own = before;
                    self.block(inner, &mut own);
                    match &mut behind {
                        Some(behind) => behind.join(own),
                        None => behind = Some(own),
                    }
                }
                *at = behind.unwrap_or_default();
            }
            out.push(stmt);
        }
        *block = out;
    }

    /// A statement, or the chords that it becomes.
    fn stmt(&mut self, stmt: Stmt, at: &Known, out: &mut Vec<Stmt>) {
        let StmtKind::Arc { clockwise, plane, to, center, exact } = &stmt.kind else {
            out.push(stmt);
            return;
        };
        let words = Words { clockwise: *clockwise, plane: *plane, to, center, exact: *exact };
        match self.chords(&words, at, &stmt.span) {
            Ok(chords) => {
                let tolerance = tolerance_um(&self.program.profile, *plane);
                if self.cost.arcs == 0 || stmt.line < self.cost.line {
                    self.cost.line = stmt.line;
                }
                self.cost.arcs += 1;
                self.cost.chords += chords.len();
                self.cost.tolerance_um = self.cost.tolerance_um.max(tolerance);
                out.extend(chords.into_iter().map(|kind| Stmt {
                    kind,
                    span: stmt.span.clone(),
                    ..stmt
                }));
            }
            Err(why) => {
                self.refused.push(Refused { line: stmt.line, span: stmt.span.clone(), why });
                out.push(stmt);
            }
        }
    }

    /// The lines of an arc that begins with the axes at `at`.
    fn chords(&self, words: &Words<'_>, at: &Known, span: &Span) -> Result<Vec<StmtKind>, Why> {
        let shape = shape(words, at, &self.program.profile)?;
        let moved =
            |axis: &Axis| words.plane.axes().contains(axis) || words.to[axis.index()].is_some();
        let held = |axis: &Axis| moved(axis) && self.movers.handlers.contains(*axis);
        if let Some(axis) = Axis::ALL.into_iter().find(held) {
            return Err(Why::Handler(axis));
        }
        let tolerance = tolerance_um(&self.program.profile, words.plane);
        let ends = shape.chords(tolerance).map_err(|_| Why::Circle)?;
        if self.cost.chords + ends.len() > MOST {
            return Err(Why::Many);
        }
        let word = |value: i32, frame: Frame| Word {
            value: Expr { kind: Kind::Length, span: span.clone(), node: ExprKind::Const(value) },
            frame,
        };
        let mut before = [0; 3];
        let last = ends.len() - 1;
        let mut lines = Vec::with_capacity(ends.len());
        for (n, end) in ends.into_iter().enumerate() {
            let mut to = [None, None, None];
            for axis in Axis::ALL.map(Axis::index) {
                let own = words.to[axis].as_ref();
                let by = end[axis].wrapping_sub(before[axis]);
                to[axis] = match own.filter(|own| n == last && own.frame == Frame::Work) {
                    // The end is the one that was written, whatever came between.
                    Some(own) => Some(own.clone()),
                    None => (by != 0).then(|| word(by, Frame::Relative)),
                };
            }
            before = end;
            if to.iter().any(Option::is_some) {
                lines.push(StmtKind::Linear { rapid: false, to: Box::new(to), exact: words.exact });
            }
        }
        Ok(lines)
    }
}

/// A constant way along an axis, um: a Length, or Steps by the axis's scale, to a whole um.
fn way(value: &Expr, axis: Axis, profile: &Profile) -> Option<i32> {
    if value.kind != Kind::Steps {
        return length(value);
    }
    profile.axis(axis)?.scale.length(value.constant()?)
}

/// The arc in micrometres from its start.
fn shape(words: &Words<'_>, at: &Known, profile: &Profile) -> Result<Shape, Why> {
    let mut end = [0; 3];
    for axis in Axis::ALL {
        let Some(word) = &words.to[axis.index()] else { continue };
        // Steps that are no way are places of the machine, wherever the work's zero is.
        let value = match word.frame {
            Frame::Relative => way(&word.value, axis, profile),
            _ => length(&word.value),
        };
        let value = value.ok_or(Why::Word(axis.letter()))?;
        let from = match word.frame {
            Frame::Relative => 0,
            Frame::Work => at.0[axis.index()].ok_or(Why::Start(axis))?,
            Frame::Machine => return Err(Why::Start(axis)),
        };
        end[axis.index()] = value.checked_sub(from).ok_or(Why::Circle)?;
    }
    let center = match words.center {
        ArcCenter::Radius(radius) => {
            // A radius in steps is one where both axes have the same.
            let [a, b] = words.plane.axes().map(|axis| way(radius, axis, profile));
            Center::Radius(a.filter(|_| a == b).ok_or(Why::Word('R'))?)
        }
        ArcCenter::Offsets(offsets) => {
            let mut found = [0; 2];
            for (found, axis) in found.iter_mut().zip(words.plane.axes()) {
                if let Some(offset) = &offsets[axis.index()] {
                    let letter = ['I', 'J', 'K'][axis.index()];
                    *found = way(offset, axis, profile).ok_or(Why::Word(letter))?;
                }
            }
            Center::Offset(found)
        }
    };
    Ok(Shape { clockwise: words.clockwise, plane: words.plane, end, center })
}
