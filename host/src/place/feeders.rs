//! `feeders.toml`: where parts lie, how they are picked.

use lang::profile::Profile;
use serde::Deserialize;
pub use shop::terminal::{Terminal, input, output};

/// Feeders of one file.
pub const MOST: usize = 64;
/// Longest text of a feeder's name.
const LONGEST_NAME: usize = 40;

/// All of the file. Lengths in mm, machine frame, times in ms.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Feeders {
    /// Machine Z at which everything is passed.
    pub clearance: f64,
    /// Machine Z of the board's top.
    pub board: f64,
    /// Output of the vacuum.
    pub vacuum: Terminal,
    /// Input that is on while a part is held; without it nothing is tested.
    pub sensor: Option<Terminal>,
    /// Time after vacuum on, before lifting; with a sensor the longest wait.
    #[serde(default = "pick")]
    pub pick_ms: u32,
    /// Time after vacuum off, before lifting.
    #[serde(default = "drop_time")]
    pub drop_ms: u32,
    /// Picks before the next feeder with the same part is taken, then the operator is asked.
    #[serde(default = "tries")]
    pub tries: u32,
    /// The axis that turns the nozzle.
    pub turn: Option<String>,
    /// Where a part that is not wanted is let go, X and Y.
    pub discard: Option<[f64; 2]>,
    /// The feeders.
    #[serde(rename = "feeder")]
    pub feeders: Vec<Feeder>,
    /// What packages are turned by between drawing and feeder.
    #[serde(default, rename = "rotation")]
    pub rotations: Vec<Rotation>,
}

const fn pick() -> u32 {
    200
}

const fn drop_time() -> u32 {
    150
}

const fn tries() -> u32 {
    3
}

/// A feeder.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Feeder {
    /// For people.
    pub name: String,
    /// Value of its parts; `*` stands for anything.
    #[serde(default = "anything")]
    pub value: String,
    /// Package of its parts; `*` stands for anything.
    #[serde(default = "anything")]
    pub package: String,
    /// How its parts lie.
    pub kind: Kind,
    /// Strip and tray: the first part.
    pub first: Option<[f64; 2]>,
    /// Strip: the part after it, which gives pitch and direction.
    pub second: Option<[f64; 2]>,
    /// Strip: how many there are; tape and tube: how many until it is empty, without it no end.
    pub count: Option<u32>,
    /// Tray: parts side by side along X.
    pub columns: Option<u32>,
    /// Tray: rows along Y.
    pub rows: Option<u32>,
    /// Tray: distance of columns and of rows.
    pub pitch: Option<[f64; 2]>,
    /// Tape and tube: where a part is picked.
    pub at: Option<[f64; 2]>,
    /// Machine Z of the top of a part that lies there.
    pub top: f64,
    /// Height of the part.
    pub height: f64,
    /// How it lies there, degrees, counter-clockwise, against its drawing.
    #[serde(default)]
    pub turned: f64,
    /// What brings the next part.
    pub advance: Option<Advance>,
}

fn anything() -> String {
    "*".to_owned()
}

/// How parts lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// In a row.
    Strip,
    /// In rows and columns.
    Tray,
    /// One after the other at one place, brought by the advance.
    Tape,
    /// One after the other at one place, by itself.
    Tube,
}

/// What brings the next part.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Advance {
    /// An output that is switched on for a while.
    pub output: Option<Terminal>,
    /// How long.
    pub pulse_ms: Option<u32>,
    /// An axis that turns the tape on.
    pub axis: Option<String>,
    /// By how far, degrees.
    pub deg: Option<f64>,
}

/// What a package is turned by.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rotation {
    /// `*` stands for anything; the first that fits holds.
    pub package: String,
    /// Degrees, counter-clockwise.
    pub add: f64,
}

/// What is wrong: the text where it stands, and words.
pub type Wrong = (String, String);

impl Feeders {
    /// Reads a file's text.
    ///
    /// # Errors
    /// What is wrong and where.
    pub fn parse(text: &str, profile: &Profile) -> Result<Feeders, shop::Wrong> {
        let feeders: Feeders = toml::from_str(text).map_err(|error| shop::of_toml(text, &error))?;
        feeders.check(profile).map_err(|(at, words)| shop::Wrong {
            at: crate::input::place(text, text.find(&at).unwrap_or(0)),
            ..shop::Wrong::whole(words, "")
        })?;
        Ok(feeders)
    }

    fn check(&self, profile: &Profile) -> Result<(), Wrong> {
        let wrong = |at: &str, words: &str| Err((at.to_owned(), words.to_owned()));
        if let Some(axis) = &self.turn {
            let words = format!(
                "turn = \"{axis}\": the machine {} has no axis that turns the nozzle; without `turn` parts \
                 lie in their feeders as they are placed",
                profile.name
            );
            return Err(("turn".to_owned(), words));
        }
        if self.feeders.is_empty() || self.feeders.len() > MOST {
            return Err(("[[feeder]]".to_owned(), format!("a file has 1 to {MOST} feeders")));
        }
        if !(1..=20).contains(&self.tries) {
            return wrong("tries", "tries is 1 to 20");
        }
        if self.pick_ms > 60_000 || self.drop_ms > 60_000 {
            return wrong("_ms", "a time is at most 60000 ms");
        }
        let z = profile.z.as_ref().ok_or_else(|| {
            ("clearance".to_owned(), format!("the machine {} has no Z", profile.name))
        })?;
        let high = |what: &str, value: f64| {
            let um = value * 1000.0;
            if um < f64::from(z.min_um) || um > f64::from(z.max_um) || !um.is_finite() {
                let words = format!(
                    "{what} is {value}; Z goes from {} to {} mm",
                    f64::from(z.min_um) / 1000.0,
                    f64::from(z.max_um) / 1000.0
                );
                return Err((what.to_owned(), words));
            }
            Ok(())
        };
        high("clearance", self.clearance)?;
        high("board", self.board)?;
        output(profile, &self.vacuum).map_err(|words| ("vacuum".to_owned(), words))?;
        if let Some(sensor) = &self.sensor {
            input(profile, sensor).map_err(|words| ("sensor".to_owned(), words))?;
        }
        for feeder in &self.feeders {
            let at = format!("\"{}\"", feeder.name);
            let words = |words: String| (at.clone(), format!("{}: {words}", feeder.name));
            if feeder.name.is_empty() || feeder.name.chars().count() > LONGEST_NAME {
                return Err(words(format!("a name has 1 to {LONGEST_NAME} letters")));
            }
            high("top", feeder.top).map_err(|(_, text)| words(text))?;
            if !(0.0..=50.0).contains(&feeder.height) {
                return Err(words("height is 0 to 50 mm".to_owned()));
            }
            let up = f64::from(z.upward());
            high("board", self.board + up * feeder.height).map_err(|(_, text)| words(text))?;
            let room = |z: f64| up * (self.clearance - z);
            if room(feeder.top) < 0.0 || room(self.board) < 2.0 * feeder.height {
                let down = if z.counts_down() { ": Z of this machine counts downward" } else { "" };
                return Err(words(format!("its parts reach above the clearance{down}")));
            }
            feeder.check(profile).map_err(words)?;
        }
        Ok(())
    }

    /// The feeders that a part fits, in the file's order.
    pub fn fitting(&self, value: &str, package: &str) -> Vec<usize> {
        let fits = |feeder: &Feeder| like(&feeder.value, value) && like(&feeder.package, package);
        (0..self.feeders.len()).filter(|n| fits(&self.feeders[*n])).collect()
    }

    /// What a package is turned by, degrees.
    pub fn rotation(&self, package: &str) -> f64 {
        let found = self.rotations.iter().find(|rotation| like(&rotation.package, package));
        found.map_or(0.0, |rotation| rotation.add)
    }
}

impl Feeder {
    fn check(&self, profile: &Profile) -> Result<(), String> {
        let has = |what: &str, there: bool| {
            if there {
                Ok(())
            } else {
                Err(format!("a {:?} needs `{what}`", self.kind).to_lowercase())
            }
        };
        match self.kind {
            Kind::Strip => {
                has("first", self.first.is_some())?;
                has("second", self.second.is_some())?;
                has("count", self.count.is_some())?;
                if self.first == self.second {
                    return Err("first and second are the same place".to_owned());
                }
            }
            Kind::Tray => {
                has("first", self.first.is_some())?;
                has("columns", self.columns.is_some())?;
                has("rows", self.rows.is_some())?;
                has("pitch", self.pitch.is_some())?;
            }
            Kind::Tape | Kind::Tube => has("at", self.at.is_some())?,
        }
        if self.places() == Some(0) || self.places().is_some_and(|count| count > 30_000) {
            return Err("it holds 1 to 30000 parts".to_owned());
        }
        if let Some(advance) = &self.advance {
            if advance.axis.is_some() || advance.deg.is_some() {
                return Err(format!(
                    "the machine {} has no axis that turns a tape; advance = {{ output, pulse_ms }}",
                    profile.name
                ));
            }
            let named = advance.output.as_ref().ok_or("advance = { output, pulse_ms }")?;
            output(profile, named)?;
            if !(1..=60_000).contains(&advance.pulse_ms.unwrap_or(0)) {
                return Err("pulse_ms is 1 to 60000".to_owned());
            }
        }
        for [x, y] in self.corners() {
            for (axis, value, letter) in [(&profile.x, x, 'X'), (&profile.y, y, 'Y')] {
                let axis = axis.as_ref().ok_or_else(|| format!("there is no {letter}"))?;
                let um = value * 1000.0;
                if !um.is_finite() || um < f64::from(axis.min_um) || um > f64::from(axis.max_um) {
                    return Err(format!("{letter} comes to {value}, outside the machine's travel"));
                }
            }
        }
        Ok(())
    }

    /// How many parts it holds; none for no end.
    pub fn places(&self) -> Option<u32> {
        match self.kind {
            Kind::Tray => Some(self.columns.unwrap_or(0).saturating_mul(self.rows.unwrap_or(0))),
            _ => self.count,
        }
    }

    /// Its first place, the step from one to the next, parts in a row, the step from row to row; mm.
    pub fn grid(&self) -> ([f64; 2], [f64; 2], u32, [f64; 2]) {
        let first = self.first.or(self.at).unwrap_or_default();
        match self.kind {
            Kind::Strip => {
                let second = self.second.unwrap_or(first);
                let step = [second[0] - first[0], second[1] - first[1]];
                (first, step, self.count.unwrap_or(1).max(1), [0.0; 2])
            }
            Kind::Tray => {
                let pitch = self.pitch.unwrap_or_default();
                (first, [pitch[0], 0.0], self.columns.unwrap_or(1).max(1), [0.0, pitch[1]])
            }
            Kind::Tape | Kind::Tube => (first, [0.0; 2], 1, [0.0; 2]),
        }
    }

    /// The first place and the farthest ones.
    fn corners(&self) -> Vec<[f64; 2]> {
        let (first, step, columns, row) = self.grid();
        let rows = match self.kind {
            Kind::Tray => self.rows.unwrap_or(1).max(1),
            _ => 1,
        };
        let at = |c: u32, r: u32| {
            let (c, r) = (f64::from(c), f64::from(r));
            [first[0] + c * step[0] + r * row[0], first[1] + c * step[1] + r * row[1]]
        };
        vec![first, at(columns - 1, 0), at(0, rows - 1), at(columns - 1, rows - 1)]
    }
}

/// Whether a text fits a pattern in which `*` stands for anything; letters of both cases are the same.
pub fn like(pattern: &str, text: &str) -> bool {
    let (pattern, text) = (pattern.to_lowercase(), text.to_lowercase());
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or_default();
    let Some(mut rest) = text.strip_prefix(first) else { return false };
    let mut parts: Vec<&str> = parts.collect();
    let Some(last) = parts.pop() else { return rest.is_empty() };
    for part in parts {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.len() >= last.len() && rest.ends_with(last)
}
