//! The port's one owner: all users of a board send their requests here.
//!
//! A thread holds the [`Client`]. Requests of many users are served in turns, one request of
//! each; [`Helm::stop`] goes before all of them and between the exchanges of a long one. Between
//! requests the owner polls the board and publishes one [`Picture`] of it to all users, with a
//! [log](Entry) of what happened. A held jog ([`Hold`]) goes on only while its keep-alives are accepted.

pub mod follow;
mod hold;
mod log;
mod owner;
mod picture;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

pub use follow::{Debug, Pace};
pub use hold::{Hold, KEEP_FRESH, LOOK_AHEAD, Over, SLOWEST};
pub use log::Entry;
#[cfg(any(feature = "gateway", test))]
pub(crate) use picture::Round;
pub use picture::{Picture, Port};

use crate::client::Client;
use crate::link::Link;
use log::Log;

/// The master that the owner holds.
pub type Board = Client<Box<dyn Link>>;

/// Opens the port; called again whenever it was lost. The text says why it cannot.
pub type Open = Box<dyn FnMut() -> Result<Board, String> + Send>;

/// A request: it gets the board, or why there is none.
pub type Job = Box<dyn FnOnce(Result<&mut Board, &str>) + Send>;

/// Requests of one user that may wait.
const MOST_WAITING: usize = 32;

/// Who asks. Users take turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct User(u64);

impl User {
    /// A user that nobody else is.
    #[expect(clippy::new_without_default, reason = "each one is another")]
    pub fn new() -> User {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        User(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// Too many requests of this user wait already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooMany;

/// The way to the owner. Copies are the same owner; the last one that goes ends it.
#[derive(Clone)]
pub struct Helm {
    handle: Arc<Handle>,
}

struct Handle {
    shared: Arc<Shared>,
}

/// Between the owner's thread and everybody else.
struct Shared {
    wants: Mutex<Wants>,
    /// The owner has something to do.
    called: Condvar,
    shown: Mutex<Shown>,
    /// Picture or log are newer.
    changed: Condvar,
    /// Somebody wants to stop: no exchange but that one begins.
    interrupt: Arc<AtomicBool>,
}

/// What is wanted of the owner.
#[derive(Default)]
struct Wants {
    /// Users with requests, the next one's turn first.
    queues: VecDeque<(User, VecDeque<Job>)>,
    stop: bool,
    hold: Option<Hold>,
    debug: Option<Debug>,
    /// Everything is read in the next round, also what hardly changes.
    anew: bool,
    closing: bool,
}

/// What everybody may see.
struct Shown {
    number: u64,
    picture: Arc<Picture>,
    log: Log,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Helm {
    /// Starts an owner.
    pub fn start(open: Open) -> Helm {
        let shared = Arc::new(Shared {
            wants: Mutex::default(),
            called: Condvar::new(),
            shown: Mutex::new(Shown {
                number: 0,
                picture: Arc::new(Picture::default()),
                log: Log::default(),
            }),
            changed: Condvar::new(),
            interrupt: Arc::new(AtomicBool::new(false)),
        });
        let own = shared.clone();
        std::thread::spawn(move || owner::Owner::new(own, open).run());
        Helm { handle: Arc::new(Handle { shared }) }
    }

    fn shared(&self) -> &Shared {
        &self.handle.shared
    }

    /// Puts a request in its user's queue. It runs in the owner's thread, and must not wait for
    /// motion: the picture tells how that goes on.
    ///
    /// # Errors
    /// [`TooMany`] of this user wait.
    pub fn ask(
        &self,
        user: User,
        job: impl FnOnce(Result<&mut Board, &str>) + Send + 'static,
    ) -> Result<(), TooMany> {
        let mut wants = lock(&self.shared().wants);
        let job: Job = Box::new(job);
        match wants.queues.iter_mut().find(|(own, _)| *own == user) {
            Some((_, queue)) if queue.len() >= MOST_WAITING => return Err(TooMany),
            Some((_, queue)) => queue.push_back(job),
            None => wants.queues.push_back((user, VecDeque::from([job]))),
        }
        self.shared().called.notify_one();
        Ok(())
    }

    /// Stops everything on its ramp: a run, a jog, homing, probing. Comes before every request that
    /// waits, drops them, and lets no exchange of a running one begin before it.
    pub fn stop(&self) {
        let mut wants = lock(&self.shared().wants);
        wants.stop = true;
        let dropped = std::mem::take(&mut wants.queues);
        self.shared().interrupt.store(true, Ordering::SeqCst);
        self.shared().called.notify_one();
        drop(wants);
        for job in dropped.into_iter().flat_map(|(_, queue)| queue) {
            job(Err("Stop came before it"));
        }
    }

    /// Begins a held jog; it ends by itself unless [`Helm::keep`] is called again and again.
    ///
    /// # Errors
    /// Another hold is not over yet.
    pub fn hold(&self, hold: Hold) -> Result<(), TooMany> {
        let mut wants = lock(&self.shared().wants);
        if wants.hold.is_some() {
            return Err(TooMany);
        }
        wants.hold = Some(hold);
        self.shared().called.notify_one();
        Ok(())
    }

    /// Keeps a held jog alive for another [`LOOK_AHEAD`]: one write to the board.
    ///
    /// # Errors
    /// No such hold goes on; once over it stays over.
    pub fn keep(&self, user: User, id: u64) -> Result<(), Over> {
        let mut wants = lock(&self.shared().wants);
        let hold = wants.hold.as_mut().filter(|hold| hold.is(user, id)).ok_or(Over::Unknown)?;
        hold.keep(Instant::now())?;
        self.shared().called.notify_one();
        Ok(())
    }

    /// Ends a held jog, if it goes on.
    pub fn release(&self, user: User, id: u64) {
        let mut wants = lock(&self.shared().wants);
        if let Some(hold) = wants.hold.as_mut().filter(|hold| hold.is(user, id)) {
            hold.release();
            self.shared().called.notify_one();
        }
    }

    /// A user is gone: its jog ends, its requests are dropped. A stored program runs on.
    pub fn leave(&self, user: User) {
        let mut wants = lock(&self.shared().wants);
        wants.queues.retain(|(own, _)| *own != user);
        if let Some(hold) = wants.hold.as_mut().filter(|hold| hold.user() == user) {
            hold.release();
        }
        self.shared().called.notify_one();
    }

    /// Follows the next run effect by effect, with breakpoints and steps.
    pub fn debug(&self, debug: Debug) {
        lock(&self.shared().wants).debug = Some(debug);
        self.shared().called.notify_one();
    }

    /// Has everything read in the next round: the board's program was changed.
    pub fn refresh(&self) {
        lock(&self.shared().wants).anew = true;
        self.shared().called.notify_one();
    }

    /// The newest picture and its number.
    pub fn picture(&self) -> (u64, Arc<Picture>) {
        let shown = lock(&self.shared().shown);
        (shown.number, shown.picture.clone())
    }

    /// Waits until the picture or the log is newer than number `seen`, at most `patience`.
    pub fn wait(&self, seen: u64, patience: Duration) -> (u64, Arc<Picture>) {
        let shown = lock(&self.shared().shown);
        let result =
            self.shared().changed.wait_timeout_while(shown, patience, |shown| shown.number <= seen);
        let (shown, _) = result.unwrap_or_else(PoisonError::into_inner);
        (shown.number, shown.picture.clone())
    }

    /// Entries of the log behind number `seen`, and the number to ask with next.
    pub fn log(&self, seen: u64) -> (u64, Vec<Entry>) {
        lock(&self.shared().shown).log.behind(seen)
    }
}

impl Drop for Handle {
    fn drop(&mut self) {
        lock(&self.shared.wants).closing = true;
        self.shared.called.notify_one();
    }
}
