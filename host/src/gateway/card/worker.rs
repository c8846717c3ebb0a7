//! Executes a client's lines, one after the other, and answers each.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use import::card::{Card, Line, Order};
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::image::crc_in;
use lang::wire::{self, Control, RunState};

use super::drive::{Drive, Look};
use super::setting::CardSetting;
use super::stopper::{Answer, NOT_NOW};
use super::talk::{Heard, Said, Talk, Visit};

/// Longest wait for a line, between two looks whether the gateway ends.
const WAIT: Duration = Duration::from_millis(100);
/// Between two looks at a stored program that runs.
const LOOK: Duration = Duration::from_millis(15);
/// What the card's memory shows of outputs 1 to 8 and 9 to 16, and of inputs 1 to 8 (binder).
const PORTS: [i64; 3] = [65_529, 65_530, 65_531];
/// A program that does nothing: by the machine in it the board draws lines.
const NOTHING: &str = "END\n";

/// See the module.
pub struct Worker {
    talk: Arc<Talk>,
    card: Card,
    dialect: import::card::Dialect,
    drive: Drive,
    board: String,
    /// The board has this card's machine, as far as is known.
    fits: bool,
    /// CRC of the program that this card stored.
    stored: Option<u16>,
    /// It has not begun yet: an error of what ran before it is no longer this one's.
    renewed: bool,
}

impl Worker {
    /// A card that was just switched on.
    pub fn new(setting: &CardSetting, talk: Arc<Talk>, drive: Drive) -> Worker {
        let dialect = setting.dialect.into();
        let (card, board) = (Card::new(dialect), setting.board.clone());
        Worker { talk, card, dialect, drive, board, fits: false, stored: None, renewed: false }
    }

    /// Works until the gateway ends.
    pub fn run(&mut self, over: &AtomicBool) {
        // While nobody waits for it yet; what is wrong is said again to who comes.
        let _ = self.fit();
        while !over.load(Ordering::SeqCst) {
            let Some(Heard { visit, stops, said }) = self.talk.next(WAIT) else { continue };
            match said {
                Said::Reset => self.reset(),
                Said::Refused(answer) => self.talk.answer(visit, answer, ""),
                Said::Line(text) => self.line(stops, visit, &text, over),
            }
        }
    }

    fn reset(&mut self) {
        self.card = Card::new(self.dialect);
        (self.fits, self.stored, self.drive.speeds) = (false, None, [None; 3]);
        self.renewed = false;
    }

    fn line(&mut self, stops: u64, visit: Visit, text: &str, over: &AtomicBool) {
        let Some(read) = self.card.line(text) else { return };
        let line = match read {
            Ok(line) => line,
            Err(answer) => return self.talk.answer(visit, answer, ""),
        };
        if line.at_once {
            self.talk.answer(visit, '0', "");
        }
        let done = self.carry_out(stops, visit, &line, over);
        if line.at_once {
            return;
        }
        match done {
            Ok(more) => self.talk.answer(visit, '0', &more),
            // "Not the error of the stop, but ok" (binder, "Arrêt du logiciel").
            Err('F') if self.drive.stopper().was_software(stops) => {
                self.talk.answer(visit, '0', "")
            }
            Err(answer) => self.talk.answer(visit, answer, ""),
        }
    }

    /// Does what a line asks for; what stands behind the `0`, or another answer.
    fn carry_out(
        &mut self,
        stops: u64,
        visit: Visit,
        line: &Line,
        over: &AtomicBool,
    ) -> Result<String, Answer> {
        let moves =
            matches!(line.order, Order::Move { .. } | Order::Home(_) | Order::Outputs { .. });
        if moves && !self.fits {
            self.fit()?;
        }
        match &line.order {
            Order::Nothing | Order::Version | Order::Quit => {}
            Order::Axes => {
                self.stored = None;
                self.fit()?;
            }
            Order::Move { absolute, phases } => {
                for phase in phases {
                    self.drive.phase(stops, phase, *absolute)?;
                }
            }
            Order::Home(axes) => {
                self.drive.home(stops, axes)?;
                axes.iter().for_each(|axis| self.card.set_zero(*axis, 0));
            }
            Order::Zero(axes) => {
                let look = self.drive.look()?;
                for axis in axes {
                    self.card.set_zero(*axis, look.steps[axis.index()].into());
                }
            }
            Order::Outputs { first, value } => self.drive.outputs(stops, *first, *value)?,
            Order::Speeds(speeds) => self.drive.speeds = *speeds,
            Order::Stored => self.store()?,
            Order::Start => self.start(stops, visit, over)?,
            Order::Position => return Ok(position(&self.drive.look()?)),
            Order::Peek(address) => return Ok(format!("{:02X}", self.peek(*address)?)),
            Order::Handshake(on) => self.talk.set_handshake(*on),
        }
        Ok(String::new())
    }

    /// Looks whether the board is the machine that the card is for; an empty one gets a program that
    /// does nothing, by whose machine it draws lines.
    fn fit(&mut self) -> Result<(), Answer> {
        self.fits = false;
        match self.drive.must_fit() {
            Ok(true) => {}
            Ok(false) => self.upload(NOTHING).map(drop)?,
            Err(why) => {
                eprintln!("pasapas: the card of {}: {why}", self.board);
                return Err('4');
            }
        }
        self.fits = true;
        Ok(())
    }

    /// Compiles the stored instructions and brings them to the board.
    fn store(&mut self) -> Result<(), Answer> {
        self.stored = None;
        let text = self.card.program().ok_or(NOT_NOW)?;
        let options = import::Options {
            from: Some(import::Format::Isel),
            profile: Some(self.drive.profile.clone()),
            ..import::Options::default()
        };
        let script = import::import("card", text.as_bytes(), &options).map_err(|notes| {
            for note in notes.iter().filter(|note| note.severity == import::Severity::Error) {
                eprintln!("pasapas: the card of {}: {}", self.board, note.text);
            }
            NOT_NOW
        })?;
        self.fits = false;
        self.stored = Some(self.upload(&script.script)?);
        self.renewed = true;
        self.fits = true;
        Ok(())
    }

    /// Brings a script to the board; its program's CRC comes back.
    fn upload(&self, script: &str) -> Result<u16, Answer> {
        let source = Source::new("card", script.to_owned());
        let choice = ProfileChoice::Given(Box::new(self.drive.profile.clone()));
        let (program, _) = compile(&source, choice);
        let image = lang::back::compile(&program.ok_or(NOT_NOW)?).map_err(|_| '6')?.image;
        let mut client = self.drive.client().ok_or('F')?;
        let there = client.identity().map_err(|_| 'F')?;
        let crc = crc_in(&image);
        // The flash is spared where the same is there already.
        if (usize::from(there.program_bytes), there.program_crc) == (image.len(), crc) {
            return Ok(crc);
        }
        client.bring(&image, (None, "memory"), true, &mut |_| ()).map_err(|error| {
            use crate::client::upload::UploadError;
            eprintln!("pasapas: the card of {}: {error}", self.board);
            match error {
                UploadError::TooLong { .. } | UploadError::Lacks(..) => '6',
                UploadError::Busy => NOT_NOW,
                _ => 'F',
            }
        })?;
        Ok(crc)
    }

    /// Runs the stored program to its end; halted, it waits for `S`, `Q` or the Start button.
    fn start(&mut self, stops: u64, visit: Visit, over: &AtomicBool) -> Result<(), Answer> {
        let stored = self.stored.ok_or(NOT_NOW)?;
        let mut client = self.drive.client().ok_or('F')?;
        let there = client.holding(wire::PROGRAM_CRC, 1).map_err(|_| 'F')?[0];
        let before = self.drive.look()?;
        let idle = matches!(before.state, Some(RunState::Ready | RunState::Fault));
        if there != stored || !idle {
            return Err(NOT_NOW);
        }
        if before.state == Some(RunState::Fault) {
            // The remedy of a limit is a program with a reference run in it (binder, error 2).
            if !self.renewed {
                return Err(Drive::answer_of_fault(&before));
            }
            self.drive.clear(stops, &before)?;
        }
        self.renewed = false;
        let mut sent = self.drive.characters()?[0];
        self.drive.control(stops, Control::Start)?;
        self.talk.set_runs(true);
        let ended = self.follow(visit, before.runs, &mut sent, over);
        self.talk.set_runs(false);
        Drive::answer_of_end(&ended?)
    }

    /// Follows a run to its end: what it sends goes to the client, what the client sends to it.
    fn follow(
        &mut self,
        visit: Visit,
        runs: u16,
        sent: &mut u16,
        over: &AtomicBool,
    ) -> Result<Look, Answer> {
        let (mut halted, mut misses) = (false, 0);
        while !over.load(Ordering::SeqCst) {
            std::thread::sleep(LOOK);
            let Ok(look) = self.drive.look() else {
                misses += 1;
                if misses > 200 {
                    return Err('F');
                }
                continue;
            };
            misses = 0;
            let [out, waits] = self.drive.characters()?;
            if out != *sent {
                *sent = out;
                self.talk.send(out as u8);
            }
            let idle =
                matches!(look.state, Some(RunState::Ready | RunState::Empty | RunState::Fault));
            if idle && look.runs != runs {
                return Ok(look);
            }
            if waits == 0
                && let Some(character) = self.talk.character()
            {
                self.drive.give(character);
            }
            let paused = look.state == Some(RunState::Paused);
            if paused && !halted {
                // "An F may come at any time" (binder, error F).
                self.talk.answer(visit, 'F', "");
            }
            halted = paused;
            if halted {
                self.halted(&look);
            }
        }
        Err('F')
    }

    /// What a client may ask of a run that is halted.
    fn halted(&mut self, look: &Look) {
        let Some(Heard { visit, stops, said }) = self.talk.next(Duration::ZERO) else { return };
        let text = match said {
            Said::Line(text) => text,
            Said::Refused(answer) => return self.talk.answer(visit, answer, ""),
            Said::Reset => return self.reset(),
        };
        let Some(read) = self.card.line(&text) else { return };
        let done = read.and_then(|line| match line.order {
            // Its answer is that of the run's end.
            Order::Start => self.drive.control(stops, Control::Resume).map(|()| None),
            Order::Quit => self.drive.control(stops, Control::Stop).map(|()| Some(String::new())),
            Order::Position => Ok(Some(position(look))),
            _ => Err(NOT_NOW),
        });
        match done {
            Ok(None) => {}
            Ok(Some(more)) => self.talk.answer(visit, '0', &more),
            Err(answer) => self.talk.answer(visit, answer, ""),
        }
    }

    fn peek(&self, address: i64) -> Result<u8, Answer> {
        let newer = self.dialect == import::card::Dialect::Newer;
        match address {
            0 if newer => self.drive.port(false, 0),
            a if a == PORTS[0] => self.drive.port(true, 0),
            a if a == PORTS[1] => self.drive.port(true, 8),
            a if a == PORTS[2] => self.drive.port(false, 0),
            // The rest of a card's memory is not here.
            _ => Err('1'),
        }
    }
}

/// Positions of all axes: six hexadecimal digits each, negative ones as complements.
fn position(look: &Look) -> String {
    look.steps.iter().map(|steps| format!("{:06X}", steps & 0xFF_FFFF)).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn positions_are_those_of_the_binders_example() {
        let digits: String =
            [16, 8192, -2].iter().map(|steps: &i32| format!("{:06X}", steps & 0xFF_FFFF)).collect();
        assert_eq!(digits, "000010002000FFFFFE");
    }
}
