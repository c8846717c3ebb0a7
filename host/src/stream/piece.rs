//! A piece of a streamed job: an image without the axes' part of the profile.

use lang::back::constant;
use lang::effect::Effect;
use lang::fault::Fault;
use lang::image::{HEADER, Header, Image, crc_in, seal};
use lang::isa::Op;
use lang::record::{MachineRecord, feature};
use lang::vm::effects::MAX_ARGUMENTS;

/// Features that change how a piece is run; a board refuses the others.
const FEATURES: u16 = feature::INTERPOLATE | feature::START | feature::ARC | feature::EVENTS;

/// Bytes of code and texts of a piece that the board waits for, if one statement does not have more: a
/// handler begins the earlier the shorter it is.
const ANSWER: usize = 24;

/// A statement in a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Where its code begins.
    pub pc: u16,
    /// Its line.
    pub line: u32,
    /// Statements of the machine that come before it in the whole job.
    pub count: u64,
    /// Its number among all that was written.
    pub id: u64,
}

/// A piece as it goes over the link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// Header, code and data.
    pub bytes: Vec<u8>,
    /// Its statements in their order.
    pub places: Vec<Place>,
    /// Its end leaves a value in cell 0 that the job waits for.
    pub asks: bool,
    /// It answers the board's call for a handler.
    pub answers: bool,
}

impl Piece {
    /// The statement whose code holds `pc`.
    pub fn at(&self, pc: u16) -> Option<Place> {
        let after = self.places.partition_point(|place| place.pc <= pc);
        self.places.get(after.checked_sub(1)?).copied()
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
    /// The table of ON lines, with which the data of every piece begins.
    table: Vec<u8>,
    places: Vec<Place>,
    /// Statements of the machine so far.
    count: u64,
    /// Number of the next place.
    id: u64,
    /// The next piece answers a call.
    answers: bool,
}

impl Writer {
    /// Pieces of a program for a board with so much room.
    pub fn new(image: &Image<'_>, room: usize) -> Writer {
        let mut table = Vec::new();
        if image.header.has(feature::EVENTS) {
            // Their targets, which only the host knows, are the piece's beginning.
            table = vec![0; 1 + 2 * usize::from(image.events())];
            table[0] = image.events();
        }
        Writer {
            machine: image.machine.to_vec(),
            features: u16::from(image.header.features) & FEATURES,
            number: 0,
            room,
            code: Vec::new(),
            data: table.clone(),
            table,
            places: Vec::new(),
            count: 0,
            id: 0,
            answers: false,
        }
    }

    /// Pieces hold another program's statements, too.
    pub fn admit(&mut self, image: &Image<'_>) {
        self.features |= u16::from(image.header.features) & FEATURES;
    }

    /// How long a text may be so that it fits into what is left of the piece.
    pub fn text_room(&self) -> usize {
        // Its instruction with what may stand before it, its length, the piece's end.
        self.room.saturating_sub(self.code.len() + self.data.len() + 8)
    }

    /// Whether nothing was written since the last piece.
    pub fn is_empty(&self) -> bool {
        self.code.is_empty()
    }

    /// Whether the next piece answers a call.
    pub fn answers(&self) -> bool {
        self.answers
    }

    /// Appends an effect with its values and its text; `false` when the piece is full.
    pub fn put(
        &mut self,
        line: u32,
        (values, code): (&[i32], &[u8]),
        text: Option<&[u8]>,
        more: bool,
    ) -> bool {
        let mut bytes: Vec<u8> = values.iter().flat_map(|value| constant(*value)).collect();
        if more {
            bytes.push(Op::More.code());
        }
        let mut data = 0;
        match text {
            Some(text) => {
                bytes.extend([Op::PrintTextFar.code()]);
                bytes.extend((self.data.len() as u16).to_le_bytes());
                data = 1 + text.len();
            }
            None => bytes.extend(code),
        }
        if !self.fits(bytes.len() + data) {
            return false;
        }
        self.place(line);
        self.count += 1;
        self.code.extend(bytes);
        if let Some(text) = text {
            self.data.push(text.len() as u8);
            self.data.extend(text);
        }
        true
    }

    /// Appends code that is no statement of the machine; `false` when the piece is full.
    pub fn put_control(&mut self, line: u32, code: &[u8]) -> bool {
        let fits = self.fits(code.len());
        if fits {
            self.place(line);
            self.code.extend(code);
        }
        fits
    }

    fn fits(&self, bytes: usize) -> bool {
        let used = self.code.len() + self.data.len() - self.table.len();
        if self.answers && used > 0 && used + bytes > ANSWER {
            return false;
        }
        // One byte for the end, two for a value that is kept.
        self.code.len() + self.data.len() + bytes + 3 <= self.room
    }

    /// What follows in the piece is a place of its own.
    pub fn place(&mut self, line: u32) {
        let pc = self.code.len() as u16;
        self.places.push(Place { pc, line, count: self.count, id: self.id });
        self.id += 1;
    }

    /// Forgets what is not sent: the next piece has this number, answers a call, and comes behind so
    /// many statements of the machine.
    pub fn rewind(&mut self, number: u16, count: u64) {
        self.code.clear();
        self.data.clone_from(&self.table);
        self.places.clear();
        self.number = number;
        self.count = count;
        self.answers = true;
    }

    /// Completes the piece; with `asks` the value on the stack is kept for the host.
    pub fn finish(&mut self, asks: bool) -> Piece {
        if asks {
            self.code.push(Op::Store.code());
        }
        self.code.push(Op::End.code());
        let body = self.code.len() + self.data.len();
        let answers = std::mem::take(&mut self.answers);
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
            keep_base: answers.into(),
            profile_hash: self.number,
        };
        let head = header.bytes();
        let mut image = [&head, &self.machine[..], &self.code, &self.data].concat();
        seal(&mut image);
        let mut bytes = header.bytes().to_vec();
        bytes[4..6].copy_from_slice(&crc_in(&image).to_le_bytes());
        bytes.append(&mut self.code);
        bytes.append(&mut self.data);
        self.data.clone_from(&self.table);
        self.number = self.number.wrapping_add(1);
        Piece { bytes, places: std::mem::take(&mut self.places), asks, answers }
    }

    /// The axes' part of the profile.
    pub fn machine(&self) -> &[u8] {
        &self.machine
    }

    /// Statements of the machine so far.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The number that the next place gets.
    pub fn next_id(&self) -> u64 {
        self.id
    }
}

/// Whether an effect gives the program a value.
pub fn answers(effect: &Effect) -> bool {
    matches!(effect, Effect::Read(_))
}

/// Code that fails on the board as the program did on the host; `None` for a fault that no code of a
/// program has.
pub fn failing(fault: Fault) -> Option<Vec<u8>> {
    let code = |values: &[i32], ops: &[u8]| {
        let mut bytes: Vec<u8> = values.iter().flat_map(|value| constant(*value)).collect();
        bytes.extend(ops);
        bytes
    };
    // Where the value of an operation would stay, it goes: what follows begins with a clear stack.
    let dropped = |values: &[i32], op: Op| code(values, &[op.code(), Op::Drop.code()]);
    Some(match fault {
        Fault::Overflow => dropped(&[i32::MIN], Op::Neg),
        Fault::DivisionByZero => dropped(&[1, 0], Op::Div),
        Fault::ArrayIndex => code(&[0], &[Op::Check.code(), 0, Op::Drop.code()]),
        Fault::BadShift => dropped(&[1, 32], Op::Shl),
        Fault::ValueRange => dropped(&[-1], Op::Sqr),
        Fault::Stack => code(&[], &[Op::Return.code()]),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::{Writer, failing};
    use lang::fault::Fault;
    use lang::front::source::Source;
    use lang::front::{ProfileChoice, compile};
    use lang::image::Image;
    use lang::vm::{Exit, State, Vm};

    #[test]
    fn what_fails_for_the_program_fails_as_that_did() {
        let source = Source::new("a.bas", "Wait 1s\n".to_owned());
        let program = compile(&source, ProfileChoice::built_in()).0.expect("a program");
        let compiled = lang::back::compile(&program).expect("it fits");
        let image = Image::new(&compiled.image).expect("an image");
        for fault in [
            Fault::Overflow,
            Fault::DivisionByZero,
            Fault::ArrayIndex,
            Fault::BadShift,
            Fault::ValueRange,
            Fault::Stack,
        ] {
            let mut writer = Writer::new(&image, 180);
            assert!(writer.put_control(1, &failing(fault).expect("code")));
            let piece = writer.finish(false).bytes;
            let bytes = [&piece[..20], writer.machine(), &piece[20..]].concat();
            let image = Image::new(&bytes).expect("a piece");
            let mut state = State::new(&image.header);
            let mut pool = vec![0; image.header.pool_bytes()];
            assert_eq!(Vm::new(image, &mut state, &mut pool).run(9), Exit::Fault(fault));
        }
        assert_eq!(failing(Fault::SoftLimit), None);
    }
}
