//! What a block leaves behind: modes, places, whether it can be done at all.

use super::read::{Block, Reader, Value};
use crate::codes::Code;
use crate::diag::Diag;
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
                }
                _ => {}
            }
        }
        block.motion = state.motion;
        let moves = ['X', 'Y', 'Z'].into_iter().any(has);
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
        if turns {
            self.in_plane(block);
            self.arc(block, before);
        }
        block.words.retain(|(letter, _)| !(tolerance && *letter == 'P'));
        if self.laser.is_some() {
            self.beam(block);
        }
    }

    /// Follows an axis, and says where a laser's path leaves the machine.
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
        let Some(part) = self.job.profile.axis(axis).filter(|_| self.laser.is_some() && !zeroed)
        else {
            return;
        };
        let travel = i64::from(part.min_um)..=i64::from(part.max_um);
        if let Some(at) = at.filter(|at| !travel.contains(at)) {
            let (letter, at) = (axis.letter(), crate::script::mm(at));
            let text =
                format!("{letter} goes to {at}, outside the travel of `{}`", self.job.profile.name);
            let hint = format!(
                "the travel is {} to {}",
                crate::script::mm(*travel.start()),
                crate::script::mm(*travel.end())
            );
            self.error(line, 1, Code::OutOfRange, text, &hint);
        }
    }

    /// A length in the active unit, um.
    pub(super) fn um(&self, text: &str) -> Option<i64> {
        let scale = if self.state.inches { 25_400 } else { 1000 };
        Decimal::parse(text)?.scaled(scale, 1).map(|(um, _)| um)
    }
}
