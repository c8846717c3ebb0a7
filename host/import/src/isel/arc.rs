//! The card's circles: `y` counts single steps along X and Y.

/// Longest arc, in turns, that one G-code arc can draw.
const FULL: f64 = 1.0;

/// Where an arc ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum End {
    /// Where it began: a full circle.
    Start,
    /// Seen from the centre, steps.
    At(f64, f64),
    /// More than one turn.
    Beyond,
}

/// The end of an arc that begins at `from`, seen from the centre, and is `length` single steps
/// long. The card moves one axis by one step at a time along the circle, so a quarter of a circle
/// of radius r counts 2 r steps and a whole one 8 r (binder, "Interpolation circulaire",
/// `R' = 4 r (b - a) / 180`).
pub(crate) fn end(from: [i64; 2], length: i64, clockwise: bool) -> End {
    #[expect(clippy::cast_precision_loss, reason = "24-bit values are exact")]
    let (x, y, mut left) = (from[0] as f64, from[1] as f64, length as f64);
    let radius = x.hypot(y);
    let turn = 8.0 * radius;
    // The parameters were rounded to whole steps, each of the two ends by up to one.
    if (left - FULL * turn).abs() <= 2.0 {
        return End::Start;
    }
    if left > turn {
        return End::Beyond;
    }
    // Mirrored, a clockwise arc is one the other way.
    let sense = if clockwise { -1.0 } else { 1.0 };
    let mut angle = (sense * y).atan2(x);
    for _ in 0..5 {
        let quarter = std::f64::consts::FRAC_PI_2;
        let border = ((angle / quarter + 1e-9).floor() + 1.0) * quarter;
        let run =
            radius * ((angle.cos() - border.cos()).abs() + (angle.sin() - border.sin()).abs());
        if run >= left - 1e-6 {
            angle = within(angle, border, left / radius);
            break;
        }
        left -= run;
        angle = border;
    }
    End::At(radius * angle.cos(), sense * radius * angle.sin())
}

/// The angle in a quarter up to which |dx| + |dy| on the unit circle is `run`, by halving: the
/// sum grows with the angle.
fn within(from: f64, to: f64, run: f64) -> f64 {
    let (mut low, mut high) = (from, to);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        let sum = (from.cos() - middle.cos()).abs() + (from.sin() - middle.sin()).abs();
        if sum < run { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::{End, end};

    fn at(end: End) -> (i64, i64) {
        match end {
            End::At(x, y) => (x.round() as i64, y.round() as i64),
            other => panic!("{other:?}"),
        }
    }

    /// The binder's formula for r = 10 mm, 400 steps on 4 mm, from 0 to 90 degrees: 2000 steps.
    #[test]
    fn a_quarter_has_two_radii() {
        assert_eq!(at(end([1000, 0], 2000, false)), (0, 1000));
        assert_eq!(at(end([1000, 0], 2000, true)), (0, -1000));
        assert_eq!(at(end([0, 1000], 4000, false)), (0, -1000));
    }

    /// 45 degrees: the formula gives r, and 0.293 r + 0.707 r is r.
    #[test]
    fn an_eighth_has_one_radius() {
        assert_eq!(at(end([1000, 0], 1000, false)), (707, 707));
        assert_eq!(at(end([707, 707], 2000, false)), (-707, 707));
    }

    #[test]
    fn eight_radii_close_the_circle() {
        assert_eq!(end([1000, 0], 8000, true), End::Start);
        assert_eq!(end([-333, 444], 4440, true), End::Start);
        assert_eq!(end([1000, 0], 8100, true), End::Beyond);
    }
}
