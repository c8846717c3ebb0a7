//! Drilling cycles: DRILLDEF says how, each DRILL where.

use std::fmt::Write;

use lang::axis::Axis;

use super::words::Words;
use super::{Reader, per_minute, thousandths};
use crate::codes::Code;

/// Least length that is believed to be um: Fusion's post writes mm.
const LEAST_UM: i64 = 100;

/// What DRILLDEF has said, um, um/s and ms. Each line adds to it.
#[derive(Default)]
pub(super) struct Cycle {
    said: Vec<(char, i64)>,
}

impl Cycle {
    /// Takes what a DRILLDEF says.
    pub fn define(&mut self, words: &Words) {
        for (letter, value) in &words.list {
            self.said.retain(|(known, _)| known != letter);
            self.said.push((*letter, *value));
        }
    }

    fn get(&self, letter: char) -> Option<i64> {
        self.said.iter().find(|(known, _)| *known == letter).map(|(_, value)| *value)
    }
}

impl Reader<'_> {
    /// `DRILL X1000 Y2000`: C1 is one plunge, C2 pecks by F and then O, C3 dwells at the bottom. D is
    /// the depth below the plane P; S or L, how far above it the drill travels.
    pub(super) fn drill(&mut self, words: &Words) -> Option<String> {
        let lengths = ['D', 'S', 'L', 'F', 'O'];
        let get = |letter| self.cycle.get(letter);
        let small = lengths
            .into_iter()
            .find(|letter| get(*letter).is_some_and(|um| um != 0 && um.abs() < LEAST_UM));
        if let Some(letter) = small {
            let value = get(letter).unwrap_or(0);
            let text = format!("DRILLDEF {letter}{value} would be {value} um");
            let hint = "lengths are um here, and some tools write mm: write them times 1000";
            return self.error(Code::Inconsistent, text, hint);
        }
        let Some(depth) = get('D').filter(|depth| *depth > 0) else {
            let hint = "`DRILLDEF D1800` drills 1.8 mm deep";
            return self.error(Code::WrongCount, "DRILL before DRILLDEF has said how deep", hint);
        };
        let plane = get('P').unwrap_or(0);
        // Whether it counts from the plane or is a place itself: the higher of both.
        let above = get('S').into_iter().chain(get('L')).max();
        let Some(above) = above.map(|above| above.max(plane + above)) else {
            let hint = "`DRILLDEF S2000` lifts the drill 2 mm above the plane P";
            return self.error(Code::WrongCount, "DRILL without a height between the holes", hint);
        };
        let Some(speed) = get('V').filter(|speed| *speed > 0).or(self.speed) else {
            let hint = "`DRILLDEF V1000` drills at 1 mm/s";
            return self.error(Code::WrongCount, "DRILL without a speed", hint);
        };
        let dwell = get('T').filter(|ms| *ms > 0);
        let peck = get('F').into_iter().chain(get('O')).filter(|um| *um > 0).min();
        let (word, more) = match (get('C').unwrap_or(1), peck, dwell) {
            (1 | 3, _, None) => (81, String::new()),
            (1 | 3, _, Some(ms)) => (82, format!(" P{}", thousandths(ms))),
            (2, Some(um), _) => (83, format!(" Q{}", thousandths(um))),
            (2, None, _) => {
                let hint = "`DRILLDEF O500` goes 0.5 mm deeper with each peck";
                return self.error(Code::WrongCount, "pecks without a depth", hint);
            }
            (other, ..) => {
                let text = format!("DRILLDEF C{other} is no cycle that is known here");
                return self.error(Code::Unsupported, text, "known are C1, C2 and C3");
            }
        };
        let mut block = format!("{}G99 G{word}", self.mode(false));
        for (letter, um) in &words.list {
            let Some(axis) = Axis::from_letter(*letter).filter(|axis| *axis != Axis::Z) else {
                let text = format!("`{letter}` is no word of DRILL");
                return self.error(Code::Unreadable, text, "known are X and Y");
            };
            self.go(axis, *um, false);
            let _ = write!(block, " {letter}{}", thousandths(*um));
        }
        self.at[Axis::Z.index()] = Some(above);
        self.fed = Some(speed);
        let (bottom, speed) = (plane - depth, per_minute(speed));
        let _ = write!(block, " Z{} R{}{more} F{speed}", thousandths(bottom), thousandths(above));
        Some(block)
    }
}
