//! `pasapas torture`: faults of every kind, injected by the thousand, and what came of each.
//!
//! Each kind has a file. It tries a number of cases, each made from the seed and the case's number
//! alone, so that a loss is repeated by `--seed S --from N --count 1`. A case survives when
//! everything holds that the device or the tool promises under that fault; else it is lost.

pub mod compare;
#[cfg(feature = "gateway")]
pub mod gateway;
pub mod generate;
pub mod host;
pub mod images;
pub mod line;
pub mod people;
pub mod power;
pub mod programs;
pub mod registers;
pub mod stack;
pub mod stand;
pub mod table;
pub mod time;
pub mod times;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use emulator::Rng;
use serde::Serialize;

use crate::board::{Build, F5529};

/// How much to try.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// All kinds together within a minute of a development build.
    Short,
    /// A few minutes.
    Usual,
    /// Hours: the counts that the project promises.
    Long,
}

/// What to try.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// How much.
    pub length: Length,
    /// As many cases of each fault instead.
    pub count: Option<u64>,
    /// What the cases are made of.
    pub seed: u64,
    /// Number of the first case.
    pub from: u64,
    /// The boards that take part.
    pub builds: &'static [&'static Build],
}

impl Settings {
    /// Number of cases, by length.
    fn count(&self, short: u64, usual: u64, long: u64) -> u64 {
        self.count.unwrap_or(match self.length {
            Length::Short => short,
            Length::Usual => usual,
            Length::Long => long,
        })
    }

    /// Whether the firmware's machine on the desktop takes part: it is the F5529's.
    fn has_desk(&self) -> bool {
        self.builds.iter().any(|build| build.part == F5529.part)
    }

    /// The random numbers of case `n` of a fault.
    fn rng(&self, fault: &str, n: u64) -> Rng {
        // FNV-1a (Fowler, Noll, Vo) of the name keeps the faults' numbers apart.
        let name = fault.bytes().fold(0xCBF2_9CE4_8422_2325, |hash: u64, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3)
        });
        let mut rng = Rng::new(self.seed.wrapping_add(name) ^ n.wrapping_mul(0x9E37_79B9));
        rng.bits();
        rng
    }
}

/// What came of a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Everything held.
    Survived,
    /// The case says nothing: it was not made, or it hangs on an instant.
    Skipped,
    /// Something did not hold.
    Lost(String),
}

/// A line of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Kind.
    pub kind: &'static str,
    /// The board's part, `host` where none takes part.
    pub part: &'static str,
    /// What was done to it.
    pub fault: &'static str,
    /// How often.
    pub tried: u64,
    /// How often everything held.
    pub survived: u64,
    /// How often something did not.
    pub lost: u64,
    /// Seed of the cases.
    pub seed: u64,
    /// What it took, s.
    pub seconds: f64,
    /// Figures beside.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub note: String,
    /// The first losses: number of the case and what did not hold.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub losses: Vec<String>,
}

/// Takes each line of the table as it is had; the error ends the torture.
pub type Sink<'a> = &'a mut dyn FnMut(Row) -> Result<(), String>;

/// A kind of fault: its name and what injects it.
pub type Kind = (&'static str, fn(&Settings, Sink<'_>) -> Result<(), String>);

/// Every kind.
pub const KINDS: &[Kind] = &[
    ("programs", programs::run),
    ("images", images::run),
    ("people", people::run),
    ("power", power::run),
    ("line", line::run),
    ("registers", registers::run),
    ("time", time::run),
    ("times", times::run),
    ("stack", stack::run),
    ("host", host::run),
    #[cfg(feature = "gateway")]
    ("gateway", gateway::run),
];

/// In the table, the firmware's machine on the desktop.
const DESK: &str = "desk";

/// Kinds that are tried only where they are named: not all of what they ask for holds.
pub const NAMED: &[&str] = &["times"];

/// Losses that a row tells of.
const TOLD: usize = 20;

impl Row {
    /// An empty row of what concerns no board.
    fn new(kind: &'static str, fault: &'static str, settings: &Settings) -> Row {
        Row::of("host", kind, fault, settings)
    }

    /// An empty row of a board with this firmware.
    fn on(build: &Build, kind: &'static str, fault: &'static str, settings: &Settings) -> Row {
        Row::of(build.part.name, kind, fault, settings)
    }

    fn of(part: &'static str, kind: &'static str, fault: &'static str, settings: &Settings) -> Row {
        Row {
            kind,
            part,
            fault,
            tried: 0,
            survived: 0,
            lost: 0,
            seed: settings.seed,
            seconds: 0.0,
            note: String::new(),
            losses: Vec::new(),
        }
    }

    /// Counts a case.
    fn count(&mut self, n: u64, verdict: Verdict) {
        match verdict {
            Verdict::Skipped => return,
            Verdict::Survived => self.survived += 1,
            Verdict::Lost(text) => {
                self.lost += 1;
                if self.losses.len() < TOLD {
                    self.losses.push(format!("case {n}: {text}"));
                }
            }
        }
        self.tried += 1;
    }

    /// Runs cases `settings.from..` on all processors. A case that panics is lost.
    fn run(&mut self, settings: &Settings, count: u64, case: impl Fn(u64) -> Verdict + Sync) {
        let begun = Instant::now();
        let next = AtomicU64::new(settings.from);
        let end = settings.from.saturating_add(count);
        let row = Mutex::new(self);
        let workers = std::thread::available_parallelism().map_or(1, usize::from);
        let work = || {
            loop {
                let n = next.fetch_add(1, Ordering::Relaxed);
                if n >= end {
                    return;
                }
                let verdict = catch_unwind(AssertUnwindSafe(|| case(n)))
                    .unwrap_or_else(|_| Verdict::Lost("panicked".to_owned()));
                row.lock().unwrap_or_else(std::sync::PoisonError::into_inner).count(n, verdict);
            }
        };
        std::thread::scope(|scope| {
            for _ in 0..workers {
                scope.spawn(work);
            }
        });
        let row = row.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        row.seconds += begun.elapsed().as_secs_f64();
    }
}
