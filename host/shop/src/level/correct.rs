//! Lays a job of G-code onto a surface: lines are split, arcs become lines, each Z gets the height below
//! it.

use std::f64::consts::TAU;
use std::fmt::Write;

use super::heights::Heights;
use super::words::{self, Word};
use crate::Wrong;
use crate::text::plain;

/// Longest job that is written, bytes.
const MOST: usize = 64 << 20;
/// Errors that are kept.
const MOST_ERRORS: usize = 20;
/// How far a chord may lie off its arc, mm.
const CHORD: f64 = 0.01;
/// G words that say where a move goes otherwise than by the work's axes.
const ELSEWHERE: [f64; 3] = [28.0, 30.0, 53.0];
/// G words that change nothing here.
const PLAIN: [f64; 15] =
    [4.0, 17.0, 40.0, 49.0, 54.0, 61.0, 64.0, 80.0, 94.0, 97.0, 98.0, 99.0, 91.1, 50.0, 69.0];

/// A job on its surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Corrected {
    /// G-code, absolute.
    pub text: String,
    /// For each of its lines the line of the job.
    pub places: Vec<u32>,
    /// Moves of the job, and what they became.
    pub moves: [usize; 2],
}

struct Writer<'h> {
    heights: &'h Heights,
    split: f64,
    /// X, Y and Z of the work, mm; none when the job has not said it.
    at: [Option<f64>; 3],
    motion: u8,
    relative: bool,
    /// mm of a unit.
    unit: f64,
    line: u32,
    out: Corrected,
    wrong: Vec<Wrong>,
}

/// Corrects a job; pieces of lines are at most `split` long.
///
/// # Errors
/// What cannot be corrected, by line.
pub fn correct(job: &str, heights: &Heights, split: f64) -> Result<Corrected, Vec<Wrong>> {
    let out = Corrected { text: String::new(), places: Vec::new(), moves: [0; 2] };
    let mut writer = Writer {
        heights,
        split,
        at: [None; 3],
        motion: 0,
        relative: false,
        unit: 1.0,
        line: 1,
        out,
        wrong: Vec::new(),
    };
    writer.put("G90");
    for (number, text) in (1..).zip(job.lines()) {
        writer.line = number;
        if let Err(wrong) = writer.take(text) {
            writer.wrong.push(wrong);
        }
        if writer.wrong.len() >= MOST_ERRORS {
            break;
        }
    }
    let moves = writer.out.moves[0];
    if writer.wrong.is_empty() && moves == 0 {
        let hint = "level takes G-code with G0, G1, G2 and G3";
        writer.wrong.push(Wrong::new(1, "a job without a move", hint));
    }
    if writer.wrong.is_empty() { Ok(writer.out) } else { Err(writer.wrong) }
}

impl Writer<'_> {
    fn put(&mut self, line: &str) {
        self.out.text.push_str(line);
        self.out.text.push('\n');
        self.out.places.push(self.line);
    }

    fn error(&self, text: impl Into<String>, hint: &str) -> Wrong {
        Wrong::new(self.line, text, hint)
    }

    fn take(&mut self, text: &str) -> Result<(), Wrong> {
        if text.trim().is_empty() || text.trim() == "%" {
            self.put(text.trim());
            return Ok(());
        }
        let read = words::line(text).map_err(|bad| {
            self.error(
                format!("`{bad}` is no word of G-code"),
                "level takes G-code without variables and scripts",
            )
        })?;
        let mut kept: Vec<Word> = Vec::new();
        let mut elsewhere = false;
        for (letter, value) in &read.words {
            match letter {
                'G' if ELSEWHERE.contains(value) => elsewhere = true,
                'G' if [0.0, 1.0, 2.0, 3.0].contains(value) => self.motion = *value as u8,
                'G' if *value == 90.0 => self.relative = false,
                'G' if *value == 91.0 => self.relative = true,
                'G' if *value == 20.0 => self.unit = 25.4,
                'G' if *value == 21.0 => self.unit = 1.0,
                'G' if !PLAIN.contains(value) => {
                    let words = format!("G{value} cannot be corrected");
                    let hint = "let the CAM program write G0, G1, G2 and G3 in the plane X Y, without cycles";
                    return Err(self.error(words, hint));
                }
                'X' | 'Y' | 'Z' | 'I' | 'J' | 'R' => continue,
                _ => {}
            }
            let own = *letter == 'G' && [0.0, 1.0, 2.0, 3.0, 90.0, 91.0].contains(value);
            if !own {
                kept.push((*letter, *value));
            }
        }
        let of = |wanted: char| read.words.iter().find(|(l, _)| *l == wanted).map(|(_, v)| *v);
        let goals = ['X', 'Y', 'Z'].map(of);
        if elsewhere {
            // The place behind it is not known.
            for (at, _) in self.at.iter_mut().zip(goals).filter(|(_, goal)| goal.is_some()) {
                *at = None;
            }
            if goals == [None; 3] {
                self.at = [None; 3];
            }
            self.put(text.trim());
            if self.relative || read.words.contains(&('G', 91.0)) {
                self.put("G90");
            }
            return Ok(());
        }
        let dwell = kept.contains(&('G', 4.0));
        if goals == [None; 3] && of('I').is_none() && of('J').is_none() || dwell {
            let line = format!("{} {}", spelled(&kept), read.comment);
            self.put(line.trim());
            return Ok(());
        }
        let to = self.goal(goals)?;
        let middle = [of('I'), of('J'), of('R')].map(|v| v.map(|v| v * self.unit));
        self.go(to, middle, &kept, read.comment)
    }

    /// Where a move goes, mm; an axis that is not known and not named stays so.
    fn goal(&self, goals: [Option<f64>; 3]) -> Result<[Option<f64>; 3], Wrong> {
        let mut to = self.at;
        for (n, goal) in goals.into_iter().enumerate() {
            let Some(goal) = goal else { continue };
            to[n] = match (self.relative, self.at[n]) {
                (false, _) => Some(goal * self.unit),
                (true, Some(at)) => Some(at + goal * self.unit),
                (true, None) => {
                    let words = "a relative move from a place that the job does not tell";
                    return Err(self.error(words, "begin with G90 and a place for X, Y and Z"));
                }
            };
        }
        Ok(to)
    }

    fn go(
        &mut self,
        to: [Option<f64>; 3],
        middle: [Option<f64>; 3],
        kept: &[Word],
        comment: &str,
    ) -> Result<(), Wrong> {
        let first = spelled(kept);
        if self.motion == 0 {
            let line = self.piece(to);
            let text = format!("G0{line} {first} {comment}");
            self.put(text.trim_end());
            self.at = to;
            self.out.moves[0] += 1;
            self.out.moves[1] += 1;
            return Ok(());
        }
        let known = |at: [Option<f64>; 3]| Some([at[0]?, at[1]?, at[2]?]);
        let (Some(from), Some(end)) = (known(self.at), known(to)) else {
            let words = "the job has not said where X, Y and Z are before it cuts";
            return Err(self.error(words, "begin with a G0 to a place of X, Y and Z"));
        };
        let places = match self.motion {
            1 => line(from, end, self.split),
            way => arc(from, end, middle, way == 2, self.split).ok_or_else(|| {
                self.error("an arc without a middle", "I and J, or R, say where it is")
            })?,
        };
        for (n, spot) in places.iter().enumerate() {
            if !self.heights.covers(spot[0], spot[1]) {
                let [low, high] = self.heights.bounds();
                let words = format!(
                    "X {} Y {} lies outside of the heights: X {} to {}, Y {} to {}",
                    plain(spot[0]),
                    plain(spot[1]),
                    plain(low[0]),
                    plain(high[0]),
                    plain(low[1]),
                    plain(high[1])
                );
                return Err(self.error(words, "probe a larger surface, or move the job's zero"));
            }
            let line = self.piece(spot.map(Some));
            let text = match n {
                0 => format!("G1{line} {first} {comment}"),
                _ => format!("G1{line}"),
            };
            self.put(text.trim_end());
        }
        if self.out.text.len() > MOST {
            let words = format!("the corrected job is longer than {} MB", MOST >> 20);
            return Err(self.error(words, "a longer --split"));
        }
        self.out.moves[0] += 1;
        self.out.moves[1] += places.len();
        self.at = to;
        Ok(())
    }

    /// The words of a place with its height, in the job's unit.
    fn piece(&self, to: [Option<f64>; 3]) -> String {
        let height = match to {
            [Some(x), Some(y), _] => self.heights.at(x, y),
            _ => 0.0,
        };
        let mut out = String::new();
        for (letter, (n, mm)) in "XYZ".chars().zip(to.into_iter().enumerate()) {
            if let Some(mm) = mm {
                let mm = if n == 2 { mm + height } else { mm };
                let value = mm / self.unit;
                // An inch wants more digits than a mm.
                let text = if self.unit == 1.0 { plain(value) } else { format!("{value:.5}") };
                let _ = write!(out, " {letter}{text}");
            }
        }
        out
    }
}

/// Words as a line has them.
fn spelled(words: &[Word]) -> String {
    words.iter().map(|(letter, value)| format!("{letter}{value}")).collect::<Vec<_>>().join(" ")
}

/// Places on a line, without its first.
fn line(from: [f64; 3], to: [f64; 3], split: f64) -> Vec<[f64; 3]> {
    let length = (to[0] - from[0]).hypot(to[1] - from[1]);
    let count = (length / split).ceil().clamp(1.0, 100_000.0);
    let place = |n: usize| {
        let part = n as f64 / count;
        [0, 1, 2]
            .map(|i| if n as f64 == count { to[i] } else { from[i] + (to[i] - from[i]) * part })
    };
    (1..=count as usize).map(place).collect()
}

/// Places on an arc in the plane X Y, without its first; Z goes evenly.
fn arc(
    from: [f64; 3],
    to: [f64; 3],
    [i, j, r]: [Option<f64>; 3],
    clockwise: bool,
    split: f64,
) -> Option<Vec<[f64; 3]>> {
    let middle = match (i, j, r) {
        (None, None, None) => return None,
        (None, None, Some(radius)) => {
            let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
            let chord = dx.hypot(dy);
            if chord == 0.0 || radius.abs() < chord / 2.0 - 0.01 {
                return None;
            }
            let off = (radius * radius - chord * chord / 4.0).max(0.0).sqrt();
            let off = if clockwise == (radius > 0.0) { -off } else { off };
            [from[0] + dx / 2.0 - dy / chord * off, from[1] + dy / 2.0 + dx / chord * off]
        }
        _ => [from[0] + i.unwrap_or(0.0), from[1] + j.unwrap_or(0.0)],
    };
    let polar = |x: f64, y: f64| {
        ((x - middle[0]).hypot(y - middle[1]), (y - middle[1]).atan2(x - middle[0]))
    };
    let ((r0, a0), (r1, a1)) = (polar(from[0], from[1]), polar(to[0], to[1]));
    if r0 == 0.0 || (r1 - r0).abs() > 0.05 + r0 * 0.01 {
        return None;
    }
    let mut sweep = if clockwise { a0 - a1 } else { a1 - a0 }.rem_euclid(TAU);
    if !(1e-9..=TAU - 1e-9).contains(&sweep) {
        sweep = TAU;
    }
    let chord = 2.0 * (1.0 - (CHORD / r0).min(1.0)).acos();
    let count = (sweep / chord).max(sweep * r0 / split).ceil().clamp(2.0, 100_000.0);
    let place = |n: usize| {
        let part = n as f64 / count;
        if n as f64 == count {
            return to;
        }
        let angle = if clockwise { a0 - sweep * part } else { a0 + sweep * part };
        let radius = r0 + (r1 - r0) * part;
        let z = from[2] + (to[2] - from[2]) * part;
        [middle[0] + radius * angle.cos(), middle[1] + radius * angle.sin(), z]
    };
    Some((1..=count as usize).map(place).collect())
}
