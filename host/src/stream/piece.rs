//! A piece of a streamed job: an image without the axes' part of the profile.

use lang::back::constant;
use lang::effect::Effect;
use lang::image::{HEADER, Header, crc_in, seal};
use lang::isa::Op;
use lang::record::{MachineRecord, feature};
use lang::vm::effects::MAX_ARGUMENTS;

/// Features that change how a piece is run; a board refuses the others.
const FEATURES: u16 = feature::INTERPOLATE | feature::START | feature::ARC;

/// A piece as it goes over the link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// Header, code and data.
    pub bytes: Vec<u8>,
    /// Where each statement's code begins, in ascending order, its line, and how many statements of
    /// the machine came before it in the whole job.
    pub places: Vec<(u16, u32, u64)>,
    /// Its end leaves a value in cell 0 that the job waits for.
    pub asks: bool,
}

impl Piece {
    /// The line whose code holds `pc`, and the statements before it.
    pub fn at(&self, pc: u16) -> Option<(u32, u64)> {
        let after = self.places.partition_point(|place| place.0 <= pc);
        self.places.get(after.checked_sub(1)?).map(|place| (place.1, place.2))
    }
}

/// A piece that is being written.
#[derive(Debug)]
pub struct Writer {
    machine: Vec<u8>,
    features: u16,
    /// Number of the next piece.
    number: u16,
    /// Bytes of code and data that a piece may have.
    room: usize,
    code: Vec<u8>,
    data: Vec<u8>,
    places: Vec<(u16, u32, u64)>,
    /// Statements of the machine so far.
    count: u64,
}

impl Writer {
    /// Pieces of a program for a board with so much room.
    pub fn new(header: &Header, machine: &[u8], room: usize) -> Writer {
        Writer {
            machine: machine.to_vec(),
            features: u16::from(header.features) & FEATURES,
            number: 0,
            room,
            code: Vec::new(),
            data: Vec::new(),
            places: Vec::new(),
            count: 0,
        }
    }

    /// How long a text may be so that it fits into what is left of the piece.
    pub fn text_room(&self) -> usize {
        // Its instruction, its length, the piece's end.
        self.room.saturating_sub(self.code.len() + self.data.len() + 7)
    }

    /// Whether nothing was written since the last piece.
    pub fn is_empty(&self) -> bool {
        self.code.is_empty()
    }

    /// Appends an instruction with its values and its text; `false` when the piece is full.
    pub fn put(&mut self, line: u32, values: &[i32], code: &[u8], text: Option<&[u8]>) -> bool {
        let mut bytes: Vec<u8> = values.iter().flat_map(|value| constant(*value)).collect();
        let mut data = 0;
        match text {
            Some(text) => {
                bytes.extend([Op::PrintTextFar.code()]);
                bytes.extend((self.data.len() as u16).to_le_bytes());
                data = 1 + text.len();
            }
            None => bytes.extend(code),
        }
        // One byte for the end, two for a value that is kept.
        if self.code.len() + self.data.len() + bytes.len() + data + 3 > self.room {
            return false;
        }
        self.places.push((self.code.len() as u16, line, self.count));
        self.count += 1;
        self.code.extend(bytes);
        if let Some(text) = text {
            self.data.push(text.len() as u8);
            self.data.extend(text);
        }
        true
    }

    /// Completes the piece; with `asks` the value on the stack is kept for the host.
    pub fn finish(&mut self, asks: bool) -> Piece {
        if asks {
            self.code.push(Op::Store.code());
        }
        self.code.push(Op::End.code());
        let body = self.code.len() + self.data.len();
        let header = Header {
            features: self.features as u8,
            len: HEADER + MachineRecord::SIZE + body,
            code_len: self.code.len(),
            entry: 0,
            cells: 1,
            stack: MAX_ARGUMENTS as u8 + 1,
            frame: MAX_ARGUMENTS as u8 + 1,
            calls: 0,
            keeps: 0,
            keep_base: 0,
            profile_hash: self.number,
        };
        let head = header.bytes();
        let mut image = [&head, &self.machine[..], &self.code, &self.data].concat();
        seal(&mut image);
        let mut bytes = header.bytes().to_vec();
        bytes[4..6].copy_from_slice(&crc_in(&image).to_le_bytes());
        bytes.append(&mut self.code);
        bytes.append(&mut self.data);
        self.number = self.number.wrapping_add(1);
        Piece { bytes, places: std::mem::take(&mut self.places), asks }
    }

    /// The axes' part of the profile.
    pub fn machine(&self) -> &[u8] {
        &self.machine
    }

    /// Statements of the machine so far.
    pub fn count(&self) -> u64 {
        self.count
    }
}

/// Whether an effect gives the program a value.
pub fn answers(effect: &Effect) -> bool {
    matches!(effect, Effect::Read(_))
}
