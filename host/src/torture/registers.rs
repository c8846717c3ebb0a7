//! Registers at any time: after any write, read, button press, power cut or unplugging at any instant the board answers,
//! comes to rest when commanded, has its outputs as a stop requires, and moves no axis without a request.
//!
//! A storm is made of bytes, so that a fuzzer drives it (`host/fuzz`), and runs on the firmware's machine on the desktop
//! and on the emulated board.

use std::sync::OnceLock;

use desk::board::NativeBoard;
use emulator::plant::Contact;
use emulator::{Config, Wiring};
use lang::record::OutputStates;
use lang::wire::{
    CELLS, COMMAND, Control, HOMED, JOG_HOLD, KEEPS, MACHINE_POSITIONS, OUTPUTS, OVERRIDES, OWN,
    POSITIONS, PROFILE_WINDOW, RUN_CONTROL, RUN_STATE, RunState, STREAM_CONTROL, STREAM_MACHINE,
    STREAM_PIECE, TRACE_MODE, UPLOAD_CONTROL, UPLOAD_LENGTH, UPLOAD_WINDOW, Upload, upload_window,
};

use super::power::image;
use super::stand::{Answer, BOOT_US, Fresh, Stand, framed, words};
use super::table::Table;
use super::{DESK, Row, Settings, Sink, Verdict};
use crate::board::F5529;

/// What runs on the board: it moves X, and nothing else does.
const SCRIPT: &str = "KEEP rounds\nDO\nrounds = rounds + 1\nMoveAxe X, 2mm\nSetOut 3, ON\n\
                      Wait 3ms\nG1 X1 F900\nSetOut 3, OFF\nMoveAxe X, 0mm\nIF IN(4) THEN Home? X\nLOOP\n";
/// Where a request may do something.
const PLACES: [u16; 18] = [
    0,
    256,
    1000,
    1030,
    COMMAND,
    OUTPUTS,
    POSITIONS,
    OVERRIDES,
    3000,
    CELLS,
    KEEPS,
    OWN,
    RUN_CONTROL,
    UPLOAD_CONTROL,
    PROFILE_WINDOW,
    UPLOAD_WINDOW,
    STREAM_MACHINE,
    STREAM_PIECE,
];
/// Registers whose writes move an axis or may have that done, and how many.
const MOVERS: [(u16, u16); 6] = [
    (COMMAND, 21),
    (POSITIONS, 12),
    (JOG_HOLD, 1),
    (RUN_CONTROL, 1),
    (STREAM_CONTROL, 4),
    (STREAM_PIECE, 256),
];
/// Longest storm, in acts.
const ACTS: usize = 80;
/// Longest time that a run may take to end once it was stopped, in looks.
const LOOKS: u32 = 400;
const LOOK_US: u64 = 10_000;
/// Steps cease so soon behind an emergency stop, us.
const CEASE_US: u64 = 4_000;
/// A reply to a request of which an erase took a part comes so late at most, us.
const OWED_US: u64 = 400_000;
/// Registers of one write of an upload.
const PIECE: usize = 21;

/// The bytes of a storm; behind their end there are zeros.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        first
    }

    fn word(&mut self) -> u16 {
        u16::from_le_bytes([self.byte(), self.byte()])
    }

    fn of<T: Copy>(&mut self, list: &[T]) -> Option<T> {
        list.get(usize::from(self.byte()) % list.len().max(1)).copied()
    }
}

/// A board in a storm.
struct Storm<'a, B> {
    stand: Stand<B>,
    bytes: Bytes<'a>,
    image: &'a [u8],
    /// Only what moves X is asked for.
    only_x: bool,
    /// Somebody has asked for a run.
    asked: bool,
    /// Power failed in an operation of the flash, or was to: the next one finds a word half written.
    cut: bool,
    /// A reply may still come to a request that was not waited for to its end.
    owed: bool,
}

/// The image of [`SCRIPT`].
fn program() -> Result<&'static [u8], String> {
    static IMAGE: OnceLock<Result<Vec<u8>, String>> = OnceLock::new();
    IMAGE.get_or_init(|| image(SCRIPT)).as_deref().map_err(Clone::clone)
}

/// A board with the program.
fn ready<B: Table>(mut stand: Stand<B>) -> Result<Fresh<B>, String> {
    stand.upload(program()?, true).map_err(|answer| format!("upload: {answer:?}"))?;
    Ok(Fresh::new(stand))
}

/// A storm on the firmware's machine on the desktop: the body of a fuzz target.
///
/// # Errors
/// What did not hold.
pub fn storm(data: &[u8]) -> Result<(), String> {
    static BOARD: OnceLock<Result<(Wiring, Vec<u8>), String>> = OnceLock::new();
    let fresh = BOARD.get_or_init(|| ready(Stand::native()).map(|fresh| fresh.copy().board.kept()));
    let board = NativeBoard::copy_of(fresh.as_ref().map_err(Clone::clone)?);
    try_out(Stand::around(board), data)
}

/// A storm on a board that holds the program.
///
/// # Errors
/// What did not hold.
pub fn try_out<B: Table>(stand: Stand<B>, data: &[u8]) -> Result<(), String> {
    let mut bytes = Bytes(data);
    let only_x = bytes.byte().is_multiple_of(2);
    let mut storm =
        Storm { stand, bytes, image: program()?, only_x, asked: false, cut: false, owed: false };
    let position = -i64::from(storm.bytes.byte()) - 50;
    storm.stand.board.plant_mut().switches[0] = Some(Contact { axis: 0, position, above: false });
    storm.stand.board.run_us(BOOT_US);
    for _ in 0..ACTS {
        if storm.bytes.0.is_empty() {
            break;
        }
        storm.act()?;
        if !storm.stand.board.powered() {
            storm.stand.board.power_up();
        }
    }
    storm.end()
}

impl<B: Table> Storm<'_, B> {
    fn act(&mut self) -> Result<(), String> {
        self.follow_line();
        let kind = self.bytes.byte() % 16;
        if kind <= 5 && std::mem::take(&mut self.owed) {
            self.stand.board.run_us(OWED_US);
        }
        match kind {
            0..=4 => return self.request(),
            5 => {
                let mut frame = self.any_frame();
                let at = usize::from(self.bytes.byte()) % frame.len();
                frame[at] ^= 1 << (self.bytes.byte() & 7);
                if let Answer::Reply(reply) = self.stand.exchange(&frame) {
                    return Err(format!("{frame:02X?} was answered by {reply:02X?}"));
                }
            }
            6 | 7 => {
                (self.asked, self.owed) = (true, true);
                let code = self.bytes.of(Control::ALL).unwrap_or(Control::Start);
                self.stand.control(code);
            }
            8 => {
                self.asked = true;
                let (start, on) = (self.bytes.byte() & 1 == 0, self.bytes.byte() & 1 == 0);
                let mut plant = self.stand.board.plant_mut();
                if start { plant.press_start(on) } else { plant.press_stop(on) }
            }
            9 => {
                let (n, on) = (1 + self.bytes.byte() % 8, self.bytes.byte() & 1 == 0);
                self.stand.board.plant_mut().set_input(n, on);
            }
            10 | 11 => {
                let us = u64::from(self.bytes.byte());
                self.stand.board.run_us(us * us * 8);
            }
            12 => self.upload(),
            13 => self.stand.board.pull_reset(),
            14 => {
                let (n, seed) = (u64::from(self.bytes.byte()), u64::from(self.bytes.byte()));
                self.cut = true;
                self.stand.board.fail_at(n + 1, seed);
            }
            _ => {
                self.stand.board.power_cut();
                self.stand.board.run_us(1_000);
            }
        }
        Ok(())
    }

    /// The host's end of the line has the board's rate, as a client's that looks for it: with Stop held at a reset the board comes
    /// up with another one.
    fn follow_line(&mut self) {
        let format = self.stand.board.uart_format();
        self.stand.board.set_uart_format(format);
    }

    /// A sound frame to this board or to all.
    fn any_frame(&mut self) -> Vec<u8> {
        let address = u8::from(!self.bytes.byte().is_multiple_of(8));
        let function = match self.bytes.byte() {
            own @ 0..16 => own,
            other => [1, 2, 3, 4, 5, 6, 15, 16][usize::from(other & 7)],
        };
        let place = self.bytes.of(&PLACES).unwrap_or_default();
        let place = place.wrapping_add((self.bytes.byte() % 80).into());
        let mut body = vec![address, function];
        body.extend(place.to_be_bytes());
        match function {
            15 | 16 => {
                let count = 1 + self.bytes.byte() % PIECE as u8;
                let bytes = if function == 15 { count.div_ceil(8) } else { 2 * count };
                body.extend([0, count, bytes]);
                body.extend((0..bytes).map(|_| self.bytes.byte()));
            }
            5 => body.extend([if self.bytes.byte() & 1 == 0 { 0xFF } else { 0 }, 0]),
            1..=4 => body.extend([0, 1 + self.bytes.byte() % 40]),
            _ => body.extend(self.bytes.word().to_be_bytes()),
        }
        framed(&body)
    }

    /// Whether a frame may have an axis moved other than by the program, or the program changed.
    fn moves(frame: &[u8]) -> bool {
        let [_, function, high, low, _, count, ..] = *frame else { return false };
        let (first, count) = (u16::from_be_bytes([high, low]), u16::from(count));
        let last = if function == 16 { first.saturating_add(count) } else { first + 1 };
        // The program stays what it is, too.
        let own = first < OWN + 200 && last > OWN && first != TRACE_MODE;
        let moved = MOVERS.iter().any(|&(at, count)| first < at + count && last > at);
        ![1, 2, 3, 4, 5, 15].contains(&function) && (own || moved)
    }

    fn request(&mut self) -> Result<(), String> {
        let frame = self.any_frame();
        if Self::moves(&frame) {
            if self.only_x {
                return Ok(());
            }
            self.asked = true;
        }
        let answer = self.stand.exchange(&frame);
        self.owed = answer == Answer::Silence;
        let good = match &answer {
            // What comes while flash is erased may be lost, and power may fail in it.
            Answer::Silence | Answer::NoPower => true,
            Answer::Reply(reply) => frame[0] == 1 && reply[..2] == frame[..2],
            Answer::Exception(code) => frame[0] == 1 && [1, 2, 3, 4, 6].contains(code),
            // A reply that power cuts off.
            Answer::Noise(_) => !self.stand.board.powered(),
        };
        if good { Ok(()) } else { Err(format!("{frame:02X?} was answered by {answer:02X?}")) }
    }

    /// An upload of the same program that ends somewhere, whatever the board says to it.
    fn upload(&mut self) {
        let control = self.bytes.of(&[Upload::Begin, Upload::Replace]).unwrap_or(Upload::Begin);
        let pieces = usize::from(self.bytes.byte() % 16);
        self.owed = true;
        self.stand.expects(self.image.len());
        self.stand.write(UPLOAD_LENGTH, &[self.image.len() as u16 | 1 << 15]);
        self.stand.write(UPLOAD_CONTROL, &[control as u16]);
        let start = upload_window(self.image.len());
        for (n, piece) in words(self.image).chunks(PIECE).enumerate().take(pieces) {
            self.stand.write(start + (PIECE * n) as u16, piece);
        }
        if self.bytes.byte() & 1 == 0 {
            self.stand.write(UPLOAD_CONTROL, &[Upload::Commit as u16]);
        }
    }

    /// Everything is let go, and the emergency stop pressed: all rests, and all is looked at.
    fn end(mut self) -> Result<(), String> {
        {
            let mut plant = self.stand.board.plant_mut();
            plant.press_stop(false);
            plant.press_start(false);
            (1..=8).for_each(|n| plant.set_input(n, false));
        }
        // No cut comes any more.
        self.stand.board.fail_at(u64::MAX / 2, 0);
        self.stand.board.run_us(2 * BOOT_US);
        self.follow_line();
        if !self.stand.answers() {
            return Err("no answer behind the storm".to_owned());
        }
        let pulses = |stand: &Stand<B>| stand.board.plant().motors.each_ref().map(|own| own.pulses);
        match self.stand.control(Control::EmergencyStop) {
            Answer::Reply(_) => {}
            answer => return Err(format!("an emergency stop was answered by {answer:02X?}")),
        }
        self.stand.board.run_us(CEASE_US);
        let ceased = pulses(&self.stand);
        let mut looks = 0;
        while !self.stand.state().is_some_and(|state| {
            [RunState::Empty, RunState::Ready, RunState::Fault]
                .iter()
                .any(|own| *own as u16 == state)
        }) {
            self.stand.board.run_us(LOOK_US);
            looks += 1;
            if looks > LOOKS {
                return Err(format!("the run does not end: state {:?}", self.stand.state()));
            }
        }
        if self.stand.read(RUN_STATE) == Some(RunState::Fault as u16) {
            let OutputStates { keep, on } = lang::record::BoardRecord::DEFAULT.fault;
            let outputs = self.stand.board.plant().outputs();
            if (outputs ^ on) & !keep != 0 {
                return Err(format!("outputs {outputs:04X} behind an emergency stop"));
            }
            if self.stand.read(HOMED) != Some(0) {
                return Err("places are known behind an emergency stop".to_owned());
            }
        }
        for _ in 0..4 {
            let (n, on) = (1 + self.bytes.byte() % 5, self.bytes.byte() & 1 == 0);
            self.stand.board.plant_mut().set_input(n, on);
            self.stand.board.run_us(8_000);
        }
        let after = pulses(&self.stand);
        if after != ceased {
            return Err(format!("{ceased:?} pulses behind the emergency stop, then {after:?}"));
        }
        if self.only_x && (after[1..] != [0, 0] || !self.asked && after[0] != 0) {
            return Err(format!("{after:?} pulses, asked for a run of X: {}", self.asked));
        }
        for axis in 1..if self.only_x { 3 } else { 1 } {
            let told = self.stand.read_long(MACHINE_POSITIONS + 2 * axis);
            if told != Some(0) {
                return Err(format!("axis {axis} is told to be at {told:?}"));
            }
        }
        // A word that a cut left half written is written once more than the data sheet likes.
        let warning = self.stand.board.warning().filter(|_| !self.cut);
        let plant = self.stand.board.plant();
        let violation = plant.violations().first().map(|own| format!("{own:?}"));
        violation.filter(|_| self.only_x).or(warning).map_or(Ok(()), Err)
    }
}

fn cases<B: Table>(mut row: Row, fresh: &Fresh<B>, settings: &Settings, count: u64) -> Row {
    row.run(settings, count, |n| {
        let mut rng = settings.rng(WHAT, n);
        let length = 20 + rng.below(400);
        let data: Vec<u8> = (0..length).map(|_| rng.bits() as u8).collect();
        match try_out(fresh.copy(), &data) {
            Ok(()) => Verdict::Survived,
            Err(text) => Verdict::Lost(text),
        }
    });
    row
}

const WHAT: &str = "any request, hand, cut, any time";

/// Storms, on the emulated MSP430F5529 and on its machine on the desktop.
///
/// # Errors
/// The shipped firmware is damaged, or the table cannot be written.
pub fn run(settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    if !settings.has_desk() {
        return Ok(());
    }
    let emulated = ready(Stand::new(&F5529, &Config::default())?)?;
    let row = Row::on(&F5529, "registers", WHAT, settings);
    sink(cases(row, &emulated, settings, settings.count(4, 100, 2_000)))?;
    let desk = ready(Stand::native())?;
    let row = Row::of(DESK, "registers", WHAT, settings);
    sink(cases(row, &desk, settings, settings.count(120, 10_000, 500_000)))
}

#[cfg(test)]
mod tests {
    use super::super::stand::{crc, write_body};
    use super::*;

    #[test]
    fn a_board_that_comes_up_with_stop_held_is_asked_at_its_rate() {
        let fresh = ready(Stand::new(&F5529, &Config::default()).expect("a board")).expect("ready");
        // Stop is pressed, power fails and comes back, a register is read.
        try_out(fresh.copy(), &[0, 0, 8, 1, 0, 15, 0, 1, 3, 11]).expect("it answers");
    }

    #[test]
    fn a_frame_that_moves_is_known() {
        type Own = Storm<'static, NativeBoard>;
        let frame = |at, values: &[u16]| framed(&write_body(at, values));
        assert_eq!(crc(&frame(OUTPUTS, &[1])), 0);
        assert!(!Own::moves(&frame(OUTPUTS, &[1])));
        assert!(!Own::moves(&frame(TRACE_MODE, &[1])));
        assert!(Own::moves(&frame(RUN_CONTROL, &[1])));
        assert!(Own::moves(&frame(COMMAND - 1, &[1, 2])));
        assert!(!Own::moves(&frame(COMMAND - 1, &[1])));
    }
}
