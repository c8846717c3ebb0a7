//! The program image: what the compiler writes, the link carries, flash holds and the VM runs.
//!
//! | part | bytes |
//! |---|---|
//! | header | 20 |
//! | axes' part of the profile: [`MachineRecord`] | [`MachineRecord::SIZE`] |
//! | code | `code_len` |
//! | data: table of handlers, texts, table columns, limits of AT variables, statement table | the rest |
//!
//! With feature `EVENTS` the data begins with the number of ON lines in one byte and the targets of
//! their handlers; with feature `LINES` the data offset of the statement table follows, with
//! [`MachineRecord::AT_LIMITS`] that of the [`limits`].
//!
//! Numbers stand least byte first. Addresses count from the start of the code, data offsets from
//! the start of the data; both have two bytes, in a wide image three. Only the host runs wide
//! images: they exist so that a simulation is not bound by the device's flash.
//!
//! | header byte | holds |
//! |---|---|
//! | 0 | [`FORMAT`] |
//! | 1 | [`feature`] bits |
//! | 2, 3 | [`FINGERPRINT`](crate::isa::FINGERPRINT) of the opcode table |
//! | 4, 5 | with it the CRC-16 of all bytes is 0 |
//! | 6, 7 | length of the image |
//! | 8, 9 | length of the code |
//! | 10 | deepest expression of all routines that are open at once |
//! | 11 | KEEP values |
//! | 12, 13 | address of the main program |
//! | 14 | cells |
//! | 15 | deepest expression of one routine |
//! | 16 | depth of the call stack |
//! | 17 | first KEEP cell; the others follow it. Those before it are AT variables', kept from run to run |
//! | 18, 19 | hash of the profile; in a wide image the third bytes of the two lengths |

pub mod course;
pub mod limits;
pub mod statements;

use crate::record::{AxisRecord, MachineRecord, feature};
use crate::wire::{self, CRC_START, crc16, crc16_back};
use crate::{isa, part};

/// Version of the container.
pub const FORMAT: u8 = 3;
/// Bytes of the header.
pub const HEADER: usize = 20;
/// Longest image with addresses of two bytes: the link tells its length in 15 bits.
pub const NARROW: usize = 0x7FFF;
/// Cells that a program may have: as many as a byte names.
pub const MAX_CELLS: usize = 256;
/// ON lines that a program may have.
pub const MAX_EVENTS: usize = 4;

/// Offsets of the header's numbers.
pub mod at {
    /// CRC.
    pub const CRC: usize = 4;
    /// Length of the image.
    pub const LEN: usize = 6;
    /// Length of the code.
    pub const CODE_LEN: usize = 8;
    /// Values on the expression stack at most.
    pub const STACK: usize = 10;
    /// KEEP values.
    pub const KEEPS: usize = 11;
    /// Address of the main program.
    pub const ENTRY: usize = 12;
    /// Cells, see [`cells`](super::cells).
    pub const CELLS: usize = 14;
    /// Values that one routine has on the expression stack at most.
    pub const FRAME: usize = 15;
    /// Entries of the call stack.
    pub const CALLS: usize = 16;
    /// First KEEP cell, and so the number of cells before it, which AT variables take.
    pub const KEEP_BASE: usize = 17;
    /// Hash of the profile.
    pub const PROFILE: usize = 18;
}

/// Cells of a program whose header has this byte: 255 stands for 256.
pub const fn cells(byte: u8) -> u16 {
    if byte == u8::MAX { 256 } else { byte as u16 }
}

/// Bytes of the device's RAM that cells, expression stack and call stack share, as the language
/// promises them.
pub const fn pool_limit(features: u8) -> usize {
    part::F5529.pool_for(features as u16) as usize
}

/// Why an image is refused, in detail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Flaw {
    /// Shorter than its header or than its length says.
    Truncated = 1,
    /// Another version of the container.
    Format = 2,
    /// Another instruction set.
    Fingerprint = 3,
    /// Damaged.
    Crc = 4,
    /// Parts of the image do not fit into it.
    Layout = 5,
    /// More cells, stack or calls than the VM has.
    Memory = 6,
    /// A feature that this VM does not have.
    Feature = 7,
    /// A code that is no instruction.
    Opcode = 8,
    /// An operand that lies outside.
    Operand = 9,
    /// A jump that does not lead to the start of an instruction.
    Target = 10,
    /// Stack depth that does not agree.
    Depth = 11,
    /// The code does not end.
    End = 12,
}

impl Flaw {
    /// As the link reports it.
    pub const fn refusal(self) -> wire::Refusal {
        match self {
            Flaw::Truncated => wire::Refusal::Incomplete,
            Flaw::Format | Flaw::Fingerprint => wire::Refusal::Version,
            Flaw::Crc => wire::Refusal::Crc,
            Flaw::Memory => wire::Refusal::Memory,
            Flaw::Feature => wire::Refusal::Feature,
            Flaw::Layout
            | Flaw::Opcode
            | Flaw::Operand
            | Flaw::Target
            | Flaw::Depth
            | Flaw::End => wire::Refusal::Code,
        }
    }
}

/// What the header says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Header {
    /// [`feature`] bits, those below 256.
    pub features: u8,
    /// Length of the image.
    pub len: usize,
    /// Length of the code.
    pub code_len: usize,
    /// Address of the main program.
    pub entry: usize,
    /// Cells, at most 256.
    pub cells: u16,
    /// Values on the expression stack at most.
    pub stack: u8,
    /// Values that one routine has on it at most.
    pub frame: u8,
    /// Entries of the call stack.
    pub calls: u8,
    /// KEEP values.
    pub keeps: u8,
    /// First KEEP cell, and so the number of cells before it, which AT variables take.
    pub keep_base: u8,
    /// Hash of the profile, 0 in a wide image.
    pub profile_hash: u16,
}

impl Header {
    /// Whether addresses have three bytes.
    pub const fn wide(&self) -> bool {
        self.has(feature::WIDE)
    }

    /// Whether the program uses a [`feature`].
    pub const fn has(&self, feature: u16) -> bool {
        self.features as u16 & feature != 0
    }

    /// Bytes of memory that the host's VM needs, and the largest part's.
    pub const fn pool_bytes(&self) -> usize {
        part::F5529.pool_bytes(self)
    }

    /// The header of an image.
    ///
    /// # Errors
    /// The bytes are too few or of another format or instruction set.
    pub fn read(bytes: &[u8]) -> Result<Header, Flaw> {
        let Some(h) = bytes.first_chunk::<HEADER>() else { return Err(Flaw::Truncated) };
        if h[0] != FORMAT {
            return Err(Flaw::Format);
        }
        if u16::from_le_bytes([h[2], h[3]]) != isa::FINGERPRINT {
            return Err(Flaw::Fingerprint);
        }
        let word = |at: usize| u16::from_le_bytes([h[at], h[at + 1]]);
        let wide = h[1] as u16 & feature::WIDE != 0;
        let [len_high, code_high, profile_hash] = match word(at::PROFILE).to_le_bytes() {
            [len, code] if wide => [len.into(), code.into(), 0],
            hash => [0, 0, u16::from_le_bytes(hash)],
        };
        Ok(Header {
            features: h[1],
            len: long(word(at::LEN), len_high)?,
            code_len: long(word(at::CODE_LEN), code_high)?,
            entry: usize::from(word(at::ENTRY)),
            cells: cells(h[at::CELLS]),
            stack: h[at::STACK],
            frame: h[at::FRAME],
            calls: h[at::CALLS],
            keeps: h[at::KEEPS],
            keep_base: h[at::KEEP_BASE],
            profile_hash,
        })
    }

    /// The header's bytes, with a CRC of 0.
    #[cfg(feature = "compiler")]
    pub fn bytes(&self) -> [u8; HEADER] {
        let mut h = [0; HEADER];
        h[0] = FORMAT;
        h[1] = self.features;
        h[2..4].copy_from_slice(&isa::FINGERPRINT.to_le_bytes());
        let mut put = |at: usize, word: u16| h[at..at + 2].copy_from_slice(&word.to_le_bytes());
        put(at::LEN, self.len as u16);
        put(at::CODE_LEN, self.code_len as u16);
        put(at::ENTRY, self.entry as u16);
        put(at::PROFILE, self.profile_hash);
        if self.wide() {
            h[at::PROFILE] = (self.len >> 16) as u8;
            h[at::PROFILE + 1] = (self.code_len >> 16) as u8;
        }
        h[at::STACK] = self.stack;
        h[at::KEEPS] = self.keeps;
        h[at::CELLS] = if self.cells < 0xFF { self.cells as u8 } else { 0xFF };
        h[at::FRAME] = self.frame;
        h[at::CALLS] = self.calls;
        h[at::KEEP_BASE] = self.keep_base;
        h
    }
}

fn long(low: u16, high: u16) -> Result<usize, Flaw> {
    usize::try_from(u32::from(high) << 16 | u32::from(low)).map_err(|_| Flaw::Layout)
}

/// CRC that an image ought to carry: the one with which the CRC over all of it, these two bytes
/// included, is 0.
pub fn crc_of(bytes: &[u8]) -> u16 {
    let head = bytes.get(..at::CRC).unwrap_or_default();
    let rest = bytes.get(at::CRC + 2..).unwrap_or_default();
    let before = head.iter().fold(CRC_START, |crc, &byte| crc16(crc, byte));
    // Two bytes take the CRC from `before` to what the rest brings to 0; they go into it by xor.
    let behind = rest.iter().rev().fold(0, |crc, &byte| crc16_back(crc, byte));
    before ^ crc16_back(crc16_back(behind, 0), 0)
}

/// CRC that an image carries.
pub fn crc_in(bytes: &[u8]) -> u16 {
    match bytes.get(at::CRC..at::CRC + 2) {
        Some(&[low, high]) => u16::from_le_bytes([low, high]),
        _ => 0,
    }
}

/// Writes the CRC into an image.
#[cfg(feature = "compiler")]
pub fn seal(bytes: &mut [u8]) {
    let crc = crc_of(bytes).to_le_bytes();
    if let Some(place) = bytes.get_mut(at::CRC..at::CRC + 2) {
        place.copy_from_slice(&crc);
    }
}

/// An image taken apart. Its layout holds together; its code is not verified yet.
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    /// The header.
    pub header: Header,
    /// The axes' part of the profile, a [`MachineRecord`].
    pub machine: &'a [u8],
    /// The code.
    pub code: &'a [u8],
    /// The data.
    pub data: &'a [u8],
}

impl<'a> Image<'a> {
    /// Takes an image apart. `bytes` may be longer than the image.
    ///
    /// The CRC is not looked at: see [`crc_of`].
    ///
    /// # Errors
    /// The header is of another format or its lengths do not fit.
    pub fn new(bytes: &'a [u8]) -> Result<Image<'a>, Flaw> {
        let header = Header::read(bytes)?;
        let bytes = bytes.get(..header.len).ok_or(Flaw::Truncated)?;
        let body = bytes.get(HEADER..).ok_or(Flaw::Layout)?;
        let (machine, rest) = body.split_at_checked(MachineRecord::SIZE).ok_or(Flaw::Layout)?;
        let (code, data) = rest.split_at_checked(header.code_len).ok_or(Flaw::Layout)?;
        Ok(Image { header, machine, code, data })
    }

    /// Bytes of an address or a data offset.
    pub const fn address_bytes(&self) -> usize {
        2 + self.header.wide() as usize
    }

    fn address_at(&self, offset: usize) -> Option<usize> {
        address(self.data, offset, self.header.wide())
    }

    /// Steps and micrometres of an axis's scale; `None` when the machine lacks the axis.
    pub fn scale(&self, axis: u8) -> Option<(u16, u16)> {
        let record = self.machine.get(8 + usize::from(axis) * AxisRecord::SIZE..)?;
        let &[present, _, steps, steps_high, um, um_high] = record.first_chunk::<6>()?;
        if u16::from(present) & AxisRecord::PRESENT == 0 {
            return None;
        }
        Some((u16::from_le_bytes([steps, steps_high]), u16::from_le_bytes([um, um_high])))
    }

    /// Top rate of the fastest axis, steps/s.
    pub fn top_rate(&self) -> u32 {
        let rate = |axis: usize| {
            // Behind seven words, as [`AxisRecord`] has them.
            let place = 8 + axis * AxisRecord::SIZE + 14;
            self.machine.get(place..)?.first_chunk::<4>().map(|bytes| u32::from_le_bytes(*bytes))
        };
        (0..3).filter_map(rate).max().unwrap_or(0)
    }

    /// Number of ON lines.
    pub fn events(&self) -> u8 {
        match self.data.first() {
            Some(&count) if self.header.has(feature::EVENTS) => count,
            _ => 0,
        }
    }

    /// Address of the handler of the ON line in event slot `slot`.
    pub fn event_target(&self, slot: u8) -> Option<usize> {
        if slot >= self.events() {
            return None;
        }
        self.address_at(1 + usize::from(slot) * self.address_bytes())
    }

    /// Bytes of the table of handlers.
    fn handlers(&self) -> usize {
        match self.header.has(feature::EVENTS) {
            true => 1 + usize::from(self.events()) * self.address_bytes(),
            false => 0,
        }
    }

    /// The statement table of a program with ON ERROR.
    pub fn statements(&self) -> Option<statements::Statements<'a>> {
        if !self.header.has(feature::LINES) {
            return None;
        }
        let offset = self.address_at(self.handlers())?;
        Some(statements::Statements::new(self.data.get(offset..)?, self.header.wide()))
    }

    /// Whether AT variables have limits.
    pub fn has_limits(&self) -> bool {
        self.machine.first().is_some_and(|flags| flags & MachineRecord::AT_LIMITS != 0)
    }

    /// The limits of AT variables, of a program that has some.
    pub fn limits(&self) -> Option<limits::Limits<'a>> {
        if !self.has_limits() {
            return None;
        }
        let lines = usize::from(self.header.has(feature::LINES));
        let offset = self.address_at(self.handlers() + lines * self.address_bytes())?;
        limits::Limits::new(self.column(offset)?)
    }

    /// Whether lines run through their corners by slow points.
    pub fn has_courses(&self) -> bool {
        self.machine.first().is_some_and(|flags| flags & MachineRecord::COURSES != 0)
    }

    /// Each instruction that only larger parts have ([`isa::EXTRA`]): its address and the feature that it wants.
    pub fn extra(&self) -> impl Iterator<Item = (usize, u16)> + use<'a> {
        const RESUME: u8 = isa::Op::Resume as u8;
        const SYNC: u8 = isa::Op::Sync as u8;
        const AOUT: u8 = isa::Op::SetAout as u8;
        let (code, wide) = (self.code, self.header.wide());
        let mut pc = 0;
        core::iter::from_fn(move || {
            loop {
                let (here, op) = (pc, *code.get(pc)?);
                pc += 1 + isa::shape(op)?.operands().len(wide);
                if (isa::EXTRA.0..=isa::EXTRA.1).contains(&op) {
                    let wanted = match op {
                        RESUME => feature::RETRY,
                        SYNC => feature::ACTIONS,
                        AOUT => feature::AOUT,
                        _ => feature::MATHS,
                    };
                    return Some((here, wanted));
                }
            }
        })
    }

    /// The slow points of a course, whose record is at a data offset.
    pub fn course(&self, offset: usize) -> impl Iterator<Item = course::Entry> + use<'a> {
        course::entries(self.data.get(offset + 1..).unwrap_or_default())
    }

    /// The text at a data offset: its length in one byte, then its bytes.
    pub fn text(&self, offset: usize) -> Option<&'a [u8]> {
        let (&len, rest) = self.data.get(offset..)?.split_first()?;
        rest.get(..usize::from(len))
    }

    /// The table column at a data offset.
    pub fn column(&self, offset: usize) -> Option<Column<'a>> {
        Column::new(self.data.get(offset..)?)
    }
}

/// The address in `bytes` at `at`.
pub fn address(bytes: &[u8], at: usize, wide: bool) -> Option<usize> {
    let low = *bytes.get(at)?;
    let middle = *bytes.get(at + 1)?;
    let high = if wide { *bytes.get(at + 2)? } else { 0 };
    long(u16::from_le_bytes([low, middle]), high.into()).ok()
}

/// A column of a table.
///
/// | byte | holds |
/// |---|---|
/// | 0 | bytes of a value, 1..=4 |
/// | 1, 2 | row count |
/// | 3, 4 | what each value is multiplied by: 1..=65535 |
/// | .. | values, signed, highest byte first |
#[derive(Clone, Copy, Debug)]
pub struct Column<'a> {
    scale: u16,
    width: u8,
    rows: u16,
    values: &'a [u8],
}

/// Bytes of a column before its values.
pub const COLUMN_HEAD: usize = 5;

impl<'a> Column<'a> {
    fn new(bytes: &'a [u8]) -> Option<Column<'a>> {
        let (&[width, low, high, scale @ ..], rest) = bytes.split_first_chunk::<COLUMN_HEAD>()?;
        if !(1..=4).contains(&width) {
            return None;
        }
        let rows = u16::from_le_bytes([low, high]);
        let values = rest.get(..usize::from(rows).checked_mul(usize::from(width))?)?;
        Some(Column { scale: u16::from_le_bytes(scale), width, rows, values })
    }

    /// Number of rows.
    pub const fn rows(&self) -> u16 {
        self.rows
    }

    /// The value of a row, `None` outside.
    pub fn get(&self, row: i32) -> Option<i32> {
        let row = u16::try_from(row).ok().filter(|&row| row < self.rows)?;
        let width = usize::from(self.width);
        let bytes = self.values.get(usize::from(row) * width..)?.get(..width)?;
        let mut value: i32 = 0;
        for &byte in bytes {
            value = value << 8 | i32::from(byte);
        }
        let unused = 32 - 8 * u32::from(self.width);
        let value = value << unused >> unused;
        Some(value.wrapping_mul(i32::from(self.scale)))
    }
}
