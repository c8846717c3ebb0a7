//! A proof in words and as JSON lines.

use cell::vary::Deviation;
use serde::Serialize;

use super::{Proof, Tally};
use crate::plot::time;

/// Bounds of a share that holds with 95 %: Wilson's interval, which is right for few runs and for shares near 0 and 1.
#[must_use]
pub fn interval(hits: u64, runs: u64) -> [f64; 2] {
    if runs == 0 {
        return [0.0, 1.0];
    }
    // 1.96 standard deviations.
    let (n, z2) = (runs as f64, 1.96_f64 * 1.96);
    let share = hits as f64 / n;
    let middle = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = 1.96 / (1.0 + z2 / n) * (share * (1.0 - share) / n + z2 / (4.0 * n * n)).sqrt();
    [(middle - half).max(0.0), (middle + half).min(1.0)]
}

fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}

impl Tally {
    /// The smallest deviations in words, for people.
    fn smallest(&self) -> Option<String> {
        let shrunk = self.shrunk.as_ref()?;
        let list: Vec<String> = shrunk.deviations.iter().map(Deviation::text).collect();
        Some(if list.is_empty() { "no deviation at all".to_owned() } else { list.join("; ") })
    }
}

impl Proof {
    /// Whether every run was passed or handled, and there was one where one was to be made.
    #[must_use]
    pub fn holds(&self) -> bool {
        (self.runs > 0 || self.wanted == 0) && !self.tallies.iter().any(|tally| tally.class.fails())
    }

    /// The table for people. `line_of` makes the line in the user's file of one in the script, `nominal` tells what the
    /// cell file says of a key.
    #[must_use]
    pub fn table(
        &self,
        file: &str,
        line_of: &dyn Fn(u32) -> u32,
        nominal: &dyn Fn(&str) -> Option<f64>,
    ) -> String {
        let mut rows = vec![["outcome", "runs", "share", "95 %", "first seed"].map(str::to_owned)];
        for tally in &self.tallies {
            let [least, most] = interval(tally.runs, self.runs);
            rows.push([
                tally.class.word().to_owned(),
                tally.runs.to_string(),
                percent(tally.runs as f64 / self.runs.max(1) as f64),
                format!("{} to {}", percent(least), percent(most)),
                tally.seed.to_string(),
            ]);
        }
        let width = |column: usize| rows.iter().map(|row| row[column].len()).max().unwrap_or(0);
        let widths: [usize; 5] = std::array::from_fn(width);
        let mut text = String::new();
        for row in &rows {
            let cells = row.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}  "));
            text += cells.collect::<String>().trim_end();
            text.push('\n');
        }
        let failures: u64 =
            self.tallies.iter().filter(|own| own.class.fails()).map(|own| own.runs).sum();
        if failures == 0 && self.runs > 0 {
            // The rule of three, which says nothing of fewer runs.
            let most = percent((3.0 / self.runs as f64).min(1.0));
            text += &format!("0 failures in {} runs: below {most} with 95 %\n", self.runs);
        }
        for tally in &self.tallies {
            text += &case(tally, file, line_of, nominal);
        }
        if !self.unreached.is_empty() {
            let lines: Vec<String> =
                self.unreached.iter().map(|line| line_of(*line).to_string()).collect();
            let word = if lines.len() == 1 { "line" } else { "lines" };
            text += &format!("never reached: {word} {}\n", lines.join(", "));
        }
        let seconds = self.took.as_secs_f64().max(1e-3);
        let of =
            if self.runs < self.wanted { format!(" of {}", self.wanted) } else { String::new() };
        let rate = self.runs as f64 / seconds;
        text += &format!("{}{of} runs in {seconds:.1} s, {rate:.1} a second\n", self.runs);
        text
    }

    /// The same as JSON lines.
    #[must_use]
    pub fn json(&self, line_of: &dyn Fn(u32) -> u32) -> Vec<String> {
        let texts = |list: &[Deviation]| list.iter().map(Deviation::text).collect::<Vec<_>>();
        let of = |tally: &Tally| {
            let end = tally.shrunk.as_ref().map(|shrunk| &shrunk.ran);
            Outcome {
                outcome: tally.class.word(),
                runs: tally.runs,
                share: tally.runs as f64 / self.runs.max(1) as f64,
                seed: tally.seed,
                before: end.map(|_| tally.deviations.len()),
                deviations: tally.shrunk.as_ref().map(|own| texts(&own.deviations)),
                end: end.map(|ran| ran.report.end.how.clone()),
                line: end.map(|ran| line_of(ran.end.line)),
            }
        };
        let mut lines: Vec<String> = self
            .tallies
            .iter()
            .map(|tally| serde_json::to_string(&of(tally)).unwrap_or_default())
            .collect();
        let count = |word: &str| {
            self.tallies.iter().find(|own| own.class.word() == word).map_or(0, |own| own.runs)
        };
        let sum = Sum {
            runs: self.runs,
            s: (self.took.as_secs_f64() * 1000.0).round() / 1000.0,
            passed: count("passed"),
            handled: count("handled"),
            unreached: self.unreached.iter().map(|line| line_of(*line)).collect(),
        };
        lines.push(serde_json::to_string(&sum).unwrap_or_default());
        lines
    }
}

#[derive(Serialize)]
struct Outcome {
    outcome: &'static str,
    runs: u64,
    share: f64,
    seed: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    before: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    deviations: Option<Vec<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    end: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<u32>,
}

#[derive(Serialize)]
struct Sum {
    runs: u64,
    s: f64,
    passed: u64,
    handled: u64,
    unreached: Vec<u32>,
}

/// A failing case: seed, deviations before and after, end, line, time, expectation, and how to see it again.
fn case(
    tally: &Tally,
    file: &str,
    line_of: &dyn Fn(u32) -> u32,
    nominal: &dyn Fn(&str) -> Option<f64>,
) -> String {
    let (Some(shrunk), Some(smallest)) = (&tally.shrunk, tally.smallest()) else {
        return String::new();
    };
    let word = tally.class.word();
    let mut text = format!(
        "\n{word}: seed {}, {} deviations, {} after {} runs of shrinking\n",
        tally.seed,
        tally.deviations.len(),
        shrunk.deviations.len(),
        shrunk.runs
    );
    text += &format!("  {word} with {smallest}\n");
    for deviation in &shrunk.deviations {
        if let (Some(value), [by]) = (nominal(&deviation.what), deviation.by.as_slice()) {
            let side = if *by < 0.0 { "below" } else { "above" };
            let limit = ((value + by) * 1000.0).round() / 1000.0;
            text +=
                &format!("  that is {} {side} {limit}; the cell says {value}\n", deviation.what);
        }
    }
    let ran = &shrunk.ran;
    let line = line_of(ran.end.line);
    text += &format!(
        "  it ended {} in line {line} after {}\n",
        ran.report.end.how,
        time(ran.report.end.us)
    );
    for row in ran.report.rows.iter().filter(|row| !row.holds) {
        let things = if row.things.is_empty() {
            String::new()
        } else {
            format!(" ({})", row.things.join(", "))
        };
        text += &format!("  {}: wanted {}, was {}{things}\n", row.name, row.wanted, row.was);
    }
    let again: String =
        shrunk.deviations.iter().map(|own| format!(" --deviate \"{}\"", own.text())).collect();
    text += &format!("  again: pasapas sim {file}{again}\n");
    text
}

#[cfg(test)]
mod tests {
    use super::interval;

    #[test]
    fn bounds_hold_for_few_and_for_many() {
        // Wilson 1927; the figures of Newcombe 1998, table I: 81 of 263, 15 of 148, 0 of 20.
        for (hits, runs, least, most) in
            [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611)]
        {
            let [a, b] = interval(hits, runs);
            assert!(
                (a - least).abs() < 1e-3 && (b - most).abs() < 1e-3,
                "{hits} of {runs}: {a} {b}"
            );
        }
        assert_eq!(interval(0, 0), [0.0, 1.0]);
    }
}
