//! Writing scripts.

use core::fmt::Write;

use lang::axis::Axis;
use lang::profile::{Profile, Scale};

/// Column at which remarks behind statements begin.
const REMARK_COLUMN: usize = 40;

/// A script as it grows.
#[derive(Debug, Default)]
pub(crate) struct Script {
    text: String,
    indent: usize,
    /// Line of the source that is being written.
    place: u32,
    places: Vec<u32>,
}

/// A finished script.
#[derive(Clone, Debug, Default)]
pub(crate) struct Made {
    /// Its text.
    pub text: String,
    /// For each line the line of the source that it came from, 0 where there is none.
    pub places: Vec<u32>,
}

impl Script {
    /// The head of every script: where it comes from, and its profile.
    pub fn new(name: &str, what: &str, profile: &Profile) -> Script {
        let mut script = Script::default();
        let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
        script.remark(&format!("Imported from {}: {what}.", clean(name)));
        script.line(&format!("PROFILE \"{}\"", profile.name));
        script
    }

    /// What follows comes from this line of the source.
    pub fn set_place(&mut self, line: u32) {
        self.place = line;
    }

    /// One line.
    pub fn line(&mut self, text: &str) {
        self.pad();
        self.text.push_str(text);
        self.end();
    }

    fn end(&mut self) {
        self.text.push('\n');
        self.places.push(self.place);
    }

    /// One line at the left margin.
    pub fn label(&mut self, name: &str) {
        let _ = write!(self.text, "{name}:");
        self.end();
    }

    /// A line with a remark behind it; an empty one is left out.
    pub fn remarked(&mut self, text: &str, remark: &str) {
        let remark = clean(remark);
        if remark.is_empty() {
            return self.line(text);
        }
        self.pad();
        let width = REMARK_COLUMN.saturating_sub(2 * self.indent);
        let _ = write!(self.text, "{text:width$} ' {remark}");
        self.end();
    }

    /// A line of its own for a remark.
    pub fn remark(&mut self, text: &str) {
        self.pad();
        let text = clean(text);
        self.text.push('\'');
        if !text.is_empty() {
            self.text.push(' ');
            self.text.push_str(&text);
        }
        self.end();
    }

    /// An empty line.
    pub fn gap(&mut self) {
        if !self.text.ends_with("\n\n") {
            self.end();
        }
    }

    /// What follows stands deeper.
    pub fn open(&mut self, text: &str) {
        self.line(text);
        self.indent += 1;
    }

    /// What follows stands less deep.
    pub fn close(&mut self, text: &str) {
        self.indent = self.indent.saturating_sub(1);
        self.line(text);
    }

    /// The script, done.
    pub fn finish(self) -> Made {
        Made { text: self.text, places: self.places }
    }

    fn pad(&mut self) {
        for _ in 0..self.indent {
            self.text.push_str("  ");
        }
    }
}

/// Text for a remark: no control characters, no blanks at its ends, and no ` _` at its end, which
/// would go on with the next line.
pub(crate) fn clean(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    text.trim().trim_end_matches(|c: char| c == '_' || c.is_whitespace()).to_owned()
}

/// Text for PRINT: without what would end the literal.
pub(crate) fn literal(text: &str) -> String {
    clean(&text.replace('"', "'"))
}

/// A length in um as a literal: `2.54mm`.
pub(crate) fn mm(um: i64) -> String {
    let sign = if um < 0 { "-" } else { "" };
    let (whole, rest) = (um.unsigned_abs() / 1000, um.unsigned_abs() % 1000);
    if rest == 0 {
        return format!("{sign}{whole}mm");
    }
    let rest = format!("{rest:03}");
    format!("{sign}{whole}.{}mm", rest.trim_end_matches('0'))
}

/// A time in ms as a literal: `1.5s`.
pub(crate) fn time(ms: i64) -> String {
    match (ms / 1000, ms % 1000) {
        (0, ms) if ms > 0 => format!("{ms}ms"),
        (s, 0) => format!("{s}s"),
        (s, rest) => format!("{s}.{}s", format!("{rest:03}").trim_end_matches('0')),
    }
}

/// How the steps of a source are written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Units {
    /// The source's scale of each axis, where it is known.
    source: [Option<Scale>; 3],
    /// The axes whose scale the profile shares.
    same: [bool; 3],
}

impl Units {
    /// Compares the source's scales with the profile's.
    pub fn new(source: [Option<Scale>; 3], profile: &Profile) -> Units {
        let same = Axis::ALL.map(|axis| match (source[axis.index()], profile.axis(axis)) {
            (Some(scale), Some(part)) => equal(scale, part.scale),
            _ => false,
        });
        Units { source, same }
    }

    /// Whether lengths of the axis may be written in mm.
    pub fn metric(&self, axis: Axis) -> bool {
        self.same[axis.index()]
    }

    /// Steps of an axis as a literal: mm where that is exact, else steps.
    pub fn steps(&self, axis: Axis, steps: i64) -> String {
        match self.exact(axis, steps).filter(|_| self.metric(axis)) {
            Some(um) => mm(um),
            None => format!("{steps}st"),
        }
    }

    /// What the steps are in the source's mm, where the script does not say it itself.
    pub fn told(&self, axis: Axis, steps: i64) -> Option<String> {
        if steps == 0 || self.metric(axis) && self.exact(axis, steps).is_some() {
            return None;
        }
        let scale = self.source[axis.index()]?;
        let um = steps * i64::from(scale.um) / i64::from(scale.steps);
        Some(format!("{} {}", axis.letter(), mm(um)))
    }

    fn exact(&self, axis: Axis, steps: i64) -> Option<i64> {
        let scale = self.source[axis.index()]?;
        let um = steps.checked_mul(i64::from(scale.um))?;
        (um % i64::from(scale.steps) == 0).then(|| um / i64::from(scale.steps))
    }
}

/// Whether two scales are one ratio.
fn equal(a: Scale, b: Scale) -> bool {
    u32::from(a.steps) * u32::from(b.um) == u32::from(b.steps) * u32::from(a.um)
}

#[cfg(test)]
mod tests {
    use super::{clean, mm, time};

    #[test]
    fn lengths_are_short_and_exact() {
        assert_eq!(mm(2540), "2.54mm");
        assert_eq!(mm(-5), "-0.005mm");
        assert_eq!(mm(-12_000), "-12mm");
        assert_eq!(mm(0), "0mm");
    }

    #[test]
    fn times_are_short_and_exact() {
        assert_eq!([0, 250, 1000, 1500, 90_000].map(time), ["0s", "250ms", "1s", "1.5s", "90s"]);
    }

    #[test]
    fn a_remark_never_continues_its_line() {
        assert_eq!(clean("  a\tb _ "), "a b");
        assert_eq!(clean("_"), "");
    }
}
