//! Circles, before the compiler sees them: what cannot be drawn is reported with the file's line, and
//! what is straight to the micrometre becomes a line.

use super::read::{Block, Reader, Value};
use crate::codes::Code;
use crate::diag::Diag;
use lang::axis::Axis;

/// How far an end may miss its circle, um (RS274/NGC 3.5.3).
const MISS_UM: f64 = 5.0;
/// And in parts of the radius.
const MISS_PART: f64 = 0.001;
/// Greatest radius that the motion draws, um.
const FAR_UM: f64 = 4_000_000.0;
/// An arc that leaves its chord by less than this is a line, um.
const STRAIGHT_UM: f64 = 1.0;

impl Reader<'_, '_> {
    /// Writes the word of arcs again where the block before has G1 instead and this one none.
    pub(super) fn restore(&mut self, block: &mut Block<'_>) {
        let Some(word) = self.state.lined else { return };
        let named = block.words.iter().any(|(letter, value)| {
            let motions = ["0", "1", "2", "3", "80", "81", "82", "83"];
            *letter == 'G' && matches!(value, Value::Text(text) if motions.contains(text))
        });
        let moves = block.words.iter().any(|(letter, _)| "XYZIJKR".contains(*letter));
        if moves && !named {
            block.words.insert(0, ('G', Value::Text(word)));
        }
        if moves || named {
            self.state.lined = None;
        }
    }

    /// Drops a centre's word of 0 outside the plane, which FreeCAD's posts write.
    pub(super) fn in_plane(&mut self, block: &mut Block<'_>) {
        let letters = ['I', 'J', 'K'];
        let outside = (0..3).find(|i| !self.state.plane.contains(i)).map(|i| letters[i]);
        let zero = |(letter, value): &(char, Value<'_>)| {
            Some(*letter) == outside
                && matches!(value, Value::Text(text) if self.um(text) == Some(0))
        };
        let count = block.words.len();
        block.words.retain(|word| !zero(word));
        if block.words.len() < count
            && let Some(letter) = outside
        {
            let text = format!("{letter}0 outside the plane says nothing and is left out");
            self.diags.once(Diag::new(Code::Said, block.line, 1, text).note());
        }
    }

    /// Looks at an arc that begins at `from`, where its places are known.
    #[expect(clippy::cast_precision_loss, reason = "lengths have 32 bits")]
    pub(super) fn arc(&mut self, block: &mut Block<'_>, from: [Option<i64>; 3]) {
        let axes = self.state.plane;
        let run = |i: usize| Some((self.state.at[i]? - from[i]?) as f64);
        let (Some(a), Some(b)) = (run(axes[0]), run(axes[1])) else { return };
        let value = |wanted: char| {
            let found = block.words.iter().find(|(letter, _)| *letter == wanted)?;
            let Value::Text(text) = found.1 else { return None };
            self.um(text).map(|um| um as f64)
        };
        let chord = a.hypot(b);
        let wrong = match value('R') {
            Some(radius) => {
                let short = chord / 2.0 - radius.abs();
                (short > MISS_UM && short > MISS_PART * radius.abs())
                    .then(|| format!("the end is {} away, more than twice the radius", mm(chord)))
            }
            None => {
                let center = axes.map(|i| value(['I', 'J', 'K'][i]).unwrap_or(0.0));
                let radius = center[0].hypot(center[1]);
                let miss = ((a - center[0]).hypot(b - center[1]) - radius).abs();
                if radius > FAR_UM {
                    // The centre lies to the right of a short clockwise arc.
                    let right = a * center[1] - b * center[0] < 0.0;
                    let short = right == (self.state.motion == 2) && miss <= MISS_UM;
                    if short && chord > 0.0 && chord * chord / (8.0 * radius) < STRAIGHT_UM {
                        return self.straighten(block);
                    }
                    Some(format!("its radius is {}; 4 m is the most", mm(radius)))
                } else if radius == 0.0 {
                    Some("its radius is 0".to_owned())
                } else {
                    (miss > MISS_UM && miss > MISS_PART * radius)
                        .then(|| format!("its end misses the circle by {}", mm(miss)))
                }
            }
        };
        if let Some(what) = wrong {
            let text = format!("this arc cannot be drawn: {what}");
            // The centre as a place instead of a way from the start.
            let place = axes.map(|i| value(['I', 'J', 'K'][i]).zip(Some(i)));
            let absolute = value('R').is_none()
                && !self.state.relative
                && place.iter().all(Option::is_some)
                && {
                    let way = |ends: [Option<i64>; 3]| {
                        let ways = place.iter().flatten().map(|(center, i)| {
                            ends[*i].map_or(f64::NAN, |end| end as f64 - center)
                        });
                        ways.fold(0.0, f64::hypot)
                    };
                    let (radius, end) = (way(from), way(self.state.at));
                    radius > 0.0 && (end - radius).abs() <= MISS_UM
                };
            if absolute {
                let hint = "I, J and K fit as places of the centre: let the CAM tool write them from \
                            the arc's start (incremental, G91.1)";
                return self.error(block.line, 1, Code::OutOfRange, text, hint);
            }
            let hint = "an end may miss its circle by 0.005 mm or 0.1 % of the radius: let the CAM \
                        tool write more decimals, or lines";
            self.error(block.line, 1, Code::OutOfRange, text, hint);
        }
    }

    /// Makes a line of an arc.
    fn straighten(&mut self, block: &mut Block<'_>) {
        let text = "arcs of more than 4 m radius are lines here, which differ by less than 1 um";
        self.diags.once(Diag::new(Code::Changed, block.line, 1, text).note());
        self.state.lined = Some(if self.state.motion == 2 { "2" } else { "3" });
        block.motion = 1;
        block.words.retain(|(letter, value)| {
            let turn = *letter == 'G' && matches!(value, Value::Text("2" | "3"));
            !turn && !matches!(letter, 'I' | 'J' | 'K')
        });
        let at = block.words.iter().position(|(letter, _)| Axis::from_letter(*letter).is_some());
        block.words.insert(at.unwrap_or(0), ('G', Value::Text("1")));
    }
}

/// A length in mm, for people.
fn mm(um: f64) -> String {
    format!("{:.3} mm", um / 1000.0)
}
