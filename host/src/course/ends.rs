//! How fast the lines of a run may end, one after the other as they are executed.

use super::Found;
use super::held;
use super::walk::Piece;

/// See the module.
#[derive(Clone, Debug)]
pub struct LineEnds {
    /// See [`held::ends`], of each course.
    courses: Vec<Vec<Option<f64>>>,
    order: Vec<Piece>,
    repeats: Option<usize>,
    /// The piece that is executed, and so many of its lines.
    at: usize,
    lines: usize,
}

impl LineEnds {
    pub(super) fn of(found: &Found) -> LineEnds {
        let each = found.made.iter().zip(&found.bounds);
        LineEnds {
            courses: each
                .map(|(lines, bounds)| held::ends(&found.records, lines, bounds))
                .collect(),
            order: found.walked.order.clone(),
            repeats: found.walked.repeats,
            at: 0,
            lines: 0,
        }
    }

    /// The square of the speed that the end of the next G1 with steps to make may have, (um/s)^2: 0 of one that rests, nothing
    /// of one that is joined to the next.
    pub fn take_next(&mut self) -> Option<f64> {
        if self.at == self.order.len() {
            self.at = self.repeats.unwrap_or(self.at);
        }
        let Some(Piece::Course(course)) = self.order.get(self.at) else {
            self.at += 1;
            return Some(0.0);
        };
        let ends = &self.courses[*course];
        let end = ends[self.lines];
        self.lines += 1;
        if self.lines == ends.len() {
            self.at += 1;
            self.lines = 0;
        }
        end
    }
}
