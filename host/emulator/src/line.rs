//! The host's end of the serial line: its own rate and parity, and noise on the wire.

use std::collections::VecDeque;

use crate::periph::NEVER;
use crate::rng::Rng;

/// Parity of the host's port.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Parity {
    /// No parity bit.
    #[default]
    None,
    /// Even.
    Even,
    /// Odd.
    Odd,
}

/// Setting of the host's port: 8 data bits, one stop bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Format {
    /// Bits per second.
    pub baud: u32,
    /// Parity bit.
    pub parity: Parity,
}

impl Default for Format {
    fn default() -> Self {
        Format { baud: 115_200, parity: Parity::None }
    }
}

impl Format {
    /// Bits of a character, start and stop included.
    #[must_use]
    pub fn bits(self) -> u64 {
        if self.parity == Parity::None { 10 } else { 11 }
    }

    /// Ticks from the start of a character to the boundary after `halves` half bits.
    fn at(self, halves: u64, ticks_per_second: u64) -> u64 {
        halves * ticks_per_second / (2 * u64::from(self.baud.max(1)))
    }

    fn encode(self, byte: u8) -> u16 {
        let ones = byte.count_ones() as u16 & 1;
        let data = u16::from(byte) << 1;
        match self.parity {
            Parity::None => data | 1 << 9,
            Parity::Even => data | ones << 9 | 1 << 10,
            Parity::Odd => data | (ones ^ 1) << 9 | 1 << 10,
        }
    }
}

/// The host's transmitter and receiver.
#[derive(Debug, Clone)]
pub struct HostLine {
    /// Ticks in a second of the host's clock, which is true.
    pub(crate) ticks_per_second: u64,
    /// Rate and parity.
    pub format: Format,
    /// Level changes to come on the line to the chip.
    edges: VecDeque<(u64, bool)>,
    /// When the line is free for the next character.
    free: u64,
    last: bool,
    /// Level on the chip's receive pin.
    pub level: bool,
    /// Time of the next level change.
    pub next: u64,
    /// Flips bits in both directions: generator and probability in millionths.
    noise: Option<(Rng, u32)>,
    start: Option<u64>,
    heard: Vec<(u64, bool)>,
    tx_level: bool,
    received: Vec<(u64, u8)>,
    /// Characters from the chip with wrong parity or without stop bit.
    pub errors: u64,
}

impl HostLine {
    /// A line at rest, on a board with this many ticks in a second.
    pub fn new(ticks_per_second: u64) -> Self {
        HostLine {
            ticks_per_second,
            format: Format::default(),
            edges: VecDeque::new(),
            free: 0,
            last: true,
            level: true,
            next: NEVER,
            noise: None,
            start: None,
            heard: Vec::new(),
            tx_level: true,
            received: Vec::new(),
            errors: 0,
        }
    }

    /// Ticks from the start of a character to the boundary after `halves` half bits.
    fn at(&self, halves: u64) -> u64 {
        self.format.at(halves, self.ticks_per_second)
    }

    /// Flips `per_million` of all bits from now on; 0 ends it.
    pub fn set_noise(&mut self, seed: u64, per_million: u32) {
        self.noise = (per_million > 0).then(|| (Rng::new(seed), per_million));
    }

    fn flip(&mut self) -> bool {
        match &mut self.noise {
            Some((rng, per_million)) => rng.below(1_000_000) < u64::from(*per_million),
            None => false,
        }
    }

    fn level_from(&mut self, at: u64, level: bool) {
        if level != self.last {
            self.last = level;
            self.edges.push_back((at, level));
            if self.next == NEVER {
                self.next = at;
            }
        }
    }

    /// Queues characters behind what is queued already, not before `not_before`. Returns when the
    /// last of them has left.
    pub fn send(&mut self, bytes: &[u8], not_before: u64) -> u64 {
        for byte in bytes {
            let start = self.free.max(not_before);
            let bits = self.format.encode(*byte);
            for i in 0..self.format.bits() {
                let level = (bits >> i & 1 != 0) ^ self.flip();
                self.level_from(start + self.at(2 * i), level);
            }
            self.free = start + self.at(2 * self.format.bits());
            // The line rests high whatever noise did to the stop bit.
            self.level_from(self.free, true);
        }
        self.free
    }

    /// Queues raw levels, each for a number of ticks: glitches, breaks, wrong rates.
    pub fn send_raw(&mut self, levels: &[(bool, u64)], not_before: u64) {
        let mut at = self.free.max(not_before);
        for (level, ticks) in levels {
            self.level_from(at, *level);
            at += ticks;
        }
        self.level_from(at, true);
        self.free = at;
    }

    /// When everything queued has left.
    #[must_use]
    pub fn free(&self) -> u64 {
        self.free
    }

    /// The chip had no power until `now`: what was on the line meanwhile is gone.
    pub(crate) fn skip(&mut self, now: u64) {
        while self.next <= now {
            self.event();
        }
        self.start = None;
        self.tx_level = true;
    }

    /// The level change due at `next` happens.
    pub(crate) fn event(&mut self) {
        if let Some((_, level)) = self.edges.pop_front() {
            self.level = level;
        }
        self.next = self.edges.front().map_or(NEVER, |(at, _)| *at);
    }

    /// The chip's transmit pin changed.
    pub(crate) fn hear(&mut self, now: u64, level: bool) {
        self.poll(now);
        if level == self.tx_level {
            return;
        }
        self.tx_level = level;
        if self.start.is_some() {
            self.heard.push((now, level));
        } else if !level {
            self.start = Some(now);
            self.heard.clear();
        }
    }

    /// Finishes a character whose stop bit has been sampled by `now`.
    pub(crate) fn poll(&mut self, now: u64) {
        let Some(start) = self.start else { return };
        let bits = self.format.bits();
        let end = start + self.at(2 * bits - 1);
        if now < end {
            return;
        }
        self.start = None;
        let mut sampled = 0u16;
        for i in 0..bits {
            let at = start + self.at(2 * i + 1);
            let level = self.heard.iter().rev().find(|(t, _)| *t <= at).is_some_and(|(_, l)| *l);
            let level = level ^ self.flip();
            sampled |= u16::from(level) << i;
        }
        if sampled & 1 != 0 {
            return;
        }
        let byte = (sampled >> 1) as u8;
        if self.format.encode(byte) != sampled {
            self.errors += 1;
        }
        self.received.push((end, byte));
    }

    /// Characters that arrived, each with the time of its stop bit.
    pub fn take(&mut self, now: u64) -> Vec<(u64, u8)> {
        self.poll(now);
        std::mem::take(&mut self.received)
    }
}
