//! The fewest entries that let every line of a course end as fast as it can.

use lang::image::course::{Entry, MOST};

use super::bounds::Bounds;

/// What a line's end may lose of the square of its best speed, from the first that leaves the program room: half of that
/// of the speed. Beyond them a line takes as long as at half its speed.
pub const LOSSES: [f64; 9] = [0.02, 0.04, 0.07, 0.1, 0.15, 0.2, 0.3, 0.5, 0.75];

/// The squares that the first line of an entry may have: none is lost below the one, none is too fast up to the other.
#[derive(Clone, Copy, Debug)]
struct Span {
    least: f64,
    most: f64,
}

impl Span {
    const ANY: Span = Span { least: 0.0, most: f64::INFINITY };

    fn with(self, least: f64, most: f64) -> Span {
        Span { least: self.least.max(least), most: self.most.min(most) }
    }

    /// The largest value of an entry in it.
    fn bound(self) -> Option<u16> {
        let bound = upper(self.most);
        (value(bound) >= self.least).then_some(bound)
    }
}

/// The upper half of the number of 24 bits next below.
fn upper(square: f64) -> u16 {
    if square < 1.0 {
        return 0;
    }
    // Infinite where a course is one straight line.
    let square = square.min(1e18);
    let exponent = square.log2().floor() as i32;
    let mantissa = (square / 2f64.powi(exponent) * 128.0).floor() as u16;
    (exponent + 105) as u16 * 256 + mantissa
}

/// What it stands for.
pub fn value(bound: u16) -> f64 {
    let (exponent, mantissa) = (i32::from(bound >> 8), f64::from(bound & 0xFF));
    mantissa / 128.0 * 2f64.powi(exponent - 105)
}

/// The entries of a course, for each of its lines: in a loop one behind them would begin them anew. `None` when all of
/// its lines rest.
pub fn entries(bounds: &Bounds, loss: f64) -> Option<Vec<Entry>> {
    let count = bounds.most.len();
    if bounds.most.iter().all(|most| *most == 0.0) {
        return None;
    }
    let mut all = Vec::new();
    let mut n = 0;
    while n < count {
        let declines = longest(bounds, loss, n, false);
        let holds = longest(bounds, loss, n, true);
        let (lines, bound, holds) = match holds.0 > declines.0 {
            true => (holds.0, holds.1, true),
            false => (declines.0, declines.1, false),
        };
        all.push(Entry { lines: lines as u8, holds, bound });
        n += lines;
    }
    Some(all)
}

/// How many lines from the n-th on one entry serves, and its value.
fn longest(bounds: &Bounds, loss: f64, n: usize, holds: bool) -> (usize, u16) {
    let count = bounds.most.len();
    let (mut span, mut taken) = (Span::ANY, 0.0);
    let (mut lines, mut bound) = (0, 0);
    while n + lines < count && lines < MOST.into() {
        let at = n + lines;
        if lines > 0 && !holds {
            taken += bounds.ramp[at];
        }
        let most = if bounds.most[at] > 0.0 { bounds.most[at] } else { bounds.rest * 0.99 };
        // What rests loses nothing, and no more than what rest allows is worth an entry.
        let least = match bounds.best[at] > bounds.rest {
            true => bounds.best[at] * (1.0 - loss) - 0.2 * bounds.rest,
            false => f64::NEG_INFINITY,
        };
        span = span.with(least + taken, most + taken);
        match span.bound() {
            Some(found) => bound = found,
            // One line is served in any case, as well as two bytes say it.
            None if lines == 0 => bound = upper(span.most),
            None => break,
        }
        lines += 1;
    }
    (lines, bound)
}
