//! A board of a line as all clients see it: its counters, its memory, and whether it answers.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::backoff::{Backoff, Health};
use super::cache::Cache;
use super::counters::Counters;
use super::pdu::Touch;
use super::turns::Asker;
use crate::link::mover::Mover;

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// See the module.
pub struct Station {
    /// Modbus address.
    pub address: u8,
    /// What is counted of it.
    pub counters: Counters,
    cache: Mutex<Cache>,
    backoff: Mutex<Backoff>,
    mover: Mutex<Mover>,
    begun: Instant,
}

impl Station {
    /// A board that nobody asked yet.
    pub fn new(address: u8) -> Station {
        Station {
            address,
            counters: Counters::default(),
            cache: Mutex::default(),
            backoff: Mutex::default(),
            mover: Mutex::default(),
            begun: Instant::now(),
        }
    }

    /// A client asks it.
    pub fn heard(&self, asker: Asker, pdu: &[u8]) {
        lock(&self.mover).asks(asker, pdu, self.begun.elapsed());
    }

    /// When the motion of a client that asks no more is to be ended.
    pub fn held_until(&self) -> Option<Instant> {
        lock(&self.mover).until().map(|until| self.begun + until)
    }

    /// Whether that has come. It comes once.
    pub fn is_let_go(&self) -> bool {
        lock(&self.mover).ends(self.begun.elapsed())
    }

    /// Whether it answers.
    pub fn health(&self) -> Health {
        lock(&self.backoff).health()
    }

    /// It answered.
    pub fn hit(&self) {
        lock(&self.backoff).hit();
        self.counters.health.set(Health::Up as u32);
    }

    /// It did not answer.
    pub fn miss(&self) {
        lock(&self.backoff).miss(Instant::now());
        lock(&self.cache).forget();
        self.counters.timeouts.add();
        self.counters.health.set(Health::Silent as u32);
    }

    /// Whether it may be asked now.
    pub fn may_ask(&self) -> bool {
        lock(&self.backoff).may_ask(Instant::now())
    }

    /// Whether it may be told to stop now, though it is left alone otherwise.
    pub fn may_stop(&self) -> bool {
        lock(&self.backoff).may_stop(Instant::now())
    }

    /// The same, and the next such try has to rest if this one fails.
    pub fn takes_stop(&self) -> bool {
        lock(&self.backoff).takes_stop(Instant::now())
    }

    /// Requests without an answer since the last one with one.
    pub fn misses(&self) -> u32 {
        lock(&self.backoff).misses()
    }

    /// Keeps a reply to a read.
    pub fn keep(&self, touch: &Touch, reply: &[u8]) {
        lock(&self.cache).keep(touch, reply, Instant::now());
    }

    /// It was told something: what it said before may hold no more.
    pub fn forget(&self) {
        lock(&self.cache).forget();
    }

    /// The reply to a read out of memory, if there is one younger than `age`.
    pub fn kept(&self, touch: &Touch, age: Duration) -> Option<Vec<u8>> {
        lock(&self.cache).reply(touch, age, Instant::now())
    }
}
