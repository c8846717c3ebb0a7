//! What both pictures say in words: numbers with units, titles, source lines.

use crate::sim::Outcome;

/// A time as people write it: `850 ms`, `12.4 s`, `3 min 05 s`, `2 h 14 min`.
pub fn time(us: u64) -> String {
    let seconds = us as f64 / 1e6;
    if us < 1_000_000 {
        format!("{} ms", us / 1000)
    } else if seconds < 100.0 {
        format!("{seconds:.1} s")
    } else if seconds < 6000.0 {
        format!("{} min {:02} s", us / 60_000_000, us / 1_000_000 % 60)
    } else {
        format!("{} h {:02} min", us / 3_600_000_000, us / 60_000_000 % 60)
    }
}

/// The run in a line: time, statements, travel of each axis that moved.
pub fn subtitle(outcome: &Outcome, ending: &str) -> String {
    let summary = &outcome.summary;
    let mut text = format!("{ending} after {}", time(summary.us));
    for (letter, travel) in ['X', 'Y', 'Z'].into_iter().zip(summary.travel_um) {
        if travel > 0 {
            text += &format!("  \u{b7}  {letter} {:.1} mm", travel as f64 / 1000.0);
        }
    }
    if outcome.record.truncated {
        text += "  \u{b7}  only the beginning is drawn";
    }
    text
}

/// A script's text by its lines.
pub struct Lines<'a>(Vec<&'a str>);

impl<'a> Lines<'a> {
    /// Takes a text apart.
    pub fn of(source: &'a str) -> Lines<'a> {
        Lines(source.lines().collect())
    }

    /// A line, from 1, trimmed and shortened; empty where there is none.
    pub fn short(&self, line: u32) -> String {
        const LONGEST: usize = 80;
        let index = (line as usize).checked_sub(1);
        let text = index.and_then(|index| self.0.get(index)).copied().unwrap_or_default().trim();
        let mut short: String = text.chars().take(LONGEST).collect();
        if text.chars().nth(LONGEST).is_some() {
            short.push('\u{2026}');
        }
        short
    }

    /// What names a statement: its line's number and text.
    pub fn title(&self, line: u32) -> String {
        format!("line {line}: {}", self.short(line))
    }
}

#[cfg(test)]
mod tests {
    use super::{Lines, time};

    #[test]
    fn times_read_well_at_every_size() {
        assert_eq!(time(850_400), "850 ms");
        assert_eq!(time(12_440_000), "12.4 s");
        assert_eq!(time(185_000_000), "3 min 05 s");
        assert_eq!(time(8_040_000_000), "2 h 14 min");
    }

    #[test]
    fn a_source_line_is_trimmed_and_a_missing_one_is_empty() {
        let lines = Lines::of("a\n  G1 X1 \n");
        assert_eq!(lines.title(2), "line 2: G1 X1");
        assert_eq!((lines.short(9), lines.short(0)), (String::new(), String::new()));
    }
}
