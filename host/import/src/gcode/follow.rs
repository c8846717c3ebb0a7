//! State after a block: modes, positions, and whether it can be converted at all.

use super::read::{Block, Reader, Value};
use crate::codes::Code;
use crate::diag::Diag;
use crate::script::mm;
use lang::axis::Axis;
use lang::front::literal::Decimal;

/// Longest dwell that is not doubted, s.
const LONG_DWELL: i64 = 60;

impl<'a> Reader<'a, '_> {
    /// Follows the block in the controller's state; `broken` when a word of it was refused.
    pub(super) fn follow(&mut self, block: &mut Block<'a>, broken: bool) {
        self.restore(block);
        let words = core::mem::take(&mut block.words);
        let has = |letter: char| words.iter().any(|(known, _)| *known == letter);
        let number = |letter: char, text: &str| {
            words.iter().any(|(known, value)| *known == letter && *value == Value::Text(text))
        };
        let state = &mut self.state;
        state.feed |= has('F');
        let (mut special, mut zeroed) = (false, false);
        for (_, value) in words.iter().filter(|(letter, _)| *letter == 'G') {
            match value {
                Value::Text("20") => state.inches = true,
                Value::Text("21") => state.inches = false,
                Value::Text("90") => state.relative = false,
                Value::Text("91") => state.relative = true,
                Value::Text("17") => state.plane = [0, 1],
                Value::Text("18") => state.plane = [2, 0],
                Value::Text("19") => state.plane = [1, 2],
                Value::Text("92") => zeroed = true,
                Value::Text("28" | "38.2" | "38.3" | "53") => special = true,
                Value::Text(mode @ ("0" | "1" | "2" | "3" | "80" | "81" | "82" | "83")) => {
                    state.motion = mode.parse().unwrap_or(80);
                    if (0..=3).contains(&state.motion) {
                        state.before_cycle = state.motion;
                    }
                }
                _ => {}
            }
        }
        let moves = ['X', 'Y', 'Z'].into_iter().any(has);
        // Some posts take it for granted that G80 brings back G0 or G1. A controller that does not
        // refuses the line, so nothing else can be meant.
        let back = (moves && state.motion == 80 && !special && !zeroed)
            .then_some(match state.before_cycle {
                0 => Some("0"),
                1 => Some("1"),
                _ => None,
            })
            .flatten();
        if let Some(word) = back {
            let text = format!("axis words after G80: they move as before the cycle, by G{word}");
            self.diags.once(Diag::new(Code::Changed, block.line, 1, text).note());
            self.state.motion = self.state.before_cycle;
        }
        let state = &mut self.state;
        block.motion = state.motion;
        if moves && !special && !zeroed && state.motion == 80 && !broken {
            let text = "axis words before any of G0, G1, G2 and G3".to_owned();
            self.error(block.line, 1, Code::Unreadable, text, "write the motion word");
        } else if moves && matches!(state.motion, 1..=3) && !state.feed && !broken {
            self.state.feed = true;
            let text = "a feed move before any F".to_owned();
            self.error(
                block.line,
                1,
                Code::Unreadable,
                text,
                "write F, or choose a profile with a default feed: `--profile thesis`",
            );
        }
        let dwell =
            number('G', "4").then(|| words.iter().find(|(letter, _)| *letter == 'P')).flatten();
        if let Some((_, Value::Text(text))) = dwell
            && Decimal::parse(text)
                .and_then(|p| p.scaled(1, 1))
                .is_some_and(|(s, _)| s > LONG_DWELL)
        {
            let text = format!("G4 P{text} waits for {text} s; some tools mean milliseconds");
            self.diags.once(Diag::new(Code::Inconsistent, block.line, 1, text).note());
        }
        // P behind G64 is a tolerance, which the profile sets here.
        let tolerance = number('G', "64") && has('P');
        if tolerance {
            let text = "P of G64: the corner tolerance is the profile's `corner_um`";
            self.diags.once(Diag::new(Code::LeftOut, block.line, 1, text).note());
        }
        let before = self.state.at;
        for axis in Axis::ALL {
            let word = words.iter().find(|(letter, _)| *letter == axis.letter());
            self.track(block.line, axis, word.map(|(_, value)| *value), special, zeroed);
        }
        if (81..=83).contains(&self.state.motion) && moves {
            // Where a cycle leaves the tool hangs on G98 and G99.
            self.state.at[2] = None;
        }
        block.to = match self.state.relative {
            true => [None; 2],
            false => [self.state.at[0], self.state.at[1]],
        };
        self.state.ended |= number('M', "2") || number('M', "30");
        let round = ['I', 'J', 'K', 'R'].into_iter().any(has);
        let turns = matches!(self.state.motion, 2 | 3) && round && !special && !broken;
        block.words = words;
        if let Some(word) = back {
            block.words.retain(|word| *word != ('G', Value::Text("80")));
            block.words.insert(0, ('G', Value::Text(word)));
        }
        if turns {
            self.in_plane(block);
            self.arc(block, before);
        }
        block.words.retain(|(letter, _)| !(tolerance && *letter == 'P'));
        if self.laser.is_some() {
            self.beam(block);
        }
    }

    /// Follows an axis: where it is, and how far a laser's picture reaches.
    fn track(
        &mut self,
        line: u32,
        axis: Axis,
        value: Option<Value<'_>>,
        special: bool,
        zeroed: bool,
    ) {
        let Some(Value::Text(text)) = value else { return };
        let Some(um) = self.um(text).filter(|um| um.abs() <= i64::from(i32::MAX)) else {
            let text = format!("{text} is too far away");
            return self.error(line, 1, Code::OutOfRange, text, "the greatest length is 2147 mm");
        };
        let before = self.state.at[axis.index()];
        let at = match self.state.relative {
            _ if special => None,
            true if !zeroed => before.and_then(|before| before.checked_add(um)),
            _ => Some(um),
        };
        self.state.at[axis.index()] = at;
        match at {
            // From here on places count from another origin.
            _ if zeroed => self.reach[axis.index()].range = None,
            Some(at) if self.laser.is_some() => self.reaches(line, axis, at),
            _ => {}
        }
    }

    /// Widens the range of an axis to `at`, um, and refuses the first line with which the picture
    /// becomes larger than the machine's table.
    ///
    /// Where the picture lies is no matter here: its origin is where the work zero is set, and many
    /// tools put it into the middle of the picture.
    fn reaches(&mut self, line: u32, axis: Axis, at: i64) {
        let Some(part) = self.job.profile.axis(axis) else { return };
        let [first, last] = [part.min_um, part.max_um].map(i64::from);
        let reach = &mut self.reach[axis.index()];
        let [least, most] =
            reach.range.map_or([at; 2], |[least, most]| [least.min(at), most.max(at)]);
        reach.range = Some([least, most]);
        if most - least <= last - first || reach.refused {
            return;
        }
        reach.refused = true;
        let (letter, name) = (axis.letter(), &self.job.profile.name);
        let text = format!(
            "the picture is wider in {letter} than the table of `{name}`: it goes from {} to {}",
            mm(least),
            mm(most)
        );
        let hint = format!(
            "the travel is {} to {}: make the picture smaller, or choose another machine with `--profile`",
            mm(first),
            mm(last)
        );
        self.error(line, 1, Code::OutOfRange, text, &hint);
    }

    /// Says where the work zero must lie when the picture leaves the travel as it stands.
    pub(super) fn placed(&mut self) {
        for axis in Axis::ALL {
            let reach = self.reach[axis.index()];
            let (Some(part), Some([least, most]), false) =
                (self.job.profile.axis(axis), reach.range, reach.refused)
            else {
                continue;
            };
            let [first, last] = [part.min_um, part.max_um].map(i64::from);
            if first <= least && most <= last {
                continue;
            }
            let (letter, name) = (axis.letter(), &self.job.profile.name);
            let text = format!(
                "{letter} goes from {} to {}; the travel of `{name}` is {} to {}",
                mm(least),
                mm(most),
                mm(first),
                mm(last)
            );
            let hint = format!(
                "set the work zero between {letter} {} and {}",
                mm(first - least),
                mm(last - most)
            );
            self.diags.push(Diag::new(Code::Said, 1, 1, text).note().hint(hint));
        }
    }

    /// A length in the active unit, um.
    pub(super) fn um(&self, text: &str) -> Option<i64> {
        let scale = if self.state.inches { 25_400 } else { 1000 };
        Decimal::parse(text)?.scaled(scale, 1).map(|(um, _)| um)
    }
}
