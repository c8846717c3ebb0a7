//! What each build of the firmware runs. The chips and the builds themselves are rows of `part/rows.rs`.
//!
//! The G2553 build leaves out what its 512 bytes of RAM and 16 KB of flash cannot hold; the
//! compiler names it, and the board's verifier refuses it once more.

pub mod chip;
pub mod pins;
mod rows;

use self::chip::Chip;
pub use self::rows::{F5529, G2553, G2553_HANDLERS, PARTS};
use crate::called;
use crate::image::{Header, Image, MAX_CELLS, NARROW};
use crate::record::{MachineRecord, feature};

/// A chip with the firmware made for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// As on the command line.
    pub name: &'static str,
    /// What it is, in a few words, where it is chosen.
    pub about: &'static str,
    /// What it runs on.
    pub chip: &'static Chip,
    /// Rate of its processor and of the step timer, Hz.
    pub clock: u32,
    /// Cycles between two steps of an axis that leave the processor enough for everything else (`pasapas bench motion`).
    pub event_cycles: u32,
    /// Features ([`crate::record::feature`]) that it has.
    pub features: u16,
    /// Bytes of RAM for cells, expression stack and call stack: of a program that moves one axis at
    /// a time, and of any other.
    pub pool: [u16; 2],
    /// Bytes of it that a program with ON lines leaves to them: for what a handler interrupts, and for
    /// each line. Nothing where they have memory of their own.
    pub event_pool: [u16; 2],
    /// Bytes of it that a program with slow points ([`crate::image::course`]) leaves to them, a multiple of 4; 0 where
    /// the part knows none.
    pub course_pool: u16,
    /// What the next line of such a program takes of the processor until it is planned, us, by its axes, 1 to 3: with a busy
    /// link, but without step interrupts (`pasapas bench costs`).
    pub course_us: [u16; 3],
    /// What each line that is joined to the next one adds to it, us, by its axes.
    pub join_us: [u16; 3],
    /// Bytes of an entry of the call stack: two hold 12 bits of address and 4 of kind, four a word of each.
    pub call_bytes: u8,
    /// Flash segments of 512 bytes that hold programs. KEEP values take the last two of them, in a library two of
    /// each program that has any.
    pub segments: u8,
    /// Programs that they hold, with a name each where there are several.
    pub programs: u8,
    /// Where in the information memory the two copies of the board's profile are.
    pub profiles: [u16; 2],
    /// Consecutive G1, G2 and G3 run through their corners; without it each begins and ends at the
    /// start rate.
    pub look_ahead: bool,
    /// Bytes of the call stack and of AT variables behind it that may live between runs
    /// ([`Part::keeps_at`]), 0 for none.
    pub at_room: u16,
    /// The link refuses a value outside of the MIN and MAX of an AT variable.
    pub at_limits: bool,
    /// A host in trace mode halts the program before any effect, and sees which one it is and who called
    /// for it ([`crate::wire::WAITS`]).
    pub halts: bool,
    /// Its step engine has STEP active low where the profile says so, and delays a step until DIR has stood for
    /// `dir_setup_us`. Without it STEP is active high, and steps come as they are planned.
    pub shapes_steps: bool,
}

/// What a profile asks of the signals STEP and DIR.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signals {
    /// Width of a STEP pulse, us.
    pub pulse_us: u8,
    /// Time from a change of DIR to the next step, us.
    pub setup_us: u8,
    /// STEP is active when low.
    pub step_low: bool,
    /// There are analog inputs.
    pub analog: bool,
    /// An analog output.
    pub aout: bool,
}

impl From<u8> for Signals {
    /// Pulses of this width, us, and nothing else that a part could lack.
    fn from(pulse_us: u8) -> Signals {
        Signals { pulse_us, setup_us: 1, step_low: false, analog: false, aout: false }
    }
}

#[cfg(feature = "compiler")]
impl From<&crate::profile::Profile> for Signals {
    fn from(profile: &crate::profile::Profile) -> Signals {
        let (pulse_us, setup_us) = (profile.pulse_us, profile.dir_setup_us);
        let (analog, aout) = (!profile.analogs.is_empty(), !profile.aouts.is_empty());
        Signals { pulse_us, setup_us, step_low: profile.step_invert, analog, aout }
    }
}

/// Time from the event of the step engine at which DIR changes to the change itself, us, with interrupts of the link
/// before it: it is lost to the set-up on a part that does not wait for it ([`Part::shapes_steps`]).
const DIR_LATE_US: u32 = 25;

/// Rate, steps/s, from which an axis may turn round on a part that does not wait for DIR: the first step behind a change
/// comes half an interval later.
const fn turning_rate(setup_us: u8) -> u32 {
    500_000 / (setup_us as u32 + DIR_LATE_US)
}

/// Bytes of a flash segment (SLAU144, 7.2).
pub const SEGMENT: usize = 512;
/// Characters of a program's name in a library.
pub const NAME: usize = 16;

/// Bytes of a slot before its image, in a store of so many programs: commit word and spare word, in a library number
/// and size of the slot, and the name.
pub const fn slot_head(programs: u8) -> usize {
    if programs > 1 { 6 + NAME } else { 4 }
}

/// Every chip that a part is for.
pub fn chips() -> impl Iterator<Item = &'static Chip> {
    let first = |n: usize| PARTS.iter().position(|part| part.chip == PARTS[n].chip) == Some(n);
    (0..PARTS.len()).filter(move |n| first(*n)).map(|n| PARTS[n].chip)
}

/// Step events of a path in a second, at most: its interrupt of 212 cycles at a segment's change comes behind one of the
/// link's of 55, and the F5529 has 274 of its 25 MHz. An axis on its own is as fast as [`Part::top_rate`].
pub const PATH_RATE: u32 = 91_000;

/// The longest time, ms, by which an action on the way (SYNC) comes before its place: the step engine holds that much more
/// of the path.
pub const SYNC_LEAD_MS: i32 = 50;

/// The longest lag and pulse of one, ms.
pub const SYNC_MS: i32 = i16::MAX as i32;

/// The longest lead and lag of one along the path, um: places along it are counted to 4.29 km and then from 0 again, so half
/// of that is the most that two of them may be apart.
pub const SYNC_WAY: i32 = 1_000_000_000;

/// The longest STEP pulse that one interrupt makes, us.
pub const SHORT_PULSE_US: u8 = 3;

/// A longer pulse takes a second interrupt: beside its width both interrupts and what else may come between
/// must pass before the next event, cycles.
const LONG_EVENT_CYCLES: u32 = 360;

impl Part {
    /// Steps in a second that the engine keeps up with pulses of this width, the link busy: those of a single axis or,
    /// up to [`PATH_RATE`], of a path, or two fifths of it of each axis where they move on their own (START). Three axes at
    /// half of it leave the main loop so little time that both lines together make it too slow for the watchdog.
    pub const fn top_rate(&self, pulse_us: u8, on_their_own: bool) -> u32 {
        let cycles = match pulse_us {
            0..=SHORT_PULSE_US => self.event_cycles,
            _ => self.clock / 1_000_000 * pulse_us as u32 + LONG_EVENT_CYCLES,
        };
        // Whole thousands where it is for the reader.
        let rate = self.clock / cycles;
        let rate = if pulse_us <= SHORT_PULSE_US { rate / 1000 * 1000 } else { rate };
        if on_their_own { rate / 5 * 2 } else { rate }
    }
}

/// The highest [`Part::top_rate`] of all parts: what a profile may ask for.
pub fn top_rate(pulse_us: u8) -> u32 {
    PARTS.iter().map(|part| part.top_rate(pulse_us, false)).max().unwrap_or(0)
}

/// What a program wants that a part does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lack {
    /// A [`feature`] bit.
    Feature(u16),
    /// Bytes of RAM for cells and stacks.
    Memory {
        /// Wanted.
        used: u16,
        /// There.
        available: u16,
    },
    /// Steps in a second of the fastest axis.
    Rate {
        /// Its top rate.
        wanted: u32,
        /// What the chip makes with these pulses.
        possible: u32,
    },
    /// STEP that is active when low.
    StepLow,
    /// Time from DIR to the next step.
    Setup {
        /// Wanted, us.
        wanted: u8,
        /// Rate at which an axis may turn round, steps/s.
        rate: u32,
        /// The highest one at which the part keeps that time.
        possible: u32,
    },
    /// Bytes of flash for the image.
    Flash {
        /// Wanted.
        used: usize,
        /// There.
        available: usize,
        /// The program has KEEP values, which take two segments.
        keeps: bool,
    },
}

const fn same(a: &[u8], b: &[u8]) -> bool {
    let mut n = 0;
    while n < a.len() && n < b.len() && a[n] == b[n] {
        n += 1;
    }
    n == a.len() && n == b.len()
}

impl Part {
    /// Whether SetPos lets the machine place of an axis that is far away begin anew ([`is_far`](crate::place::is_far)).
    /// The part without look-ahead has no room for it.
    pub const fn renews(&self) -> bool {
        self.look_ahead
    }

    /// The part of this name.
    pub const fn named(name: &str) -> Option<Part> {
        let mut n = 0;
        while n < PARTS.len() {
            if same(PARTS[n].name.as_bytes(), name.as_bytes()) {
                return Some(PARTS[n]);
            }
            n += 1;
        }
        None
    }

    /// Whether it lacks this [`feature`].
    pub const fn lacks_feature(&self, feature: u16) -> bool {
        self.features & feature == 0
    }

    /// Bytes of RAM that a program with these features may use.
    pub const fn pool_for(&self, features: u16) -> u16 {
        let several = features & (feature::INTERPOLATE | feature::START) != 0;
        self.pool[several as usize]
    }

    /// Bytes of them that so many ON lines take.
    const fn event_bytes(&self, events: u8) -> u16 {
        let [all, each] = self.event_pool;
        if events == 0 { 0 } else { all + each * events as u16 }
    }

    /// Bytes of RAM that the program of this header takes, beside its ON lines.
    pub const fn pool_bytes(&self, header: &Header) -> usize {
        let calls = self.call_bytes as usize * header.calls as usize;
        4 * (header.cells as usize + header.stack as usize) + calls
    }

    /// Cells that the program of this header, with so many ON lines, may have beside its stacks.
    pub const fn cells_for(&self, header: &Header, events: u8) -> usize {
        let pool = self.pool_for(header.features as u16) as usize;
        let own = self.pool_bytes(header) - 4 * header.cells as usize;
        let cells = pool.saturating_sub(own + self.event_bytes(events) as usize) / 4;
        if cells > MAX_CELLS { MAX_CELLS } else { cells }
    }

    /// The first thing that a program, on a board with these signals or STEP pulses of this width, wants and the part
    /// lacks.
    pub fn lacks<'a>(&self, image: &'a Image<'a>, signals: impl Into<Signals>) -> Option<Lack> {
        self.all_lacks(image, signals.into()).next()
    }

    /// Everything that a program, on a board with these signals, wants and the part lacks.
    pub fn all_lacks(
        &self,
        image: &Image<'_>,
        signals: Signals,
    ) -> impl Iterator<Item = Lack> + use<> {
        let pulse_us = signals.pulse_us;
        let shapes = self.signal_lacks(signals, image.machine);
        let starts = u16::from(image.header.features) & feature::START != 0;
        let (wanted, possible) = (image.top_rate(), self.top_rate(pulse_us, starts));
        let rate = (wanted > possible).then_some(Lack::Rate { wanted, possible });
        let library = Lack::Feature(feature::LIBRARY);
        let runs = self.lacks_feature(feature::LIBRARY) && called::runs(image).next().is_some();
        let runs = runs.then_some(library);
        let courses = image.has_courses() && self.lacks_feature(feature::COURSE);
        let courses = courses.then_some(Lack::Feature(feature::COURSE));
        let extra = image.extra().fold(0, |all, (_, feature)| all | feature) & !self.features;
        let extra = [feature::RETRY, feature::MATHS, feature::ACTIONS, feature::AOUT]
            .into_iter()
            .filter(move |bit| extra & bit != 0);
        self.header_lacks(&image.header, image.events())
            .chain(extra.map(Lack::Feature))
            .chain(runs)
            .chain(courses)
            .chain(rate)
            .chain(shapes)
    }

    /// What these signals want, for a machine of which this is the [`MachineRecord`], and the part lacks.
    pub fn signal_lacks(
        &self,
        signals: Signals,
        machine: &[u8],
    ) -> impl Iterator<Item = Lack> + use<> {
        let low = (signals.step_low && !self.shapes_steps).then_some(Lack::StepLow);
        let (rate, possible) =
            (MachineRecord::turning_rate(machine), turning_rate(signals.setup_us));
        let setup = Lack::Setup { wanted: signals.setup_us, rate, possible };
        let setup = (rate > possible && !self.shapes_steps).then_some(setup);
        let analog = signals.analog && self.lacks_feature(feature::ANALOG);
        let analog = analog.then_some(Lack::Feature(feature::ANALOG));
        let aout = signals.aout && self.lacks_feature(feature::AOUT);
        let aout = aout.then_some(Lack::Feature(feature::AOUT));
        low.into_iter().chain(setup).chain(analog).chain(aout)
    }

    /// Those that the header tells of, for so many ON lines.
    fn header_lacks(&self, header: &Header, events: u8) -> impl Iterator<Item = Lack> + use<> {
        let features = u16::from(header.features);
        // Addresses of three bytes are for what is too large for the flash anyway, which is told below.
        let missing = features & !self.features & !feature::WIDE;
        let bits = (0..u16::BITS).map(|bit| 1 << bit);
        let lacking = bits.filter(move |bit| missing & bit != 0).map(Lack::Feature);
        let lines = self.event_bytes(events);
        let (used, available) = (self.pool_bytes(header) as u16 + lines, self.pool_for(features));
        let memory = (used > available).then_some(Lack::Memory { used, available });
        let (used, keeps) = (header.len, header.keeps > 0);
        let available = self.room_for(keeps);
        let flash = (used > available).then_some(Lack::Flash { used, available, keeps });
        lacking.chain(memory).chain(flash)
    }

    /// Whether the AT variables of the program of this header live between runs: the link reads and writes
    /// them, and Start keeps them.
    pub const fn keeps_at(&self, header: &Header) -> bool {
        self.call_bytes as u16 * header.calls as u16 + 4 * header.keep_base as u16 <= self.at_room
    }

    /// Bytes of the longest image, of a program without KEEP values or with them.
    pub const fn room_for(&self, keeps: bool) -> usize {
        let segments = if keeps { self.segments.saturating_sub(2) } else { self.segments };
        let room = (segments as usize * SEGMENT).saturating_sub(slot_head(self.programs));
        if room > NARROW { NARROW } else { room }
    }
}

#[cfg(feature = "compiler")]
impl core::fmt::Display for Lack {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let what = match *self {
            Lack::Flash { used, available, keeps } => {
                let leaves = if keeps { "KEEP values leave" } else { "it has" };
                return write!(
                    f,
                    "{used} bytes of flash for the program, of which {leaves} {available}"
                );
            }
            Lack::Memory { used, available } => {
                return write!(
                    f,
                    "{used} bytes of RAM for variables and stacks, of which it has {available}"
                );
            }
            Lack::Rate { wanted, possible } => {
                return write!(f, "{wanted} steps/s of an axis, of which it makes {possible}");
            }
            Lack::StepLow => "STEP active low (step_invert in the profile)",
            Lack::Setup { wanted, rate, possible } => {
                return write!(
                    f,
                    "{wanted} us from DIR to STEP (dir_setup_us) of an axis that turns round at {rate} steps/s (start_rate, or \
                     what corner_um allows), which it keeps up to {possible}"
                );
            }
            Lack::Feature(feature::INTERPOLATE) => "interpolated moves (G0, G1)",
            Lack::Feature(feature::START) => "axes on their own (START, MoveSpeed)",
            Lack::Feature(feature::ARC) => "arcs (G2, G3)",
            Lack::Feature(feature::EVENTS) => "events (ON IN, ON EVERY)",
            Lack::Feature(feature::KEEP) => "KEEP variables",
            Lack::Feature(feature::STREAM) => "jobs larger than its memory (stream)",
            Lack::Feature(feature::LIBRARY) => "a library of programs (RUN)",
            Lack::Feature(feature::POWER) => "a laser's power (S); M3 and M5 alone switch it",
            Lack::Feature(feature::RETRY) => "RESUME, which runs the failed statement again",
            Lack::Feature(feature::ACTIONS) => "actions on the way (SYNC, M62, M63)",
            Lack::Feature(feature::AOUT) => {
                "an analog output (SetAout, M67, M68; [[aout]] in the profile)"
            }
            Lack::Feature(feature::MATHS) => "SIN, COS, ATAN2 and SCALE",
            Lack::Feature(feature::ANALOG) => "analog inputs ([[analog]] in the profile)",
            Lack::Feature(feature::LINES) => "error handlers (ON ERROR)",
            Lack::Feature(_) => "more than 32 KB of program",
        };
        f.write_str(what)
    }
}

#[cfg(test)]
mod tests {
    use super::{F5529, G2553, Lack, PARTS, Part, top_rate};
    use crate::image::Header;
    use crate::record::feature;

    #[test]
    fn longer_pulses_make_slower_engines() {
        for part in PARTS {
            let rates = [2, 3, 4, 10, 20, 30].map(|pulse| part.top_rate(pulse, false));
            assert!(rates.is_sorted_by(|a, b| a >= b), "{}: {rates:?}", part.name);
        }
        assert_eq!([2, 30].map(|pulse| G2553.top_rate(pulse, false)), [60_000, 19_047]);
        assert_eq!([2, 30].map(|pulse| F5529.top_rate(pulse, false)), [100_000, 22_522]);
        assert_eq!([2, 30].map(top_rate), [100_000, 22_522]);
    }

    #[test]
    fn a_part_names_what_it_lacks() {
        let mut header = Header { features: feature::ARC as u8, ..Header::default() };
        assert_eq!(G2553.header_lacks(&header, 0).next(), Some(Lack::Feature(feature::ARC)));
        assert_eq!(F5529.header_lacks(&header, 0).next(), None);
        header = Header { len: 4000, cells: 40, ..header };
        let all: [Lack; 3] = [
            Lack::Feature(feature::ARC),
            Lack::Memory { used: 160, available: 64 },
            Lack::Flash { used: 4000, available: G2553.room_for(false), keeps: false },
        ];
        assert!(G2553.header_lacks(&header, 0).eq(all));
        header = Header { cells: 255, stack: 16, calls: 16, ..Header::default() };
        assert_eq!(F5529.header_lacks(&header, 0).next(), None);
        header.calls = 18;
        assert_eq!(
            F5529.header_lacks(&header, 0).next(),
            Some(Lack::Memory { used: 1156, available: 1152 })
        );
        let small = Part { features: u16::MAX, ..G2553 };
        let features = feature::EVENTS as u8;
        header = Header { features, cells: 4, stack: 3, calls: 0, ..header };
        assert_eq!(small.header_lacks(&header, 2).next(), None);
        assert_eq!(
            small.header_lacks(&header, 3).next(),
            Some(Lack::Memory { used: 70, available: 64 })
        );
        assert_eq!(F5529.header_lacks(&header, 4).next(), None);
        assert_eq!(Part::named("g2553"), Some(G2553));
        assert_eq!(Part::named("g2452"), None);
    }

    #[cfg(feature = "compiler")]
    #[test]
    fn the_small_chip_names_the_signals_that_it_cannot_make() {
        use super::Signals;
        use crate::profile::Profile;
        use crate::record::MachineRecord;
        let mut profile = Profile::built_in("mill").expect("built in");
        let lacks = |part: &Part, profile: &Profile| -> Vec<String> {
            let machine = MachineRecord::of(profile).to_bytes();
            let lacks = part.signal_lacks(Signals::from(profile), &machine);
            lacks.map(|lack| lack.to_string()).collect()
        };
        assert_eq!(lacks(&G2553, &profile), [""; 0]);
        profile.step_invert = true;
        profile.dir_setup_us = 250;
        // Slow axes have the time between two steps.
        profile.x.as_mut().expect("it has X").start_rate = 2_500;
        let told = lacks(&G2553, &profile);
        assert_eq!(told.len(), 2, "{told:?}");
        assert!(told[0].contains("step_invert"), "{told:?}");
        assert!(told[1].contains("250 us") && told[1].contains("dir_setup_us"), "{told:?}");
        assert_eq!(lacks(&F5529, &profile), [""; 0]);
        profile.step_invert = false;
        assert_eq!(lacks(&G2553, &profile).len(), 1, "the set-up alone");
    }
}
