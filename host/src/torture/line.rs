//! The line: damaged frames, lost and doubled bytes, other addresses, every function with any
//! payload, two masters, noise, a cable that is pulled. Nothing changes without a sound frame, the
//! board goes on answering, and the client recovers or says what happened.

pub mod cable;
pub mod slave;

use emulator::{Config, Rng};
use lang::record::feature;
use lang::wire::{
    Control, HOMED, MACHINE_POSITIONS, OUTPUTS, OVERRIDES, PROFILE_WINDOW, PROGRAM_CRC, RUN_COUNT,
    RUN_STATE, TRACE_MODE, UPLOAD_LENGTH,
};

use super::power::image;
use super::stand::{Answer, Fresh, Stand, crc, framed, read_body, write_body};
use super::{Row, Settings, Sink, Verdict};
use crate::board::Build;

/// Where a request may do something, and where nothing is.
const PLACES: [u16; 18] = [
    0, 15, 16, 256, 1000, 1350, 2000, 2160, 2400, 2430, 3000, 3004, 4000, 5000, 5050, 5060, 5200,
    8000,
];

/// A frame of 21 registers' write, which every part takes; longer ones may be ignored.
const FRAME: usize = 52;

/// A request of any function with any payload, right CRC; to this board, another or all.
pub fn any_request(rng: &mut Rng) -> Vec<u8> {
    let address = [1, 1, 1, 1, 0, 2, 247][rng.below(7) as usize];
    let function = match rng.below(8) {
        0 => rng.bits() as u8,
        n => [1, 2, 3, 4, 5, 6, 15, 16][n as usize],
    };
    let mut body = vec![address, function];
    let place = match rng.below(4) {
        0 => rng.bits() as u16,
        _ => PLACES[rng.below(18) as usize].wrapping_add(rng.below(90) as u16),
    };
    body.extend(place.to_be_bytes());
    match (function, rng.below(4)) {
        (15 | 16, 1..) => {
            let count = 1 + rng.below(21) as u16;
            let bytes = if function == 15 { count.div_ceil(8) } else { count * 2 };
            body.extend(count.to_be_bytes());
            body.push(bytes as u8);
            body.extend((0..bytes).map(|_| small(rng) as u8));
        }
        (_, 0) => body.extend((0..rng.below(50)).map(|_| rng.bits() as u8)),
        (5, _) => body.extend([if rng.below(2) == 0 { 0xFF } else { 0 }, 0]),
        _ => body.extend(small(rng).to_be_bytes()),
    }
    body.truncate(52);
    framed(&body)
}

/// A number that is often small.
fn small(rng: &mut Rng) -> u16 {
    let bits = rng.bits() as u16;
    if rng.below(3) == 0 { bits } else { bits & 31 }
}

/// What the line makes of a frame: one to three bits wrong, bytes lost, doubled, added.
pub fn damage(rng: &mut Rng, frame: &[u8]) -> Vec<u8> {
    let mut bytes = frame.to_vec();
    for _ in 0..1 + rng.below(3) {
        if bytes.is_empty() {
            break;
        }
        let at = rng.below(bytes.len() as u64) as usize;
        match rng.below(6) {
            0 => drop(bytes.remove(at)),
            1 => bytes.insert(at, bytes[at]),
            2 => bytes.truncate(at),
            3 => bytes.insert(at, rng.bits() as u8),
            _ => bytes[at] ^= 1 << rng.below(8),
        }
    }
    bytes
}

/// Whether a receiver at `address` is to take the bytes for a frame.
pub fn is_sound(bytes: &[u8], address: u8) -> bool {
    bytes.len() >= 4 && crc(bytes) == 0 && [address, 0].contains(&bytes[0])
}

/// What a host can change, as the board tells it.
fn snapshot(stand: &mut Stand) -> Option<Vec<Vec<u8>>> {
    let looks = [
        (OUTPUTS, 1),
        (OVERRIDES, 2),
        (MACHINE_POSITIONS, 6),
        (RUN_STATE, 1),
        (RUN_COUNT, 1),
        (HOMED, 1),
        (TRACE_MODE, 1),
        (UPLOAD_LENGTH, 2),
        (PROGRAM_CRC, 1),
        (PROFILE_WINDOW, 32),
    ];
    let mut all = Vec::new();
    for (first, count) in looks {
        match stand.ask(&read_body(first, count)) {
            Answer::Reply(reply) => all.push(reply),
            // A part may lack the block.
            Answer::Exception(code) => all.push(vec![code]),
            _ => return None,
        }
    }
    Some(all)
}

/// Damaged frames on the emulated wire.
fn damaged(stand: &mut Stand, rng: &mut Rng) -> Result<(), String> {
    let before = snapshot(stand).ok_or("no answer before")?;
    for _ in 0..6 {
        let frame = any_request(rng);
        let mut bytes = damage(rng, &frame);
        if is_sound(&bytes, 1) || bytes.is_empty() {
            bytes = vec![0xFF];
        }
        match stand.exchange(&bytes) {
            Answer::Silence => {}
            answer => return Err(format!("{bytes:02X?} was answered by {answer:02X?}")),
        }
    }
    match snapshot(stand) {
        None => Err("no answer behind damaged frames".to_owned()),
        Some(after) if after != before => Err("damaged frames changed something".to_owned()),
        Some(_) => Ok(()),
    }
}

/// Any sound request on the emulated wire: a sound answer, or none to another's.
fn any(stand: &mut Stand, rng: &mut Rng) -> Result<(), String> {
    for _ in 0..6 {
        let frame = any_request(rng);
        let answer = stand.exchange(&frame);
        let function = frame[1];
        let good = match &answer {
            Answer::Silence => frame[0] != 1 || frame.len() > FRAME,
            Answer::Reply(reply) => frame[0] == 1 && reply[..2] == [1, function],
            Answer::Exception(code) => frame[0] == 1 && [1, 2, 3, 4, 6].contains(code),
            Answer::Noise(_) | Answer::NoPower => false,
        };
        if !good {
            return Err(format!("{frame:02X?} was answered by {answer:02X?}"));
        }
    }
    stand.board.run_us(60_000);
    if stand.answers() { Ok(()) } else { Err("no answer behind sound frames".to_owned()) }
}

/// A second master speaks into the first one's request or its answer. What either does may be lost
/// or done, but the board answers the next request.
fn two_masters(stand: &mut Stand, rng: &mut Rng) -> Result<(), String> {
    let (one, other) = (any_request(rng), any_request(rng));
    let start = stand.board.cycles();
    if rng.below(2) == 0 {
        // Into the request: bytes of both in turn.
        let mut both: Vec<u8> = one.clone();
        let at = rng.below(one.len() as u64) as usize;
        both.splice(at..at, other);
        stand.board.uart_send(&both);
    } else {
        stand.board.uart_send(&one);
        stand.board.uart_send_at(start + stand.ticks(rng.below(12_000)), &other);
    }
    stand.board.run_us(60_000);
    if stand.answers() { Ok(()) } else { Err("no answer behind two masters".to_owned()) }
}

/// A start, and a request right behind it: every byte of the board belongs to a sound frame.
fn start_under_load(stand: &mut Stand, rng: &mut Rng) -> Result<(), String> {
    for _ in 0..10 {
        let start = framed(&write_body(lang::wire::RUN_CONTROL, &[Control::Start as u16]));
        let gone = stand.board.uart_send(&start);
        let other = framed(&read_body(RUN_STATE, 1 + rng.below(20) as u8));
        let later = gone + stand.ticks(1_750 + rng.below(40_000));
        stand.board.uart_take();
        stand.board.uart_send_at(later, &other);
        stand.board.run_until(later + stand.ticks(80_000));
        let bytes: Vec<(u64, u8)> = stand.board.uart_take();
        // Frames are parted by 1750 us (Modbus over serial line V1.02, 2.5.1.1).
        let mut frames: Vec<Vec<u8>> = Vec::new();
        let mut last = 0;
        for (at, byte) in bytes {
            if at > last + stand.ticks(1_750) {
                frames.push(Vec::new());
            }
            last = at;
            frames.last_mut().ok_or("no first frame")?.push(byte);
        }
        if frames.is_empty() || frames.iter().any(|frame| crc(frame) != 0) {
            return Err(format!("answers {frames:02X?}"));
        }
        stand.control(Control::Stop);
        stand.control(Control::Acknowledge);
        stand.board.run_us(20_000);
    }
    Ok(())
}

/// Faults of the line.
///
/// # Errors
/// The shipped firmware is damaged, or the table cannot be written.
pub fn run(settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    slave::run(settings, sink)?;
    settings.builds.iter().try_for_each(|build| on_boards(build, settings, sink))
}

fn on_boards(build: &Build, settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    type Case = fn(&mut Stand, &mut Rng) -> Result<(), String>;
    let keeps = build.part.features & feature::KEEP != 0;
    let programs = [
        image("DO\nSetOut 3, ON\nSetOut 3, OFF\nLOOP")?,
        image(if keeps { "KEEP n\nn = n + 1" } else { "DIM n\nDO\nn = n + 1\nLOOP" })?,
        image("DIM a\na = 1 / a")?,
    ];
    let cases: [(&'static str, Case, [u64; 3]); 4] = [
        ("damaged frames, board", damaged, [8, 300, 2_000]),
        ("any function and payload, board", any, [12, 600, 4_000]),
        ("two masters, board", two_masters, [12, 600, 4_000]),
        ("a start under load, board", start_under_load, [3, 90, 900]),
    ];
    let mut boards = Vec::new();
    for program in &programs {
        let mut stand = Stand::new(build, &Config::default())?;
        stand.upload(program, keeps).map_err(|answer| format!("upload: {answer:?}"))?;
        boards.push(Fresh::new(stand));
    }
    for (fault, case, [short, usual, long]) in cases {
        let mut row = Row::on(build, "line", fault, settings);
        row.run(settings, settings.count(short, usual, long), |n| {
            let mut rng = settings.rng(fault, n);
            let mut stand = boards[n as usize % boards.len()].copy();
            case(&mut stand, &mut rng).map_or_else(Verdict::Lost, |()| Verdict::Survived)
        });
        sink(row)?;
    }
    cable::run(build, settings, sink)
}
