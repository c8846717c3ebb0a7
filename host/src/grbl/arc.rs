//! The geometry of G2 and G3 in a plane: the centre by offsets or by a radius, the angle, the
//! extremes.

use std::f64::consts::{PI, TAU};

use super::Error;

/// Longest radius that a board draws, mm.
const MOST_RADIUS: f64 = 4000.0;
/// What counts as no turn at all, as in Grbl: then it is a full circle, radians.
const FULL: f64 = 5e-7;

/// An arc in its plane, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// The centre.
    pub center: [f64; 2],
    /// The radius.
    pub radius: f64,
    /// Angle at which it begins, radians.
    begin: f64,
    /// How far it turns, radians, below 0 clockwise.
    pub turn: f64,
}

/// How a line gives the centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Center {
    /// By its offset from the start, mm.
    Offset([f64; 2]),
    /// By a radius, mm; below 0 the longer arc.
    Radius(f64),
}

impl Arc {
    /// The arc from one place to another.
    ///
    /// # Errors
    /// `error:33` where no circle fits, `error:34` where the radius is too short for the end.
    pub fn new(
        from: [f64; 2],
        to: [f64; 2],
        center: Center,
        clockwise: bool,
    ) -> Result<Arc, Error> {
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let offset = match center {
            Center::Offset(offset) => offset,
            Center::Radius(radius) => {
                if (dx, dy) == (0.0, 0.0) {
                    return Err(Error::TARGET);
                }
                let square = 4.0 * radius * radius - dx * dx - dy * dy;
                if square < 0.0 {
                    return Err(Error::ARC_RADIUS);
                }
                // Grbl's own derivation (gcode.c): the centre lies beside the middle of the chord.
                let mut h = -square.sqrt() / dx.hypot(dy);
                if !clockwise {
                    h = -h;
                }
                if radius < 0.0 {
                    h = -h;
                }
                [0.5 * (dx - dy * h), 0.5 * (dy + dx * h)]
            }
        };
        let center = [from[0] + offset[0], from[1] + offset[1]];
        let radius = offset[0].hypot(offset[1]);
        let other = (to[0] - center[0]).hypot(to[1] - center[1]);
        let miss = (radius - other).abs();
        if miss > 0.005 && miss > 0.001 * radius || !(0.0005..=MOST_RADIUS).contains(&radius) {
            return Err(Error::TARGET);
        }
        let begin = (-offset[1]).atan2(-offset[0]);
        let end = (to[1] - center[1]).atan2(to[0] - center[0]);
        let mut turn = end - begin;
        if clockwise {
            if turn >= -FULL {
                turn -= TAU;
            }
        } else if turn <= FULL {
            turn += TAU;
        }
        Ok(Arc { center, radius, begin, turn })
    }

    /// Its length in the plane, mm.
    pub fn length(&self) -> f64 {
        self.radius * self.turn.abs()
    }

    /// The least and greatest coordinates that it comes to.
    pub fn reach(&self, from: [f64; 2], to: [f64; 2]) -> [[f64; 2]; 2] {
        let mut reach = [0, 1].map(|i| [from[i].min(to[i]), from[i].max(to[i])]);
        let (low, high) =
            (self.begin.min(self.begin + self.turn), self.begin.max(self.begin + self.turn));
        let mut quarter = (low / (PI / 2.0)).ceil();
        while quarter * PI / 2.0 <= high {
            let angle = quarter * PI / 2.0;
            for (i, part) in [angle.cos(), angle.sin()].into_iter().enumerate() {
                let at = self.center[i] + self.radius * part;
                reach[i] = [reach[i][0].min(at), reach[i][1].max(at)];
            }
            quarter += 1.0;
        }
        reach
    }
}

#[cfg(test)]
mod tests {
    use super::{Arc, Center};
    use crate::grbl::Error;
    use std::f64::consts::{PI, TAU};

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-6
    }

    #[test]
    fn quarters_and_circles_turn_as_far_as_they_say() {
        let quarter = Arc::new([0.0, 0.0], [10.0, 10.0], Center::Offset([10.0, 0.0]), true);
        let quarter = quarter.expect("good");
        assert!(near(quarter.turn, -PI / 2.0) && near(quarter.length(), 5.0 * PI));
        let circle = Arc::new([0.0, 0.0], [0.0, 0.0], Center::Offset([10.0, 0.0]), false);
        let circle = circle.expect("good");
        assert!(near(circle.turn, TAU));
        let [x, y] = circle.reach([0.0, 0.0], [0.0, 0.0]);
        assert!(near(x[0], 0.0) && near(x[1], 20.0) && near(y[0], -10.0) && near(y[1], 10.0));
    }

    #[test]
    fn a_radius_finds_the_shorter_or_the_longer_way() {
        let (from, to) = ([0.0, 0.0], [10.0, 0.0]);
        let short = Arc::new(from, to, Center::Radius(10.0), true).expect("good");
        assert!(near(short.turn, -PI / 3.0), "{short:?}");
        let long = Arc::new(from, to, Center::Radius(-10.0), true).expect("good");
        assert!(near(long.turn, PI / 3.0 - TAU), "{long:?}");
        assert!(near(long.reach(from, to)[1][1], 10.0 * (1.0 + (PI / 6.0).cos())));
    }

    #[test]
    fn what_is_no_circle_is_refused() {
        let from = [0.0, 0.0];
        let arc = |to, center| Arc::new(from, to, center, false).map(drop);
        assert_eq!(arc([10.0, 0.0], Center::Radius(4.0)), Err(Error::ARC_RADIUS));
        assert_eq!(arc([0.0, 0.0], Center::Radius(4.0)), Err(Error::TARGET));
        assert_eq!(arc([10.0, 0.0], Center::Offset([4.0, 0.0])), Err(Error::TARGET));
        assert_eq!(arc([0.0, 0.0], Center::Offset([0.0, 0.0])), Err(Error::TARGET));
        assert_eq!(arc([0.0, 0.0], Center::Offset([1e9, 0.0])), Err(Error::TARGET));
    }
}
