//! What goes into the chip's RAM: the writer, a round's segments, and the sums by which it knows them. The
//! layout is that of `writer.s`.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use super::frame::{BLOCK, PASSWORD, Report, block};
use crate::board::image_file;

/// The writer, assembled: TI-TXT.
const WRITER: &str = include_str!("writer.txt");
/// Where it begins, and is started.
pub const ENTRY: u32 = 0x2500;
/// Where its reset is, and where `late` is put.
const RESET: u16 = 0x259E;
const LATE: u16 = 0x2600;
/// Bytes of a flash segment.
pub const SEGMENT: usize = 512;
/// Of a round.
const MOST: usize = 6;
/// Flash of the MSP430F5529 by numbers of segments, and the one with the vectors (SLAS590, "Memory
/// Organization").
const FLASH: std::ops::RangeInclusive<u16> = 0x22..=0x121;
const VECTORS: u16 = 0x7F;

const SUMS: usize = 0x00EC;
const TO_COMPARE: usize = 0x00F0;
const TO_WRITE: usize = 0x00F2;
const BEHIND: usize = 0x00FE;
const DATA: usize = 0x0100;
const COMPARED: usize = 0x0300;
const END: usize = 0x0D00;

/// The writer, and `late`.
static CODE: LazyLock<[Vec<u8>; 2]> = LazyLock::new(|| {
    let image = emulator::Image::parse(WRITER.as_bytes()).unwrap_or_default();
    let mut pieces = image.segments.into_iter().map(|segment| segment.data);
    [(); 2].map(|()| pieces.next().unwrap_or_default())
});

/// A firmware by the flash segments that it takes.
#[derive(Clone, Debug)]
pub struct Segments(BTreeMap<u16, Box<[u8; SEGMENT]>>);

impl Segments {
    /// Of an ELF file.
    ///
    /// # Errors
    /// It is none, or has parts outside the flash of an MSP430F5529, or no reset vector.
    pub fn of_image(elf: &[u8]) -> Result<Segments, String> {
        let mut segments = BTreeMap::new();
        for (start, bytes) in image_file::pieces(elf)? {
            for (at, byte) in (start..).zip(bytes) {
                let number = u16::try_from(at as usize / SEGMENT).unwrap_or(u16::MAX);
                if !FLASH.contains(&number) {
                    return Err(format!("it has a byte at {at:05X}, where this chip has no flash"));
                }
                let blank = || Box::new([0xFF; SEGMENT]);
                segments.entry(number).or_insert_with(blank)[at as usize % SEGMENT] = byte;
            }
        }
        match segments.get(&VECTORS) {
            Some(vectors) if vectors[SEGMENT - 2..] != [0xFF; 2] => Ok(Segments(segments)),
            _ => Err("it has no reset vector".to_owned()),
        }
    }

    /// How many there are.
    #[allow(clippy::len_without_is_empty, reason = "the one with the vectors is always there")]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// First address and bytes of each stretch of them.
    pub fn ranges(&self) -> Vec<(u32, u32)> {
        let mut ranges: Vec<(u32, u32)> = Vec::new();
        for number in self.0.keys() {
            let at = u32::from(*number) * SEGMENT as u32;
            match ranges.last_mut() {
                Some((first, bytes)) if *first + *bytes == at => *bytes += SEGMENT as u32,
                _ => ranges.push((at, SEGMENT as u32)),
            }
        }
        ranges
    }

    /// The password of a chip that has this firmware.
    pub fn password(&self) -> [u8; PASSWORD] {
        let mut bytes = [0xFF; PASSWORD];
        if let Some(vectors) = self.0.get(&VECTORS) {
            bytes.copy_from_slice(&vectors[SEGMENT - PASSWORD..]);
        }
        bytes
    }

    /// The rounds that write all but the vectors, which become blank first.
    pub fn rounds(&self) -> Vec<Round> {
        let blank = [0xFF; SEGMENT];
        let rest: Vec<_> = self.0.iter().filter(|(number, _)| **number != VECTORS).collect();
        let first = Round::new(&[(VECTORS, &blank)], None);
        let others = rest.chunks(MOST).map(|some| {
            let some: Vec<_> = some.iter().map(|(number, bytes)| (**number, &***bytes)).collect();
            Round::new(&some, None)
        });
        std::iter::once(first).chain(others).collect()
    }

    /// The one that compares all but the vectors, and comes back late if something is wrong.
    pub fn comparison(&self) -> Round {
        let mut round = Round::new(&[], Some(&self.sums()));
        round.0[DATA..DATA + CODE[1].len()].copy_from_slice(&CODE[1]);
        round.0[BEHIND..DATA].copy_from_slice(&LATE.to_le_bytes());
        round.seal();
        round
    }

    /// The last one: all are compared again, then the vectors are written.
    pub fn last_round(&self) -> Round {
        let vectors = self.0.get(&VECTORS).map(|bytes| (VECTORS, &**bytes));
        Round::new(vectors.as_slice(), Some(&self.sums()))
    }

    fn sums(&self) -> Vec<(u16, [u16; 2])> {
        let rest = self.0.iter().filter(|(number, _)| **number != VECTORS);
        rest.map(|(number, bytes)| (*number, sums(&bytes[..]))).collect()
    }
}

/// The sum of words, and the sum of the sums on the way.
fn sums(bytes: &[u8]) -> [u16; 2] {
    let words = bytes.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
    words.fold([0; 2], |[sum, of_sums], word| {
        let sum = sum.wrapping_add(word);
        [sum, of_sums.wrapping_add(sum)]
    })
}

/// What the chip's RAM holds from [`ENTRY`] on.
#[derive(Clone, Debug)]
pub struct Round(Vec<u8>);

impl Round {
    /// Writes at most six segments, or one behind a look at others.
    fn new(write: &[(u16, &[u8; SEGMENT])], compare: Option<&[(u16, [u16; 2])]>) -> Round {
        let compare = compare.unwrap_or_default();
        let mut ram = vec![0; END];
        ram[..CODE[0].len()].copy_from_slice(&CODE[0]);
        let mut put = |at: usize, word: u16| ram[at..at + 2].copy_from_slice(&word.to_le_bytes());
        put(BEHIND, RESET);
        put(TO_COMPARE, compare.len() as u16);
        for (n, (number, [first, second])) in compare.iter().enumerate() {
            let at = COMPARED + 6 * n;
            put(at, *number);
            put(at + 2, *first);
            put(at + 4, *second);
        }
        for (n, (number, _)) in write.iter().enumerate() {
            put(TO_WRITE + 2 * n, *number);
        }
        for (place, (_, bytes)) in ram[DATA..].chunks_exact_mut(SEGMENT).zip(write) {
            place.copy_from_slice(&bytes[..]);
        }
        let mut round = Round(ram);
        round.seal();
        round
    }

    /// Puts the sums before what they are of.
    fn seal(&mut self) {
        let [first, second] = sums(&self.0[TO_COMPARE..]);
        self.0[SUMS..SUMS + 2].copy_from_slice(&first.to_le_bytes());
        self.0[SUMS + 2..SUMS + 4].copy_from_slice(&second.to_le_bytes());
    }

    /// The reports that bring it there. The code, which nothing looks at before it runs, comes twice.
    pub fn reports(&self) -> impl Iterator<Item = Report> + '_ {
        [&self.0[..DATA], &self.0[..]].into_iter().flat_map(|bytes| {
            let places = (ENTRY..).step_by(BLOCK);
            places.zip(bytes.chunks(BLOCK)).map(|(at, bytes)| block(at, bytes))
        })
    }
}
