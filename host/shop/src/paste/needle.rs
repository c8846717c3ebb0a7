//! The needle's file: what gives the dots, how large they are, how high it goes.

use std::f64::consts::PI;

use lang::axis::Axis;
use lang::profile::Profile;
use serde::Deserialize;

use crate::terminal::{Terminal, input, output};
use crate::wrong::{Wrong, of_toml, place};

/// Longest time, ms.
const LONGEST: u32 = 60_000;

/// All of the file. Lengths in mm, machine frame, times in ms.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Needle {
    /// Inner diameter of the needle.
    pub diameter: f64,
    /// Width of one dot on the board.
    pub dot: f64,
    /// Thickness of the stencil that the dots stand in for.
    pub stencil: f64,
    /// Output of the valve.
    pub output: Terminal,
    /// How long it is open for one dot.
    pub ms: u32,
    /// Machine Z at which everything is passed.
    pub clearance: f64,
    /// Machine Z of the board's top.
    pub board: f64,
    /// How far the needle goes up from dot to dot.
    #[serde(default = "lift")]
    pub lift: f64,
    /// After a dot, before the needle goes up.
    #[serde(default)]
    pub suck_ms: u32,
    /// Output that is on meanwhile: it draws the paste back.
    pub suck: Option<Terminal>,
    /// Where the needle is emptied before the first dot, X and Y.
    pub purge: Option<[f64; 2]>,
    /// For how long.
    #[serde(default)]
    pub purge_ms: u32,
    /// A place that the needle's tip touches before the first dot: X, Y, and the machine's Z there.
    pub touch: Option<[f64; 3]>,
    /// Input that is on while it touches.
    pub probe: Option<Terminal>,
    /// Long pads get beads.
    pub bead: Option<Bead>,
}

/// Lines of paste on the way. Lengths in mm, speeds in mm/s.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bead {
    /// Length of the shortest pad that gets one.
    pub from: f64,
    /// Range of the needle's speed.
    pub slowest: f64,
    /// See `slowest`.
    pub fastest: f64,
    /// From the valve's signal to the first paste, ms.
    #[serde(default)]
    pub opens_ms: u32,
    /// Paste that still comes when the valve has closed, as a length of the bead.
    #[serde(default)]
    pub thread: f64,
}

/// Longest time that a valve takes to open, ms.
const LONGEST_OPENING: u32 = 1000;

const fn lift() -> f64 {
    1.0
}

impl Needle {
    /// Reads a file's text.
    ///
    /// # Errors
    /// What is wrong and where.
    pub fn parse(text: &str, profile: &Profile) -> Result<Needle, Wrong> {
        let needle: Needle = toml::from_str(text).map_err(|error| of_toml(text, &error))?;
        needle.check(profile).map_err(|(key, words, hint)| {
            let stands = |line: &str| line.split('=').next().is_some_and(|k| k.trim() == key);
            let at = text.lines().position(stands).unwrap_or(0);
            let start = text.lines().take(at).map(|line| line.len() + 1).sum();
            Wrong { at: place(text, start), text: words, hint, warning: false }
        })?;
        Ok(needle)
    }

    fn check(&self, profile: &Profile) -> Result<(), (&'static str, String, String)> {
        let sizes = [("diameter", self.diameter), ("dot", self.dot), ("stencil", self.stencil)];
        for (key, size) in sizes {
            if !(0.01..=20.0).contains(&size) {
                let hint = format!("{key} is 0.01 to 20 mm");
                return Err((key, format!("{key} is {size}"), hint));
            }
        }
        if self.dot < self.diameter / 2.0 {
            let words =
                format!("a dot {} mm wide comes from a needle of {} mm", self.dot, self.diameter);
            return Err(("dot", words, "a dot is at least half as wide as the needle".to_owned()));
        }
        let times = [("ms", self.ms), ("suck_ms", self.suck_ms), ("purge_ms", self.purge_ms)];
        for (key, ms) in times {
            if ms > LONGEST || key == "ms" && self.ms == 0 {
                return Err((
                    key,
                    format!("{key} is {ms}"),
                    format!("a time is 1 to {LONGEST} ms"),
                ));
            }
        }
        self.heights(profile)?;
        let named = |key, found: Result<i32, String>| {
            let hint = "a number, or a name of the profile".to_owned();
            found.map(drop).map_err(|words| (key, words, hint))
        };
        named("output", output(profile, &self.output))?;
        if let Some(suck) = &self.suck {
            named("suck", output(profile, suck))?;
            if self.suck_ms == 0 {
                let hint = "suck_ms is how long the output is on".to_owned();
                return Err(("suck", "suck without suck_ms".to_owned(), hint));
            }
        }
        if let Some(probe) = &self.probe {
            named("probe", input(profile, probe))?;
        }
        if let Some(bead) = &self.bead {
            bead.check()?;
        }
        self.places(profile)
    }

    fn heights(&self, profile: &Profile) -> Result<(), (&'static str, String, String)> {
        let Some(z) = &profile.z else {
            let words = format!("the machine {} has no Z", profile.name);
            return Err(("board", words, "--profile names a machine with a Z axis".to_owned()));
        };
        let (low, high) = (f64::from(z.min_um) / 1000.0, f64::from(z.max_um) / 1000.0);
        let touch = self.touch.map_or(self.board, |touch| touch[2]);
        for (key, height) in
            [("clearance", self.clearance), ("board", self.board), ("touch", touch)]
        {
            if !(low..=high).contains(&height) {
                let words = format!("{key} is at Z {height}");
                return Err((key, words, format!("Z goes from {low} to {high} mm")));
            }
        }
        if !(0.05..=100.0).contains(&self.lift) {
            let hint = "lift is 0.05 to 100 mm".to_owned();
            return Err(("lift", format!("lift is {}", self.lift), hint));
        }
        let up = f64::from(z.upward());
        if up * (self.clearance - self.board) < self.gap() + self.lift {
            let words = "the needle lifts above the clearance".to_owned();
            let down = if z.counts_down() { "; Z of this machine counts downward" } else { "" };
            return Err(("clearance", words, format!("clearance lies above board and lift{down}")));
        }
        Ok(())
    }

    fn places(&self, profile: &Profile) -> Result<(), (&'static str, String, String)> {
        if self.purge.is_some() != (self.purge_ms > 0) {
            let words = "purge and purge_ms go together".to_owned();
            return Err(("purge", words, "purge = [X, Y], purge_ms = 500".to_owned()));
        }
        if self.touch.is_some() != self.probe.is_some() {
            let words = "touch and probe go together".to_owned();
            return Err(("touch", words, "touch = [X, Y, Z], probe = 3".to_owned()));
        }
        let touch = self.touch.map(|[x, y, _]| [x, y]);
        for (key, place) in [("purge", self.purge), ("touch", touch)] {
            for (letter, mm) in ["X", "Y"].into_iter().zip(place.into_iter().flatten()) {
                let axis = if letter == "X" { &profile.x } else { &profile.y };
                let range = axis.as_ref().map(|axis| (axis.min_um, axis.max_um));
                let inside = |(low, high): (i32, i32)| {
                    (f64::from(low)..=f64::from(high)).contains(&(mm * 1000.0))
                };
                if !range.is_some_and(inside) {
                    let words = format!("{key} is at {letter} {mm}, outside the machine's travel");
                    return Err((key, words, "a place of the machine, mm".to_owned()));
                }
            }
        }
        Ok(())
    }

    /// How high above the board the needle stands, mm: half its diameter.
    pub fn gap(&self) -> f64 {
        self.diameter / 2.0
    }

    /// The area that a stencil would have for what one dot holds, mm2. A dot is taken as half a ball.
    pub fn area(&self) -> f64 {
        PI / 12.0 * self.dot.powi(3) / self.stencil
    }

    /// The Z of the machine that lies `deep` mm below `z`, as far as its travel goes.
    pub(super) fn below(profile: &Profile, z: f64, deep: f64) -> f64 {
        let Some(own) = profile.axis(Axis::Z) else { return z };
        let [low, high] = [own.min_um, own.max_um].map(|um| f64::from(um) / 1000.0);
        (z - f64::from(own.upward()) * deep).clamp(low, high)
    }
}

impl Bead {
    fn check(&self) -> Result<(), (&'static str, String, String)> {
        for (key, value, least, most) in [
            ("from", self.from, 0.1, 1000.0),
            ("slowest", self.slowest, 0.1, 500.0),
            ("fastest", self.fastest, 0.1, 500.0),
            ("thread", self.thread, 0.0, 20.0),
        ] {
            if !(least..=most).contains(&value) {
                return Err((
                    key,
                    format!("{key} is {value}"),
                    format!("{key} is {least} to {most}"),
                ));
            }
        }
        if self.slowest > self.fastest {
            let words = format!("slowest is {} and fastest is {}", self.slowest, self.fastest);
            return Err(("slowest", words, "slowest is at most fastest".to_owned()));
        }
        if self.opens_ms > LONGEST_OPENING {
            let words = format!("opens_ms is {}", self.opens_ms);
            return Err(("opens_ms", words, format!("opens_ms is 0 to {LONGEST_OPENING}")));
        }
        if self.thread >= self.from {
            let words = format!("thread is {} and from is {}", self.thread, self.from);
            return Err(("thread", words, "thread is shorter than the shortest pad".to_owned()));
        }
        Ok(())
    }
}
