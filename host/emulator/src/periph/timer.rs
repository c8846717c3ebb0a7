//! Timer_A (SLAU144, chapter 12) with any number of capture/compare channels and their output units,
//! and what Timer_B and the timers of the MSP430x5xx add (SLAU208, chapters 17 and 18): compare
//! latches, a further divider, other interrupt vector values.

use super::{NEVER, Rates};

/// Offset of the first CCTL register from the control register.
pub const CCTL: u16 = 0x02;
/// Offset of the counter.
pub const COUNT: u16 = 0x10;
/// Offset of the first CCR register.
pub const CCR: u16 = 0x12;
/// Offset of the further divider (EX0).
pub const EX0: u16 = 0x20;

const TACLR: u16 = 0x04;
const TAIE: u16 = 0x02;
const TAIFG: u16 = 0x01;
const CAP: u16 = 0x0100;
const SCCI: u16 = 0x0400;
/// Shift of Timer_B's latch load field in CCTL.
const CLLD: u16 = 9;
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

/// In what a timer differs from Timer_A of the MSP430x2xx.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    /// What the interrupt vector register reads for the counter's overflow.
    pub overflow: u16,
    /// Compare values pass through latches (Timer_B).
    pub latches: bool,
    /// Erratum TB25: in up mode they do not wait for the next period.
    pub tb25: bool,
}

impl Variant {
    /// Timer_A of the MSP430x2xx.
    pub const A2: Variant = Variant { overflow: 0x0A, latches: false, tb25: false };
    /// Timer_A of the MSP430x5xx.
    pub const A5: Variant = Variant { overflow: 0x0E, latches: false, tb25: false };
    /// Timer_B of the MSP430x5xx.
    pub const B5: Variant = Variant { overflow: 0x0E, latches: true, tb25: false };
}

/// One timer with `N` channels.
#[derive(Debug, Clone)]
pub struct Timer<const N: usize> {
    variant: Variant,
    /// Channels that have registers, at most `N`; the others stay as they are after a reset.
    channels: usize,
    ctl: u16,
    cctl: [u16; N],
    ccr: [u16; N],
    /// What the counter is compared with: `ccr`, at once or when a latch takes it over.
    latch: [u16; N],
    /// Further divider less 1 (EX0).
    ex0: u16,
    /// TAR at `base`.
    count: u16,
    base: u64,
    /// Ticks of one count, 0 when stopped.
    period: u64,
    down: bool,
    /// Output signals of the units.
    pub out: [bool; N],
    /// Captured values that were not read yet.
    unread: [bool; N],
    /// Levels at the selected capture inputs.
    inputs: [bool; N],
    /// When something next happens.
    pub next: u64,
}

impl<const N: usize> Default for Timer<N> {
    fn default() -> Self {
        Timer::new(Variant::A2, N)
    }
}

impl<const N: usize> Timer<N> {
    /// A timer as after a POR.
    pub fn new(variant: Variant, channels: usize) -> Timer<N> {
        Timer {
            variant,
            channels: channels.min(N),
            ctl: 0,
            cctl: [0; N],
            ccr: [0; N],
            latch: [0; N],
            ex0: 0,
            count: 0,
            base: 0,
            period: 0,
            down: false,
            out: [false; N],
            unread: [false; N],
            inputs: [false; N],
            next: NEVER,
        }
    }

    /// As after a POR, with the levels at its inputs.
    pub fn reset(&mut self) {
        *self = Timer { inputs: self.inputs, ..Timer::new(self.variant, self.channels) };
    }

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

    fn rate(&self, clock: &Rates) -> u64 {
        let stopped = match self.mode() {
            Mode::Stop => true,
            // A period of 0 halts up and up/down mode (section 12.2.3).
            Mode::Up | Mode::UpDown => self.latch[0] == 0,
            Mode::Continuous => false,
        };
        let source = match self.ctl >> 8 & 3 {
            1 => clock.aclk,
            2 => clock.smclk,
            _ => 0,
        };
        if stopped { 0 } else { (source << (self.ctl >> 6 & 3)) * (u64::from(self.ex0) + 1) }
    }

    /// Clocks or registers changed: new rate, new next event.
    pub fn reclock(&mut self, now: u64, clock: &Rates) {
        self.sync(now);
        let period = self.rate(clock);
        if period != self.period {
            // A clock that the FLL trims keeps the part of a count that has passed.
            let part = now.saturating_sub(self.base);
            let kept =
                (part * period).checked_div(self.period).filter(|_| self.variant != Variant::A2);
            self.base = now.saturating_sub(kept.unwrap_or(0));
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
            let top = if self.mode() == Mode::Continuous { 0xFFFF } else { self.latch[0] };
            match self.mode() {
                // At the period up/down mode turns; above a shortened one both restart.
                Mode::UpDown if self.count < top => u64::from(top - self.count),
                Mode::UpDown => 1,
                _ if self.count < top => u64::from(top - self.count) + 1,
                _ => 1,
            }
        };
        for n in 0..N {
            if self.cctl[n] & CAP == 0 {
                let away = if self.down {
                    self.count.wrapping_sub(self.latch[n])
                } else {
                    self.latch[n].wrapping_sub(self.count)
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
                if self.count >= self.latch[0] {
                    self.count = 0;
                    self.ctl |= TAIFG;
                } else {
                    self.count += 1;
                }
            }
            Mode::UpDown => {
                if !self.down && self.count >= self.latch[0] {
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
        // EQU0 comes last: it acts on the outputs of the others.
        for n in (1..N).chain([0]) {
            if self.cctl[n] & CAP == 0 && self.latch[n] == self.count {
                self.compare(n);
            }
        }
        if self.variant.latches {
            self.load_latches();
        }
        self.schedule();
        before != self.out
    }

    /// EQUn: flag, latched input, output unit n; EQU0 also acts on the other outputs.
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
            for m in 1..N {
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
            self.latch[n] = self.count;
            self.cctl[n] |= CCIFG;
            self.schedule();
        }
    }

    /// Timer_B: latches whose time has come take over their CCR (SLAU208, table 18-3).
    fn load_latches(&mut self) {
        let zero = self.count == 0;
        let turn = self.mode() == Mode::UpDown && (zero || self.count == self.latch[0]);
        for n in 0..N {
            let due = match self.cctl[n] >> CLLD & 3 {
                1 => zero,
                2 => zero && self.mode() != Mode::UpDown || turn,
                3 => self.count == self.latch[n],
                _ => true,
            };
            if due && self.cctl[n] & CAP == 0 {
                self.latch[n] = self.ccr[n];
            }
        }
    }

    /// The channel whose register of a row that begins at `base` lies at `offset`.
    fn channel(&self, offset: u16, base: u16) -> Option<usize> {
        let n = usize::from(offset.checked_sub(base)? / 2);
        (n < self.channels).then_some(n)
    }

    /// Reads the register at `offset` from the control register.
    pub fn read(&mut self, offset: u16, now: u64) -> u16 {
        match offset {
            0x00 => return self.ctl,
            COUNT => {
                self.sync(now);
                return self.count;
            }
            EX0 => return self.ex0,
            _ => {}
        }
        if let Some(n) = self.channel(offset, CCR) {
            self.unread[n] = false;
            self.ccr[n]
        } else if let Some(n) = self.channel(offset, CCTL) {
            self.cctl[n] & !CCI | if self.inputs[n] { CCI } else { 0 }
        } else {
            0
        }
    }

    /// Writes the register at `offset` from the control register. True when an output may have
    /// changed.
    pub fn write(&mut self, offset: u16, value: u16, now: u64, clock: &Rates) -> bool {
        self.sync(now);
        let before = self.out;
        match offset {
            0x00 => {
                let kept = if self.variant.latches { 0x7BF3 } else { 0x03F3 };
                self.ctl = value & kept;
                if value & TACLR != 0 {
                    self.count = 0;
                    self.base = now;
                    self.down = false;
                }
                if self.mode() != Mode::UpDown {
                    self.down = false;
                }
            }
            COUNT => {
                self.count = value;
                self.base = now;
            }
            EX0 => self.ex0 = value & 7,
            _ => {
                if let Some(n) = self.channel(offset, CCR) {
                    self.ccr[n] = value;
                    let at_once = match self.cctl[n] >> CLLD & 3 {
                        0 => true,
                        3 => false,
                        _ => self.variant.tb25 && self.mode() == Mode::Up,
                    };
                    if !self.variant.latches || at_once {
                        self.latch[n] = value;
                    }
                } else if let Some(n) = self.channel(offset, CCTL) {
                    let kept = if self.variant.latches { 0xFFF7 } else { 0xF9F7 };
                    self.cctl[n] = value & kept & !SCCI | self.cctl[n] & SCCI;
                    if self.variant.latches {
                        self.cctl[n] = value & kept;
                        if value >> CLLD & 3 == 0 {
                            self.latch[n] = self.ccr[n];
                        }
                    }
                    if value >> 5 & 7 == 0 {
                        self.out[n] = value & OUT != 0;
                    }
                }
            }
        }
        self.reclock(now, clock);
        before != self.out
    }

    /// Whether the registers ask for what is not modelled: groups of latches, or a counter shorter
    /// than 16 bits.
    pub fn unsupported(&self) -> bool {
        self.ctl & 0x7800 != 0
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
        let pending = |n: &usize| self.cctl[*n] & (CCIE | CCIFG) == CCIE | CCIFG;
        match (1..N).find(pending) {
            Some(n) => 2 * n as u16,
            None if self.ctl & (TAIE | TAIFG) == TAIE | TAIFG => self.variant.overflow,
            None => 0,
        }
    }

    /// Reads TAIV, or writes to it: gives and resets the highest pending source.
    pub fn take_vector(&mut self) -> u16 {
        let vector = self.vector();
        if vector == self.variant.overflow {
            self.ctl &= !TAIFG;
        } else if let Some(cctl) =
            self.cctl.get_mut(usize::from(vector / 2)).filter(|_| vector != 0)
        {
            *cctl &= !CCIFG;
        }
        vector
    }
}
