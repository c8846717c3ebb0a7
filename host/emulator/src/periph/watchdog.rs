//! Watchdog timers: WDT+ (SLAU144, chapter 10) and WDT_A (SLAU208, chapter 16).

use super::{NEVER, Rates};

/// Key of a write, in the high byte of WDTCTL.
pub const KEY: u16 = 0x5A00;
const READ: u16 = 0x6900;
const HOLD: u16 = 0x80;
const TMSEL: u16 = 0x10;
const CNTCL: u16 = 0x08;
/// WDT+: ACLK instead of SMCLK.
const SSEL: u16 = 0x04;

/// Which watchdog it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variant {
    /// WDT+ of the MSP430x2xx.
    Plus,
    /// WDT_A of the MSP430x5xx.
    A,
}

impl Variant {
    /// Low byte of WDTCTL after a PUC: 32 768 cycles of SMCLK.
    fn after_reset(self) -> u16 {
        match self {
            Variant::Plus => 0,
            Variant::A => 4,
        }
    }

    /// Cycles of the interval that WDTISx chooses.
    fn interval(self, ctl: u16) -> u64 {
        match self {
            Variant::Plus => [1 << 15, 1 << 13, 1 << 9, 1 << 6][usize::from(ctl & 3)],
            Variant::A => {
                const BITS: [u32; 8] = [31, 27, 23, 19, 15, 13, 9, 6];
                1 << BITS[usize::from(ctl & 7)]
            }
        }
    }

    /// Ticks of a cycle of the clock that WDTSSELx chooses, or of what stands in for a stopped one.
    fn period(self, ctl: u16, clock: &Rates) -> u64 {
        let (chosen, other) = match self {
            // WDT+ falls back to the DCO when its source fails (SLAU144, section 10.2.4).
            Variant::Plus if ctl & SSEL != 0 => (clock.aclk, clock.mclk),
            Variant::Plus => (clock.smclk, clock.mclk),
            // WDT_A falls back to the VLO (SLAU208, section 16.2.5).
            Variant::A => match ctl >> 5 & 3 {
                0 => (clock.smclk, clock.vlo),
                1 => (clock.aclk, clock.vlo),
                _ => (clock.vlo, clock.vlo),
            },
        };
        if chosen == 0 { other } else { chosen }
    }
}

/// How often the counter was cleared: firmware that does so once in each pass of its main loop tells by this how
/// long they take.
#[derive(Debug, Clone, Copy, Default)]
pub struct Kicks {
    /// Times since the measurement began.
    pub count: u64,
    /// Longest time between two of them, ticks.
    pub longest: u64,
    /// When the newest was, ticks.
    last: Option<u64>,
}

impl Kicks {
    fn kick(&mut self, now: u64) {
        let since = self.last.map_or(0, |last| now.saturating_sub(last));
        *self = Kicks { count: self.count + 1, longest: self.longest.max(since), last: Some(now) };
    }
}

/// Watchdog state.
#[derive(Debug, Clone)]
pub struct Watchdog {
    /// How often it was cleared.
    pub kicks: Kicks,
    variant: Variant,
    ctl: u16,
    /// Counter at `base`.
    count: u64,
    base: u64,
    /// Ticks of a count, 0 when stopped.
    period: u64,
    /// When the interval ends.
    pub next: u64,
}

impl Watchdog {
    /// As after a PUC: running in reset mode from SMCLK.
    pub fn new(variant: Variant, now: u64, clock: &Rates) -> Watchdog {
        let ctl = variant.after_reset();
        let kicks = Kicks::default();
        let mut wdt = Watchdog { kicks, variant, ctl, count: 0, base: now, period: 0, next: NEVER };
        wdt.reclock(now, clock);
        wdt
    }

    /// WDTCTL as read.
    pub fn read(&self) -> u16 {
        READ | self.ctl
    }

    /// Whether the interval ends in an interrupt instead of a reset.
    pub fn interval_mode(&self) -> bool {
        self.ctl & TMSEL != 0
    }

    /// Writes WDTCTL. False when the key is wrong.
    pub fn write(&mut self, value: u16, now: u64, clock: &Rates) -> bool {
        if value & 0xFF00 != KEY {
            return false;
        }
        self.stop(now);
        self.ctl = value & 0xF7;
        if value & CNTCL != 0 {
            self.count = 0;
            self.kicks.kick(now);
        }
        self.go(clock);
        true
    }

    /// The clocks changed.
    pub fn reclock(&mut self, now: u64, clock: &Rates) {
        // The FLL trims other clocks than this one all the time.
        let same = self.period != 0 && self.period == self.variant.period(self.ctl, clock);
        if same && self.variant == Variant::A {
            return;
        }
        self.stop(now);
        self.go(clock);
    }

    /// The interval ended: the counter starts again.
    pub fn expire(&mut self) {
        self.base = self.next;
        self.count = 0;
        self.schedule();
    }

    fn interval(&self) -> u64 {
        self.variant.interval(self.ctl)
    }

    fn stop(&mut self, now: u64) {
        let elapsed = now.saturating_sub(self.base);
        self.count += elapsed.checked_div(self.period).unwrap_or(0);
        self.base = now;
        self.period = 0;
    }

    fn go(&mut self, clock: &Rates) {
        if self.ctl & HOLD == 0 {
            self.period = self.variant.period(self.ctl, clock);
        }
        self.schedule();
    }

    fn schedule(&mut self) {
        self.next = if self.period == 0 {
            NEVER
        } else {
            // A counter already past a shorter interval ends with its next overflow of that bit.
            self.base + (self.interval() - self.count % self.interval()) * self.period
        };
    }
}
