//! The program area of flash: what the Rust twins work on, and images to put there.

use firmware::WHOLE;
use firmware::store::{Flash, SEGMENT};
use firmware::verify::{self, Bytes};
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};

use crate::chip::Chip;

/// Start of the program area.
pub const AREA: u16 = 0xFE00 - SEGMENT * WHOLE.segments as u16;
/// Bytes of it.
pub const BYTES: usize = SEGMENT as usize * WHOLE.segments as usize;

/// A copy of the area.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Area(pub Vec<u8>);

struct From<'a>(&'a [u8]);

impl Bytes for From<'_> {
    fn byte(&self, offset: u16) -> u8 {
        self.0.get(usize::from(offset)).copied().unwrap_or(0xFF)
    }
}

impl Area {
    /// Erased.
    pub fn new() -> Area {
        Area(vec![0xFF; BYTES])
    }

    /// What the chip's flash holds.
    pub fn of(chip: &Chip) -> Area {
        Area((0..BYTES as u16).map(|at| chip.board.peek8(AREA + at)).collect())
    }
}

impl Flash for Area {
    const SEGMENTS: u8 = WHOLE.segments;

    fn read(&self, offset: u16) -> u16 {
        let at = usize::from(offset);
        u16::from_le_bytes([self.0[at], self.0[at + 1]])
    }
    fn write(&mut self, offset: u16, word: u16) {
        let at = usize::from(offset);
        for (byte, mask) in self.0[at..].iter_mut().zip(word.to_le_bytes()) {
            *byte &= mask;
        }
    }
    fn erase(&mut self, offset: u16) {
        let at = usize::from(offset / SEGMENT * SEGMENT);
        self.0[at..at + usize::from(SEGMENT)].fill(0xFF);
    }
    fn image(&self, offset: u16) -> Option<u16> {
        verify::sound(&From(&self.0[usize::from(offset)..]), BYTES as u16 - offset)
    }
    fn length(&self, offset: u16) -> u16 {
        self.read(offset + lang::image::at::LEN as u16)
    }
}

/// The image of a script.
pub fn image(script: &str) -> Vec<u8> {
    let source = Source::new("test.bas", script.to_owned());
    let (program, findings) = compile(&source, ProfileChoice::built_in());
    let program = program.unwrap_or_else(|| panic!("{findings:?}"));
    lang::back::compile(&program).expect("it fits").image
}

/// Words as an upload brings them.
pub fn words(image: &[u8]) -> Vec<u16> {
    image
        .chunks(2)
        .map(|pair| u16::from_le_bytes([pair[0], *pair.get(1).unwrap_or(&0xFF)]))
        .collect()
}

/// Announces an image and takes it in, up to the words before the commit; `false` when `Begin` is
/// refused.
pub fn send(chip: &mut Chip, image: &[u8], keep: bool, code: u16) -> bool {
    chip.set_word("UPLOAD", image.len() as u16 | u16::from(keep) << 15);
    if chip.try_call("upload_control", &[(12, code)]).is_none() || chip.reg(12) != 0 {
        return false;
    }
    words(image).iter().enumerate().all(|(at, &word)| {
        chip.try_call("upload_word", &[(12, at as u16), (13, word)]).is_some() && chip.reg(12) == 0
    })
}
