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

/// A line of the source, trimmed and shortened.
pub fn source_line(source: &str, line: u32) -> String {
    const LONGEST: usize = 80;
    let text = source.lines().nth((line as usize).saturating_sub(1)).unwrap_or_default().trim();
    let mut short: String = text.chars().take(LONGEST).collect();
    if text.chars().count() > LONGEST {
        short.push('\u{2026}');
    }
    short
}

#[cfg(test)]
mod tests {
    use super::{source_line, time};

    #[test]
    fn times_read_well_at_every_size() {
        assert_eq!(time(850_400), "850 ms");
        assert_eq!(time(12_440_000), "12.4 s");
        assert_eq!(time(185_000_000), "3 min 05 s");
        assert_eq!(time(8_040_000_000), "2 h 14 min");
    }

    #[test]
    fn a_source_line_is_trimmed_and_a_missing_one_is_empty() {
        assert_eq!(source_line("a\n  G1 X1 \n", 2), "G1 X1");
        assert_eq!(source_line("a\n", 9), "");
    }
}
