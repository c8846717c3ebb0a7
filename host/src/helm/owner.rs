//! The owner's thread: Stop first, then a held jog, then users in turns, then a poll of the board.

use std::sync::Arc;
use std::sync::PoisonError;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use lang::wire::{self, Exception, RunState, command};

use super::follow::{Debug, Follow};
use super::hold::{Due, Hold};
use super::log::Entry;
use super::picture::{Picture, Port, Round};
use super::{Board, Job, Open, Shared, lock};
use crate::client::orders;
use crate::client::status::{StatusWords, long};
use crate::client::{ClientError, Patience};

/// Between the beginnings of two rounds of looks.
const ROUND: Duration = Duration::from_millis(50);
/// Between two tries to open a port, or to reach a board that is silent.
const AGAIN: Duration = Duration::from_millis(500);
/// Looks wait less than requests: the next one comes soon.
const LOOK_PATIENCE: Patience = Patience { reply: Duration::from_millis(250), attempts: 2 };
/// Bytes of a printed line that is still open; a longer one is shown in pieces.
const LONGEST_LINE: usize = 4096;

/// Why a hold is over that another process at the line, or the machine's own Stop, has ended.
const STOPPED: &str = "somebody else stopped it: let the button go, and press it again";

/// What to do next.
enum Work {
    Stop,
    Hold(Due),
    Debug(Debug),
    Job(Job),
    Look,
    Close,
}

/// The thread's own.
pub struct Owner {
    shared: Arc<Shared>,
    open: Open,
    board: Option<Board>,
    /// Why there is no board.
    lost: String,
    round: Round,
    /// When the next look is due.
    look_at: Instant,
    round_began: Instant,
    follow: Option<Follow>,
    holding: Holding,
    /// Print that has no line end yet.
    line: Vec<u8>,
    /// Runs begun, by the last picture.
    runs: Option<u16>,
}

/// What the owner knows of the running hold.
#[derive(Default)]
struct Holding {
    id: Option<u64>,
    /// Work position less machine position, from when the axis rested.
    offset: i64,
    last: Option<i64>,
    /// How fast the axis was when it got that target, steps/s.
    speed: u32,
    /// State of the run, fault and its input, as the last look found them.
    fault: Option<[u16; 3]>,
}

impl Owner {
    pub(super) fn new(shared: Arc<Shared>, open: Open) -> Owner {
        let now = Instant::now();
        Owner {
            shared,
            open,
            board: None,
            lost: "the port is not open yet".to_owned(),
            round: Round::new(),
            look_at: now,
            round_began: now,
            follow: None,
            holding: Holding::default(),
            line: Vec::new(),
            runs: None,
        }
    }

    /// Serves until the last [`Helm`](super::Helm) is gone; then nothing moves by hand any more.
    pub(super) fn run(mut self) {
        loop {
            match self.next() {
                Work::Stop => self.stop(),
                Work::Hold(Due::Extend) => self.extend(),
                Work::Hold(Due::End(why)) => self.end_hold(why.text()),
                Work::Debug(debug) => self.debug(debug),
                Work::Job(job) => self.serve(job),
                Work::Look => self.look(),
                Work::Close => break,
            }
        }
        if self.holding.id.is_some() {
            self.end_hold("the tool ends");
        }
        if self.follow.take().is_some()
            && let Some(board) = &mut self.board
        {
            // The program goes on alone; nobody is there who could be told.
            let _ = Follow::end(board);
        }
    }

    /// Waits for the next thing to do.
    fn next(&mut self) -> Work {
        let mut wants = lock(&self.shared.wants);
        loop {
            if wants.closing {
                return Work::Close;
            }
            if std::mem::take(&mut wants.stop) {
                return Work::Stop;
            }
            let now = Instant::now();
            if let Some(due) = wants.hold.as_mut().and_then(|hold| hold.due(now)) {
                return Work::Hold(due);
            }
            if let Some(debug) = wants.debug.take() {
                return Work::Debug(debug);
            }
            // The user that was served goes behind the others.
            if let Some((user, mut queue)) = wants.queues.pop_front() {
                let job = queue.pop_front();
                if !queue.is_empty() {
                    wants.queues.push_back((user, queue));
                }
                if let Some(job) = job {
                    return Work::Job(job);
                }
            }
            if now >= self.look_at {
                return Work::Look;
            }
            let over = wants.hold.as_ref().map(Hold::until);
            let until = over.map_or(self.look_at, |over| over.min(self.look_at));
            let wait = until.saturating_duration_since(now).max(Duration::from_millis(1));
            wants = self
                .shared
                .called
                .wait_timeout(wants, wait)
                .unwrap_or_else(PoisonError::into_inner)
                .0;
        }
    }

    fn serve(&mut self, job: Job) {
        match &mut self.board {
            Some(board) => job(Ok(board)),
            None => job(Err(&self.lost)),
        }
        // What it changed shows soon.
        self.look_at = Instant::now();
    }

    /// Ends whatever moves: one command for a run, a jog, homing and probing alike.
    fn stop(&mut self) {
        self.shared.interrupt.store(false, Ordering::SeqCst);
        self.forget_hold("Stop");
        if let Some(board) = &mut self.board
            && let Err(error) = board.write_all(wire::COMMAND, &[command::STOP_AXES, 0b111])
        {
            self.log(Entry::Port(format!("Stop did not reach the board: {error}")));
        }
        if let Some(follow) = &mut self.follow {
            follow.ask(Debug::Leave);
        }
        self.look_at = Instant::now();
    }

    /// Gives the held axis its next target.
    fn extend(&mut self) {
        let Some(hold) = lock(&self.shared.wants).hold.clone() else { return };
        let first = self.holding.id != Some(hold.id());
        let result = match &mut self.board {
            Some(board) => {
                if first {
                    self.holding = Holding { id: Some(hold.id()), ..Holding::default() };
                }
                advance(board, &hold, &mut self.holding)
            }
            None => Err(self.lost.clone()),
        };
        if let Err(why) = result {
            self.end_hold(&why);
        }
    }

    fn end_hold(&mut self, why: &str) {
        if let Some(board) = &mut self.board {
            // The axis rests within 300 ms whether or not this arrives.
            let _ = board.write_all(wire::COMMAND, &[command::STOP_AXES, 0b111]);
        }
        self.forget_hold(why);
    }

    fn forget_hold(&mut self, why: &str) {
        let hold = lock(&self.shared.wants).hold.take();
        let id = self.holding.id.take().or(hold.map(|hold| hold.id()));
        if let Some(id) = id {
            self.log(Entry::Hold { id, why: why.to_owned() });
        }
        self.look_at = Instant::now();
    }

    fn debug(&mut self, debug: Debug) {
        self.look_at = Instant::now();
        let Some(board) = &mut self.board else { return };
        match (debug, &mut self.follow) {
            (Debug::Start { profile, line_of, breaks, pace }, None) => {
                match Follow::start(board, *profile, line_of, breaks, pace) {
                    Ok(follow) => self.follow = Some(follow),
                    Err(error) => self.log(Entry::Port(format!("it did not start: {error}"))),
                }
            }
            (debug, Some(follow)) => follow.ask(debug),
            (_, None) => {}
        }
    }

    /// One exchange of the round of looks, or of a followed run.
    fn look(&mut self) {
        let now = Instant::now();
        let Some(board) = &mut self.board else {
            self.reopen();
            return;
        };
        if std::mem::take(&mut lock(&self.shared.wants).anew) {
            self.round.restart();
        }
        if self.round.is_fresh() {
            self.round_began = now;
        }
        let usual = board.set_patience(LOOK_PATIENCE);
        let result = Self::look_at(board, &mut self.follow, &mut self.line, &mut self.round);
        board.set_patience(usual);
        match result {
            Ok(Seen { picture, entries, over }) => {
                if over {
                    self.follow = None;
                }
                self.show(picture, entries);
            }
            Err(ClientError::Interrupted) => {}
            Err(error @ ClientError::Port(_)) => self.lose(&error.to_string(), true),
            Err(error) => self.lose(&error.to_string(), false),
        }
    }

    fn look_at(
        board: &mut Board,
        follow: &mut Option<Follow>,
        line: &mut Vec<u8>,
        round: &mut Round,
    ) -> Result<Seen, ClientError> {
        let mut seen = Seen::default();
        match follow {
            Some(follow) => {
                let heard = follow.look(board)?;
                seen.over = heard.is_none() || follow.is_over();
                for what in heard.into_iter().flatten() {
                    if let crate::sim::trace::What::Print { text, .. } = &what {
                        seen.entries.push(Entry::Print(text.clone()));
                    }
                    seen.entries.push(Entry::Effect(what));
                }
                if seen.over {
                    Follow::end(board)?;
                }
            }
            None if round.is_fresh() => {
                line.extend(board.take_print()?);
                while let Some(end) = line.iter().position(|byte| *byte == b'\n') {
                    let text: Vec<u8> = line.drain(..=end).collect();
                    let text = String::from_utf8_lossy(&text[..end]).into_owned();
                    seen.entries.push(Entry::Print(text));
                }
                if line.len() > LONGEST_LINE {
                    let text = String::from_utf8_lossy(&std::mem::take(line)).into_owned();
                    seen.entries.push(Entry::Print(text));
                }
            }
            None => {}
        }
        seen.picture = round.look(board)?;
        Ok(seen)
    }

    fn show(&mut self, picture: Option<Picture>, mut entries: Vec<Entry>) {
        let now = Instant::now();
        let Some(mut picture) = picture else {
            self.look_at = now;
            if !entries.is_empty() {
                self.publish(None, entries);
            }
            return;
        };
        // A followed run is asked all the while, unless it is halted.
        let busy = self.follow.as_ref().is_some_and(|follow| follow.halt().is_none());
        self.look_at = if busy { now } else { self.round_began + ROUND };
        picture.followed = self.follow.is_some();
        picture.halted = self.follow.as_ref().and_then(|follow| follow.halt().cloned());
        picture.hold = self.holding.id;
        let runs = picture.status.as_ref().map(|status| status.runs);
        if let (Some(before), Some(runs)) = (self.runs, runs)
            && before != runs
        {
            entries.insert(0, Entry::Begun(runs));
        }
        self.runs = runs;
        self.publish(Some(picture), entries);
    }

    fn publish(&self, picture: Option<Picture>, entries: Vec<Entry>) {
        let mut shown = lock(&self.shared.shown);
        let changed = picture.as_ref().is_some_and(|picture| *shown.picture != *picture);
        if !changed && entries.is_empty() {
            return;
        }
        if let Some(picture) = picture.filter(|_| changed) {
            shown.picture = Arc::new(picture);
        }
        for entry in entries {
            shown.log.push(entry);
        }
        shown.number += 1;
        drop(shown);
        self.shared.changed.notify_all();
    }

    fn log(&self, entry: Entry) {
        self.publish(None, vec![entry]);
    }

    /// The board does not answer, or (`closed`) its port is gone.
    fn lose(&mut self, why: &str, closed: bool) {
        self.look_at = Instant::now() + AGAIN;
        self.follow = None;
        self.runs = None;
        self.round.restart();
        if self.holding.id.is_some() {
            self.forget_hold(why);
            self.look_at = Instant::now() + AGAIN;
        }
        if closed {
            self.board = None;
        }
        if self.lost != why {
            why.clone_into(&mut self.lost);
            self.log(Entry::Port(why.to_owned()));
        }
        let lost = Picture { port: Port::Lost, lost: Some(why.to_owned()), ..Picture::default() };
        self.publish(Some(lost), Vec::new());
    }

    fn reopen(&mut self) {
        match (self.open)() {
            Ok(mut board) => {
                board.set_interrupt(self.shared.interrupt.clone());
                self.board = Some(board);
                self.lost.clear();
                self.round.restart();
                self.look_at = Instant::now();
                self.log(Entry::Port("the board answers".to_owned()));
            }
            Err(why) => self.lose(&why, true),
        }
    }
}

/// What a look brought.
#[derive(Default)]
struct Seen {
    picture: Option<Picture>,
    entries: Vec<Entry>,
    /// The followed run is over.
    over: bool,
}

/// One bounded move of a hold. A part that takes no target on the way gets the next one when it
/// rests.
fn advance(board: &mut Board, hold: &Hold, holding: &mut Holding) -> Result<(), String> {
    let words = |error: ClientError| error.to_string();
    let axis = hold.axis.index() as u16;
    let seen = board.holding(wire::RUN_STATE, StatusWords::RUN_LENGTH).map_err(words)?;
    let of = |register: u16| seen[usize::from(register - wire::RUN_STATE)];
    // A fault on the way ends it: what stopped the axis may be over before the button is let go.
    let fault = [of(wire::RUN_STATE), of(wire::FAULT), of(wire::FAULT_INPUT)];
    let is_fault = RunState::from_number(fault[0]) == Some(RunState::Fault);
    if is_fault && holding.fault.is_some_and(|before| before != fault) {
        return Err("the board told a fault".to_owned());
    }
    holding.fault = Some(fault);
    let place = wire::MACHINE_POSITIONS + 2 * axis;
    let at = i64::from(long(of(place), of(place + 1)));
    if holding.last.is_none() {
        // Registers 1027 to 1029 between the two do not exist: a request over them is refused.
        if board.input(wire::MOVING, 1).map_err(words)?[0] & 0xFF != 0 {
            return Err("an axis moves already".to_owned());
        }
        let seen = board.input(wire::WORK_POSITIONS + 2 * axis, 2).map_err(words)?;
        holding.offset = i64::from(long(seen[0], seen[1])) - at;
    }
    if let Some(last) = holding.last {
        let seen = board.holding(wire::SPEEDS + 2 * axis, 2).map_err(words)?;
        let speed = long(seen[0], seen[1]).unsigned_abs();
        let before = std::mem::replace(&mut holding.speed, speed);
        if hold.was_stopped(last - at, before, speed) {
            return Err(STOPPED.to_owned());
        }
    }
    // An axis that has arrived begins anew: what else asks the board may have kept the keep-alive waiting.
    let goes_on = holding.last.is_some_and(|last| last != at);
    let homed = of(wire::HOMED) >> axis & 1 != 0;
    let target = hold.target(at, holding.last, homed, Instant::now());
    if holding.last == Some(target) || (holding.last.is_none() && target == at) {
        holding.last = Some(target);
        return Ok(());
    }
    // What somebody else has stopped gets no further target. The board is asked first, and once more after the order, as
    // a Stop may come between the two.
    if goes_on {
        bound_hold(board, wire::JOG_GOES_ON)?;
    }
    let order = orders::move_to(hold.axis, [hold.accel; 2], hold.rate, target + holding.offset);
    match board.once(|board| board.write_all(wire::COMMAND, &order)) {
        Ok(()) => {
            holding.last = Some(target);
            if goes_on {
                return bound_hold(board, wire::JOG_GOES_ON);
            }
            match bound_hold(board, 1) {
                // Of a first order that is so short that it has arrived already there is nothing to hold.
                Err(why) if why == STOPPED => Ok(()),
                done => done,
            }
        }
        Err(error) if error.is_exception(Exception::Busy) && holding.last.is_some() => {
            // A part that takes no target on the way is busy while the axis moves; one that rests is
            // held by an emergency stop.
            if board.input(wire::MOVING, 1).map_err(words)?[0] & 0xFF != 0 {
                return Ok(());
            }
            Err("the board takes no move now: look at the emergency stop".to_owned())
        }
        Err(error) => Err(words(error)),
    }
}

/// Lets the board's own clock end the hold as well, where the board has one: `time` is a value of [`wire::JOG_HOLD`].
fn bound_hold(board: &mut Board, time: u16) -> Result<(), String> {
    match board.once(|board| board.write_all(wire::JOG_HOLD, &[time])) {
        Err(error) if error.is_exception(Exception::Busy) => Err(STOPPED.to_owned()),
        Err(error) if !error.is_exception(Exception::IllegalAddress) => Err(error.to_string()),
        _ => Ok(()),
    }
}
