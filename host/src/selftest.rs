//! What the emulator promises, measured on a board: for the first owner of a chip and for every builder
//! after. Each check is a line: what is expected, what was found.
//!
//! The link's clock is the measure: the computer's, or the emulated time of a board in this process. What no
//! register shows (edges at the pins, pulse widths) a logic analyser must: firmware/README.md says which.

mod capture;
mod clock;
mod contacts;
mod hands;
mod line;
mod motion;
#[cfg(test)]
mod pins_tests;
mod store;
#[cfg(test)]
mod tests;

use std::fmt;
use std::time::Duration;

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::part::{PARTS, Part};
use lang::record::{BoardRecord, feature};
use serde::Serialize;

use crate::client::identity::Identity;
use crate::client::{Client, ClientError};
use crate::link::Link;

/// What may be done to the board.
#[derive(Clone, Copy, Debug, Default)]
pub struct Plan {
    /// Motors, and what the outputs switch, are unplugged: STEP pulses and outputs harm nothing.
    pub unplugged: bool,
    /// Each output has a wire to the input of its number.
    pub jumpers: bool,
    /// Somebody wires pins of the board to those of its timer when the test asks for it.
    pub captures: bool,
    /// Somebody is there to press Start, Stop and RST.
    pub hands: bool,
    /// The stored program may be given up.
    pub replace: bool,
    /// The port has bits a second.
    pub rates: bool,
    /// How long the board's milliseconds are held against the clock.
    pub listen: Duration,
}

/// What a person is asked for.
#[derive(Clone, Copy, Debug)]
pub enum Ask<'a> {
    /// To press something; the test looks whether it was.
    Press(&'a str),
    /// To wire pins, in place of what was wired before; the test goes on when that is done.
    Wire(&'a str),
}

/// How a check went.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase", tag = "result", content = "why")]
pub enum Verdict {
    /// As expected.
    Good,
    /// Otherwise.
    Bad,
    /// It was left out; why.
    Left(String),
}

/// A line of the report.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Row {
    /// What was checked.
    pub check: String,
    /// What should be found.
    pub expected: String,
    /// What was.
    pub found: String,
    /// How it went.
    #[serde(flatten)]
    pub verdict: Verdict,
}

/// All of them.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The firmware's part, as far as its features tell; of those with all features `f5529`.
    pub part: &'static str,
    /// Hardware revision of the chip, 0 of one that does not tell it.
    pub revision: u16,
    /// What the board says of itself.
    pub board: Identity,
    /// The checks in their order.
    pub rows: Vec<Row>,
    /// How many found something else than expected.
    pub bad: usize,
    /// How many were left out.
    pub left: usize,
}

/// Why nothing was measured, or the measuring ended.
#[derive(Debug)]
pub enum Trouble {
    /// The board does not answer, or refuses.
    Board(ClientError),
    /// In words.
    Words(String),
}

impl From<ClientError> for Trouble {
    fn from(error: ClientError) -> Trouble {
        Trouble::Board(error)
    }
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Trouble::Board(error) => error.fmt(f),
            Trouble::Words(text) => f.write_str(text),
        }
    }
}

/// A board under test.
struct Bench<'a, L> {
    board: &'a mut Client<L>,
    plan: Plan,
    part: &'static Part,
    /// What it has at the beginning, and gets back.
    own: BoardRecord,
    /// What holds now.
    record: BoardRecord,
    rows: Vec<Row>,
    tell: &'a mut dyn FnMut(&Row),
    ask: &'a mut dyn FnMut(Ask<'_>),
}

/// Measures a board. `tell` hears each line as it comes, `ask` what a person is to do.
///
/// # Errors
/// Its firmware is not this tool's, it is locked, it holds a program that the plan does not give up, or it fell
/// silent; what it had is put back as far as it answers.
pub fn run<L: Link>(
    board: &mut Client<L>,
    plan: Plan,
    tell: &mut dyn FnMut(&Row),
    ask: &mut dyn FnMut(Ask<'_>),
) -> Result<Report, Trouble> {
    let identity = board.identity()?;
    identity.check().map_err(Trouble::Words)?;
    if identity.program_bytes > 0 && !plan.replace {
        return Err(Trouble::Words(
            "the board holds a program, which the test would erase: --replace gives it up"
                .to_owned(),
        ));
    }
    let own = board.board_record()?;
    let revision = board.chip_revision()?;
    let part = identity.part();
    // Contacts of a machine would act on the test.
    let chained = own.flags & BoardRecord::CHAIN;
    let record = BoardRecord {
        sequence: own.sequence,
        flags: BoardRecord::DEFAULT.flags & !BoardRecord::CHAIN
            | chained
            | own.flags & BoardRecord::STEP_LOW,
        address: own.address,
        rate: own.rate,
        pulse: own.pulse,
        setup: own.setup,
        reference: if chained != 0 { BoardRecord::DEFAULT.reference } else { [1, 2, 3] },
        probe: if chained != 0 { BoardRecord::DEFAULT.probe } else { 4 },
        ..BoardRecord::DEFAULT
    };
    let mut bench = Bench { board, plan, part, own, record, rows: Vec::new(), tell, ask };
    let measured = bench.measure(&identity);
    let put_back = bench.put_back();
    let rows = bench.rows;
    measured.and(put_back)?;
    let count =
        |wanted: fn(&Verdict) -> bool| rows.iter().filter(|row| wanted(&row.verdict)).count();
    let bad = count(|verdict| *verdict == Verdict::Bad);
    let left = count(|verdict| matches!(verdict, Verdict::Left(_)));
    Ok(Report { part: part.name, revision, board: identity, rows, bad, left })
}

impl<L: Link> Bench<'_, L> {
    fn measure(&mut self, identity: &Identity) -> Result<(), Trouble> {
        self.firmware(identity);
        self.set_record(self.record)?;
        self.after_reset()?;
        self.store()?;
        self.erase_under_requests()?;
        self.clock()?;
        self.contacts()?;
        self.motion()?;
        self.captures()?;
        self.long_requests()?;
        self.rates()?;
        self.hands()?;
        self.health()
    }

    /// Profile and program as they were, or none.
    fn put_back(&mut self) -> Result<(), Trouble> {
        let sequence = self.board.board_record()?.sequence;
        let own = BoardRecord { sequence, ..self.own };
        self.set_record(own)?;
        self.board.erase().map_err(|error| Trouble::Words(error.to_string()))
    }

    fn push(
        &mut self,
        check: impl Into<String>,
        expected: String,
        found: String,
        verdict: Verdict,
    ) {
        let row = Row { check: check.into(), expected, found, verdict };
        (self.tell)(&row);
        self.rows.push(row);
    }

    /// A check that was done.
    fn row(
        &mut self,
        check: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
        good: bool,
    ) {
        let verdict = if good { Verdict::Good } else { Verdict::Bad };
        self.push(check, expected.into(), found.into(), verdict);
    }

    /// A check that was not done, and why.
    fn left_out(&mut self, check: &str, why: &str) {
        self.push(check, String::new(), String::new(), Verdict::Left(why.to_owned()));
    }

    fn firmware(&mut self, identity: &Identity) {
        let known = PARTS.iter().any(|part| part.features == identity.features);
        let names: Vec<&str> = PARTS.iter().map(|part| part.name).collect();
        let found =
            if known { self.part.name.to_owned() } else { format!("{:04X}", identity.features) };
        self.row("firmware's features", format!("one of {}", names.join(", ")), found, known);
    }

    /// Gives the board another record, and resets it.
    fn set_record(&mut self, record: BoardRecord) -> Result<(), Trouble> {
        let sequence = self.record.sequence.wrapping_add(1);
        let pins = record.emergency.iter().fold(0, |pins, n| pins | record.pin(*n));
        let record = BoardRecord {
            sequence,
            emergency_pin: pins,
            emergency_falls: pins & record.falling(),
            ..record
        };
        self.record = record.sealed();
        self.board.set_board_record(&self.record)?;
        self.board.restart()?;
        self.board.set_address(self.record.address);
        Ok(self.board.find()?)
    }

    /// Compiles a script and makes it the stored program.
    fn program(&mut self, text: &str) -> Result<Vec<u8>, Trouble> {
        let source = Source::new("selftest", text.to_owned());
        let (program, diags) = compile(&source, ProfileChoice::built_in());
        let program = program.ok_or_else(|| Trouble::Words(diags.render(&source)))?;
        let compiled = lang::back::compile(&program)
            .map_err(|excesses| Trouble::Words(format!("{excesses:?}")))?;
        let uploaded = self.board.bring(&compiled.image, (None, "selftest"), true, &mut |_| {});
        uploaded.map_err(|error| Trouble::Words(error.to_string()))?;
        Ok(compiled.image)
    }

    /// Whether it is an MSP430F5529, which has a crystal's clock, by its part.
    fn has_crystal(&self) -> bool {
        !self.part.lacks_feature(feature::STREAM)
    }
}
