//! The library of programs that a board holds (lang's `wire` module, Library).

use std::fmt;

use lang::called;
use lang::part::NAME;
use lang::record::feature;
use lang::wire::{self, LIBRARY_ENTRY, LIBRARY_NAME};
use serde::Serialize;

use super::{Client, ClientError};
use crate::link::Link;

/// Programs of which one request reads.
const AT_ONCE: usize = 7;

/// A program of the library.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Entry {
    /// Its number, 1 to 64.
    pub number: u8,
    /// Its name, empty for none.
    pub name: String,
    /// Bytes of its image.
    pub bytes: u16,
    /// CRC of its image.
    #[serde(skip)]
    pub crc: u16,
    /// KEEP values.
    pub keeps: u16,
}

/// What a board holds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Library {
    /// By number.
    pub entries: Vec<Entry>,
    /// Number of the program that Start runs, 0 for none.
    pub selected: u8,
}

/// A program as people call it: by its number, or by its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Called {
    /// 1 to 64.
    Number(u8),
    /// Up to 16 characters.
    Name(String),
}

impl fmt::Display for Called {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Called::Number(number) => write!(f, "number {number}"),
            Called::Name(name) => write!(f, "`{name}`"),
        }
    }
}

impl std::str::FromStr for Called {
    type Err = String;

    fn from_str(text: &str) -> Result<Called, String> {
        let programs = lang::part::F5529.programs;
        if let Ok(number) = text.parse::<u32>() {
            return match u8::try_from(number) {
                Ok(number @ 1..) if number <= programs => Ok(Called::Number(number)),
                _ => Err(format!("programs have the numbers 1 to {programs}")),
            };
        }
        called::check(text).map(|()| Called::Name(text.to_owned()))
    }
}

/// The name that a file's program gets: of its name what fits.
pub fn name_of(path: &str) -> String {
    let stem = std::path::Path::new(path).file_stem().unwrap_or_default().to_string_lossy();
    let plain = |c: char| if c.is_ascii_graphic() && c != '"' { c } else { '_' };
    let mut name: String = stem.chars().map(plain).take(NAME).collect();
    // A number alone would be taken for the program's number.
    if name.parse::<u32>().is_ok() {
        name.insert(0, '_');
        name.truncate(NAME);
    }
    if name.is_empty() { "program".to_owned() } else { name }
}

/// A name as registers hold it.
pub fn words_of(name: &str) -> Vec<u16> {
    let mut bytes = name.as_bytes().to_vec();
    bytes.resize(NAME, 0);
    bytes.as_chunks().0.iter().map(|pair| u16::from_be_bytes(*pair)).collect()
}

fn name_in(words: &[u16]) -> String {
    let bytes = words.iter().flat_map(|word| word.to_be_bytes());
    let text: Vec<u8> = bytes.take_while(|byte| *byte != 0 && *byte != 0xFF).collect();
    String::from_utf8_lossy(&text).into_owned()
}

impl Library {
    /// The program that is called so.
    pub fn find(&self, called: &Called) -> Option<&Entry> {
        self.entries.iter().find(|entry| match called {
            Called::Number(number) => entry.number == *number,
            Called::Name(name) => called::same(&entry.name, name),
        })
    }

    /// The lowest number that is free.
    pub fn free(&self) -> Option<u8> {
        let taken = |number: &u8| self.entries.iter().any(|entry| entry.number == *number);
        (1..=lang::part::F5529.programs).find(|number| !taken(number))
    }

    /// Number and name of the program that an upload brings.
    ///
    /// # Errors
    /// The library is full.
    pub fn place(&self, called: &Called, file: &str) -> Result<(u8, String), String> {
        if let Some(there) = self.find(called) {
            let name = match called {
                Called::Number(_) if there.name.is_empty() => name_of(file),
                _ => there.name.clone(),
            };
            return Ok((there.number, name));
        }
        match called {
            Called::Number(number) => Ok((*number, name_of(file))),
            Called::Name(name) => match self.free() {
                Some(number) => Ok((number, name.clone())),
                None => Err(format!(
                    "the library is full: {} programs; `pasapas erase NAME` makes room",
                    self.entries.len()
                )),
            },
        }
    }

    /// What there is, for who asked for something else.
    pub fn names(&self) -> String {
        let name = |entry: &Entry| match entry.name.as_str() {
            "" => entry.number.to_string(),
            name => format!("{} {name}", entry.number),
        };
        match self.entries.as_slice() {
            [] => "it holds none".to_owned(),
            entries => {
                format!("it holds {}", entries.iter().map(name).collect::<Vec<_>>().join(", "))
            }
        }
    }
}

impl<L: Link> Client<L> {
    /// What the board holds; `None`: one program without a name.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn library(&mut self) -> Result<Option<Library>, ClientError> {
        let features = self.holding(wire::FEATURES, 1)?[0];
        if features & feature::LIBRARY == 0 {
            return Ok(None);
        }
        let selected = self.holding(wire::SELECTED, 1)?[0] as u8;
        let mut entries = Vec::new();
        let numbers: Vec<u8> = (1..=lang::part::F5529.programs).collect();
        for numbers in numbers.chunks(AT_ONCE) {
            let first = wire::LIBRARY + u16::from(numbers[0] - 1) * LIBRARY_ENTRY;
            let words = self.holding(first, numbers.len() as u16 * LIBRARY_ENTRY)?;
            for (&number, words) in numbers.iter().zip(words.chunks(usize::from(LIBRARY_ENTRY))) {
                if words[0] != 0 {
                    let name = name_in(&words[usize::from(LIBRARY_NAME)..]);
                    let [bytes, crc, keeps] = [words[0], words[1], words[2]];
                    entries.push(Entry { number, name, bytes, crc, keeps });
                }
            }
        }
        Ok(Some(Library { entries, selected }))
    }

    /// What the program of a number is called, nothing for one without a name or that there is not.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn program_name(&mut self, number: u8) -> Result<String, ClientError> {
        let first = wire::LIBRARY + u16::from(number.saturating_sub(1)) * LIBRARY_ENTRY;
        Ok(name_in(&self.holding(first + LIBRARY_NAME, LIBRARY_ENTRY - LIBRARY_NAME)?))
    }

    /// From now on Start runs this program.
    ///
    /// # Errors
    /// See [`ClientError`]; exception 3 when there is none of that number, 6 while one runs.
    pub fn select(&mut self, number: u8) -> Result<(), ClientError> {
        self.while_it_checks(lang::image::NARROW, |client| {
            client.write(wire::SELECTED, u16::from(number))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Called, Entry, Library, name_in, name_of, words_of};

    #[test]
    fn names_are_what_registers_hold() {
        for name in ["a", "drill", "sixteen letters!", ""] {
            assert_eq!(name_in(&words_of(name)), name);
        }
        assert_eq!(name_of("jobs/drill plate (final version).bas"), "drill_plate_(fin");
        assert_eq!(name_of("12.bas"), "_12");
        assert_eq!(name_of("Stück.bas"), "St_ck");
        assert_eq!(name_of(""), "program");
    }

    #[test]
    fn a_program_is_called_by_number_or_name() {
        assert_eq!("64".parse(), Ok(Called::Number(64)));
        assert_eq!("drill".parse(), Ok(Called::Name("drill".into())));
        for wrong in ["0", "65", "4711", "", " a", "a\"b", "é", "seventeen letters"] {
            assert!(wrong.parse::<Called>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn an_upload_takes_the_place_of_its_name_or_a_free_one() {
        let entry =
            |number, name: &str| Entry { number, name: name.into(), bytes: 9, crc: 1, keeps: 0 };
        let mut library = Library { entries: vec![entry(1, "a"), entry(3, "")], selected: 1 };
        let place =
            |library: &Library, called: &str| library.place(&called.parse().unwrap(), "x.bas");
        assert_eq!(place(&library, "A"), Ok((1, "a".into())));
        assert_eq!(place(&library, "b"), Ok((2, "b".into())));
        assert_eq!(place(&library, "3"), Ok((3, "x".into())));
        assert_eq!(place(&library, "9"), Ok((9, "x".into())));
        library.entries = (1..=64).map(|number| entry(number, "")).collect();
        assert!(place(&library, "b").unwrap_err().contains("full"));
    }
}
