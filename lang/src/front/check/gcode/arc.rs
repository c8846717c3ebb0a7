//! G2 and G3.

use super::block::Block;
use super::modal::Group;
use super::word::Context;
use crate::axis::Axis;
use crate::effect::Frame;
use crate::fault::Fault;
use crate::front::check::Checker;
use crate::front::check::expr::value_of;
use crate::front::codes::Code;
use crate::hir::{self, ArcCenter, StmtKind, Word};
use crate::kind::Kind;

/// How far an end may miss its circle, um (lang/README.md, G-code; RS274/NGC 3.5.3).
const MISS_UM: f64 = 5.0;
/// And in parts of the radius.
const MISS_PART: f64 = 0.001;

impl<'a> Checker<'a> {
    pub(super) fn arc(
        &mut self,
        block: &Block<'a>,
        context: &Context,
        clockwise: bool,
    ) -> Option<Vec<StmtKind>> {
        let plane = self.plane(context);
        let to = self.axis_words(block, context);
        let mut offsets = [None, None, None];
        let mut ok = true;
        for (slot, word) in offsets.iter_mut().zip(block.offsets) {
            if let Some(word) = word {
                *slot = self.distance_word(word, context, false);
                ok &= slot.is_some();
            }
        }
        let radius = match block.r {
            Some(word) => Some(self.distance_word(word, context, false)?),
            None => None,
        };
        let (plane, to) = (plane?, to?);
        if !ok {
            return None;
        }
        let axes = plane.axes().map(Axis::index);
        let outside = (0..3).find(|i| !axes.contains(i)).and_then(|i| block.offsets[i]);
        if let Some(word) = outside {
            let message = format!("{} lies outside the active plane", word.letter);
            let hint =
                "the centre is given in the plane: I J under G17, I K under G18, J K under G19";
            self.error(Code::GcodeNoMeaning, word.span, message, hint);
            return None;
        }
        let has_offsets = offsets.iter().any(Option::is_some);
        let center = match radius {
            Some(_) if has_offsets => {
                let message = "an arc with both R and I J K";
                self.error(Code::GcodeTwice, block.span, message, "give the centre once");
                return None;
            }
            Some(radius) => {
                if axes.iter().all(|&i| to[i].is_none()) {
                    let message = "R without an end point in the plane";
                    self.error(
                        Code::GcodeMissing,
                        block.span,
                        message,
                        "a full circle needs I J K",
                    );
                    return None;
                }
                ArcCenter::Radius(Box::new(radius))
            }
            None if has_offsets => ArcCenter::Offsets(Box::new(offsets)),
            None => {
                let message = "an arc without its centre";
                self.error(Code::GcodeMissing, block.span, message, "add I and J, or R");
                return None;
            }
        };
        self.check_arc(axes, &to, &center, block);
        let mut out = self.need_feed(context)?;
        let exact = self.modal(context, Group::Exact)? == 1;
        self.note_path(plane.axes(), true);
        self.gcode.follow(&to);
        out.push(StmtKind::Arc { clockwise, plane, to: Box::new(to), center, exact });
        Some(out)
    }

    /// Warns of an arc that can not be drawn, where all its words are constant.
    fn check_arc(
        &mut self,
        axes: [usize; 2],
        to: &[Option<Word>; 3],
        center: &ArcCenter,
        block: &Block<'a>,
    ) {
        let length = |value: &hir::Expr| {
            value_of(value).filter(|_| value.kind == Kind::Length).map(f64::from)
        };
        // The end as seen from the start.
        let run = |i: usize| match &to[i] {
            None => Some(0.0),
            Some(word) => {
                let value = length(&word.value)?;
                match word.frame {
                    Frame::Relative => Some(value),
                    Frame::Work => Some(value - f64::from(self.gcode.position[i]?)),
                    Frame::Machine => None,
                }
            }
        };
        let wrong = match center {
            ArcCenter::Radius(radius) => {
                let (Some(r), Some(a), Some(b)) = (length(radius), run(axes[0]), run(axes[1]))
                else {
                    return;
                };
                let chord = a.hypot(b);
                if chord == 0.0 {
                    Some("R with its end at the start".to_owned())
                } else {
                    let short = chord / 2.0 - r.abs();
                    (short > MISS_UM && short > MISS_PART * r.abs()).then(|| {
                        format!("the end is {chord:.0}um away, more than twice the radius")
                    })
                }
            }
            ArcCenter::Offsets(offsets) => {
                let at = |i: usize| offsets[i].as_ref().map_or(Some(0.0), length);
                let (Some(i), Some(j)) = (at(axes[0]), at(axes[1])) else { return };
                let radius = i.hypot(j);
                if radius == 0.0 {
                    Some("its radius is 0".to_owned())
                } else {
                    let (Some(a), Some(b)) = (run(axes[0]), run(axes[1])) else { return };
                    let miss = ((a - i).hypot(b - j) - radius).abs();
                    (miss > MISS_UM && miss > MISS_PART * radius)
                        .then(|| format!("its end misses the circle by {miss:.0}um"))
                }
            }
        };
        if let Some(what) = wrong {
            self.run_time_fault(
                Fault::Arc,
                block.span,
                &format!("this arc can not be drawn, {what}"),
            );
        }
    }
}
