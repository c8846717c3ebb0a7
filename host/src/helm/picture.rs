//! A snapshot of the board, read register by register between the requests of users.

use lang::axis::Axis;
use lang::wire;
use serde::Serialize;

use super::Board;
use super::follow::Halt;
use crate::client::ClientError;
use crate::client::aout::AoutUnit;
use crate::client::identity::Identity;
use crate::client::status::{Status, StatusWords, long};

/// Whether there is a board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Port {
    /// It is being opened.
    #[default]
    Opening,
    /// The board answers.
    Up,
    /// The port is gone, or the board does not answer.
    Lost,
}

/// One picture of the board for everybody; its parts are of one round of looks.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Picture {
    /// Whether there is a board.
    pub port: Port,
    /// Why there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lost: Option<String>,
    /// State, fault, machine positions, inputs and outputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub status: Option<Status>,
    /// Work positions, steps.
    pub work: [i32; 3],
    /// Axes that search their switch.
    pub homing: Vec<char>,
    /// Axes whose last reference run failed.
    pub homing_error: Vec<char>,
    /// Axes at the negative end of their travel.
    pub at_low: Vec<char>,
    /// Axes at the positive end.
    pub at_high: Vec<char>,
    /// Override of feeds and of rapid moves, per cent.
    pub overrides: [u16; 2],
    /// Who the board is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub identity: Option<Identity>,
    /// Values of the stored program's cells.
    pub cells: Vec<i32>,
    /// The run is followed effect by effect.
    pub followed: bool,
    /// Where a followed run is halted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub halted: Option<Halt>,
    /// Number of the held jog.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hold: Option<u64>,
}

/// Registers of cells that one look reads: half a request's most, two for each cell.
const CELLS_AT_ONCE: u16 = 8;
/// Every so many rounds what hardly changes is read.
const SELDOM: u32 = 20;

/// The exchanges of a round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Motion,
    Run,
    Work,
    Inputs,
    Outputs,
    Overrides,
    Identity,
    Analog,
    Cells(u16),
    /// Only where F14 may be a line that came too late.
    Late,
}

/// A round of looks at the board, an exchange at a time.
pub struct Round {
    step: Step,
    /// Rounds begun.
    count: u32,
    words: StatusWords,
    next: Picture,
    shift: [Shift; 3],
    /// Of the board's analog output, if it has one.
    unit: Option<AoutUnit>,
}

/// Work position less machine position of an axis. The two are read one after the other, and an axis
/// that moves is elsewhere by then; their difference changes only while it rests. So it is taken where
/// two rounds agree, and added to the machine position of the round.
#[derive(Clone, Copy, Debug, Default)]
struct Shift {
    taken: Option<i32>,
    last: Option<i32>,
}

impl Shift {
    /// The work position that belongs to a machine position.
    fn work(&mut self, machine: i32, work: i32, moves: bool) -> i32 {
        let now = work.wrapping_sub(machine);
        let before = std::mem::replace(&mut self.last, Some(now).filter(|_| !moves));
        if !moves && before == Some(now) || self.taken.is_none() {
            self.taken = Some(now);
        }
        machine.wrapping_add(self.taken.unwrap_or(now))
    }
}

fn letters(bits: u16) -> Vec<char> {
    let on = Axis::ALL.into_iter().filter(|axis| bits >> axis.index() & 1 != 0);
    on.map(Axis::letter).collect()
}

impl Round {
    /// The first one.
    pub fn new() -> Round {
        Round {
            step: Step::Motion,
            count: 0,
            words: StatusWords::default(),
            next: Picture::default(),
            shift: Default::default(),
            unit: None,
        }
    }

    /// Whether no look of the round has been made yet.
    pub fn is_fresh(&self) -> bool {
        self.step == Step::Motion
    }

    /// Begins from the first look again, with everything read.
    pub fn restart(&mut self) {
        (self.step, self.count) = (Step::Motion, 0);
    }

    /// Reads some cells, from `first` on. Returns what comes next; after the last ones everything has been read.
    fn cells(next: &mut Picture, board: &mut Board, first: u16) -> Result<Step, ClientError> {
        let all = next.cells.len() as u16;
        let count = all.saturating_sub(first).min(CELLS_AT_ONCE);
        if count > 0 {
            let words = board.holding(wire::CELLS + 2 * first, 2 * count)?;
            for (pair, cell) in words.chunks_exact(2).zip(&mut next.cells[first.into()..]) {
                *cell = long(pair[0], pair[1]);
            }
        }
        Ok(if first + count < all { Step::Cells(first + count) } else { Step::Late })
    }

    /// Makes the next look. The picture comes with the round's last one.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn look(&mut self, board: &mut Board) -> Result<Option<Picture>, ClientError> {
        let (next, was) = (&mut self.next, self.step);
        self.step = match was {
            // Before the places: what rests then is read where it rests.
            Step::Motion => {
                let words = board.input(wire::MOVING, wire::LIMITS - wire::MOVING + 1)?;
                self.words.moving = words[0];
                (next.homing, next.homing_error) = (letters(words[1]), letters(words[1] >> 8));
                (next.at_low, next.at_high) = (letters(words[2]), letters(words[2] >> 8));
                Step::Run
            }
            Step::Run => {
                self.words.run = board.holding(wire::RUN_STATE, StatusWords::RUN_LENGTH)?;
                Step::Work
            }
            Step::Work => {
                let words = board.input(wire::WORK_POSITIONS, 6)?;
                next.work = [0, 1, 2].map(|n| {
                    let at = usize::from(wire::MACHINE_POSITIONS - wire::RUN_STATE) + 2 * n;
                    let pair = self.words.run.get(at..at + 2);
                    let machine = pair.map_or(0, |pair| long(pair[0], pair[1]));
                    let moves = self.words.moving >> n & 1 != 0;
                    self.shift[n].work(machine, long(words[2 * n], words[2 * n + 1]), moves)
                });
                Step::Inputs
            }
            Step::Inputs => {
                self.words.inputs = board.inputs(wire::INPUT_BITS, 17)?;
                Step::Outputs
            }
            Step::Outputs => {
                self.words.outputs = board.coils(wire::COILS, 16)?;
                if self.count.is_multiple_of(SELDOM) { Step::Overrides } else { Step::Analog }
            }
            Step::Overrides => {
                // A part without an override has no such block.
                next.overrides = match board.holding(wire::OVERRIDES, 2) {
                    Ok(words) => [words[0], words[1]],
                    Err(ClientError::Exception(_)) => [0; 2],
                    Err(error) => return Err(error),
                };
                Step::Identity
            }
            Step::Identity => {
                let (identity, cells) = (board.identity()?, board.program_cells()?);
                next.cells.resize(usize::from(cells), 0);
                next.identity = Some(identity);
                self.unit = board.aout_unit()?;
                Step::Analog
            }
            // Without one there is nothing to read: the exchange is that of the cells.
            Step::Analog if self.unit.is_some() => {
                self.words.aouts = board.aouts(self.unit)?;
                Step::Cells(0)
            }
            Step::Analog => Round::cells(next, board, 0)?,
            Step::Cells(first) => Round::cells(next, board, first)?,
            Step::Late => {
                if let Some(status) = &mut next.status {
                    board.explain_late_line(status)?;
                }
                Step::Motion
            }
        };
        if was != Step::Late && self.step == Step::Late {
            let status = std::mem::take(&mut self.words).status();
            if !status.may_be_late_line() {
                self.step = Step::Motion;
            }
            next.status = Some(status);
        }
        if self.step != Step::Motion {
            return Ok(None);
        }
        self.count = self.count.wrapping_add(1);
        next.port = Port::Up;
        Ok(Some(next.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::Shift;

    #[test]
    fn positions_of_a_moving_axis_are_of_one_moment() {
        let mut own = Shift::default();
        assert_eq!((own.work(0, 500, false), own.work(0, 500, false)), (500, 500));
        // It moves evenly: the work position is read later each time, 30 steps on.
        assert_eq!((own.work(100, 630, true), own.work(200, 730, true)), (600, 700));
        // Zeroed at rest: the second look at the same difference takes it.
        assert_eq!((own.work(300, 0, false), own.work(300, 0, false)), (800, 0));
        // It sets off between the two looks.
        assert_eq!((own.work(300, 7, false), own.work(400, 130, true)), (0, 100));
    }
}
