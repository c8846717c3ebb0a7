//! Keeps a board supplied with pieces until the job is over.

use std::collections::VecDeque;
use std::fmt;
use std::time::Duration;

use lang::fault::Fault;
use lang::wire::{Control, End, RunState, Stream};

use super::feed::Job;
use super::piece::Piece;
use crate::client::stream::{Slots, Standing};
use crate::client::{Client, ClientError, Patience};
use crate::link::Link;

/// How often the board is asked how it stands while its slots are full.
const POLL: Duration = Duration::from_millis(20);
/// Rest between two stretches of a program that only computes.
const THINK: Duration = Duration::from_micros(50);
/// How often at least.
const LOOK: Duration = Duration::from_millis(200);
/// The board takes 10 ms for a reply and halts after 2 s without a request.
const PATIENCE: Patience = Patience { reply: Duration::from_millis(150), attempts: 10 };
/// Pieces whose places are remembered: those in the board and the one that ended last.
const REMEMBERED: usize = 16;

/// Where a job stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Progress {
    /// What the board does.
    pub state: Option<RunState>,
    /// The line that runs.
    pub line: u32,
    /// Statements of the machine that were begun.
    pub count: u64,
    /// The KEEP values there.
    pub keeps: Vec<i32>,
}

/// How a job ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// How.
    pub end: End,
    /// Why, at a fault.
    pub fault: Option<Fault>,
    /// Where.
    pub line: u32,
    /// Statements of the machine.
    pub count: u64,
    /// Pieces that were sent.
    pub pieces: u64,
    /// How often motion stood because no piece was there, waits for an answer not counted.
    pub starved: u16,
    /// From the first piece's start to the end.
    pub time: Duration,
    /// The KEEP values there.
    pub keeps: Vec<i32>,
}

/// Why a job could not be brought to an end.
#[derive(Debug)]
pub enum PumpError {
    /// The link failed while this line ran.
    Link(ClientError, u32),
    /// The board refused a piece.
    Refused(Option<lang::wire::Refusal>),
    /// Something keeps it from starting.
    Busy,
}

impl fmt::Display for PumpError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PumpError::Link(error, line) => write!(
                f,
                "{error}; the board ramps down two seconds after the last request and switches its \
                 outputs off (F18); line {line} ran last: bring the tool there and go on with \
                 --from-line {line}"
            ),
            PumpError::Refused(refusal) => write!(
                f,
                "the board refused a piece of the job ({refusal:?}); `pasapas flash` brings it this \
                 tool's firmware"
            ),
            PumpError::Busy => f.write_str(
                "the board does not start: Stop, a door or a hold input is active, a program runs, \
                 or a fault is latched (`pasapas status` tells, `pasapas start` acknowledges)",
            ),
        }
    }
}

impl std::error::Error for PumpError {}

/// Told how the job stands, at least five times a second; answers with what the user wants.
pub type Watcher<'a> = &'a mut dyn FnMut(&Progress) -> Option<Control>;
/// Takes what the job prints.
pub type Printer<'a> = &'a mut dyn FnMut(&[u8]);

struct Pump<'a, 'j, L: Link> {
    client: &'a mut Client<L>,
    job: &'a mut Job<'j>,
    slots: Slots,
    /// Pieces sent, with their places.
    sent: VecDeque<(u16, Piece)>,
    number: u16,
    pieces: u64,
    /// A piece that waits for a slot.
    pending: Option<Piece>,
    /// The newest piece asks.
    asked: bool,
    /// The job goes on behind an answer.
    answered: bool,
    running: bool,
    finished: bool,
    standing: Standing,
    line: u32,
    count: u64,
    /// Starvation that was a wait for an answer.
    excused: u16,
}

/// Runs a job on a board that can stream.
///
/// # Errors
/// See [`PumpError`].
pub fn run<L: Link>(
    client: &mut Client<L>,
    job: &mut Job<'_>,
    slots: Slots,
    watcher: Watcher<'_>,
    printer: Printer<'_>,
) -> Result<Outcome, PumpError> {
    let usual = client.set_patience(PATIENCE);
    let result = Pump::open(client, job, slots).and_then(|mut pump| pump.run(watcher, printer));
    client.set_patience(usual);
    result
}

impl<'a, 'j, L: Link> Pump<'a, 'j, L> {
    fn open(
        client: &'a mut Client<L>,
        job: &'a mut Job<'j>,
        slots: Slots,
    ) -> Result<Pump<'a, 'j, L>, PumpError> {
        let busy = |error: ClientError| match error.is_exception(lang::wire::Exception::Busy) {
            true => PumpError::Busy,
            false => PumpError::Link(error, 1),
        };
        client.stream_open(&slots, job.machine()).map_err(busy)?;
        let standing = client.stream_standing().map_err(busy)?;
        Ok(Pump {
            client,
            job,
            slots,
            sent: VecDeque::new(),
            number: 0,
            pieces: 0,
            pending: None,
            asked: false,
            answered: false,
            running: false,
            finished: false,
            standing,
            line: 1,
            count: 0,
            excused: 0,
        })
    }

    fn link(&self) -> impl Fn(ClientError) -> PumpError + use<L> {
        let line = self.line;
        move |error| PumpError::Link(error, line)
    }

    fn run(&mut self, watcher: Watcher<'_>, printer: Printer<'_>) -> Result<Outcome, PumpError> {
        let runs = self.standing.runs;
        let mut begun_at = self.client.link().now();
        let mut looked_at = begun_at;
        loop {
            self.fill()?;
            let full = self.pending.is_some() || self.asked || self.job.over().is_some();
            if !self.running && full {
                self.start()?;
                begun_at = self.client.link().now();
            }
            let over = self.job.over().is_some() && self.pending.is_none();
            if over && self.running && !self.finished {
                self.client.stream_control(Stream::Finish).map_err(self.link())?;
                self.finished = true;
            }
            if !full && self.client.link().now().saturating_sub(looked_at) < LOOK {
                if self.pending.is_none() {
                    self.client.link().pause(THINK);
                }
                continue;
            }
            if full {
                self.client.link().pause(POLL);
            }
            looked_at = self.client.link().now();
            self.look()?;
            if self.standing.runs != runs
                && matches!(
                    self.standing.state,
                    Some(RunState::Ready | RunState::Empty | RunState::Fault)
                )
            {
                if self.job.prints {
                    self.print(printer)?;
                }
                return Ok(self.outcome(begun_at));
            }
            if self.asked && self.standing.dry && self.standing.begun == self.number {
                let value = self.client.stream_answer().map_err(self.link())?;
                self.job.answer(value);
                self.asked = false;
                self.answered = true;
            }
            if self.job.prints {
                self.print(printer)?;
            }
            let progress = Progress {
                state: self.standing.state,
                line: self.line,
                count: self.count,
                keeps: self.job.keeps(Some(self.count)),
            };
            if let Some(control) = watcher(&progress) {
                if control == Control::Stop && !self.running {
                    // The job computes and has not come to the machine yet.
                    let (line, pieces) = (self.line, self.pieces);
                    let time = Duration::ZERO;
                    let end = End::Stopped;
                    return Ok(Outcome {
                        end,
                        fault: None,
                        line,
                        count: 0,
                        pieces,
                        starved: 0,
                        time,
                        keeps: self.job.keeps(Some(0)),
                    });
                }
                // Only Start means another thing the second time.
                match control {
                    Control::Start => self.client.control(control),
                    _ => self.client.write(lang::wire::RUN_CONTROL, control as u16),
                }
                .map_err(self.link())?;
            }
        }
    }

    /// Sends pieces while there is one and a slot for it.
    fn fill(&mut self) -> Result<(), PumpError> {
        if self.pending.is_none() && !self.asked {
            self.pending = self.job.piece();
        }
        let most = if self.running { self.slots.count - 1 } else { self.slots.count };
        let waiting = self.number.wrapping_sub(self.standing.begun);
        let Some(piece) = self.pending.take() else { return Ok(()) };
        if waiting >= most {
            self.pending = Some(piece);
            return Ok(());
        }
        match self.client.stream_piece(&self.slots, self.number, &piece.bytes) {
            Ok(true) => {
                self.asked = piece.asks;
                // The axes rested for the answer, not for want of a piece.
                self.excused += u16::from(std::mem::take(&mut self.answered));
                self.sent.push_back((self.number, piece));
                if self.sent.len() > REMEMBERED {
                    self.sent.pop_front();
                }
                self.number = self.number.wrapping_add(1);
                self.pieces += 1;
                Ok(())
            }
            Ok(false) => {
                self.pending = Some(piece);
                self.look()
            }
            Err(error) if error.is_exception(lang::wire::Exception::DeviceFailure) => {
                self.look()?;
                Err(PumpError::Refused(self.standing.refusal))
            }
            Err(error) => Err(self.link()(error)),
        }
    }

    fn start(&mut self) -> Result<(), PumpError> {
        match self.client.stream_control(Stream::Run) {
            Ok(()) => {
                self.running = true;
                Ok(())
            }
            Err(error) if error.is_exception(lang::wire::Exception::Busy) => Err(PumpError::Busy),
            Err(error) => Err(self.link()(error)),
        }
    }

    fn look(&mut self) -> Result<(), PumpError> {
        self.standing = self.client.stream_standing().map_err(self.link())?;
        let (line, count) = self.place(self.standing.pc);
        self.line = line;
        self.count = count;
        Ok(())
    }

    /// Line and count of a place in the newest piece.
    fn place(&self, pc: u16) -> (u32, u64) {
        let newest = self.standing.begun.wrapping_sub(1);
        let piece = self.sent.iter().find(|(number, _)| *number == newest);
        piece.and_then(|(_, piece)| piece.at(pc)).unwrap_or((self.line, self.count))
    }

    fn print(&mut self, printer: Printer<'_>) -> Result<(), PumpError> {
        loop {
            let bytes = self.client.take_print().map_err(self.link())?;
            if bytes.is_empty() {
                return Ok(());
            }
            printer(&bytes);
        }
    }

    fn outcome(&mut self, begun_at: Duration) -> Outcome {
        let end = self.standing.end.unwrap_or(End::None);
        let own = self.job.over().flatten();
        let (mut fault, mut line, mut count) = (None, self.line, self.count);
        let mut how = end;
        match end {
            End::Fault => {
                fault = u8::try_from(self.standing.fault).ok().and_then(Fault::from_number);
                (line, count) = self.place(self.standing.fault_pc);
            }
            End::Done => {
                count = self.job.count();
                if let Some((own, at)) = own {
                    (fault, line, how) = (Some(own), at, End::Fault);
                }
            }
            _ => {}
        }
        let time = self.client.link().now().saturating_sub(begun_at);
        let starved = self.standing.starved.saturating_sub(self.excused);
        let keeps = self.job.keeps((end != End::Done).then_some(count));
        Outcome { end: how, fault, line, count, pieces: self.pieces, starved, time, keeps }
    }
}
