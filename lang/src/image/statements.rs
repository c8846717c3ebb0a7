//! The statement table: which line a piece of code belongs to, and where RESUME NEXT goes on.
//!
//! Only programs with ON ERROR carry one. Entries follow each other in the order of the code,
//! from address 0, without gaps:
//!
//! | byte | holds |
//! |---|---|
//! | 0 | bits 0..4: bytes of code, 31: 31 and the next byte; bit 5: a resume address follows; bits 6, 7: line |
//! | .. | line 0: as before; 1: one more; 2: the next byte more, 0 where the statement of the entry before goes on; 3: a number of address size |
//! | .. | resume address, if there is one; otherwise the code after the entry |

use super::address;

const LENGTH: u8 = 31;
const RESUME: u8 = 1 << 5;
const LINE: u8 = 6;

/// What the table says of a place in the code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Line, from 1.
    pub line: usize,
    /// Where RESUME NEXT goes on.
    pub resume: usize,
    /// Address of the statement's code.
    pub start: usize,
    /// Address of the entry's code: another than the statement's where it goes on from the entry before.
    pub entry: usize,
    /// Address of the first byte behind the statement's code.
    pub end: usize,
}

/// A statement table in an image.
#[derive(Clone, Copy, Debug)]
pub struct Statements<'a> {
    bytes: &'a [u8],
    wide: bool,
    place: Place,
}

impl<'a> Statements<'a> {
    /// The table whose first entry stands at the start of `bytes`.
    pub const fn new(bytes: &'a [u8], wide: bool) -> Statements<'a> {
        Statements { bytes, wide, place: Place { line: 0, resume: 0, start: 0, entry: 0, end: 0 } }
    }

    /// The statement whose code holds `pc`.
    pub fn at(mut self, pc: usize) -> Option<Place> {
        self.find(|place| pc < place.end)
    }
}

impl Iterator for Statements<'_> {
    type Item = Place;

    fn next(&mut self) -> Option<Place> {
        let mut take = || {
            let (&byte, rest) = self.bytes.split_first()?;
            self.bytes = rest;
            Some(byte)
        };
        let head = take()?;
        let mut len = usize::from(head & LENGTH);
        if len == usize::from(LENGTH) {
            len += usize::from(take()?);
        }
        let mut line = self.place.line;
        let entry = self.place.end;
        let mut start = entry;
        match head >> LINE {
            0 => {}
            1 => line += 1,
            2 => {
                let more = take()?;
                line += usize::from(more);
                if more == 0 {
                    start = self.place.start;
                }
            }
            _ => {
                line = address(self.bytes, 0, self.wide)?;
                self.bytes = self.bytes.get(2 + usize::from(self.wide)..)?;
            }
        }
        let end = self.place.end.checked_add(len)?;
        let mut resume = end;
        if head & RESUME != 0 {
            resume = address(self.bytes, 0, self.wide)?;
            self.bytes = self.bytes.get(2 + usize::from(self.wide)..)?;
        }
        self.place = Place { line, resume, start, entry, end };
        Some(self.place)
    }
}

/// The most code of one entry.
#[cfg(feature = "compiler")]
pub const LONGEST: usize = 286;

/// Writes a table; the entries follow each other without gaps. A statement that takes more than [`LONGEST`] is several
/// places of the same start.
#[cfg(feature = "compiler")]
pub fn write(entries: &[Place], wide: bool) -> Vec<u8> {
    let mut out = Vec::new();
    let mut before = Place::default();
    let address = |out: &mut Vec<u8>, value: usize| {
        out.extend(&(value as u32).to_le_bytes()[..2 + usize::from(wide)]);
    };
    for place in entries {
        let mut rest = place.end - before.end;
        let mut end = before.end;
        let mut continues = place.entry != place.start;
        // One of more code that nothing parts.
        while rest > 0 {
            let len = rest.min(LONGEST);
            rest -= len;
            end += len;
            let explicit = place.resume != end;
            let delta = place.line as i64 - before.line as i64;
            let line = match delta {
                0 if continues => 2,
                0 => 0,
                1 => 1,
                2..=255 => 2,
                _ => 3,
            };
            let short = len.min(usize::from(LENGTH)) as u8;
            out.push(short | if explicit { RESUME } else { 0 } | line << LINE);
            if short == LENGTH {
                out.push((len - usize::from(LENGTH)) as u8);
            }
            match line {
                2 => out.push(delta as u8),
                3 => address(&mut out, place.line),
                _ => {}
            }
            if explicit {
                address(&mut out, place.resume);
            }
            continues = true;
            before = Place { end, ..*place };
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{Place, Statements, write};

    proptest! {
        #[test]
        fn every_byte_of_code_finds_its_statement_again(
            statements in prop::collection::vec((1usize..700, 1usize..60_000, prop::bool::ANY), 1..20),
            wide in prop::bool::ANY,
        ) {
            let mut end = 0;
            let places: Vec<Place> = statements
                .iter()
                .map(|&(len, line, jump)| {
                    let start = end;
                    end += len;
                    Place { line, resume: if jump { line } else { end }, start, entry: start, end }
                })
                .collect();
            let bytes = write(&places, wide);
            let table = Statements::new(&bytes, wide);
            let mut start = 0;
            for place in &places {
                for pc in start..place.end {
                    let found = table.at(pc).expect("inside the code");
                    prop_assert_eq!((found.line, found.resume), (place.line, place.resume));
                    prop_assert_eq!(found.start, place.start);
                }
                start = place.end;
            }
            prop_assert_eq!(table.at(end), None);
        }
    }
}
