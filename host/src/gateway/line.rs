//! The thread that owns a line and all boards on it: it serves all clients in turns.
//!
//! [`Helm`](crate::helm::Helm) owns a port with one board and polls it all the time. Here several
//! boards share a line, requests are passed on unchanged, and a board that does not answer must cost the
//! others next to nothing.

use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use lang::wire;

use super::backoff::Health;
use super::known::Program;
use super::looks::Looks;
use super::named::Named;
use super::pdu::{NO_ANSWER, NO_PATH, Touch, refusal};
use super::station::Station;
use super::turns::{Asker, Turns};
use crate::client::{Client, ClientError, Heard, Patience};
use crate::helm::Picture;
use crate::link::Link;
use crate::link::mover::END_JOG;

/// The master that a line's thread holds.
pub type Board = Client<Box<dyn Link>>;

/// Opens the line; called again when it was lost. The text says why it cannot.
pub type Open = Box<dyn FnMut() -> Result<Board, String> + Send>;

/// Between two tries to open a line.
const AGAIN: Duration = Duration::from_millis(500);
/// How long clients may keep the owner from a look that is due.
const LOOK_PATIENCE: Duration = Duration::from_millis(250);
/// The first wait for a reply, beside its time on the wire, is at least the longest one divided by this.
const HASTE: u32 = 5;
/// A line on which nobody answers is opened anew so often: its boards may have another rate now.
const RENEW: Duration = Duration::from_secs(30);
/// Longest wait for the reply to a write: a board erases and writes its flash meanwhile (wire.rs, Upload).
const WRITING: Duration = Duration::from_millis(400);
/// The same where the board checks a program first, of the longest there is.
const CHECKING: Duration = Duration::from_millis(wire::check_ms(lang::image::NARROW) + 100);

/// All that a board shows.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// What every board has.
    pub picture: Picture,
    /// The variables of its program, if their names are known.
    pub variables: Vec<Named>,
}

/// What a look at a board brought.
#[derive(Clone, Debug)]
pub enum Look {
    /// What it shows.
    Picture(Box<Seen>),
    /// It printed a line.
    Print(String),
    /// It does not answer, or its line is lost.
    Silent,
}

/// Somebody who wants to see the boards of a line: how often, and who hears of it, by the board's
/// place on the line.
pub struct Watch {
    /// Between two looks at a board.
    pub every: Duration,
    /// Lines that are printed are taken from the boards; who else asks for them finds none.
    pub prints: bool,
    /// What is known of the program with this CRC, of the board at a place on the line.
    pub program: Box<dyn Fn(usize, u16) -> Option<Program> + Send>,
    /// Hears of each look.
    pub tell: Box<dyn Fn(usize, Look) + Send>,
}

/// Whether the line is open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
enum State {
    Opening,
    Open,
    Lost,
}

/// Takes the reply to a request: function and data.
pub type Answer = Box<dyn FnOnce(Vec<u8>) + Send>;

/// Work for the board, or why it cannot be done. The line sees by the board's newest exchange whether it answers.
pub type Job = Box<dyn FnOnce(Result<&mut Board, &str>) + Send>;

enum Work {
    Ask {
        station: Arc<Station>,
        pdu: Vec<u8>,
        touch: Touch,
        age: Duration,
        answer: Answer,
    },
    /// `stops`: it ends motion.
    Do {
        station: Arc<Station>,
        stops: bool,
        job: Job,
    },
}

/// The way to a line's thread. The last copy that goes ends it.
pub struct Line {
    shared: Arc<Shared>,
    /// Its boards, in the order in which they were given.
    pub stations: Vec<Arc<Station>>,
}

struct Shared {
    wants: Mutex<Wants>,
    called: Condvar,
    state: AtomicU8,
}

#[derive(Default)]
struct Wants {
    turns: Turns<Work>,
    closing: bool,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Line {
    /// Starts the owner of a line with boards at these addresses. `reply`: longest wait for the reply to
    /// a read, beside its time on the wire.
    pub fn start(addresses: &[u8], reply: Duration, watch: Option<Watch>, open: Open) -> Line {
        let shared = Arc::new(Shared {
            wants: Mutex::default(),
            called: Condvar::new(),
            state: AtomicU8::new(State::Opening as u8),
        });
        let stations: Vec<Arc<Station>> =
            addresses.iter().map(|address| Arc::new(Station::new(*address))).collect();
        let (own, boards) = (shared.clone(), stations.clone());
        std::thread::spawn(move || Owner::new(own, boards, reply, watch, open).run());
        Line { shared, stations }
    }

    /// Asks a board. The answer may come at once, from this thread: out of memory that is younger
    /// than `age`, or because the board cannot be asked.
    pub fn ask(
        &self,
        asker: Asker,
        station: usize,
        (pdu, touch): (Vec<u8>, Touch),
        age: Duration,
        answer: Answer,
    ) {
        let station = &self.stations[station];
        station.heard(asker, &pdu);
        if let Some(reply) = station.kept(&touch, age) {
            station.counters.cached.add();
            return answer(reply);
        }
        let lost = self.shared.state.load(Ordering::Relaxed) == State::Lost as u8;
        let urgent = touch.is_stop(&pdu);
        // One reply that was lost must not keep a stop from the board.
        let may = station.may_ask() || urgent && station.may_stop();
        if lost || !may {
            station.counters.spared.add();
            return answer(refusal(&pdu, if lost { NO_PATH } else { NO_ANSWER }));
        }
        let work = Work::Ask { station: station.clone(), pdu, touch, age, answer };
        self.put(asker, urgent, work);
    }

    /// Does something with a board that takes more than a request. It must not wait for motion.
    pub fn order(&self, asker: Asker, station: usize, urgent: bool, job: Job) {
        let station = self.stations[station].clone();
        self.put(asker, urgent, Work::Do { station, stops: urgent, job });
    }

    fn put(&self, asker: Asker, urgent: bool, work: Work) {
        let mut wants = lock(&self.shared.wants);
        let put =
            if urgent { wants.turns.push_urgent(work) } else { wants.turns.push(asker, work) };
        drop(wants);
        match put {
            Ok(()) => self.shared.called.notify_one(),
            Err(work) => refuse(work, wire::Exception::Busy as u8, "too many requests wait"),
        }
    }
}

/// Ends what cannot be done.
fn refuse(work: Work, code: u8, why: &str) {
    match work {
        Work::Ask { pdu, answer, station, .. } => {
            station.counters.spared.add();
            answer(refusal(&pdu, code));
        }
        Work::Do { job, .. } => job(Err(why)),
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        lock(&self.shared.wants).closing = true;
        self.shared.called.notify_one();
    }
}

/// The line's thread.
struct Owner {
    shared: Arc<Shared>,
    stations: Vec<Arc<Station>>,
    open: Open,
    reply: Duration,
    /// How long boards of this line take beyond the wire's time; an old slow one counts less and less.
    usual: Duration,
    looks: Option<Looks>,
    board: Option<Board>,
    /// Why there is none.
    lost: String,
    /// When to try to open the line.
    open_at: Instant,
    opened: Instant,
}

impl Owner {
    fn new(
        shared: Arc<Shared>,
        stations: Vec<Arc<Station>>,
        reply: Duration,
        watch: Option<Watch>,
        open: Open,
    ) -> Owner {
        let (lost, now) = ("the line is not open yet".to_owned(), Instant::now());
        let looks = watch.map(|watch| Looks::new(watch, stations.len()));
        Owner {
            shared,
            stations,
            open,
            reply,
            usual: Duration::ZERO,
            looks,
            board: None,
            lost,
            open_at: now,
            opened: now,
        }
    }

    fn run(mut self) {
        loop {
            if self.board.is_none() && Instant::now() >= self.open_at {
                self.reopen();
            }
            let Some(work) = self.next() else { break };
            self.end_jogs();
            match work {
                None => self.look(),
                Some(Work::Ask { station, pdu, touch, age, answer }) => {
                    let reply = self.ask(&station, &pdu, &touch, age);
                    answer(reply);
                }
                Some(Work::Do { station, stops, job }) => self.order(&station, stops, job),
            }
            self.renew();
        }
        for work in lock(&self.shared.wants).turns.take() {
            refuse(work, NO_PATH, "the gateway ends");
        }
    }

    /// The next thing to do; none within while it is time for something else, none at the end.
    fn next(&mut self) -> Option<Option<Work>> {
        let mut wants = lock(&self.shared.wants);
        loop {
            if wants.closing {
                return None;
            }
            let now = Instant::now();
            let look = self.look_at();
            // Clients come first, but a look that is long overdue comes in between.
            if look.is_some_and(|due| now >= due + LOOK_PATIENCE) {
                return Some(None);
            }
            if let Some(work) = wants.turns.pop() {
                return Some(Some(work));
            }
            let open = if self.board.is_none() { self.open_at } else { now + RENEW };
            let held = self.stations.iter().filter_map(|station| station.held_until()).min();
            let due = [look, held].into_iter().flatten().fold(open, Instant::min);
            if now >= due {
                return Some(None);
            }
            let wait = self.shared.called.wait_timeout(wants, due - now);
            wants = wait.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Ends what a client moves by command that has asked for nothing for two seconds, as a board does on a line of its own.
    fn end_jogs(&mut self) {
        let own = self.stations.iter().filter(|station| station.is_let_go());
        for station in own.cloned().collect::<Vec<_>>() {
            // A board that does not hear this hears nobody, and ends it itself.
            let _ = self.exchange(&station, &END_JOG, 5, self.reply, true);
            station.forget();
        }
    }

    /// When the next look is due.
    fn look_at(&self) -> Option<Instant> {
        self.board.as_ref()?;
        self.looks.as_ref()?.next(&self.stations).map(|(_, due)| due)
    }

    /// One exchange of a look at the board whose turn it is, if one is due.
    fn look(&mut self) {
        let (Some(board), Some(looks)) = (&mut self.board, &mut self.looks) else { return };
        let Some((place, due)) = looks.next(&self.stations) else { return };
        if Instant::now() < due {
            return;
        }
        let station = &self.stations[place];
        board.set_patience(Patience { reply: self.reply, attempts: 2 });
        board.set_address(station.address);
        match looks.look(place, board) {
            Ok(()) => station.hit(),
            Err(ClientError::Port(error)) => self.lose(error.to_string()),
            Err(_) => {
                station.miss();
                looks.silent(place);
            }
        }
    }

    fn set_state(&self, state: State) {
        self.shared.state.store(state as u8, Ordering::Relaxed);
    }

    fn reopen(&mut self) {
        match (self.open)() {
            Ok(board) => {
                self.board = Some(board);
                self.opened = Instant::now();
                self.set_state(State::Open);
            }
            Err(why) => self.lose(why),
        }
    }

    fn lose(&mut self, why: String) {
        self.board = None;
        self.lost = why;
        self.open_at = Instant::now() + AGAIN;
        self.set_state(State::Lost);
        if let Some(looks) = &mut self.looks {
            (0..self.stations.len()).for_each(|place| looks.silent(place));
        }
        for work in lock(&self.shared.wants).turns.take() {
            refuse(work, NO_PATH, &self.lost);
        }
    }

    /// Opens a line anew on which nobody answers.
    fn renew(&mut self) {
        let dead = self.stations.iter().all(|one| one.health() == Health::Silent);
        if self.board.is_some() && dead && self.opened.elapsed() > RENEW {
            self.board = None;
            self.open_at = Instant::now();
        }
    }

    fn ask(&mut self, station: &Station, pdu: &[u8], touch: &Touch, age: Duration) -> Vec<u8> {
        // Others may have asked the same while this waited.
        if let Some(reply) = station.kept(touch, age) {
            station.counters.cached.add();
            return reply;
        }
        let stops = touch.is_stop(pdu);
        if !(station.may_ask() || stops && station.takes_stop()) {
            station.counters.spared.add();
            return refusal(pdu, NO_ANSWER);
        }
        let known = station.health() == Health::Up;
        // To a board that hardly is there no write is sent that nobody would know to be done.
        // Nor one whose reply is waited for so long that a board that is gone would keep the others.
        let checks = touch.checks(pdu);
        if (!known || checks) && touch.write && !stops {
            let [high, low] = wire::VERSION.to_be_bytes();
            let probe = [3, high, low, 0, 1];
            if let Err(code) = self.exchange(station, &probe, 4, self.first_wait(station), false) {
                return refusal(pdu, code);
            }
        }
        let wait = match (touch.write, stops) {
            (false, _) => self.first_wait(station),
            (true, true) => self.reply,
            (true, false) if checks => self.reply.max(CHECKING),
            (true, false) => self.reply.max(WRITING),
        };
        let length = touch.reply_length();
        let mut result = self.exchange(station, pdu, length, wait, stops);
        // A read that was lost on the way is asked for once more, and a stop is told once more.
        if known && (!touch.write || stops) && result == Err(NO_ANSWER) && self.board.is_some() {
            result = self.exchange(station, pdu, length, self.reply, stops);
        }
        if touch.write {
            station.forget();
        } else if let Ok(reply) = &result {
            station.keep(touch, reply);
        }
        result.unwrap_or_else(|code| refusal(pdu, code))
    }

    /// How long to wait for a reply that is hardly ever late: by what the line's boards take, so that a
    /// dead one keeps the others from it as briefly as can be. Each fourth time all of it, for a board that
    /// is slower than the others.
    fn first_wait(&self, station: &Station) -> Duration {
        if self.usual.is_zero() || station.misses() % 4 == 3 {
            return self.reply;
        }
        (4 * self.usual).clamp(self.reply / HASTE, self.reply)
    }

    /// One exchange on the line; the error is a gateway's exception.
    fn exchange(
        &mut self,
        station: &Station,
        pdu: &[u8],
        length: usize,
        reply: Duration,
        urgent: bool,
    ) -> Result<Vec<u8>, u8> {
        let Some(board) = &mut self.board else { return Err(NO_PATH) };
        station.counters.exchanges.add();
        board.set_patience(Patience { reply, attempts: 1 });
        let begun = Instant::now();
        let result = board.pass_on(station.address, pdu, length, urgent);
        let wire = board.mode().time_of(pdu.len() + length + 6);
        station
            .counters
            .last_us
            .set(u32::try_from(begun.elapsed().as_micros()).unwrap_or(u32::MAX));
        match result {
            // What stands between may be a gateway itself.
            Ok(reply) if matches!(reply[..], [_, NO_PATH | NO_ANSWER]) => {
                station.miss();
                Err(reply[1])
            }
            Ok(reply) => {
                if reply[0] & 0x80 != 0 {
                    station.counters.exceptions.add();
                }
                let took = begun.elapsed().saturating_sub(wire);
                self.usual = took.max(self.usual * 49 / 50).max(Duration::from_micros(1));
                station.hit();
                Ok(reply)
            }
            Err(ClientError::Port(error)) => {
                self.lose(error.to_string());
                Err(NO_PATH)
            }
            Err(_) => {
                station.miss();
                Err(NO_ANSWER)
            }
        }
    }

    fn order(&mut self, station: &Station, stops: bool, job: Job) {
        match &mut self.board {
            None => job(Err(&self.lost)),
            Some(_) if !(station.may_ask() || stops && station.takes_stop()) => {
                job(Err("the board does not answer"))
            }
            Some(board) => {
                // A board that is gone costs the others no more than a client's request to it.
                board.set_patience(Patience { reply: self.reply.max(WRITING), attempts: 2 });
                board.set_address(station.address);
                board.take_heard();
                job(Ok(board));
                station.forget();
                match board.take_heard() {
                    Heard::Reply => station.hit(),
                    Heard::Nothing => station.miss(),
                    Heard::Broken => self.lose("the port failed".to_owned()),
                    Heard::Unasked => {}
                }
            }
        }
    }
}
