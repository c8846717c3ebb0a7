//! Power management module and supply supervisors (SLAU208, chapter 2).

use crate::periph::NEVER;
use crate::reset::Reset;

/// Password in the high byte.
const KEY: u16 = 0xA5;
const READ: u16 = 0x9600;
const DELAY_LOW: u16 = 0x0001;
const LEVEL_LOW: u16 = 0x0004;
const DELAY_HIGH: u16 = 0x0010;
const MONITOR_HIGH: u16 = 0x0020;
const SUPERVISOR_HIGH_ON: u16 = 0x0400;
const MONITOR_HIGH_ON: u16 = 0x4000;
const SUPERVISOR_HIGH_RESETS: u16 = 0x1000;

/// Highest MCLK in hertz and lowest supply in millivolts at each core level (SLAS590,
/// "Recommended Operating Conditions").
pub const LEVELS: [(u64, u32); 4] =
    [(8_000_000, 1_800), (12_000_000, 2_000), (20_000_000, 2_200), (25_000_000, 2_400)];

/// Supply in millivolts at which the high-side monitor answers, by SVSMHRRL (SLAS590, typical).
const MONITOR_MV: [u32; 8] = [1_740, 1_940, 2_140, 2_260, 2_400, 2_700, 3_000, 3_000];
/// Supply in millivolts at which the high-side supervisor resets, by SVSHRVL (SLAS590, typical).
const SUPERVISOR_MV: [u32; 4] = [1_570, 1_790, 1_980, 2_100];

/// What a write asks of the chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Nothing.
    Done,
    /// The module is closed: nothing was written.
    Closed,
    /// A core level that is not the next one.
    LevelSkipped,
    /// A reset.
    Reset(Reset),
}

/// Registers.
#[derive(Debug, Clone)]
pub struct Pmm {
    open: bool,
    ctl0: u16,
    ctl1: u16,
    high: u16,
    low: u16,
    io: u16,
    ifg: u16,
    ie: u16,
    pm5: u16,
    delay: u64,
    high_due: u64,
    low_due: u64,
}

impl Pmm {
    /// As after a BOR; supervisors need `delay` ticks behind a setting.
    pub fn new(delay: u64) -> Pmm {
        Pmm {
            open: false,
            ctl0: 0,
            ctl1: 0,
            high: 0x4400,
            low: 0x4400,
            io: 0x0020,
            ifg: 0,
            ie: 0x1100,
            pm5: 0,
            delay,
            high_due: NEVER,
            low_due: NEVER,
        }
    }

    /// A BOR: everything as at power-up.
    pub fn brown_out(&mut self) {
        *self = Pmm::new(self.delay);
    }

    /// A PUC closes the module.
    pub fn close(&mut self) {
        self.open = false;
    }

    /// Core level, 0 to 3.
    pub fn level(&self) -> u8 {
        (self.ctl0 & 3) as u8
    }

    /// When a supervisor's delay ends.
    pub fn next(&self) -> u64 {
        self.high_due.min(self.low_due)
    }

    /// A delay ended.
    pub fn event(&mut self, now: u64, vcc: u32) {
        if self.high_due <= now {
            self.high_due = NEVER;
            self.ifg |= DELAY_HIGH;
            self.watch(vcc);
        }
        if self.low_due <= now {
            self.low_due = NEVER;
            self.ifg |= DELAY_LOW;
        }
    }

    /// The supply is `vcc` millivolts: flags, and whether the supervisor resets.
    pub fn watch(&mut self, vcc: u32) -> bool {
        if self.high & MONITOR_HIGH_ON != 0 && vcc < MONITOR_MV[usize::from(self.high & 7)] {
            self.ifg |= MONITOR_HIGH;
        }
        let limit = SUPERVISOR_MV[usize::from(self.high >> 8 & 3)];
        self.high & SUPERVISOR_HIGH_ON != 0 && self.ie & SUPERVISOR_HIGH_RESETS != 0 && vcc < limit
    }

    /// Reads the register at `offset` from PMMCTL0.
    pub fn read(&self, offset: u16) -> Option<u16> {
        Some(match offset {
            0x00 => READ | self.ctl0,
            0x02 => self.ctl1,
            0x04 => self.high,
            0x06 => self.low,
            0x08 => self.io,
            0x0C => self.ifg,
            0x0E => self.ie,
            0x10 => self.pm5,
            _ => return None,
        })
    }

    /// Writes bytes of the register at even `offset`: those that `mask` covers.
    pub fn write(&mut self, offset: u16, value: u16, mask: u16, now: u64, vcc: u32) -> Outcome {
        if offset == 0 && mask & 0xFF00 != 0 {
            let right = value >> 8 == KEY;
            if !right && mask == 0xFFFF {
                return Outcome::Reset(Reset::PowerKey);
            }
            self.open = right;
        }
        if !self.open {
            return if mask & 0x00FF == 0 { Outcome::Done } else { Outcome::Closed };
        }
        let put = |register: &mut u16| *register = *register & !mask | value & mask;
        match offset {
            0x00 if mask & 0x00FF != 0 => return self.control(value, now),
            0x02 => put(&mut self.ctl1),
            0x04 => {
                put(&mut self.high);
                self.high_due = now + self.delay;
                self.watch(vcc);
            }
            0x06 => {
                put(&mut self.low);
                self.low_due = now + self.delay;
            }
            0x08 => put(&mut self.io),
            0x0C => put(&mut self.ifg),
            0x0E => put(&mut self.ie),
            0x10 => put(&mut self.pm5),
            _ => {}
        }
        Outcome::Done
    }

    fn control(&mut self, value: u16, now: u64) -> Outcome {
        let old = self.level();
        self.ctl0 = value & 0x0013;
        if value & 0x04 != 0 {
            return Outcome::Reset(Reset::SoftwareBrownOut);
        }
        if value & 0x08 != 0 {
            return Outcome::Reset(Reset::SoftwarePowerOn);
        }
        if self.level() != old {
            self.ifg |= LEVEL_LOW;
            self.low_due = now + self.delay;
        }
        if self.level() > old + 1 { Outcome::LevelSkipped } else { Outcome::Done }
    }

    /// Flags whose interrupts are enabled, as SYSSNIV numbers them.
    pub fn system_interrupt(&self) -> Option<u16> {
        const ORDER: [(u16, u16); 6] =
            [(0x02, 2), (0x20, 4), (0x01, 6), (0x10, 8), (0x04, 0x10), (0x40, 0x12)];
        let pending = self.ifg & self.ie;
        ORDER.iter().find(|(bit, _)| pending & bit != 0).map(|(_, number)| *number)
    }
}
