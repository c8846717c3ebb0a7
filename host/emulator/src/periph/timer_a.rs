//! Timer_A3 (SLAU144, chapter 12): three capture/compare channels with output units.

use super::NEVER;
use super::clock::Clock;

const TACLR: u16 = 0x04;
const TAIE: u16 = 0x02;
const TAIFG: u16 = 0x01;
const CAP: u16 = 0x0100;
const SCCI: u16 = 0x0400;
const CCIE: u16 = 0x10;
const CCI: u16 = 0x08;
const OUT: u16 = 0x04;
const COV: u16 = 0x02;
const CCIFG: u16 = 0x01;

/// Counting mode MCx.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    Stop,
    Up,
    Continuous,
    UpDown,
}

/// One timer.
#[derive(Debug, Clone)]
pub struct TimerA {
    ctl: u16,
    cctl: [u16; 3],
    ccr: [u16; 3],
    /// TAR at `base`.
    count: u16,
    base: u64,
    /// Ticks of one count, 0 when stopped.
    period: u64,
    down: bool,
    /// Output signals of the three units.
    pub out: [bool; 3],
    /// Captured values that were not read yet.
    unread: [bool; 3],
    /// Levels at the selected capture inputs.
    inputs: [bool; 3],
    /// When something next happens.
    pub next: u64,
}

impl Default for TimerA {
    fn default() -> Self {
        TimerA {
            ctl: 0,
            cctl: [0; 3],
            ccr: [0; 3],
            count: 0,
            base: 0,
            period: 0,
            down: false,
            out: [false; 3],
            unread: [false; 3],
            inputs: [false; 3],
            next: NEVER,
        }
    }
}

impl TimerA {
    fn mode(&self) -> Mode {
        match self.ctl >> 4 & 3 {
            0 => Mode::Stop,
            1 => Mode::Up,
            2 => Mode::Continuous,
            _ => Mode::UpDown,
        }
    }

    /// Brings TAR up to `now`; no event lies before it.
    fn sync(&mut self, now: u64) {
        if self.period == 0 {
            self.base = now;
            return;
        }
        let counts = now.saturating_sub(self.base) / self.period;
        self.base += counts * self.period;
        let counts = counts as u16;
        self.count = if self.down {
            self.count.wrapping_sub(counts)
        } else {
            self.count.wrapping_add(counts)
        };
    }

    fn rate(&self, clock: &Clock) -> u64 {
        let stopped = match self.mode() {
            Mode::Stop => true,
            // A period of 0 halts up and up/down mode (section 12.2.3).
            Mode::Up | Mode::UpDown => self.ccr[0] == 0,
            Mode::Continuous => false,
        };
        let source = match self.ctl >> 8 & 3 {
            1 => clock.aclk,
            2 => clock.smclk,
            _ => 0,
        };
        if stopped { 0 } else { source << (self.ctl >> 6 & 3) }
    }

    /// Clocks or registers changed: new rate, new next event.
    pub fn reclock(&mut self, now: u64, clock: &Clock) {
        self.sync(now);
        let period = self.rate(clock);
        if period != self.period {
            self.base = now;
            self.period = period;
        }
        self.schedule();
    }

    fn schedule(&mut self) {
        if self.period == 0 {
            self.next = NEVER;
            return;
        }
        let mut counts = if self.down {
            u64::from(self.count)
        } else {
            let top = if self.mode() == Mode::Continuous { 0xFFFF } else { self.ccr[0] };
            match self.mode() {
                // At the period up/down mode turns; above a shortened one both restart.
                Mode::UpDown if self.count < top => u64::from(top - self.count),
                Mode::UpDown => 1,
                _ if self.count < top => u64::from(top - self.count) + 1,
                _ => 1,
            }
        };
        for n in 0..3 {
            if self.cctl[n] & CAP == 0 {
                let away = if self.down {
                    self.count.wrapping_sub(self.ccr[n])
                } else {
                    self.ccr[n].wrapping_sub(self.count)
                };
                if away != 0 {
                    counts = counts.min(u64::from(away));
                }
            }
        }
        self.next = self.base + counts.max(1) * self.period;
    }

    /// The event due at `next`. True when an output may have changed.
    pub fn event(&mut self) -> bool {
        let last = self.next - self.period;
        self.sync(last);
        self.base = self.next;
        match self.mode() {
            Mode::Stop => {}
            Mode::Continuous => {
                self.count = self.count.wrapping_add(1);
                if self.count == 0 {
                    self.ctl |= TAIFG;
                }
            }
            Mode::Up => {
                if self.count >= self.ccr[0] {
                    self.count = 0;
                    self.ctl |= TAIFG;
                } else {
                    self.count += 1;
                }
            }
            Mode::UpDown => {
                if !self.down && self.count >= self.ccr[0] {
                    self.down = true;
                }
                if self.down {
                    self.count = self.count.saturating_sub(1);
                    if self.count == 0 {
                        self.ctl |= TAIFG;
                        self.down = false;
                    }
                } else {
                    self.count += 1;
                }
            }
        }
        let before = self.out;
        for n in [1, 2, 0] {
            if self.cctl[n] & CAP == 0 && self.ccr[n] == self.count {
                self.compare(n);
            }
        }
        self.schedule();
        before != self.out
    }

    /// EQUn: flag, latched input, output unit n; EQU0 also acts on the outputs 1 and 2.
    fn compare(&mut self, n: usize) {
        self.cctl[n] |= CCIFG;
        self.cctl[n] = self.cctl[n] & !SCCI | if self.inputs[n] { SCCI } else { 0 };
        self.out[n] = match self.cctl[n] >> 5 & 7 {
            1 | 3 => true,
            2 | 4 | 6 => !self.out[n],
            5 | 7 => false,
            _ => self.out[n],
        };
        if n == 0 {
            for m in [1, 2] {
                match self.cctl[m] >> 5 & 7 {
                    2 | 3 => self.out[m] = false,
                    6 | 7 => self.out[m] = true,
                    _ => {}
                }
            }
        }
    }

    /// Level of the input that CCISx of channel `n` selects: 0 A, 1 B; ground and Vcc are here.
    pub fn selected_input(&self, n: usize, a: bool, b: bool) -> bool {
        match self.cctl[n] >> 12 & 3 {
            0 => a,
            1 => b,
            2 => false,
            _ => true,
        }
    }

    /// The input of channel `n` is `level` at `now`: captures on the selected edges.
    pub fn input(&mut self, n: usize, level: bool, now: u64) {
        if self.inputs[n] == level {
            return;
        }
        self.inputs[n] = level;
        let edge = if level { 1 } else { 2 };
        if self.cctl[n] & CAP != 0 && self.cctl[n] >> 14 & edge != 0 {
            self.sync(now);
            // COV: captured again before the first value was read (section 12.2.4.1).
            if self.unread[n] {
                self.cctl[n] |= COV;
            }
            self.unread[n] = true;
            self.ccr[n] = self.count;
            self.cctl[n] |= CCIFG;
            self.schedule();
        }
    }

    /// Reads the register at `offset` from TACTL.
    pub fn read(&mut self, offset: u16, now: u64) -> u16 {
        match offset {
            0x00 => self.ctl,
            0x02 | 0x04 | 0x06 => {
                let n = usize::from(offset / 2 - 1);
                self.cctl[n] & !CCI | if self.inputs[n] { CCI } else { 0 }
            }
            0x10 => {
                self.sync(now);
                self.count
            }
            0x12 | 0x14 | 0x16 => {
                let n = usize::from(offset / 2 - 9);
                self.unread[n] = false;
                self.ccr[n]
            }
            _ => 0,
        }
    }

    /// Writes the register at `offset` from TACTL. True when an output may have changed.
    pub fn write(&mut self, offset: u16, value: u16, now: u64, clock: &Clock) -> bool {
        self.sync(now);
        let before = self.out;
        match offset {
            0x00 => {
                self.ctl = value & 0x03F3;
                if value & TACLR != 0 {
                    self.count = 0;
                    self.base = now;
                    self.down = false;
                }
                if self.mode() != Mode::UpDown {
                    self.down = false;
                }
            }
            0x02 | 0x04 | 0x06 => {
                let n = usize::from(offset / 2 - 1);
                self.cctl[n] = value & 0xF9F7 & !SCCI | self.cctl[n] & SCCI;
                if value >> 5 & 7 == 0 {
                    self.out[n] = value & OUT != 0;
                }
            }
            0x10 => {
                self.count = value;
                self.base = now;
            }
            0x12 | 0x14 | 0x16 => self.ccr[usize::from(offset / 2 - 9)] = value,
            _ => {}
        }
        self.reclock(now, clock);
        before != self.out
    }

    /// Whether the CCR0 vector asks for service.
    pub fn irq0(&self) -> bool {
        self.cctl[0] & (CCIE | CCIFG) == CCIE | CCIFG
    }

    /// Whether the shared vector asks for service.
    pub fn irq1(&self) -> bool {
        self.vector() != 0
    }

    /// The CCR0 interrupt was accepted, which resets its flag.
    pub fn accepted0(&mut self) {
        self.cctl[0] &= !CCIFG;
    }

    fn vector(&self) -> u16 {
        let pending = |n: usize| self.cctl[n] & (CCIE | CCIFG) == CCIE | CCIFG;
        if pending(1) {
            2
        } else if pending(2) {
            4
        } else if self.ctl & (TAIE | TAIFG) == TAIE | TAIFG {
            10
        } else {
            0
        }
    }

    /// Reads TAIV, or writes to it: gives and resets the highest pending source.
    pub fn take_vector(&mut self) -> u16 {
        let vector = self.vector();
        match vector {
            2 => self.cctl[1] &= !CCIFG,
            4 => self.cctl[2] &= !CCIFG,
            10 => self.ctl &= !TAIFG,
            _ => {}
        }
        vector
    }
}
