//! The statement of a job that comes nearest to a place.

use lang::axis::Axis;
use lang::effect::Effect;

use super::check::{CHECK, fails};
use super::feed::{BUDGET, Feed, Refused, Step};
use super::job::Goal;
use crate::track::Track;

/// A way that passes no further from a place is as good as one through it, um: the first such is taken.
const NEAR_UM: f64 = 50.0;

/// The work positions of X and Y, um.
fn here(track: &Track) -> [f64; 2] {
    [Axis::X, Axis::Y].map(|axis| {
        let zero = track.zero(axis).unwrap_or_default();
        f64::from(track.place(axis).um) - f64::from(zero)
    })
}

/// From a point to a straight way.
fn distance(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let (way, off) = ([to[0] - from[0], to[1] - from[1]], [point[0] - from[0], point[1] - from[1]]);
    let square = way[0] * way[0] + way[1] * way[1];
    let along = if square > 0.0 { (off[0] * way[0] + off[1] * way[1]) / square } else { 0.0 };
    let along = along.clamp(0.0, 1.0);
    (off[0] - along * way[0]).hypot(off[1] - along * way[1])
}

/// The first statement that draws a line or an arc through the place (work positions of X and Y, um), or the one that
/// comes nearest to it, of an arc its chord; and how far from the place it passes, um.
///
/// # Errors
/// The job draws nothing, or fails before, or hangs on what the machine answers.
pub fn nearest(
    mut feed: Feed<'_>,
    profile: &lang::profile::Profile,
    place: [i32; 2],
) -> Result<(Goal, f64), Refused> {
    let point = place.map(f64::from);
    let mut track = Track::new(profile, [0; 3], 0);
    let mut best: Option<(Goal, f64)> = None;
    let mut number = 0;
    let mut left = CHECK;
    loop {
        match feed.step() {
            Step::Effect(effect, line) => {
                // What comes after an answer of the machine is not known.
                if Track::is_open(&effect) {
                    break;
                }
                let from = here(&track);
                match track.follow(&effect) {
                    Ok(()) => feed.complete(0),
                    Err(fault) => feed.fail(fault).map_err(|fault| fails(fault, line))?,
                }
                if matches!(effect, Effect::Linear { rapid: false, .. } | Effect::Arc { .. }) {
                    let far = distance(point, from, here(&track));
                    if best.is_none_or(|(_, least)| far < least) {
                        best = Some((Goal::Effect { number, line }, far));
                    }
                    if far <= NEAR_UM {
                        break;
                    }
                }
                number += 1;
            }
            Step::Guard(..) | Step::Left(..) => {}
            Step::Thinks => left = left.saturating_sub(BUDGET.into()),
            Step::End => break,
            Step::Fault(fault, line) => feed.fail(fault).map_err(|fault| fails(fault, line))?,
        }
        left = left.saturating_sub(1);
        if left == 0 {
            break;
        }
    }
    best.ok_or_else(|| {
        Refused::new(
            1,
            "the job draws no line that could come near the place",
            "name a line with --from-line",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::distance;

    #[test]
    fn a_point_is_as_far_as_the_nearest_point_of_the_way() {
        let far = |point, to| distance(point, [0.0, 0.0], to);
        assert!((far([3.0, 4.0], [0.0, 0.0]) - 5.0).abs() < 1e-9);
        assert!((far([5.0, 2.0], [10.0, 0.0]) - 2.0).abs() < 1e-9);
        assert!((far([-3.0, 4.0], [10.0, 0.0]) - 5.0).abs() < 1e-9);
        assert!((far([13.0, 4.0], [10.0, 0.0]) - 5.0).abs() < 1e-9);
    }
}
