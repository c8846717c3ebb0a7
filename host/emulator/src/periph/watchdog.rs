//! Watchdog timer WDT+ (SLAU144, chapter 10).

use super::NEVER;
use super::clock::Clock;

/// Key of a write, in the high byte of WDTCTL.
pub const KEY: u16 = 0x5A00;
const READ: u16 = 0x6900;
const HOLD: u16 = 0x80;
const TMSEL: u16 = 0x10;
const CNTCL: u16 = 0x08;
const SSEL: u16 = 0x04;
/// Cycles of the four intervals WDTISx.
const INTERVALS: [u64; 4] = [32_768, 8_192, 512, 64];

/// Watchdog state.
#[derive(Debug, Clone)]
pub struct Watchdog {
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
    pub fn new(now: u64, clock: &Clock) -> Watchdog {
        let mut wdt = Watchdog { ctl: 0, count: 0, base: now, period: 0, next: NEVER };
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
    pub fn write(&mut self, value: u16, now: u64, clock: &Clock) -> bool {
        if value & 0xFF00 != KEY {
            return false;
        }
        self.stop(now);
        self.ctl = value & 0xF7;
        if value & CNTCL != 0 {
            self.count = 0;
        }
        self.go(clock);
        true
    }

    /// The clocks changed.
    pub fn reclock(&mut self, now: u64, clock: &Clock) {
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
        INTERVALS[usize::from(self.ctl & 3)]
    }

    fn stop(&mut self, now: u64) {
        let elapsed = now.saturating_sub(self.base);
        self.count += elapsed.checked_div(self.period).unwrap_or(0);
        self.base = now;
        self.period = 0;
    }

    fn go(&mut self, clock: &Clock) {
        if self.ctl & HOLD == 0 {
            self.period = if self.ctl & SSEL != 0 { clock.aclk } else { clock.smclk };
            // WDT+ falls back to the DCO when its source fails (section 10.2.4).
            if self.period == 0 {
                self.period = clock.mclk;
            }
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
