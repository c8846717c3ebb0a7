//! InterpCNC's command 1000: G-code as text over Modbus, for boards that can stream.
//!
//! A client writes lines into a buffer ([`Texts`]) and reads how much room is left. A thread makes batches of the
//! waiting lines and feeds them to the board as one run, so that motion goes on from line to line. A stop from
//! any source and a fault drop the waiting lines, and nothing more is taken until a client
//! acknowledges: a client that has not noticed must not continue in the middle.

mod host;
mod modes;

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use lang::profile::Profile;
use lang::wire::{self, Control, Direct, Exception, Table, command};
use serde::Deserialize;

pub use host::{Buffers, Hosts};

use super::pdu::{Touch, refusal};
use modes::Modes;

/// Command of InterpCNC for a line of G-code.
const TEXT: u16 = 1000;
/// Registers of lines that may wait; a line takes two more than its text.
const ROOM: u16 = 4096;
/// Input register that shows how many of them are free.
const FREE: u16 = wire::CNC_STATUS + 1;
/// Lines of a batch: few enough that the first of them moves soon.
const BATCH: usize = 100;

/// `[[gcode]]`
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GcodeSetting {
    /// The board that takes G-code.
    pub board: String,
    /// Its machine.
    #[serde(default = "profile")]
    pub profile: String,
}

fn profile() -> String {
    lang::profile::DEFAULT_NAME.to_owned()
}

/// Lines that go together, with what holds before the first.
pub struct Batch {
    text: String,
    /// The program ends with them.
    last: bool,
}

struct State {
    /// Behind the last line that was taken.
    modes: Modes,
    /// Before the first line that waits.
    before: Modes,
    /// Each with the registers that it takes.
    lines: VecDeque<(String, u16)>,
    free: u16,
    /// Nothing is taken until it is acknowledged: why.
    broken: Option<String>,
}

/// The lines that wait for a board.
pub struct Texts {
    profile: Profile,
    state: Mutex<State>,
    came: Condvar,
}

impl State {
    fn forget(&mut self) {
        self.lines.clear();
        self.free = ROOM;
        (self.modes, self.before) = (Modes::default(), Modes::default());
    }
}

/// The registers that a request writes, from its first on.
fn written(pdu: &[u8]) -> Vec<u16> {
    let data = if pdu[0] == 6 { &pdu[3..] } else { pdu.get(6..).unwrap_or_default() };
    data.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect()
}

/// The text of command 1000: its length, then two characters a register, the earlier one below.
fn text_of(words: &[u16]) -> Option<String> {
    let (length, words) = words.split_first()?;
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let text = bytes.get(..usize::from(*length))?;
    let good = *length <= 255 && text.iter().all(|c| c.is_ascii_graphic() || b" \t".contains(c));
    good.then(|| String::from_utf8_lossy(text).trim().to_owned())
}

impl Texts {
    /// Nothing waits for this machine.
    pub fn new(profile: Profile) -> Texts {
        let (modes, before) = (Modes::default(), Modes::default());
        let state = State { modes, before, lines: VecDeque::new(), free: ROOM, broken: None };
        Texts { profile, state: Mutex::new(state), came: Condvar::new() }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The reply to a write that is for the buffer; none for one that goes to the board, which may end
    /// or acknowledge something here, too.
    pub fn write(&self, touch: &Touch, pdu: &[u8]) -> Option<Vec<u8>> {
        if touch.table != Table::Holding {
            return None;
        }
        let words = written(pdu);
        if touch.first == wire::COMMAND && words.first() == Some(&TEXT) {
            return Some(match self.take(&words[1..]) {
                Ok(()) => pdu[..5].to_vec(),
                Err(exception) => refusal(pdu, exception as u8),
            });
        }
        let at =
            |register: u16| words.get(usize::from(register.checked_sub(touch.first)?)).copied();
        let control = at(wire::RUN_CONTROL);
        let direct = match at(wire::COMMAND) {
            Some(command::DIRECT) => at(wire::COMMAND + 1),
            _ => None,
        };
        let is = |own: Option<u16>, code: u16| own == Some(code);
        if is(control, Control::Acknowledge as u16)
            || is(direct, u16::from(Direct::Acknowledge as u8))
        {
            self.state().broken = None;
        } else if touch.is_stop(pdu)
            && !is(control, Control::Pause as u16)
            && !is(direct, u16::from(Direct::Pause as u8))
        {
            self.end("a client stopped it");
        }
        None
    }

    /// Puts the room of the buffer into the reply to a read that shows it.
    pub fn show(&self, touch: &Touch, reply: &mut [u8]) {
        let shows = touch.table == Table::InputRegisters && touch.range().contains(&FREE.into());
        let place = 2 + 2 * usize::from(FREE.wrapping_sub(touch.first));
        if shows
            && reply.first() == Some(&(Table::InputRegisters as u8))
            && let Some(pair) = reply.get_mut(place..place + 2)
        {
            pair.copy_from_slice(&self.state().free.to_be_bytes());
        }
    }

    /// Takes a line.
    fn take(&self, words: &[u16]) -> Result<(), Exception> {
        let text = text_of(words).ok_or(Exception::IllegalValue)?;
        let mut state = self.state();
        if state.broken.is_some() {
            return Err(Exception::DeviceFailure);
        }
        let registers = 2 + words[0] / 2;
        if state.free < registers {
            return Err(Exception::Busy);
        }
        let mut modes = state.modes.clone();
        if modes.over {
            // Behind a program's end the next one begins.
            modes = Modes::default();
        }
        let head = modes.head();
        let line = modes.take(&text).map_err(|_| Exception::IllegalValue)?;
        host::compiled(&format!("{head}{line}\n"), &self.profile)
            .map_err(|_| Exception::IllegalValue)?;
        if state.lines.is_empty() {
            state.before = if state.modes.over { Modes::default() } else { state.modes.clone() };
        }
        state.modes = modes;
        state.lines.push_back((line, registers));
        state.free -= registers;
        self.came.notify_one();
        Ok(())
    }

    /// The next lines, all that wait as far as they go together; none within the time.
    pub fn batch(&self, wait: Duration) -> Option<Batch> {
        let mut state = self.state();
        if state.lines.is_empty() {
            state = self.came.wait_timeout(state, wait).unwrap_or_else(PoisonError::into_inner).0;
        }
        let mut modes = state.before.clone();
        let mut text = modes.head();
        let mut count = 0;
        while count < BATCH
            && !modes.over
            && let Some((line, registers)) = state.lines.pop_front()
        {
            text += &(line.clone() + "\n");
            state.free += registers;
            // Taken before, it is taken again.
            let _ = modes.take(&line);
            count += 1;
        }
        let last = modes.over;
        state.before = if last { Modes::default() } else { modes };
        (count > 0).then_some(Batch { text, last })
    }

    /// Whether a spindle or coolant runs for lines that are still to come.
    pub fn is_busy(&self) -> bool {
        self.state().modes.busy
    }

    /// Forgets what waits and takes nothing more until somebody acknowledges.
    pub fn end(&self, why: &str) {
        let mut state = self.state();
        state.forget();
        state.broken.get_or_insert_with(|| why.to_owned());
    }

    /// Whether it was ended since the last acknowledgement.
    pub fn is_broken(&self) -> bool {
        self.state().broken.is_some()
    }

    /// A run has ended: the next line begins a program of its own.
    pub fn rest(&self) {
        let mut state = self.state();
        if state.lines.is_empty() {
            state.modes = Modes::default();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{ROOM, Texts, text_of};
    use crate::gateway::pdu::Touch;
    use lang::profile::Profile;
    use lang::wire::{self, Exception};
    use std::time::Duration;

    fn write(first: u16, values: &[u16]) -> Vec<u8> {
        let mut pdu = vec![16];
        pdu.extend(first.to_be_bytes());
        pdu.extend((values.len() as u16).to_be_bytes());
        pdu.push(2 * values.len() as u8);
        pdu.extend(values.iter().flat_map(|value| value.to_be_bytes()));
        pdu
    }

    fn line(text: &str) -> Vec<u8> {
        let mut words = vec![1000, text.len() as u16];
        let pairs = text.as_bytes().chunks(2);
        words.extend(pairs.map(|pair| u16::from_le_bytes([pair[0], *pair.get(1).unwrap_or(&0)])));
        write(wire::COMMAND, &words)
    }

    fn send(texts: &Texts, pdu: &[u8]) -> Option<u8> {
        let reply = texts.write(&Touch::of(pdu).expect("good"), pdu)?;
        Some(if reply[0] & 0x80 == 0 { 0 } else { reply[1] })
    }

    #[test]
    fn the_manuals_example_is_read() {
        // InterpCNC, command 1000: registers 2001 on of `G01 X12.2 F3000`.
        let words = [15, 0x3047, 0x2031, 0x3158, 0x2E32, 0x2032, 0x3346, 0x3030, 0x0030];
        assert_eq!(text_of(&words).as_deref(), Some("G01 X12.2 F3000"));
        assert_eq!(text_of(&[4, 0x3047]), None, "more than there is");
    }

    #[test]
    fn lines_wait_in_their_order_with_what_holds_before_them() {
        let texts = Texts::new(Profile::built_in("mill").expect("built in"));
        for text in ["G1 X5 F600", "X10", "G91", "Y2"] {
            assert_eq!(send(&texts, &line(text)), Some(0), "{text}");
        }
        let wrong = ["X", "G81 X1 Z-1 R1", "G1 A5", "hello"];
        for text in wrong {
            let refused = Some(Exception::IllegalValue as u8);
            assert_eq!(send(&texts, &line(text)), refused, "{text}");
        }
        let batch = texts.batch(Duration::ZERO).expect("lines");
        assert_eq!(batch.text, "G21 G90 G17 G64\nG1 X5 F600\nG1 X10\nG91\nG1 Y2\n");
        assert_eq!(send(&texts, &line("X1")), Some(0));
        assert_eq!(send(&texts, &line("M30")), Some(0));
        assert_eq!(send(&texts, &line("G0 X0")), Some(0));
        let batch = texts.batch(Duration::ZERO).expect("lines");
        assert_eq!(batch.text, "G21 G91 G17 G64\nF600\nG1 X1\nM30\n");
        assert!(batch.last);
        let batch = texts.batch(Duration::ZERO).expect("lines");
        assert_eq!((&batch.text[..], batch.last), ("G21 G90 G17 G64\nG0 X0\n", false));
        assert!(texts.batch(Duration::ZERO).is_none());
    }

    #[test]
    fn the_room_is_shown_and_what_is_stopped_stays_so_until_it_is_acknowledged() {
        let texts = Texts::new(Profile::built_in("mill").expect("built in"));
        assert_eq!(send(&texts, &line("G0 X5")), Some(0));
        let read = [4, 0x0B, 0xB8, 0, 5];
        let mut reply = [&[4, 10][..], &[0; 10]].concat();
        texts.show(&Touch::of(&read).expect("good"), &mut reply);
        assert_eq!(reply[4..6], (ROOM - 4).to_be_bytes());
        assert_eq!(send(&texts, &write(wire::COMMAND, &[101, 7])), None, "the board's");
        assert!(texts.batch(Duration::ZERO).is_none());
        assert_eq!(send(&texts, &line("G0 X5")), Some(Exception::DeviceFailure as u8));
        assert_eq!(send(&texts, &write(wire::COMMAND, &[1200, 130])), None, "a pause");
        assert_eq!(send(&texts, &write(wire::COMMAND, &[1200, 88])), None);
        assert_eq!(send(&texts, &line("G0 X5")), Some(0));
        for _ in 0..2 * ROOM {
            if send(&texts, &line("G0 X5")) == Some(Exception::Busy as u8) {
                return;
            }
        }
        panic!("it takes lines without end");
    }
}
