//! Reports of the USB boot loader (SLAU319, "USB BSL"): identifier 3F, length, core command, filled to 64
//! bytes.

/// Bytes of a report with its identifier.
pub const REPORT: usize = 64;
/// Bytes of a password: the last 16 vectors.
pub const PASSWORD: usize = 32;
/// The password of a chip without vectors.
pub const BLANK: [u8; PASSWORD] = [0xFF; PASSWORD];
/// Most bytes of a block that one report carries.
pub const BLOCK: usize = 48;
/// The code of an answer that all is well.
pub const SUCCESS: u8 = 0;

/// One report, either way.
pub type Report = [u8; REPORT];

const ID: u8 = 0x3F;
const FILL: u8 = 0xAC;
const RX_PASSWORD: u8 = 0x11;
const LOAD_PC: u8 = 0x17;
const RX_FAST: u8 = 0x1B;
const MESSAGE: u8 = 0x3B;

fn report(code: u8, address: Option<u32>, data: &[u8]) -> Report {
    let mut report = [FILL; REPORT];
    let place = address.map(u32::to_le_bytes);
    let place = place.as_ref().map_or(&[][..], |bytes| &bytes[..3]);
    let content = [&[code], place, data].concat();
    report[0] = ID;
    report[1] = content.len() as u8;
    report[2..2 + content.len()].copy_from_slice(&content);
    report
}

/// The password. It is answered.
pub fn password(bytes: &[u8; PASSWORD]) -> Report {
    report(RX_PASSWORD, None, bytes)
}

/// A block of at most [`BLOCK`] bytes into RAM. It is not answered.
pub fn block(address: u32, data: &[u8]) -> Report {
    report(RX_FAST, Some(address), data)
}

/// Goes on at an address. It is not answered.
pub fn start(address: u32) -> Report {
    report(LOAD_PC, Some(address), &[])
}

/// What a report of the boot loader says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// How the command went: [`SUCCESS`], or why not.
    Code(u8),
}

/// Reads a report of the boot loader; nothing of what is no answer.
pub fn answer(report: &Report) -> Option<Answer> {
    match report[..] {
        [ID, length, MESSAGE, code, ..] if length >= 2 => Some(Answer::Code(code)),
        _ => None,
    }
}
