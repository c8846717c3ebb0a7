//! What the gateway knows of a board beyond the board's registers: its name and tags, and the
//! names of its program's variables, which the uploading tool stores here.
//!
//! Transfer is by the standard Modbus functions 20 and 21 (V1.1b3, 6.14
//! and 6.15): the gateway's own unit has a file for each board, numbered as the board's unit. A file
//! is JSON; its first record is its length in bytes.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use lang::back::Sidecar;
use lang::hir::{self, Storage};
use lang::kind::Kind;
use lang::wire::{self, Exception};
use serde::{Deserialize, Serialize};

use crate::output;

/// Bytes of a file: records are numbered to 9999, two bytes each, and the first is the length.
pub const MOST_BYTES: usize = 2 * 9_999;
/// Variables of a program: more cells and KEEP values than any board has.
const MOST_VARIABLES: usize = 512;
/// Function of reading records.
pub const READ_FILE: u8 = 20;
/// Function of writing records.
pub const WRITE_FILE: u8 = 21;
/// The only kind of reference that there is.
const REFERENCE: u8 = 6;

/// Where lines of a script begin in its code.
pub fn lines(sidecar: &Sidecar) -> Vec<(u16, u16)> {
    let mut lines: Vec<(u16, u16)> = Vec::new();
    for mark in &sidecar.marks {
        let (Ok(pc), Ok(line)) = (u16::try_from(mark.pc), u16::try_from(mark.line)) else { break };
        if lines.last().is_none_or(|(_, last)| *last != line) {
            lines.push((pc, line));
        }
    }
    lines
}

/// A variable of a script that the link sees.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variable {
    /// As the script writes it.
    pub name: String,
    /// First of its registers; a value takes two, low word first.
    pub register: u16,
    /// Values: 1, or those of an array.
    pub count: u16,
    /// An array, also one of a single value.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub array: bool,
    /// What it is a quantity of, as the language names kinds.
    pub kind: String,
    /// It outlives power.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub keep: bool,
}

/// What is known of the program on a board.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Program {
    /// Its CRC: of another program nothing is known.
    pub crc: u16,
    /// The script's name, without its folder.
    pub script: String,
    /// Name of the machine that it was made for.
    pub profile: String,
    /// What the link sees of its variables.
    pub variables: Vec<Variable>,
    /// Where lines of the script begin in its code: offset and line, in ascending order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lines: Vec<(u16, u16)>,
}

/// What is known of a board.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Known {
    /// Its name in the gateway's file.
    pub board: String,
    /// Its unit.
    pub unit: u8,
    /// Its tags.
    pub tags: Vec<String>,
    /// Its program, when somebody told of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub program: Option<Program>,
}

/// Variables of a checked script that have a register.
pub fn variables(program: &hir::Program) -> Vec<Variable> {
    let shown = |var: &hir::Var| {
        let (register, keep) = match var.storage {
            Storage::At(register) => (register, false),
            Storage::Keep(number) => (wire::KEEPS + 2 * u16::from(number), true),
            Storage::Global | Storage::Local(_) => return None,
        };
        let (name, kind) = (var.name.clone(), var.kind.name().to_owned());
        Some(Variable { name, register, count: var.len as u16, array: var.array, kind, keep })
    };
    program.vars.iter().filter_map(shown).collect()
}

impl Variable {
    /// Each of its values: name and first register.
    pub fn values(&self) -> impl Iterator<Item = (String, u16)> + '_ {
        (0..self.count).map(|i| {
            let name = if self.array { format!("{}[{i}]", self.name) } else { self.name.clone() };
            (name, self.register.saturating_add(2 * i))
        })
    }

    /// What one unit of a value is, and by what the value is to be multiplied for it.
    pub fn unit(&self) -> (&'static str, f64) {
        match Kind::from_name(&self.kind) {
            Some(Kind::Length) => ("mm", 0.001),
            Some(Kind::Speed) => ("mm/s", 0.001),
            Some(Kind::Accel) => ("mm/s2", 0.001),
            Some(Kind::Time) => ("s", 0.001),
            Some(Kind::Angle) => ("deg", 0.001),
            Some(Kind::Steps) => ("steps", 1.0),
            Some(Kind::StepRate) => ("steps/s", 1.0),
            Some(Kind::StepAccel) => ("steps/s2", 1.0),
            Some(Kind::Voltage) => ("V", 0.001),
            Some(Kind::Number | Kind::Truth) | None => ("", 1.0),
        }
    }
}

impl Program {
    /// The text that is left with a gateway. One that is longer than a file goes without its lines.
    pub fn text(&self) -> Vec<u8> {
        let text = |program: &Program| serde_json::to_vec(program).unwrap_or_default();
        let whole = text(self);
        if whole.len() < MOST_BYTES {
            return whole;
        }
        text(&Program { lines: Vec::new(), ..self.clone() })
    }

    /// The line whose code holds an offset.
    pub fn line(&self, pc: u16) -> Option<u16> {
        let behind = self.lines.partition_point(|(first, _)| *first <= pc);
        self.lines.get(behind.checked_sub(1)?).map(|(_, line)| *line)
    }

    /// Reads what somebody left.
    fn parse(text: &[u8]) -> Option<Program> {
        let program: Program = serde_json::from_slice(text).ok()?;
        let good = |var: &Variable| {
            let plain = |c: char| c.is_alphanumeric() || c == '_' || c == '$';
            let values = usize::from(var.count);
            !var.name.is_empty()
                && var.name.chars().all(plain)
                && Kind::from_name(&var.kind).is_some()
                && (1..=MOST_VARIABLES).contains(&values)
                && usize::from(var.register) + 2 * values <= 0x1_0000
        };
        let values: usize = program.variables.iter().map(|var| usize::from(var.count)).sum();
        let good = values <= MOST_VARIABLES && program.variables.iter().all(good);
        (good && program.lines.is_sorted()).then_some(program)
    }
}

/// A request for records: file, first record, and how many or what they are to be.
#[derive(Debug, PartialEq, Eq)]
enum Records<'a> {
    Read { file: u16, first: u16, count: u16 },
    Write { file: u16, first: u16, data: &'a [u8] },
}

impl Records<'_> {
    /// Reads a request with one reference; more of them in a request nobody needs here.
    fn of(pdu: &[u8]) -> Result<Records<'_>, Exception> {
        let word = |at: usize| u16::from_be_bytes([pdu[at], pdu[at + 1]]);
        match *pdu {
            [READ_FILE, 7, REFERENCE, _, _, _, _, 0, count @ 1..=120] => {
                Ok(Records::Read { file: word(3), first: word(5), count: count.into() })
            }
            [WRITE_FILE, length, REFERENCE, _, _, _, _, 0, count @ 1..=120, ref data @ ..]
                if data.len() == 2 * usize::from(count)
                    && usize::from(length) == 7 + data.len() =>
            {
                Ok(Records::Write { file: word(3), first: word(5), data })
            }
            _ => Err(Exception::IllegalValue),
        }
    }
}

/// A request for records of a file.
pub fn read_request(file: u16, first: u16, count: u8) -> Vec<u8> {
    let ([high, low], [above, below]) = (file.to_be_bytes(), first.to_be_bytes());
    vec![READ_FILE, 7, REFERENCE, high, low, above, below, 0, count]
}

/// A request that writes records of a file: `data` is bytes of at most 120 of them.
pub fn write_request(file: u16, first: u16, data: &[u8]) -> Vec<u8> {
    let ([high, low], [above, below]) = (file.to_be_bytes(), first.to_be_bytes());
    let count = (data.len() / 2) as u8;
    let mut pdu = vec![WRITE_FILE, 7 + 2 * count, REFERENCE, high, low, above, below, 0, count];
    pdu.extend(data);
    pdu
}

/// The records of a text: its length, then itself.
pub fn records_of(text: &[u8]) -> Vec<u8> {
    let mut bytes = (text.len() as u16).to_be_bytes().to_vec();
    bytes.extend(text);
    bytes.resize(bytes.len().next_multiple_of(2), b' ');
    bytes
}

/// The text whose records these are, if all of it is there.
pub fn text_of(records: &[u8]) -> Option<&[u8]> {
    let (length, text) = records.split_first_chunk::<2>()?;
    text.get(..u16::from_be_bytes(*length).into())
}

/// What is known of every board, kept in a file if there is one for it.
pub struct Book {
    file: Option<PathBuf>,
    pages: Mutex<Vec<Page>>,
}

struct Page {
    known: Known,
    /// What the gateway's own file says of its program, which may be on the board though another one was
    /// told of.
    script: Option<Program>,
    /// Records that come.
    coming: Vec<u8>,
}

impl Book {
    /// Boards of which nothing is known but what the gateway's file says, and what `file` holds of
    /// before: one that cannot be read is as none.
    pub fn open(boards: Vec<Known>, file: Option<&Path>) -> Book {
        let before = file.map(programs_in).unwrap_or_default();
        let page = |mut known: Known| {
            let script = known.program.take();
            known.program = before.get(&known.board).cloned().or_else(|| script.clone());
            Page { known, script, coming: Vec::new() }
        };
        let pages = Mutex::new(boards.into_iter().map(page).collect());
        Book { file: file.map(Path::to_owned), pages }
    }

    fn pages(&self) -> MutexGuard<'_, Vec<Page>> {
        self.pages.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is known of a board, by its number in the file.
    pub fn known(&self, board: usize) -> Option<Known> {
        self.pages().get(board).map(|page| page.known.clone())
    }

    /// What is known of the program with this CRC that a board has, by the board's number in the file.
    pub fn program(&self, board: usize, crc: u16) -> Option<Program> {
        let pages = self.pages();
        let page = pages.get(board)?;
        let told = [&page.known.program, &page.script].into_iter().flatten();
        told.clone().find(|program| program.crc == crc).cloned()
    }

    /// The board whose file a request reads, or writes: true.
    ///
    /// # Errors
    /// The exception for a request that is none.
    pub fn file_of(pdu: &[u8]) -> Result<(u16, bool), Exception> {
        Ok(match Records::of(pdu)? {
            Records::Read { file, .. } => (file, false),
            Records::Write { file, .. } => (file, true),
        })
    }

    /// The reply to a request for a board's records.
    ///
    /// # Errors
    /// The exception: there are no such records, or what came is nothing that can be known.
    pub fn answer(&self, board: usize, pdu: &[u8]) -> Result<Vec<u8>, Exception> {
        match Records::of(pdu)? {
            Records::Read { first, count, .. } => {
                let known = self.known(board).ok_or(Exception::IllegalAddress)?;
                let text = serde_json::to_vec(&known).map_err(|_| Exception::DeviceFailure)?;
                let bytes = records_of(&text);
                let first = usize::from(first);
                let range = 2 * first..2 * (first + usize::from(count));
                let data = bytes.get(range).ok_or(Exception::IllegalAddress)?;
                let length = data.len() as u8;
                Ok([&[READ_FILE, length + 2, length + 1, REFERENCE], data].concat())
            }
            Records::Write { first, data, .. } => {
                self.write(board, 2 * usize::from(first), data)?;
                Ok(pdu.to_vec())
            }
        }
    }

    /// Records in ascending order; the last one has all of them understood.
    fn write(&self, board: usize, at: usize, data: &[u8]) -> Result<(), Exception> {
        let mut pages = self.pages();
        let page = pages.get_mut(board).ok_or(Exception::IllegalAddress)?;
        // The same may come again when its reply was lost.
        if at > page.coming.len() || at + data.len() > MOST_BYTES {
            return Err(Exception::IllegalAddress);
        }
        page.coming.truncate(at);
        page.coming.extend(data);
        let Some(text) = text_of(&page.coming) else { return Ok(()) };
        let program = Program::parse(text).ok_or(Exception::DeviceFailure)?;
        page.coming.clear();
        page.known.program = Some(program);
        drop(pages);
        self.save();
        Ok(())
    }

    /// Writes the file. A gateway whose disk is full goes on; what is told once more is written then.
    fn save(&self) {
        let Some(file) = &self.file else { return };
        let programs: HashMap<String, Program> = self
            .pages()
            .iter()
            .filter_map(|page| Some((page.known.board.clone(), page.known.program.clone()?)))
            .collect();
        let written = serde_json::to_vec_pretty(&programs)
            .map_err(std::io::Error::from)
            .and_then(|text| output::replace(file, &text));
        if let Err(error) = written {
            eprintln!("pasapas: {} cannot be written: {error}", file.display());
        }
    }
}

/// What a file of [`Book`] holds, by the boards' names.
pub fn programs_in(file: &Path) -> HashMap<String, Program> {
    let text = std::fs::read(file).unwrap_or_default();
    serde_json::from_slice(&text).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::{Book, Known, Program, Records, read_request, records_of, text_of, write_request};
    use lang::wire::Exception;

    fn book(file: Option<&std::path::Path>) -> Book {
        let board = |name: &str| Known { board: name.to_owned(), ..Known::default() };
        Book::open(vec![board("drill"), board("saw")], file)
    }

    const LEFT: &str = r#"{"crc":4660,"script":"a.bas","profile":"mill","variables":
        [{"name":"made","register":4000,"count":1,"kind":"Number","keep":true}],
        "lines":[[0,1],[5,3],[9,2]]}"#;

    #[test]
    fn the_standards_examples_of_records_are_read() {
        // V1.1b3, 6.14 (one of its two references) and 6.15.
        let read = [20, 7, 6, 0, 4, 0, 1, 0, 2];
        assert_eq!(Records::of(&read), Ok(Records::Read { file: 4, first: 1, count: 2 }));
        assert_eq!(read_request(4, 1, 2), read);
        let write = [21, 13, 6, 0, 4, 0, 7, 0, 3, 6, 0xAF, 4, 0xBE, 0x10, 0x0D];
        let data = &write[9..];
        assert_eq!(Records::of(&write), Ok(Records::Write { file: 4, first: 7, data }));
        assert_eq!(write_request(4, 7, data), write);
        for end in 0..write.len() {
            assert_eq!(Records::of(&write[..end]), Err(Exception::IllegalValue));
        }
    }

    #[test]
    fn what_is_left_is_known_after_a_restart_and_damage_is_not_taken() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("names.json");
        let book_a = book(Some(&file));
        for (n, part) in records_of(LEFT.as_bytes()).chunks(40).enumerate() {
            let request = write_request(1, 20 * n as u16, part);
            assert_eq!(book_a.answer(1, &request), Ok(request.clone()));
            // Its reply was lost.
            if n == 1 {
                assert_eq!(book_a.answer(1, &request), Ok(request.clone()));
            }
        }
        let known = book(Some(&file)).known(1).and_then(|known| known.program).expect("known");
        assert_eq!((known.crc, &known.variables[0].name[..]), (0x1234, "made"));
        assert_eq!([0, 4, 5, 8, 9, 900].map(|pc| known.line(pc)), [1, 1, 3, 3, 2, 2].map(Some));
        assert!(book(Some(&file)).known(0).expect("a board").program.is_none());
        for wrong in ["{}", "", &LEFT.replace("made", "a b"), &LEFT.replace("Number", "Colour")] {
            let request = records_of(wrong.as_bytes());
            let request = write_request(1, 0, &request[..request.len().min(240)]);
            assert_eq!(book_a.answer(0, &request), Err(Exception::DeviceFailure), "{wrong}");
        }
        let apart = write_request(1, 900, b"ab");
        assert_eq!(book_a.answer(0, &apart), Err(Exception::IllegalAddress));
        assert!(
            Program::parse(LEFT.replace("\"count\":1", "\"count\":60000").as_bytes()).is_none()
        );
    }

    #[test]
    fn a_reader_gets_the_text_by_its_length() {
        let book = book(None);
        let mut records = Vec::new();
        for first in 0.. {
            match book.answer(0, &read_request(1, first, 1)) {
                Ok(reply) => records.extend(&reply[4..]),
                Err(error) => {
                    assert_eq!(error, Exception::IllegalAddress);
                    break;
                }
            }
        }
        // Beyond all that a file could have.
        for first in [u16::MAX - 1, u16::MAX] {
            let reply = book.answer(0, &read_request(1, first, 120));
            assert_eq!(reply, Err(Exception::IllegalAddress), "{first}");
        }
        let text = text_of(&records).expect("whole");
        let known: Known = serde_json::from_slice(text).expect("JSON");
        assert_eq!(known.board, "drill");
    }
}
