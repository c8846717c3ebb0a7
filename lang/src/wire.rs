//! The Modbus link: registers, bits, codes and the protocols made of them.
//!
//! The board is a Modbus RTU slave (functions 1 to 6, 15, 16, broadcast). Where InterpCNC V3 has a
//! number for a thing that this board has, that number does the same here; what is our own stands
//! in one block, [`OWN`], that functions 3 and 4 read alike. 32-bit values take two registers, low
//! word first, and are of one instant when read in one request. Texts and images are bytes: a
//! register holds two, and the one that comes first on the line (the high byte of a register as
//! Modbus sends it) is the earlier byte of a text; an image word is little endian, so its *low*
//! byte is the earlier byte of the image.
//!
//! A register that does not exist is exception 2. Only gaps between the registers of this firmware's own (from 5000 on) and
//! axes 4 to 6 of InterpCNC's read 0; the G2553, which has one block of InterpCNC's status registers, reads 0 between those, too. A value outside
//! its range is exception 3, a thing that cannot be done now is exception 6 (busy: try after the
//! state has changed), a refused image or profile or a missing program is exception 4.
//!
//! # Run control
//! Write one [`Control`] code to [`RUN_CONTROL`]; poll [`RUN_STATE`] ([`RunState`]). `Start` runs
//! the stored program from its beginning, releases `WaitStart`, resumes a paused run or
//! acknowledges a latched fault, as the button does. After an end [`LAST_END`] says how
//! ([`End`]) and [`FAULT`], [`FAULT_PC`], [`FAULT_LINE`], [`FAULT_INPUT`] why. [`RUN_COUNT`]
//! counts the runs begun, so a host that polls slowly misses none.
//!
//! # Upload
//! 1. Write the image's length in bytes to [`UPLOAD_LENGTH`], plus 8000 hexadecimal when it uses
//!    KEEP: then it must leave room for their values.
//! 2. Write [`Upload::Begin`] to [`UPLOAD_CONTROL`]: erases room beside the old program; exception
//!    4 when both do not fit ([`FREE_BYTES`]). [`Upload::Replace`] gives the old one up. Exception 6
//!    while a program runs or is paused, or while an axis moves. Allow 200 ms for the reply.
//! 3. Write the image in ascending order to [`UPLOAD_WINDOW`]: image byte 2n is the low byte of
//!    register `UPLOAD_WINDOW + n`, and on parts with room for more than 3 KB (F5529) of
//!    `UPLOAD_LARGE + n`, too. An odd image is padded with FF. The same request may be
//!    repeated: a word that already has its value stays; a different value is exception 4, on the F5529 to the next
//!    request, as it writes flash while that arrives.
//! 4. Write [`Upload::Commit`]: checks length, CRC, header and code, then makes the new program the
//!    stored one by its last word. Allow 300 ms, and 60 us for each byte of more than
//!    4 KB. Exception 4: refused, [`UPLOAD_RESULT`] holds the
//!    [`Refusal`], and the old program is still there after `Begin`. A part with a library answers a repeated commit as
//!    the first one; a part without one answers [`Refusal::NotBegun`], and [`PROGRAM_CRC`] tells which program is stored.
//!
//! # Library
//! A part with a library (F5529) holds up to 64 programs of up to 16 characters of name each. [`UPLOAD_NUMBER`] and
//! [`UPLOAD_NAME`] say which one an upload brings: the older version stays whole until the new one is there. Of program n
//! 16 registers from `LIBRARY + 16 (n - 1)` on tell length, CRC, KEEP values, and from the eighth on the name. Writing
//! [`SELECTED`] chooses the one that Start runs; a host that knows of no library replaces that one.
//!
//! # Trace
//! Write 1 to [`TRACE_MODE`]. The program then waits for room instead of losing an event. Event
//! number n (1, 2, ... from each start, modulo 65536) appears in [`TRACE_EVEN`] or [`TRACE_ODD`] by
//! n's parity, [`TRACE_LENGTH`] registers: number, [`TraceKind`] in the low byte and argument in the
//! high byte, pc, value low, value high. Reading a slot says that every event before the one that
//! belongs there was received: so read the odd slot until its number is 1, then the even one until
//! its number is 2, and so on. One request for each event, and a lost reply harms nothing.
//! `pc` is the offset of the statement's effect in the image's code. Move events carry no targets:
//! read [`COMMANDED`] in the same poll; it does not change before the next slot is free.
//! A host that takes no event halts the program before its next effect: steps and breakpoints. The
//! one under way goes on to its end; where it tells more than one event it halts between them. When
//! [`WAITS`] is 1, [`EFFECT_PLACE`] says which effect comes next, and [`OPEN_CALLS`] who called for it
//! ([`entry`](crate::vm::entry)). A run that begins in trace mode waits before its first effect, as if
//! an event 0 stood in the even slot. The host reads the slot of the last event again meanwhile, as trace
//! mode ends 2 s after its reader: when no slot has been read for that long. Stop and an emergency
//! stop wait for no host.
//!
//! A part whose [`TRACE_ROOM`] is not 0 has a queue of so many events, for a host that does not halt the program: write
//! [`TRACE_QUEUED`] to [`TRACE_MODE`]. Then the events that wait stand from `TRACE_QUEUE` on, oldest first,
//! [`TRACE_QUEUE_LENGTH`] registers each: those of a slot and the six of [`COMMANDED`] as they were then. One with
//! number 0 and kind 0 is none. Write the number of the last one that was read to [`TRACE_TAKEN`]; the program waits only
//! while the queue is full. A streamed job has fewer slots beside a queue, so it begins before [`Stream::Open`]: exception 6
//! while a job has them all. While a streamed job runs neither mode can be begun: exception 6, as the client that
//! feeds it does not take the events.
//!
//! # Print
//! [`PRINT_COUNT`] bytes wait, the first is number [`PRINT_TAIL`] modulo 65536, up to 32 of them
//! stand in [`PRINT_TEXT`] on. Write `PRINT_TAIL + n` to [`PRINT_TAIL`] to take n. A line ends with
//! LF. In trace mode a line that finds no room waits for it. Without trace mode it is dropped whole; on
//! a part whose ring is smaller than this window it waits first, but no longer than half a second
//! since something was taken or [`PRINT_COUNT`] was read as 0.
//!
//! # Characters
//! [`CHAR_OUT`]: the last `Send`, low byte the character, high byte a count modulo 256. Write a
//! character 33..=125 to [`CHAR_IN`] for `WaitChar` and `CHARIN`; it reads back until it is taken.
//!
//! # Streaming
//! A board whose [`FEATURES`] have [`feature::STREAM`](crate::record::feature::STREAM) runs a job
//! that is larger than its memory from RAM, in pieces: images of their own without KEEP and statement
//! table. It holds [`STREAM_SLOTS`] of them; the stored program stays untouched.
//! 1. Write [`Stream::Open`] to [`STREAM_CONTROL`] (exception 6 while a program runs or an axis
//!    moves), then the axes' part of the profile to [`STREAM_MACHINE`].
//! 2. Write the pieces one after the other to [`STREAM_PIECE`], each in ascending order and at most
//!    [`STREAM_REQUEST`] registers at a time: its header, then at once its code and data; the axes'
//!    part of the profile stays out. The profile hash in the header is the piece's number, from 0,
//!    modulo 65536. The piece's last word has it checked; exception 4: refused, [`STREAM_RESULT`]
//!    says why. Exception 6: no slot is free, try again. After a lost reply [`STREAM_ACCEPTED`]
//!    tells whether the piece is there.
//! 3. Write [`Stream::Run`] when the first pieces are there, and [`Stream::Finish`] when the last
//!    one is: then the run ends after it, otherwise it waits for the next ([`STREAM_DRY`]). A further
//!    piece takes [`Stream::Finish`] back: of several clients only the one that feeds knows the last one.
//!
//! Run control holds as for a stored program. The cells of the piece that ended last can be read
//! while the run waits. The run ends with F18 two seconds after the host that feeds
//! it has last done so, by a write to the registers of streaming or by a read that begins at [`STREAM_CALL`] or from
//! [`STREAM_ACCEPTED`] to [`STREAM_RESULT`]: requests of others do not keep it alive.
//!
//! Handlers are the host's: it follows the program's control flow. A piece with feature `EVENTS` may
//! hold ON lines and has their table (its targets mean nothing); `onerror` and `onerrorstop` say that
//! faults have a handler or none. What they arm outlives the piece. When an event is to be served, or a
//! fault to be handled, the board has begun the handler (no event is served, and without F): it
//! forgets the pieces that wait, shows the place in [`STREAM_CALL`] and takes no piece but one whose
//! header has the KEEP cell 1 (byte 17), numbered [`STREAM_BEGUN`]: exception 6 for others and for
//! [`Stream::Finish`]. Motion goes on as after a stored program's handler. `resumenext` in a piece
//! leaves the newest handler, and a wait that an event interrupted goes on to its end before what
//! stands after it; `leave` leaves all of them, and the wait.
//!
//! # Board profile
//! 32 registers at [`PROFILE_WINDOW`] hold the record of [`record`](crate::record). Read them; write
//! all 32 in ascending order, register 0 one more than it was, register 31 the CRC of the 62 bytes
//! before. The last one makes the record valid (exception 4 if the CRC differs: the old record
//! holds); it takes effect at the next reset ([`Control::Restart`]). Exception 6 while a program
//! runs.
//!
//! On parts with more to say, the 19 registers at [`PROFILE_MORE`] hold what belongs to the record
//! ([`MoreRecord`](crate::record::MoreRecord)). They are written before the last word of the record, whose
//! register 30 is their CRC, or 0 where there is nothing; then they need not be written.
//!
//! # Two lines
//! A board with an RS-485 line beside the back channel answers on both. The one that wrote last holds the helm for 2 s
//! after its last write ([`HELM`]): writes of the other one are exception 6 meanwhile, but for the codes of
//! [`RUN_CONTROL`] that stop, pause or stop at once. Only its requests count where motion goes on no longer than a host asks.
//!
//! # Axes
//! Commands 1110 and 1111 move axes by the axes' part of the profile in the stored program. On the F5529 the registers from
//! [`STREAM_MACHINE`] on tell it, byte 2n as the low byte of register n ([`MachineRecord`](crate::record::MachineRecord)), 0
//! without a program; on the G2553 [`PROGRAM_PROFILE`] alone tells it from others.
//!
//! # Lock
//! A board profile with a lock code ([`BoardRecord::lock`](crate::record::BoardRecord::lock)) locks
//! program and profile at the next reset: uploads, erasing and profile writes are exception 4, and
//! the profile's registers, [`PROFILE_HASH`] too, read 0; a program is never read back. Then the two
//! registers of the profile at [`LOCK_CODE`] take the code, in one request or one after the other:
//! the second one opens the lock until the next reset, or is exception 4. After a wrong code every
//! other one is wrong too until the next reset. Exception 6 while a program runs.

mod codes;
pub mod command;
mod registers;

#[cfg(any(test, feature = "compiler"))]
pub use codes::Codes;
pub use codes::{
    Called, Control, Direct, End, Exception, Refusal, RunState, Seen, Stream, TraceKind, Upload,
};

/// Version of this page; the host compares it first.
pub const WIRE_VERSION: u16 = 1;

/// CRC-16 of Modbus (polynomial A001 reflected, start FFFF), one byte more. Also the CRC of images,
/// profiles and KEEP records.
pub const fn crc16(crc: u16, byte: u8) -> u16 {
    let mut crc = crc ^ byte as u16;
    let mut bit = 0;
    while bit < 8 {
        crc = if crc & 1 != 0 { crc >> 1 ^ 0xA001 } else { crc >> 1 };
        bit += 1;
    }
    crc
}

/// The CRC before a byte was added to it that made it `crc`: [`crc16`] undone.
pub const fn crc16_back(mut crc: u16, byte: u8) -> u16 {
    let mut bit = 0;
    while bit < 8 {
        crc = if crc & 0x8000 == 0 { crc << 1 } else { (crc ^ 0xA001) << 1 | 1 };
        bit += 1;
    }
    crc ^ byte as u16
}

/// Start value of [`crc16`].
pub const CRC_START: u16 = 0xFFFF;

/// Which of Modbus' four tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Table {
    /// Coils, functions 1, 5, 15.
    Coils = 1,
    /// Discrete inputs, function 2.
    Inputs = 2,
    /// Holding registers, functions 3, 6, 16.
    Holding = 3,
    /// Input registers, function 4.
    InputRegisters = 4,
}

/// A range of addresses that a request may lie in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// The table as its reading function's number ([`Table`]).
    pub table: u8,
    /// Bit 0: writable. Bit 1: pairs of registers are 32-bit values when written.
    pub flags: u8,
    /// First address.
    pub first: u16,
    /// How many.
    pub count: u16,
}

/// [`Block::flags`]: functions 5, 6, 15, 16 may write it.
pub const WRITABLE: u8 = 1;
/// [`Block::flags`]: pairs are 32-bit values; function 6 on a low register writes its value
/// sign-extended, on a high one is exception 3, function 16 brings both halves.
pub const LONG: u8 = 2;

macro_rules! map {
    (
        blocks { $($block:ident: $table:ident $first:literal + $count:literal, $flags:expr;)* }
        registers { $($(#[doc = $doc:literal])+ $name:ident: $in:ident + $offset:literal;)* }
    ) => {
        $(
            #[doc = concat!("First address of its block in table ", stringify!($table), ".")]
            pub const $block: u16 = $first;
        )*
        /// Every block of addresses.
        pub const BLOCKS: &[Block] = &[$(
            Block { table: Table::$table as u8, flags: $flags, first: $first, count: $count },
        )*];
        $($(#[doc = $doc])+ pub const $name: u16 = $in + $offset;)*
        /// Name, address and meaning of every register and bit group, for documents.
        #[cfg(any(test, feature = "compiler"))]
        pub const NAMES: &[(&str, u16, &str)] = &[$((stringify!($name), $name, concat!($($doc),+)),)*];
    };
}

crate::register_rows!(map);

/// Registers of the profile window that hold the lock code, and take it.
pub const LOCK_CODE: u16 =
    PROFILE_WINDOW + core::mem::offset_of!(crate::record::BoardRecord, lock) as u16 / 2;

/// What commands move goes on for so long behind a write of [`JOG_HOLD`], ms.
pub const JOG_HOLD_MS: u16 = 300;

/// Written to [`JOG_HOLD`]: the time begins anew only while it runs, else exception 6.
pub const JOG_GOES_ON: u16 = 2;

/// Registers of a program in [`LIBRARY`]: its length in bytes, 0 for none, its CRC, its KEEP values, and from
/// [`LIBRARY_NAME`] on its name.
pub const LIBRARY_ENTRY: u16 = 16;
/// See [`LIBRARY_ENTRY`].
pub const LIBRARY_NAME: u16 = 8;

/// First register of the window that takes an image of so many bytes.
pub const fn upload_window(length: usize) -> u16 {
    // 1536 registers.
    if length > 3072 { UPLOAD_LARGE } else { UPLOAD_WINDOW }
}

/// How long a board's reply to [`Upload::Commit`], and to a [`Control::Start`] that begins a run, may take: it checks
/// an image of so many bytes, ms.
pub const fn check_ms(length: usize) -> u64 {
    300 + length.saturating_sub(4096) as u64 * 60 / 1000
}
/// The line that wrote last holds the helm for so long, ms.
pub const HELM_MS: u16 = 2000;

/// Registers of a trace slot.
pub const TRACE_LENGTH: u16 = 5;

/// Registers of an event in the queue.
pub const TRACE_QUEUE_LENGTH: u16 = TRACE_LENGTH + 6;
/// [`BLOCKING_INPUT`] of an MSP430F5529 that no profile has told how it is wired: it drives no pin of the machine, reads
/// none, and starts and moves nothing.
pub const UNWIRED: u16 = 255;

/// [`TRACE_MODE`] with a queue.
pub const TRACE_QUEUED: u16 = 2;

/// [`TraceKind::Aout`]'s argument: the value is one of steps of a share, not mV.
pub const TRACE_SHARE: u8 = 1 << 6;
/// [`TraceKind`] arguments: the outcome was good.
pub const TRACE_OK: u8 = 0x80;

#[cfg(test)]
mod tests {
    use super::{BLOCKS, CRC_START, NAMES, crc16, crc16_back};

    #[test]
    fn crc_matches_the_modbus_standards_example() {
        // Modbus over serial line V1.02, 6.2.2: frame 02 07 has CRC 41 12, low byte first.
        let crc = [0x02, 0x07].into_iter().fold(CRC_START, crc16);
        assert_eq!(crc, 0x1241);
    }

    #[test]
    fn a_crc_goes_back_the_way_it_came() {
        for crc in (0..=0xFFFF).step_by(7) {
            for byte in [0, 1, 0x55, 0x80, 0xFF] {
                assert_eq!(crc16_back(crc16(crc, byte), byte), crc);
            }
        }
    }

    #[test]
    fn blocks_of_one_table_do_not_overlap() {
        for (i, a) in BLOCKS.iter().enumerate() {
            for b in &BLOCKS[i + 1..] {
                assert!(
                    a.table != b.table
                        || a.first + a.count <= b.first
                        || b.first + b.count <= a.first,
                    "{a:?} and {b:?}"
                );
            }
        }
    }

    #[test]
    fn every_named_register_lies_in_a_block() {
        for (name, address, _) in NAMES {
            assert!(
                BLOCKS.iter().any(|b| (b.first..b.first + b.count).contains(address)),
                "{name} at {address}"
            );
        }
    }
}
