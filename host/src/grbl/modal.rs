//! Modal state between lines: modal words and offsets.

/// A place or an offset, mm.
pub type Point = [f64; 3];

/// Millimetres of an inch.
pub const INCH: f64 = 25.4;

/// The motion word that holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// G0
    Rapid,
    /// G1
    Line,
    /// G2
    Clockwise,
    /// G3
    CounterClockwise,
    /// G38.2 (the miss is an alarm), G38.3 (it is not), toward contact; G38.4, G38.5 away from it.
    Probe {
        /// Whether a miss is no alarm.
        quiet: bool,
        /// Whether it looks for the contact's end.
        away: bool,
    },
    /// G80
    Off,
}

impl Motion {
    /// As `$G` shows it.
    fn word(self) -> &'static str {
        match self {
            Motion::Rapid => "G0",
            Motion::Line => "G1",
            Motion::Clockwise => "G2",
            Motion::CounterClockwise => "G3",
            Motion::Probe { quiet: false, away: false } => "G38.2",
            Motion::Probe { quiet: true, away: false } => "G38.3",
            Motion::Probe { quiet: false, away: true } => "G38.4",
            Motion::Probe { quiet: true, away: true } => "G38.5",
            Motion::Off => "G80",
        }
    }
}

/// M3, M4 or M5.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spindle {
    /// M5
    Off,
    /// M3; a laser's constant power.
    Clockwise,
    /// M4; a laser's power follows the speed.
    CounterClockwise,
}

/// The modal words.
#[derive(Clone, Debug, PartialEq)]
pub struct Modal {
    /// G0 to G3, G38, G80.
    pub motion: Motion,
    /// 0 for G54 to 5 for G59.
    pub wcs: usize,
    /// 17 to 19.
    pub plane: u8,
    /// G20.
    pub inches: bool,
    /// G91.
    pub relative: bool,
    /// G93.
    pub inverse_time: bool,
    /// M3, M4, M5.
    pub spindle: Spindle,
    /// M8.
    pub flood: bool,
    /// M7.
    pub mist: bool,
    /// F in mm/min, 0 for none yet.
    pub feed: f64,
    /// S.
    pub speed: f64,
    /// T.
    pub tool: u32,
}

impl Default for Modal {
    /// As after a reset.
    fn default() -> Modal {
        Modal {
            motion: Motion::Rapid,
            wcs: 0,
            plane: 17,
            inches: false,
            relative: false,
            inverse_time: false,
            spindle: Spindle::Off,
            flood: false,
            mist: false,
            feed: 0.0,
            speed: 0.0,
            tool: 0,
        }
    }
}

impl Modal {
    /// The line that answers `$G`.
    pub fn text(&self, inches: bool) -> String {
        let coolant = match (self.mist, self.flood) {
            (false, false) => "M9",
            (true, false) => "M7",
            (false, true) => "M8",
            (true, true) => "M7 M8",
        };
        let spindle = match self.spindle {
            Spindle::Off => 5,
            Spindle::Clockwise => 3,
            Spindle::CounterClockwise => 4,
        };
        let feed = if inches { self.feed / INCH } else { self.feed };
        let decimals = usize::from(inches);
        format!(
            "[GC:{} G{} G{} G{} G{} G{} M{spindle} {coolant} T{} F{feed:.decimals$} S{:.0}]",
            self.motion.word(),
            54 + self.wcs,
            self.plane,
            if self.inches { 20 } else { 21 },
            if self.relative { 91 } else { 90 },
            if self.inverse_time { 93 } else { 94 },
            self.tool,
            self.speed,
        )
    }

    /// What M2 and M30 bring back.
    pub fn end_program(&mut self) {
        self.motion = Motion::Line;
        (self.wcs, self.plane) = (0, 17);
        (self.relative, self.inverse_time) = (false, false);
        (self.spindle, self.flood, self.mist) = (Spindle::Off, false, false);
    }
}

/// The offsets, and what a probe found. Lengths in mm, machine frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Offsets {
    /// G54 to G59.
    pub wcs: [Point; 6],
    /// G28's place.
    pub g28: Point,
    /// G30's place.
    pub g30: Point,
    /// G92.
    pub g92: Point,
    /// G43.1.
    pub tool: f64,
    /// Where the last probe met something.
    pub probed: Point,
    /// Whether it did.
    pub met: bool,
}

impl Offsets {
    /// Machine place less work place.
    pub fn work(&self, wcs: usize) -> Point {
        let own = self.wcs[wcs];
        [own[0] + self.g92[0], own[1] + self.g92[1], own[2] + self.g92[2] + self.tool]
    }

    /// The lines that answer `$#`.
    pub fn text(&self, inches: bool) -> String {
        let mut out = String::new();
        for (i, own) in self.wcs.iter().enumerate() {
            out += &format!("[G{}:{}]\r\n", 54 + i, point(own, inches));
        }
        for (name, own) in [("G28", &self.g28), ("G30", &self.g30), ("G92", &self.g92)] {
            out += &format!("[{name}:{}]\r\n", point(own, inches));
        }
        out += &format!("[TLO:{}]\r\n", length(self.tool, inches));
        out.push_str(&self.probe_text(inches));
        out.push_str("\r\n");
        out
    }

    /// `[PRB:..]`
    pub fn probe_text(&self, inches: bool) -> String {
        format!("[PRB:{}:{}]", point(&self.probed, inches), u8::from(self.met))
    }
}

/// A length for a client: mm with three decimals, or inches with four.
pub fn length(mm: f64, inches: bool) -> String {
    // What rounds to zero has no sign.
    let value = if inches { mm / INCH } else { mm };
    let decimals = if inches { 4 } else { 3 };
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(size) if size.bytes().all(|c| c == b'0' || c == b'.') => size.to_owned(),
        _ => text,
    }
}

/// Three lengths with commas between.
pub fn point(place: &Point, inches: bool) -> String {
    place.map(|value| length(value, inches)).join(",")
}

#[cfg(test)]
mod tests {
    use super::{Modal, Offsets, length};

    #[test]
    fn words_and_offsets_are_told_as_grbl_tells_them() {
        let modal = Modal { feed: 600.0, relative: true, mist: true, ..Modal::default() };
        assert_eq!(modal.text(false), "[GC:G0 G54 G17 G21 G91 G94 M5 M7 T0 F600 S0]");
        let mut offsets = Offsets::default();
        offsets.wcs[1] = [1.0, -2.5, -0.0001];
        offsets.tool = 2.0;
        let text = offsets.text(false);
        assert_eq!(text.lines().count(), 11);
        assert!(text.contains("[G55:1.000,-2.500,0.000]\r\n"), "{text}");
        assert!(text.contains("[TLO:2.000]\r\n[PRB:0.000,0.000,0.000:0]"), "{text}");
        assert_eq!(offsets.work(0), [0.0, 0.0, 2.0]);
        assert_eq!(length(25.4, true), "1.0000");
    }
}
