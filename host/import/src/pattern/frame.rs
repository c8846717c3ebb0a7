//! How a drawing lies on the machine: taught points against those that were drawn.
//!
//! The drawing is shifted and turned, never stretched: that both have one scale is checked, because
//! what differs is a wrong unit, a wrong point or a machine whose steps per millimetre are wrong.

use serde::Deserialize;

use super::MAX_UM;

/// Taught points of a drawing.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Frame {
    /// One shifts, two or more turn too.
    pub pairs: Vec<Pair>,
    /// The drawing is seen from behind, as the bottom of a board: X counts the other way.
    #[serde(default)]
    pub mirrored: bool,
}

/// A point as it was drawn, and where the machine found it, um.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pair {
    /// X and Y of the drawing.
    pub drawn: [i64; 2],
    /// X and Y of the machine.
    pub taught: [i64; 2],
}

/// Pairs of one frame.
const MOST: usize = 8;
/// Drawn points that are closer do not say how a drawing is turned, um.
const NEAREST: f64 = 1000.0;
/// A scale that differs by more is refused.
const MOST_SCALE: f64 = 0.01;
/// A scale that differs by more is told, if it is this many um over the whole too.
const SOME_SCALE: (f64, f64) = (0.001, 50.0);
/// A point that is further off than this is told, um.
const SOME_OFF: f64 = 200.0;

/// How a drawing lies.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    mirrored: bool,
    /// Cosine and sine of the angle.
    turn: [f64; 2],
    /// Middles of the drawn and of the taught points.
    middles: [[f64; 2]; 2],
    /// How it lies, in a few words.
    pub brief: String,
    /// What was found, in words.
    pub words: String,
    /// What one should look at.
    pub notes: Vec<String>,
}

impl Frame {
    /// Finds shift and angle so that the squares of the differences are least.
    ///
    /// # Errors
    /// There are too few or too many points, they lie too close, or the two do not fit; in words.
    pub fn fit(&self) -> Result<Fit, String> {
        let pairs = &self.pairs;
        if pairs.is_empty() || pairs.len() > MOST {
            return Err(format!(
                "a frame has 1 to {MOST} taught points, this one has {}",
                pairs.len()
            ));
        }
        let all = pairs.iter().flat_map(|pair| pair.drawn.into_iter().chain(pair.taught));
        if all.clone().any(|um| um.saturating_abs() > MAX_UM) {
            return Err("a point of the frame lies beyond 10 m".to_owned());
        }
        let fit = fit(pairs, self.mirrored);
        let mm = |um: f64| format!("{:.3} mm", um / 1000.0);
        let shift = fit.at([0.0, 0.0]);
        if pairs.len() == 1 {
            let words = format!("its zero at X {}, Y {}", mm(shift[0]), mm(shift[1]));
            return Ok(Fit { brief: words.clone(), words, ..fit });
        }
        let [drawn, taught] = spreads(pairs);
        if drawn < NEAREST {
            return Err(
                "the drawn points of the frame lie closer than 1 mm: take two that are far \
                        apart"
                    .to_owned(),
            );
        }
        let scale = taught / drawn - 1.0;
        let percent = format!("{:+.2} %", 100.0 * scale);
        if scale.abs() > MOST_SCALE {
            return Err(format!(
                "the taught points lie {} apart where the drawing has {} ({percent}): look whether \
                 each was taught at its own place, at the drawing's unit, and at the machine's steps \
                 per millimetre",
                mm(taught),
                mm(drawn)
            ));
        }
        let worst = worst(pairs, &fit);
        let other = worst_of_other(pairs, self.mirrored);
        if pairs.len() > 2 && other < worst / 4.0 && worst > SOME_OFF {
            return Err(format!(
                "the points fit when the drawing is {}: it is seen from the other side",
                if self.mirrored { "not mirrored" } else { "mirrored" }
            ));
        }
        let mut notes = Vec::new();
        if scale.abs() > SOME_SCALE.0 && scale.abs() * drawn > SOME_SCALE.1 {
            notes.push(format!(
                "the machine measures {percent} against the drawing over {}; nothing is stretched",
                mm(drawn)
            ));
        }
        if worst > SOME_OFF {
            notes.push(format!("one of the taught points is {} off", mm(worst)));
        }
        let angle = fit.turn[1].atan2(fit.turn[0]).to_degrees();
        let brief = format!(
            "{}turned by {angle:.3} degrees, its zero at X {}, Y {}",
            if self.mirrored { "mirrored, " } else { "" },
            mm(shift[0]),
            mm(shift[1])
        );
        let words =
            format!("{brief}; the scale differs by {percent}, the points by {} at most", mm(worst));
        Ok(Fit { brief, words, notes, ..fit })
    }
}

impl Fit {
    /// Where a drawn place lies on the machine, um.
    pub fn place(&self, drawn: [i64; 2]) -> [i64; 2] {
        self.at(drawn.map(|um| um as f64)).map(|um| um.round() as i64)
    }

    fn at(&self, drawn: [f64; 2]) -> [f64; 2] {
        let [x, y] =
            seen([drawn[0] - self.middles[0][0], drawn[1] - self.middles[0][1]], self.mirrored);
        let [cos, sin] = self.turn;
        [self.middles[1][0] + cos * x - sin * y, self.middles[1][1] + sin * x + cos * y]
    }
}

/// From behind, or as it is.
fn seen([x, y]: [f64; 2], mirrored: bool) -> [f64; 2] {
    [if mirrored { -x } else { x }, y]
}

fn fit(pairs: &[Pair], mirrored: bool) -> Fit {
    let count = pairs.len() as f64;
    let middle = |of: fn(&Pair) -> [i64; 2]| {
        [0, 1].map(|i: usize| pairs.iter().map(|pair| of(pair)[i] as f64).sum::<f64>() / count)
    };
    let middles = [middle(|pair| pair.drawn), middle(|pair| pair.taught)];
    let (mut along, mut across) = (0.0, 0.0);
    for pair in pairs {
        let apart = |place: [i64; 2], middle: [f64; 2]| [0, 1].map(|i| place[i] as f64 - middle[i]);
        let [px, py] = seen(apart(pair.drawn, middles[0]), mirrored);
        let [qx, qy] = apart(pair.taught, middles[1]);
        along += px * qx + py * qy;
        across += px * qy - py * qx;
    }
    let length = along.hypot(across);
    let turn = if length > 0.0 { [along / length, across / length] } else { [1.0, 0.0] };
    Fit { mirrored, turn, middles, brief: String::new(), words: String::new(), notes: Vec::new() }
}

/// How far the points lie apart, drawn and taught: twice the mean distance from their middle, um.
fn spreads(pairs: &[Pair]) -> [f64; 2] {
    let [drawn, taught] = fit(pairs, false).middles;
    let spread = |middle: [f64; 2], of: fn(&Pair) -> [i64; 2]| {
        let squares = pairs.iter().map(|pair| {
            let at = of(pair);
            (at[0] as f64 - middle[0]).powi(2) + (at[1] as f64 - middle[1]).powi(2)
        });
        2.0 * (squares.sum::<f64>() / pairs.len() as f64).sqrt()
    };
    [spread(drawn, |pair| pair.drawn), spread(taught, |pair| pair.taught)]
}

/// The greatest distance between a taught point and where the fit has it, um.
fn worst(pairs: &[Pair], fit: &Fit) -> f64 {
    let off = pairs.iter().map(|pair| {
        let at = fit.at(pair.drawn.map(|um| um as f64));
        (at[0] - pair.taught[0] as f64).hypot(at[1] - pair.taught[1] as f64)
    });
    off.fold(0.0, f64::max)
}

fn worst_of_other(pairs: &[Pair], mirrored: bool) -> f64 {
    worst(pairs, &fit(pairs, !mirrored))
}
