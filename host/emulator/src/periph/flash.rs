//! Flash memory controller (SLAU144, chapter 7): keys, locks, timing, wear, and power cuts.

use std::collections::HashMap;

use super::Rates;
use crate::part::Part;
use crate::rng::Rng;

/// Key of a write, in the high byte.
const KEY: u16 = 0xA500;
const READ: u16 = 0x9600;
const ERASE: u16 = 0x02;
const MERAS: u16 = 0x04;
const WRT: u16 = 0x40;
const BLKWRT: u16 = 0x80;
const BUSY: u16 = 0x01;
const KEYV: u16 = 0x02;
/// FCTL3: access violation.
pub const ACCVIFG: u16 = 0x04;
const WAIT: u16 = 0x08;
const LOCK: u16 = 0x10;
const LOCKA: u16 = 0x40;

/// Cycles of the timing generator (SLAU144, table 7-1 and SLAS735).
const WRITE_CYCLES: u64 = 30;
const BLOCK_CYCLES: u64 = 18;
const SEGMENT_CYCLES: u64 = 4819;
const MASS_CYCLES: u64 = 10_593;
/// Range of the timing generator in hertz (SLAS735).
const CLOCK_HZ: std::ops::RangeInclusive<u64> = 257_000..=476_000;

/// What a write to flash addresses does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// Programs the addressed byte or word.
    Program,
    /// Erases the segment that holds the address.
    Segment,
    /// Erases main flash; information memory too when the flag is set.
    Mass(bool),
}

/// Why a write did nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// LOCK, or LOCKA for segment A.
    Locked,
    /// Neither WRT nor an erase mode is set.
    NoMode,
}

/// Counts of a flash memory since it was made; power-off keeps them.
#[derive(Debug, Clone, Default)]
pub struct Wear {
    /// Erases by first address of a segment.
    pub erases: HashMap<u32, u32>,
    /// Program operations since the last erase, by word address.
    programs: HashMap<u32, u8>,
    /// Bits that an interrupted operation left between 0 and 1, by word address.
    unstable: HashMap<u32, u16>,
    /// Flash operations (writes and erases) in all.
    pub operations: u64,
}

/// Controller state.
#[derive(Debug, Clone)]
pub struct Flash {
    fctl1: u16,
    fctl2: u16,
    fctl3: u16,
    /// Until when an operation started from RAM is busy.
    pub busy_until: u64,
    /// Wear and operation counts.
    pub wear: Wear,
    /// Operation number (counted from 1 by `wear.operations`) at which power fails, and the seed
    /// of what it leaves.
    pub cut: Option<(u64, u64)>,
}

impl Default for Flash {
    fn default() -> Self {
        let mut flash =
            Flash { fctl1: 0, fctl2: 0, fctl3: 0, busy_until: 0, wear: Wear::default(), cut: None };
        flash.reset();
        flash
    }
}

impl Flash {
    /// Registers as after a PUC. KEYV tells the program why and is cleared by it.
    pub fn reset(&mut self) {
        self.fctl1 = 0;
        self.fctl2 = 0x42;
        self.fctl3 = LOCKA | LOCK | WAIT | self.fctl3 & KEYV;
        self.busy_until = 0;
    }

    /// Power came up: KEYV too is cleared.
    pub fn power_up(&mut self) {
        self.fctl3 = 0;
        self.reset();
    }

    /// Reads FCTL1, FCTL2 or FCTL3 by address.
    pub fn read(&self, addr: u16, now: u64) -> u16 {
        READ | match addr {
            0x128 => self.fctl1,
            0x12A => self.fctl2,
            _ => self.fctl3 | if now < self.busy_until { BUSY } else { 0 },
        }
    }

    /// Writes FCTL1, FCTL2 or FCTL3. False when the key is wrong.
    pub fn write(&mut self, addr: u16, value: u16, now: u64) -> bool {
        if value & 0xFF00 != KEY {
            self.fctl3 |= KEYV;
            return false;
        }
        let value = value & 0xFF;
        match addr {
            0x128 | 0x12A if now < self.busy_until => self.fctl3 |= ACCVIFG,
            0x128 => self.fctl1 = value & (BLKWRT | WRT | MERAS | ERASE),
            0x12A => self.fctl2 = value,
            _ => {
                // LOCKA toggles when written with 1.
                let locka = (self.fctl3 ^ value) & LOCKA;
                self.fctl3 = WAIT | locka | value & (LOCK | ACCVIFG | KEYV);
            }
        }
        true
    }

    /// Access violation flag.
    pub fn violation(&self) -> bool {
        self.fctl3 & ACCVIFG != 0
    }

    /// Sets the access violation flag.
    pub fn violate(&mut self) {
        self.fctl3 |= ACCVIFG;
    }

    /// What a write to `addr` would do.
    pub fn action(&self, part: &Part, addr: u32) -> Result<Action, Refusal> {
        if self.fctl3 & LOCK != 0 {
            return Err(Refusal::Locked);
        }
        let action = if self.fctl1 & WRT != 0 {
            Action::Program
        } else {
            match self.fctl1 & (MERAS | ERASE) {
                0 => return Err(Refusal::NoMode),
                ERASE => Action::Segment,
                MERAS => Action::Mass(false),
                _ => Action::Mass(true),
            }
        };
        let in_a = part.info.contains(&addr) && addr >= part.info.end() + 1 - part.info_segment();
        if in_a && self.fctl3 & LOCKA != 0 && !matches!(action, Action::Mass(_)) {
            return Err(Refusal::Locked);
        }
        Ok(action)
    }

    /// Whether segment A is protected.
    pub fn a_locked(&self) -> bool {
        self.fctl3 & LOCKA != 0
    }

    /// Ticks of one cycle of the timing generator, and whether its rate is allowed.
    fn clock(&self, clock: &Rates) -> (u64, bool) {
        let source = match self.fctl2 >> 6 & 3 {
            0 => clock.aclk,
            1 => clock.mclk,
            _ => clock.smclk,
        };
        let ticks = source.max(1) * (u64::from(self.fctl2 & 0x3F) + 1);
        (ticks, CLOCK_HZ.contains(&(clock.second / ticks)))
    }

    /// Ticks that `action` takes, and whether the timing generator runs within its limits.
    pub fn duration(&self, action: Action, clock: &Rates) -> (u64, bool) {
        let (tick, allowed) = self.clock(clock);
        let cycles = match action {
            Action::Program if self.fctl1 & BLKWRT != 0 => BLOCK_CYCLES,
            Action::Program => WRITE_CYCLES,
            Action::Segment => SEGMENT_CYCLES,
            Action::Mass(_) => MASS_CYCLES,
        };
        (cycles * tick, allowed)
    }

    /// Counts an operation. `Some(rng)` when power fails during it.
    pub fn begin(&mut self) -> Option<Rng> {
        self.wear.operations += 1;
        match self.cut {
            Some((n, seed)) if n == self.wear.operations => Some(Rng::new(seed)),
            _ => None,
        }
    }
}

/// Programs `value` under `mask` into the word at `addr`: bits only go from 1 to 0. With `cut` each
/// of those bits makes it or not, at random. Returns how often the word was programmed since its
/// last erase.
pub fn program(
    wear: &mut Wear,
    mem: &mut [u8],
    (addr, value, mask): (u32, u16, u16),
    cut: Option<&mut Rng>,
) -> u8 {
    let at = (addr & !1) as usize;
    let old = u16::from_le_bytes([mem[at], mem[at + 1]]);
    let wanted = !value & mask;
    let mut clear = wanted & old;
    let unstable = wear.unstable.remove(&(addr & !1)).unwrap_or(0);
    if let Some(rng) = cut {
        wear.unstable.insert(addr & !1, unstable | clear);
        clear &= rng.bits() as u16;
    } else if unstable & !wanted != 0 {
        wear.unstable.insert(addr & !1, unstable & !wanted);
    }
    mem[at..at + 2].copy_from_slice(&(old & !clear).to_le_bytes());
    let count = wear.programs.entry(addr & !1).or_insert(0);
    *count = count.saturating_add(1);
    *count
}

/// Erases `len` bytes from `start`. With `cut` the erase stops early: either each bit has flipped
/// or not at random, or a part of the segment is done and the rest is untouched.
pub fn erase(wear: &mut Wear, mem: &mut [u8], (start, len): (u32, u32), cut: Option<&mut Rng>) {
    let range = start as usize..(start + len) as usize;
    *wear.erases.entry(start).or_insert(0) += 1;
    match cut {
        None => {
            mem[range].fill(0xFF);
            let outside = |addr: u32| addr < start || addr - start >= len;
            wear.programs.retain(|addr, _| outside(*addr));
            wear.unstable.retain(|addr, _| outside(*addr));
        }
        Some(rng) => {
            let share = rng.below(256);
            let half = rng.below(2) == 0;
            let done = rng.below(u64::from(len)) as usize;
            for (i, at) in range.enumerate() {
                let before = mem[at];
                if half {
                    if i < done {
                        mem[at] = 0xFF;
                    }
                    continue;
                }
                for bit in 0..8 {
                    if rng.below(256) < share {
                        mem[at] |= 1 << bit;
                    }
                }
                let word = wear.unstable.entry(at as u32 & !1).or_insert(0);
                *word |= u16::from(!before) << (8 * (at & 1));
            }
        }
    }
}

/// Power comes up: every unstable bit reads as one or the other this time.
pub fn settle(wear: &Wear, mem: &mut [u8], rng: &mut Rng) {
    let mut words: Vec<(u32, u16)> = wear.unstable.iter().map(|(a, m)| (*a, *m)).collect();
    // The map's order is not the same in every run.
    words.sort_unstable();
    for (addr, mask) in words {
        let at = addr as usize;
        let old = u16::from_le_bytes([mem[at], mem[at + 1]]);
        let new = old & !mask | rng.bits() as u16 & mask;
        mem[at..at + 2].copy_from_slice(&new.to_le_bytes());
    }
}
