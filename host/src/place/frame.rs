//! How the board lies on the machine: points of the file against places of the machine.

use import::pattern::{Frame, Pair};

/// A scale that differs from 1 by more is a wrong point or a wrong unit.
const MOST_SCALE: f64 = 0.002;

/// A point of the file and where the machine has it, um.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Its reference, or its place in the file.
    pub name: String,
    /// In the file, X already as it is seen from above.
    pub drawn: [i64; 2],
    /// On the machine.
    pub taught: [i64; 2],
}

/// Shift and turn from the file onto the machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Onto {
    turn: [f64; 2],
    middles: [[f64; 2]; 2],
    /// How far each mark is off, um.
    pub off: Vec<(String, f64)>,
    /// Degrees, counter-clockwise.
    pub angle: f64,
}

/// Finds it: no mark leaves all as it is, one shifts, more shift and turn.
///
/// # Errors
/// The marks do not fit; in words.
pub fn onto(marks: &[Mark]) -> Result<Onto, String> {
    if marks.is_empty() {
        return Ok(Onto { turn: [1.0, 0.0], middles: [[0.0; 2]; 2], off: Vec::new(), angle: 0.0 });
    }
    let pairs: Vec<Pair> =
        marks.iter().map(|m| Pair { drawn: m.drawn, taught: m.taught }).collect();
    let distances = |of: fn(&Mark) -> [i64; 2]| {
        let first = of(&marks[0]);
        let far = marks.iter().map(|mark| {
            let at = of(mark);
            ((at[0] - first[0]) as f64).hypot((at[1] - first[1]) as f64)
        });
        far.fold(0.0, f64::max)
    };
    if marks.len() > 1 {
        let (drawn, taught) = (distances(|mark| mark.drawn), distances(|mark| mark.taught));
        let scale = taught / drawn.max(1.0) - 1.0;
        if scale.abs() > MOST_SCALE {
            return Err(format!(
                "the points' distance is {:.3} mm in the file and {:.3} mm on the machine ({:+.1} %): wrong \
                 point, or wrong unit?",
                drawn / 1000.0,
                taught / 1000.0,
                100.0 * scale
            ));
        }
    }
    let fit = Frame { pairs, mirrored: false }.fit()?;
    let place = |x: i64, y: i64| fit.place([x, y]).map(|um| um as f64);
    // Far apart, so that whole um do not show in the angle.
    const FAR: i64 = 1_000_000_000;
    let (zero, far) = (place(0, 0), place(FAR, 0));
    let (dx, dy) = (far[0] - zero[0], far[1] - zero[1]);
    let length = dx.hypot(dy);
    let turn = [dx / length, dy / length];
    let mut onto =
        Onto { turn, middles: [[0.0; 2], zero], off: Vec::new(), angle: dy.atan2(dx).to_degrees() };
    onto.off = marks
        .iter()
        .map(|mark| {
            let at = onto.place(mark.drawn);
            let off = ((at[0] - mark.taught[0]) as f64).hypot((at[1] - mark.taught[1]) as f64);
            (mark.name.clone(), off)
        })
        .collect();
    Ok(onto)
}

impl Onto {
    /// Where a place of the file is on the machine, um.
    pub fn place(&self, drawn: [i64; 2]) -> [i64; 2] {
        let [x, y] = [0, 1].map(|i| drawn[i] as f64 - self.middles[0][i]);
        let [cos, sin] = self.turn;
        [
            (self.middles[1][0] + cos * x - sin * y).round() as i64,
            (self.middles[1][1] + sin * x + cos * y).round() as i64,
        ]
    }
}
