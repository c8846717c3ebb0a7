//! The points of each pattern.

use serde::Deserialize;

use super::{MAX_UM, MOST_POINTS, Point};

/// Points in a certain order; lengths in um.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// Columns and rows.
    Grid {
        /// Points along X, and along Y.
        count: [i64; 2],
        /// From one to the next.
        pitch: [i64; 2],
        /// Every other row comes from the other end.
        zigzag: bool,
    },
    /// Evenly around a circle.
    Circle {
        /// Points.
        count: i64,
        /// Of the circle.
        diameter: i64,
        /// Where the first point lies, thousandths of a degree from X toward Y.
        first_mdeg: i64,
    },
    /// Evenly along a line, both of its ends included.
    Line {
        /// Points.
        count: i64,
        /// From the first to the last.
        way: [i64; 2],
    },
    /// Sockets of two rows of pins, side by side along X.
    Sockets {
        /// Sockets.
        count: i64,
        /// From one to the next.
        apart: i64,
        /// Pins of one row.
        pins: i64,
        /// From pin to pin.
        pitch: i64,
        /// From row to row, along Y.
        rows: i64,
    },
    /// As they are listed.
    Points(Vec<Point>),
}

impl Shape {
    /// Its points in their order, from its own zero.
    ///
    /// # Errors
    /// A number is out of range; in words.
    pub fn points(&self) -> Result<Vec<Point>, String> {
        self.check()?;
        let plain = |x: i64, y: i64| Point { at: [x, y], ..Point::default() };
        Ok(match self {
            Shape::Grid { count, pitch, zigzag } => {
                let rows = (0..count[1]).flat_map(|row| {
                    (0..count[0]).map(move |column| {
                        let back = *zigzag && row % 2 == 1;
                        (if back { count[0] - 1 - column } else { column }, row)
                    })
                });
                rows.map(|(column, row)| plain(column * pitch[0], row * pitch[1])).collect()
            }
            Shape::Circle { count, diameter, first_mdeg } => (0..*count)
                .map(|n| {
                    let turn = *first_mdeg as f64 / 360_000.0 + n as f64 / *count as f64;
                    let (sin, cos) = (turn * std::f64::consts::TAU).sin_cos();
                    let radius = *diameter as f64 / 2.0;
                    plain((radius * cos).round() as i64, (radius * sin).round() as i64)
                })
                .collect(),
            Shape::Line { count, way } => {
                // Cut as the device divides, so that the loop meets these very places.
                let gaps = (count - 1).max(1);
                (0..*count).map(|n| plain(n * way[0] / gaps, n * way[1] / gaps)).collect()
            }
            Shape::Sockets { count, apart, pins, pitch, rows } => {
                let all = (0..*count).flat_map(|socket| {
                    (0..2).flat_map(move |row| (0..*pins).map(move |pin| (socket, row, pin)))
                });
                all.map(|(socket, row, pin)| plain(socket * apart + pin * pitch, row * rows))
                    .collect()
            }
            Shape::Points(points) => points.clone(),
        })
    }

    fn check(&self) -> Result<(), String> {
        let length = |what: &str, um: i64| {
            let good = um.saturating_abs() <= MAX_UM;
            if good { Ok(()) } else { Err(format!("{what} lies beyond 10 m")) }
        };
        let some = |what: &str, um: i64| {
            length(what, um)?;
            if um == 0 { Err(format!("{what} is 0")) } else { Ok(()) }
        };
        let (count, size) = match self {
            Shape::Grid { count, pitch, .. } => {
                for ((what, n), um) in
                    [("columns", count[0]), ("rows", count[1])].into_iter().zip(*pitch)
                {
                    if n > 1 {
                        some(&format!("the distance between {what}"), um)?;
                    }
                }
                (counted(count)?, [0, 1].map(|i| far(count[i], pitch[i])))
            }
            Shape::Circle { count, diameter, first_mdeg } => {
                some("the diameter", *diameter)?;
                if *diameter < 0 || first_mdeg.saturating_abs() > 3_600_000 {
                    return Err("a diameter is positive, an angle within ten turns".to_owned());
                }
                (counted(&[*count])?, [*diameter, 0])
            }
            Shape::Line { count, way } => {
                if *count > 1 && *way == [0, 0] {
                    return Err("a line of several points has a length".to_owned());
                }
                (counted(&[*count])?, *way)
            }
            Shape::Sockets { count, apart, pins, pitch, rows } => {
                some("the distance between pins", *pitch)?;
                some("the distance between the rows", *rows)?;
                if *count > 1 {
                    some("the distance between sockets", *apart)?;
                }
                let along = far(*count, *apart).saturating_add(far(*pins, *pitch));
                (counted(&[*count, 2, *pins])?, [along, *rows])
            }
            Shape::Points(points) => {
                for at in points.iter().flat_map(|point| point.at) {
                    length("a point", at)?;
                }
                (points.len(), [0, 0])
            }
        };
        if count == 0 || count > MOST_POINTS {
            return Err(format!("a pattern has 1 to {MOST_POINTS} points, this one has {count}"));
        }
        size.into_iter().try_for_each(|um| length("the end of the pattern", um))
    }
}

/// From the first to the last of so many.
const fn far(count: i64, pitch: i64) -> i64 {
    count.saturating_sub(1).saturating_mul(pitch)
}

/// The product of counts, none of them less than 1.
fn counted(counts: &[i64]) -> Result<usize, String> {
    let product = counts.iter().try_fold(1_i64, |all, n| all.checked_mul(*n).filter(|_| *n > 0));
    let found = product.and_then(|count| usize::try_from(count).ok());
    found.ok_or_else(|| format!("a pattern has 1 to {MOST_POINTS} points, and a number of each"))
}
