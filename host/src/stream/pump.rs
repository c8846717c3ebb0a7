//! Keeps a board supplied with pieces until the job is over.

use std::collections::VecDeque;
use std::fmt;
use std::time::Duration;

use lang::fault::Fault;
use lang::wire::{Called, Control, End, RunState, Stream};

use super::job::{Job, Over};
use super::piece::{Piece, Place};
use crate::client::stream::{Slots, Standing};
use crate::client::{Client, ClientError, Patience};
use crate::link::Link;

/// How often the board is asked how it stands while its slots are full.
const POLL: Duration = Duration::from_millis(20);
/// The same for a job whose events are handled here.
const POLL_FOR_EVENTS: Duration = Duration::from_millis(4);
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
    /// The board has begun and left all that came of the job so far, and more may come; axes may
    /// still move.
    pub dry: bool,
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
                "the board refused a piece of the job: {}; `pasapas flash` brings it this tool's \
                 firmware",
                crate::client::upload::reason(*refusal)
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

/// Asks the board for something else each time that the pump has asked how it stands: that, and where
/// the job is, come with it.
pub type Observer<'a, L> =
    &'a mut dyn FnMut(&mut Client<L>, &Standing, &Progress) -> Result<(), ClientError>;

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
    /// The job went back for the handler that the board waits for, whose first piece is not there yet.
    rewound: bool,
    /// The newest piece asks.
    asked: bool,
    /// The job goes on behind an answer.
    answered: bool,
    running: bool,
    finished: bool,
    standing: Standing,
    line: u32,
    count: u64,
    /// Starvation that was a wait for an answer or a handler.
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
    run_observed(client, job, slots, watcher, Some(printer), &mut |_, _, _| Ok(()))
}

/// The same with somebody who asks the board for more, its trace for one. Without a printer what the
/// job prints stays for that.
///
/// # Errors
/// See [`PumpError`].
pub fn run_observed<L: Link>(
    client: &mut Client<L>,
    job: &mut Job<'_>,
    slots: Slots,
    watcher: Watcher<'_>,
    printer: Option<Printer<'_>>,
    observer: Observer<'_, L>,
) -> Result<Outcome, PumpError> {
    let usual = client.set_patience(PATIENCE);
    let result =
        Pump::open(client, job, slots).and_then(|mut pump| pump.run(watcher, printer, observer));
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
            rewound: false,
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

    fn run(
        &mut self,
        watcher: Watcher<'_>,
        mut printer: Option<Printer<'_>>,
        observer: Observer<'_, L>,
    ) -> Result<Outcome, PumpError> {
        let runs = self.standing.runs;
        let poll = if self.job.has_events() { POLL_FOR_EVENTS } else { POLL };
        let mut begun_at = self.client.link().now();
        let mut looked_at = begun_at;
        loop {
            let thinks = !self.fill()?;
            let full = self.pending.is_some() || self.asked || self.job.over().is_some();
            if !self.running && (full || thinks && self.pieces > 0) {
                self.start()?;
                begun_at = self.client.link().now();
            }
            let over = self.job.over().is_some() && self.pending.is_none();
            if over && self.running && !self.finished {
                self.finish()?;
            }
            // A job whose rest is not there yet is looked after as one that waits for a slot.
            let look = if self.job.awaits_more() { poll } else { LOOK };
            if !full && self.client.link().now().saturating_sub(looked_at) < look {
                if self.pending.is_none() {
                    self.client.link().pause(THINK);
                }
                continue;
            }
            if full {
                self.client.link().pause(poll);
            }
            looked_at = self.client.link().now();
            self.look()?;
            let progress = self.progress();
            let line = self.line;
            observer(self.client, &self.standing, &progress)
                .map_err(|error| PumpError::Link(error, line))?;
            if self.standing.runs != runs
                && matches!(
                    self.standing.state,
                    Some(RunState::Ready | RunState::Empty | RunState::Fault)
                )
            {
                self.print(&mut printer)?;
                return Ok(self.outcome(begun_at));
            }
            self.called();
            let waits = self.asked && self.standing.call.is_none();
            if waits && self.standing.dry && self.standing.begun == self.number {
                let value = self.client.stream_answer().map_err(self.link())?;
                self.job.answer(value);
                self.asked = false;
                self.answered = true;
            }
            self.print(&mut printer)?;
            let progress = self.progress();
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

    fn progress(&mut self) -> Progress {
        let sent = self.pending.is_none() && self.job.awaits_more();
        Progress {
            state: self.standing.state,
            line: self.line,
            count: self.count,
            keeps: self.job.keeps(Some(self.count)),
            dry: sent && self.standing.dry && self.standing.begun == self.number,
        }
    }

    /// Sends a piece if there is one and a slot for it; `false` when there is none.
    fn fill(&mut self) -> Result<bool, PumpError> {
        if self.pending.is_none() && !self.asked {
            self.pending = self.job.piece();
        }
        let most = if self.running { self.slots.count - 1 } else { self.slots.count };
        let waiting = self.number.wrapping_sub(self.standing.begun);
        let Some(piece) = self.pending.take() else { return Ok(false) };
        if waiting >= most {
            self.pending = Some(piece);
            return Ok(true);
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
                self.rewound = false;
                Ok(true)
            }
            Ok(false) => {
                self.pending = Some(piece);
                self.look()?;
                self.called();
                Ok(true)
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

    /// The last piece is there.
    fn finish(&mut self) -> Result<(), PumpError> {
        match self.client.stream_control(Stream::Finish) {
            Ok(()) => self.finished = true,
            // The board waits for a handler.
            Err(error) if error.is_exception(lang::wire::Exception::Busy) => {
                self.look()?;
                self.called();
            }
            Err(error) => return Err(self.link()(error)),
        }
        Ok(())
    }

    fn look(&mut self) -> Result<(), PumpError> {
        self.standing = self.client.stream_standing().map_err(self.link())?;
        if let Some(place) = self.place(self.standing.pc) {
            self.line = place.line;
            self.count = place.count;
        }
        // The words may be of two instants: the piece before the newest is the one surely begun.
        let begun = self.piece(self.standing.begun.wrapping_sub(2));
        if let Some(first) = begun.and_then(|piece| piece.places.first()) {
            let id = first.id;
            self.job.pass(id);
        }
        Ok(())
    }

    fn piece(&self, number: u16) -> Option<&Piece> {
        self.sent.iter().rev().find(|(own, _)| *own == number).map(|(_, piece)| piece)
    }

    /// The statement at a place of the newest piece, or the one before that piece.
    fn place(&self, pc: u16) -> Option<Place> {
        let newest = self.standing.begun.wrapping_sub(1);
        match pc {
            u16::MAX => self.piece(newest.wrapping_sub(1))?.places.last().copied(),
            _ => self.piece(newest)?.at(pc),
        }
    }

    /// Goes back to where the board waits for a handler.
    fn called(&mut self) {
        let Some(call) = self.standing.call.filter(|_| !self.rewound) else { return };
        let pc = match call.place {
            Called::Failed => self.standing.fault_pc,
            _ => self.standing.pc,
        };
        // Without a place the job is broken, which it then says.
        let id = self.place(pc).map_or(u64::MAX, |place| place.id);
        let begun = self.standing.begun;
        let newer = |number: u16| number.wrapping_sub(begun) < 0x8000;
        self.sent.retain(|(number, _)| !newer(*number));
        self.number = begun;
        self.pending = None;
        self.asked = false;
        self.finished = false;
        self.rewound = true;
        // The axes may rest until the handler is there.
        self.excused = self.excused.saturating_add(1);
        self.job.rewind(id, call, begun);
    }

    fn print(&mut self, printer: &mut Option<Printer<'_>>) -> Result<(), PumpError> {
        let Some(printer) = printer.as_mut().filter(|_| self.job.prints) else { return Ok(()) };
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
        let (mut fault, mut line, mut count) = (None, self.line, self.count);
        let mut how = end;
        match end {
            End::Fault => {
                fault = u8::try_from(self.standing.fault).ok().and_then(Fault::from_number);
                if let Some(place) = self.place(self.standing.fault_pc) {
                    (line, count) = (place.line, place.count);
                }
            }
            // Somebody else has said that there is no further piece.
            End::Done if !self.finished => how = End::Stopped,
            End::Done => {
                count = self.job.count();
                if let Some(Over::Broken(own, at)) = self.job.over() {
                    (fault, line, how) = (Some(own), at, End::Fault);
                }
            }
            _ => {}
        }
        let time = self.client.link().now().saturating_sub(begun_at);
        let starved = self.standing.starved.saturating_sub(self.excused);
        let whole = end == End::Done && self.finished;
        let keeps = self.job.keeps((!whole).then_some(count));
        Outcome { end: how, fault, line, count, pieces: self.pieces, starved, time, keeps }
    }
}
