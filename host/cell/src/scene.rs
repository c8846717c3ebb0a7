//! What stands in a cell, as the file says it: millimetres of the machine's frame, Z up.

pub use super::form::{Block, Form, V3};
use super::value::Entry;

/// A tool's kind with what belongs to it.
#[derive(Clone, Debug, PartialEq)]
pub enum ToolKind {
    /// A nozzle with its pressure.
    Vacuum(Vacuum),
    /// Two jaws.
    Gripper(Gripper),
    /// A drill or cutter.
    Drill {
        /// mm.
        diameter: f64,
        /// Length that cuts, mm.
        flute: Option<f64>,
        /// Time until it turns, us.
        spin_us: u64,
        /// Fastest plunge, mm/s.
        plunge_mm_s: Option<f64>,
    },
    /// What lays something along its way: dispenser, laser or pen.
    Flow {
        /// mg in a second.
        flow_mg_s: f64,
        /// Delay of the valve when it opens, us.
        open_us: u64,
        /// The same when it closes, us.
        close_us: u64,
        /// Greatest height above the surface, mm.
        reach: f64,
        /// In the picture, mm.
        width: f64,
    },
    /// A touch probe.
    Probe {
        /// Its contact; without it the input with that role.
        input: Option<u32>,
        /// Of its ball, mm.
        diameter: f64,
        /// From touch to signal, us.
        delay_us: u64,
    },
    /// A body alone.
    None,
}

/// A vacuum nozzle: a pressure in time.
#[derive(Clone, Debug, PartialEq)]
pub struct Vacuum {
    /// Pressures below ambient, kPa: toward which a sealed and an open nozzle go, and the least that holds a part.
    pub sealed_kpa: f64,
    /// See `sealed_kpa`.
    pub open_kpa: f64,
    /// See `sealed_kpa`.
    pub hold_kpa: f64,
    /// Time constants of build-up and venting, us.
    pub build_us: f64,
    /// See `build_us`.
    pub vent_us: f64,
    /// Loss with a part, kPa/s.
    pub leak_kpa_s: f64,
    /// Sideways, above and below the part's top, mm.
    pub reach: f64,
    /// See `reach`.
    pub gap: f64,
    /// See `reach`.
    pub press: f64,
    /// Greatest force that it holds, N.
    pub hold_n: Option<f64>,
    /// The pressure switch.
    pub input: Option<u32>,
    /// Where it closes and opens, kPa.
    pub on_kpa: f64,
    /// See `on_kpa`.
    pub off_kpa: f64,
    /// The pressure sensor.
    pub analog: Option<u32>,
    /// Its volts at the pressures of `kpa`.
    pub volts: [f64; 2],
    /// See `volts`.
    pub kpa: [f64; 2],
}

/// Two jaws.
#[derive(Clone, Debug, PartialEq)]
pub struct Gripper {
    /// Width of the open jaws, mm.
    pub opens: f64,
    /// Widths that it can hold, mm.
    pub grips: [f64; 2],
    /// Whether it closes along X, else along Y.
    pub along_x: bool,
    /// Times to open and to close, us.
    pub open_us: u64,
    /// See `open_us`.
    pub close_us: u64,
    /// On while the jaws have met.
    pub input_closed: Option<u32>,
    /// On while a part is held.
    pub input_gripped: Option<u32>,
}

/// A tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// Its name; its kind's where it has none.
    pub name: String,
    /// Its kind.
    pub kind: ToolKind,
    /// The word of its kind.
    pub word: String,
    /// Number of its `T` word; 0 is always there.
    pub number: u32,
    /// From the head, mm.
    pub tip: V3,
    /// Its body, from the tip.
    pub body: Vec<Block>,
    /// What switches it.
    pub output: Option<u32>,
    /// The axis that turns it.
    pub turn: Option<char>,
}

/// A part, or a kind of part.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// Its form.
    pub form: Form,
    /// Where it stands; `None`: a kind for feeders.
    pub at: Option<V3>,
    /// g.
    pub mass_g: f64,
    /// `#rrggbb`.
    pub colour: String,
    /// Whether an inductive sensor sees it.
    pub metal: bool,
}

/// A feeder.
#[derive(Clone, Debug, PartialEq)]
pub struct Feeder {
    /// Its name.
    pub name: String,
    /// `tray`, `tape`, `tube`, `bowl` or `list`.
    pub kind: String,
    /// Index of its part.
    pub part: usize,
    /// Its pockets, mm, and how the part lies there, degrees; one for tape, tube and bowl.
    pub pockets: Vec<(V3, f64)>,
    /// Pockets without a part, from 0.
    pub empty: Vec<usize>,
    /// What advances it.
    pub output: Option<u32>,
    /// Time of an advance, us.
    pub advance_us: u64,
    /// On while a part is ready.
    pub input: Option<u32>,
    /// Parts in it; `None`: endless.
    pub length: Option<u32>,
    /// A bowl's spread, mm and degrees.
    pub spread: [f64; 2],
}

impl Feeder {
    /// Whether it brings one part after the other to one place.
    #[must_use]
    pub fn advances(&self) -> bool {
        matches!(self.kind.as_str(), "tape" | "tube" | "bowl")
    }
}

/// A place for parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Its name.
    pub name: String,
    /// Where it is.
    pub block: Block,
    /// Middle of its bottom.
    pub at: V3,
    /// Parts that it takes; 0: any number.
    pub room: u32,
    /// Whether what lies here was rejected on purpose.
    pub reject: bool,
}

/// A fixture.
#[derive(Clone, Debug, PartialEq)]
pub struct Fixture {
    /// Its name.
    pub name: String,
    /// Its form.
    pub form: Form,
    /// Middle of its bottom.
    pub at: V3,
    /// Boxes that it is tested as when turned or round.
    pub slices: u32,
    /// Whether running into it is a collision.
    pub solid: bool,
    /// A door or clamp: the output that opens it, where it stands then, and the time that this takes, us.
    pub door: Option<(u32, V3, u64)>,
}

/// What is machined.
#[derive(Clone, Debug, PartialEq)]
pub struct Stock {
    /// Middle of its bottom.
    pub at: V3,
    /// mm.
    pub size: V3,
    /// Of the picture, mm.
    pub grid: f64,
    /// Slope of its top.
    pub tilt: [f64; 2],
    /// A file of heights instead.
    pub heights: Option<String>,
    /// On while something touches it.
    pub touch: Option<u32>,
}

/// What moves a conveyor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// It always runs.
    Always,
    /// While this output is on.
    Output(u32),
    /// With this axis.
    Axis(char),
}

/// A conveyor.
#[derive(Clone, Debug, PartialEq)]
pub struct Conveyor {
    /// Its name.
    pub name: String,
    /// Where it is.
    pub block: Block,
    /// Direction in X and Y.
    pub along: [f64; 2],
    /// What moves it.
    pub drive: Drive,
    /// mm/s.
    pub mm_s: f64,
    /// Time to that speed, us.
    pub ramp_us: u64,
    /// Its encoder and the counts in a mm.
    pub counter: Option<(u32, f64)>,
    /// The part that comes onto it, with the mm or us between two.
    pub feeds: Option<(usize, Gap)>,
    /// Name of the place after its end.
    pub takes: Option<String>,
}

/// How far parts are from each other on a conveyor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gap {
    /// us of running.
    Time(u64),
    /// mm.
    Way(f64),
}

/// What a sensor is.
#[derive(Clone, Debug, PartialEq)]
pub enum Eye {
    /// A light barrier between two places.
    Beam(V3, V3),
    /// A box in which something is.
    Box(Block),
    /// A switch of an axis: axis, place, side.
    Switch(char, f64, i8),
    /// A distance along a line, as a voltage.
    Distance(V3, V3, [f64; 2]),
    /// A colour at a place.
    Colour(V3, String),
}

/// A sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// Its name.
    pub name: String,
    /// What it is.
    pub eye: Eye,
    /// What it drives.
    pub input: Option<u32>,
    /// What a distance drives.
    pub analog: Option<u32>,
    /// Whether it sees parts, tools, held parts.
    pub sees: [bool; 3],
    /// Delays, us.
    pub on_us: u64,
    /// See `on_us`.
    pub off_us: u64,
    /// It bounces so long, us.
    pub bounce_us: u64,
    /// On while it sees nothing.
    pub invert: bool,
}

/// When a person acts.
#[derive(Clone, Debug, PartialEq)]
pub enum When {
    /// At this time, us.
    At(u64),
    /// When the script waits for Start.
    WaitStart,
    /// When a place is full.
    Full(String),
    /// When a text is printed.
    Print(String),
}

/// A person.
#[derive(Clone, Debug, PartialEq)]
pub struct Person {
    /// A name.
    pub name: String,
    /// `start`, `stop`, `estop`, `input`, `take`, `put` or `at`.
    pub does: String,
    /// When.
    pub when: When,
    /// So long after it, us.
    pub after_us: u64,
    /// A button is held so long, us.
    pub hold_us: u64,
    /// `input`: which.
    pub input: Option<u32>,
    /// `take`, `put`: what.
    pub thing: Option<String>,
    /// `at`: the register.
    pub register: Option<u32>,
    /// `at`, `input`: the value.
    pub value: i32,
    /// How often.
    pub times: u32,
}

/// An expectation; its keys are read by what it is about.
#[derive(Clone, Debug)]
pub struct Expect {
    /// What is expected.
    pub what: String,
    /// In the report.
    pub name: String,
    /// The table of the file.
    pub entry: Entry,
}

/// A variation.
#[derive(Clone, Debug, PartialEq)]
pub enum Vary {
    /// A number varies.
    Number {
        /// `nozzle.build_ms`.
        key: String,
        /// How.
        spread: Spread,
        /// Every thing of a feeder by itself.
        each: bool,
    },
    /// Something happens.
    Fault {
        /// One of the table's words.
        fault: String,
        /// What it strikes.
        of: Option<String>,
        /// 0 to 1.
        chance: f64,
        /// us.
        up_to_us: Option<u64>,
        /// Steps lost.
        steps: Option<i32>,
        /// Drawn from this time, us.
        within_us: Option<u64>,
    },
}

/// How a number varies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    /// Standard deviation in the key's unit.
    Sigma(f64),
    /// Least and greatest difference.
    Range(f64, f64),
    /// Standard deviation as a part of the value.
    Share(f64),
}

/// All of a cell.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// A title.
    pub name: Option<String>,
    /// The machine, when the script names none.
    pub profile: Option<String>,
    /// Where the head stands at power-up: X, Y, Z, A.
    pub start: Option<[f64; 4]>,
    /// Height of the table, mm.
    pub table: Option<f64>,
    /// Outcome classes that end a run.
    pub stop_on: Vec<String>,
    /// Tools.
    pub tools: Vec<Tool>,
    /// Parts.
    pub parts: Vec<Part>,
    /// Feeders.
    pub feeders: Vec<Feeder>,
    /// Places.
    pub places: Vec<Place>,
    /// Fixtures.
    pub fixtures: Vec<Fixture>,
    /// What is machined.
    pub stock: Option<Stock>,
    /// Conveyors.
    pub conveyors: Vec<Conveyor>,
    /// Sensors.
    pub sensors: Vec<Sensor>,
    /// People.
    pub persons: Vec<Person>,
    /// Expectations.
    pub expects: Vec<Expect>,
    /// Variations.
    pub varies: Vec<Vary>,
}
