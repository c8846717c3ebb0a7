//! Flash memory controller (SLAU208, chapter 7): keys, locks, modes and times. What an operation
//! does to the cells is `crate::periph::flash`'s.

use crate::f5::silicon::FlashSpeed;
use crate::part::Part;
use crate::periph::flash::Wear;
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
const ACCVIFG: u16 = 0x04;
const WAIT: u16 = 0x08;
const LOCK: u16 = 0x10;
const EMEX: u16 = 0x20;
const LOCKA: u16 = 0x40;
const LOCKINFO: u16 = 0x80;

/// Bytes of a row: block writes stay within one, and program time adds up in it.
pub const ROW: u32 = 128;
/// Microseconds that a row may be under program voltage between erases.
pub const ROW_LIMIT_US: u32 = 16_000;
/// Lowest MCLK in hertz with which flash may be written (erratum FLASH33).
pub const LOWEST_MCLK: u64 = 160_000;
/// Lowest supply in millivolts with which flash may be written (SLAS590).
pub const LOWEST_MV: u32 = 1_800;

/// What a write to flash addresses does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// Programs the addressed byte or word.
    Program,
    /// Takes a half of a long word and programs both when the second comes.
    LongWord,
    /// Programs a long word of a row in block mode.
    Block,
    /// Erases the segment that holds the address.
    Segment,
    /// Erases the bank that holds the address.
    Bank,
    /// Erases main flash.
    Mass,
}

impl Action {
    /// Whether it erases.
    pub fn erases(self) -> bool {
        matches!(self, Action::Segment | Action::Bank | Action::Mass)
    }
}

/// Why a write did nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// LOCK, LOCKA for segment A, or LOCKINFO.
    Locked,
    /// Neither a write nor an erase mode is set.
    NoMode,
}

/// Controller state.
#[derive(Debug, Clone)]
pub struct Flash {
    fctl1: u16,
    fctl3: u16,
    fctl4: u16,
    speed: FlashSpeed,
    /// Until when an operation is busy that code in RAM started.
    pub busy_until: u64,
    /// Flash that can't be read meanwhile, first and last address.
    pub busy_range: (u32, u32),
    /// Segment (first address, length) whose erase is under way.
    pub erasing: Option<(u32, u32)>,
    /// Half of a long word that waits for the other: address of the long word, which half, value.
    pub half: Option<(u32, u32, u16)>,
    /// Row of the block write under way.
    pub row: Option<u32>,
    /// Program time in microseconds by row, since its last erase.
    pub row_us: std::collections::HashMap<u32, u32>,
    /// Wear and operation counts.
    pub wear: Wear,
    /// Operation number (counted from 1 by `wear.operations`) at which power fails, and the seed
    /// of what it leaves.
    pub cut: Option<(u64, u64)>,
}

impl Flash {
    /// As after power-up.
    pub fn new(speed: FlashSpeed) -> Flash {
        let mut flash = Flash {
            fctl1: 0,
            fctl3: 0,
            fctl4: 0,
            speed,
            busy_until: 0,
            busy_range: (0, 0),
            erasing: None,
            half: None,
            row: None,
            row_us: std::collections::HashMap::new(),
            wear: Wear::default(),
            cut: None,
        };
        flash.reset(true);
        flash
    }

    /// Registers as after a PUC, or after power-up. KEYV tells the program why and is cleared by it.
    pub fn reset(&mut self, power_up: bool) {
        let kept = if power_up { 0 } else { self.fctl3 & KEYV };
        self.fctl1 = 0;
        self.fctl3 = LOCKA | LOCK | WAIT | kept;
        self.fctl4 = 0;
        self.busy_until = 0;
        self.erasing = None;
        self.half = None;
        self.row = None;
    }

    /// Reads the register at `offset` from FCTL1.
    pub fn read(&self, offset: u16, now: u64) -> Option<u16> {
        let busy = if now < self.busy_until || self.row.is_some() { BUSY } else { 0 };
        let waits = if self.row.is_some() && now < self.busy_until { 0 } else { WAIT };
        Some(
            READ | match offset {
                0 => self.fctl1,
                4 => self.fctl3 & !WAIT | waits | busy,
                6 => self.fctl4,
                _ => return None,
            },
        )
    }

    /// Writes the register at `offset` from FCTL1. False when the key is wrong. `end` is the end of
    /// a block write, which takes `tail` ticks more.
    pub fn write(&mut self, offset: u16, value: u16, now: u64, tail: u64) -> bool {
        if value & 0xFF00 != KEY {
            self.fctl3 |= KEYV;
            return false;
        }
        let value = value & 0xFF;
        match offset {
            0 if self.row.is_some() && value & BLKWRT == 0 => {
                self.row = None;
                self.busy_until = self.busy_until.max(now) + tail;
                self.fctl1 = value & (WRT | MERAS | ERASE);
            }
            0 if now < self.busy_until => self.fctl3 |= ACCVIFG,
            0 => {
                self.fctl1 = value & (BLKWRT | WRT | MERAS | ERASE | 0x20);
                self.half = None;
            }
            4 => {
                // LOCKA toggles when written with 1; EMEX stops a block write.
                let locka = (self.fctl3 ^ value) & LOCKA;
                self.fctl3 = locka | value & (LOCK | ACCVIFG | KEYV);
                if value & EMEX != 0 {
                    self.row = None;
                }
            }
            6 => self.fctl4 = value & (LOCKINFO | 0x31),
            _ => {}
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

    /// An access in the middle of a block write ends it and locks the controller.
    pub fn abort_block(&mut self) {
        self.row = None;
        self.fctl3 |= ACCVIFG | LOCK;
    }

    /// What a write to `addr` would do.
    pub fn action(&self, part: &Part, addr: u32) -> Result<Action, Refusal> {
        if self.fctl3 & LOCK != 0 {
            return Err(Refusal::Locked);
        }
        let action = match (self.fctl1 & (BLKWRT | WRT), self.fctl1 & (MERAS | ERASE)) {
            (WRT, _) => Action::Program,
            (BLKWRT, _) => Action::LongWord,
            (0, ERASE) => Action::Segment,
            (0, MERAS) => Action::Bank,
            (0, 0) => return Err(Refusal::NoMode),
            (0, _) => Action::Mass,
            _ => Action::Block,
        };
        if part.info.contains(&addr) && action != Action::Mass {
            let segment_a = addr > part.info.end() - part.info_segment();
            if segment_a && self.fctl3 & LOCKA != 0 || self.fctl4 & LOCKINFO != 0 {
                return Err(Refusal::Locked);
            }
        }
        Ok(action)
    }

    /// Microseconds that an action takes; `first` is for the first long word of a block
    /// (SLAS590, "Flash Memory").
    pub fn microseconds(&self, action: Action, first: bool) -> u32 {
        let [fast, slow] = match action {
            Action::Program | Action::LongWord => [64, 85],
            Action::Block if first => [49, 65],
            Action::Block => [37, 49],
            Action::Segment | Action::Bank | Action::Mass => [23_000, 32_000],
        };
        self.between(fast, slow)
    }

    /// Microseconds from the end of block mode to the end of its operation.
    pub fn block_tail_us(&self) -> u32 {
        self.between(55, 73)
    }

    fn between(&self, fast: u32, slow: u32) -> u32 {
        match self.speed {
            FlashSpeed::Fast => fast,
            FlashSpeed::Typical => fast.midpoint(slow),
            FlashSpeed::Slow => slow,
        }
    }

    /// Counts an operation. `Some(rng)` when power fails during it.
    pub fn begin(&mut self) -> Option<Rng> {
        self.wear.operations += 1;
        match self.cut {
            Some((n, seed)) if n == self.wear.operations => Some(Rng::new(seed)),
            _ => None,
        }
    }

    /// Adds program time to the row of `addr`. True when the row has had too much of it.
    pub fn add_row_time(&mut self, addr: u32, us: u32) -> bool {
        let time = self.row_us.entry(addr / ROW).or_insert(0);
        *time = time.saturating_add(us);
        *time > ROW_LIMIT_US
    }

    /// The rows of an erased range begin anew.
    pub fn forget_rows(&mut self, first: u32, last: u32) {
        self.row_us.retain(|row, _| !(first / ROW..=last / ROW).contains(row));
    }
}
