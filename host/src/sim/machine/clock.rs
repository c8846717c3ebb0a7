//! Simulated time: what it is, when something happens next, and where it ends.

use crate::sim::Options;

/// See the module.
#[derive(Debug)]
pub struct Clock {
    /// Simulated time, us.
    now: u64,
    /// When something happens next, us; 0 when that must be found out.
    next: u64,
    /// Where the run is given up, us.
    limit: u64,
    /// Time of a statement, us.
    statement_us: u64,
    /// Statements begun.
    statements: u64,
    /// The first statement has begun: it does so at 0.
    started: bool,
}

impl Clock {
    /// Time 0.
    pub fn new(options: &Options) -> Clock {
        Clock {
            now: 0,
            next: 0,
            limit: options.limit_us,
            statement_us: options.statement_us,
            statements: 0,
            started: false,
        }
    }

    /// Simulated time, us.
    pub fn now(&self) -> u64 {
        self.now
    }

    /// When something happens next, us.
    pub fn next(&self) -> u64 {
        self.next
    }

    /// Statements begun.
    pub fn statements(&self) -> u64 {
        self.statements
    }

    /// `count` statements begin. Gives the time to which the machine must go when something happens
    /// on the way there.
    pub fn pass(&mut self, count: u32) -> Option<u64> {
        self.statements += u64::from(count);
        if !self.started {
            self.started = true;
            return None;
        }
        let to = self.now + self.statement_us * u64::from(count);
        if to >= self.next {
            return Some(to);
        }
        self.now = to;
        None
    }

    /// It is `us` at least.
    pub fn reach(&mut self, us: u64) {
        self.now = self.now.max(us);
    }

    /// It is the time at which something happens; `true` when that is the limit.
    pub fn reach_next(&mut self) -> bool {
        self.reach(self.next);
        let over = self.now >= self.limit;
        if over {
            self.now = self.limit;
        }
        over
    }

    /// What happens next must be found out.
    pub fn look_anew(&mut self) {
        self.next = 0;
    }

    /// Whether what happens next must be found out.
    pub fn is_unsure(&self) -> bool {
        self.next == 0
    }

    /// The next thing to happen by itself, us; the limit happens in any case.
    pub fn expect(&mut self, next: Option<u64>) {
        self.next = next.unwrap_or(u64::MAX).min(self.limit).max(1);
    }
}
