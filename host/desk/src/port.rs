//! The serial line of the desktop's chip: a request arrives and a reply leaves at the line's rate.

use std::collections::VecDeque;

use firmware::machine::Port;
use firmware::modbus::{FRAME, Line};

use super::PER_US;

/// Bits of a character, as the silence between frames counts them.
const CHARACTER: u64 = 11;

/// The UART of a line.
#[derive(Clone, Debug, Default)]
pub struct Uart {
    /// Ticks of the step timer that a character takes.
    character: u64,
    /// Ticks of silence that end a frame.
    silence: u64,
    /// What arrives, and when its last bit does.
    coming: VecDeque<(u64, u8)>,
    request: Vec<u8>,
    /// When the last character of the request came.
    heard: u64,
    /// A request is whole and not answered yet.
    ready: bool,
    sends: bool,
    /// What leaves, and when its last bit does.
    going: VecDeque<(u64, u8)>,
    free: u64,
    now: u64,
}

impl Uart {
    /// Opens the line at a rate, bit/s.
    pub fn open(&mut self, rate: u32) {
        let second = 1_000_000 * PER_US;
        self.character = CHARACTER * second / u64::from(rate);
        // Modbus over Serial Line V1.02, 2.5.1.1.
        self.silence = if rate > 19_200 { 1750 * PER_US } else { self.character * 7 / 2 };
        (self.ready, self.sends) = (false, false);
        self.request.clear();
    }

    /// The host sends bytes; returns when they are through.
    pub fn send(&mut self, now: u64, bytes: &[u8]) -> u64 {
        let mut at = self.coming.back().map_or(now, |(last, _)| now.max(*last));
        for byte in bytes {
            at += self.character;
            self.coming.push_back((at, *byte));
        }
        at
    }

    /// What the host has received.
    pub fn take(&mut self, now: u64) -> Vec<(u64, u8)> {
        let whole = self.going.iter().take_while(|(at, _)| *at <= now).count();
        self.going.drain(..whole).collect()
    }

    /// Time goes on.
    pub fn advance(&mut self, now: u64) {
        self.now = now;
        while let Some((at, byte)) = self.coming.front().copied().filter(|(at, _)| *at <= now) {
            self.coming.pop_front();
            // What comes during a reply is nobody's.
            if self.ready || self.sends {
                continue;
            }
            if !self.request.is_empty() && at > self.heard + self.silence {
                self.request.clear();
            }
            self.request.push(byte);
            self.heard = at;
        }
        let over = !self.request.is_empty() && now >= self.heard + self.silence;
        if over && !self.ready && !self.sends {
            self.ready = true;
        }
    }

    /// Whether a request is being answered.
    pub fn is_busy(&self) -> bool {
        self.ready || self.sends
    }

    /// When something happens next by itself, if anything.
    pub fn next(&self) -> Option<u64> {
        let request = !self.request.is_empty() && !self.ready && !self.sends;
        let end = request.then_some(self.heard + self.silence);
        self.coming.front().map(|(at, _)| *at).into_iter().chain(end).min()
    }
}

impl Line for Uart {
    fn byte(&self, index: u8) -> u8 {
        self.request.get(usize::from(index)).copied().unwrap_or_default()
    }
    fn room(&self) -> u8 {
        let waiting = self.going.iter().filter(|(at, _)| *at > self.now + self.character).count();
        (FRAME - 1).saturating_sub(waiting) as u8
    }
    fn put(&mut self, byte: u8) {
        self.ready = false;
        self.sends = true;
        self.free = self.free.max(self.now) + self.character;
        self.going.push_back((self.free, byte));
    }
    fn finish(&mut self) {
        (self.ready, self.sends) = (false, false);
        self.request.clear();
    }
}

impl Port for Uart {
    fn frame(&mut self) -> Option<u8> {
        if !self.ready {
            return None;
        }
        let length = u8::try_from(self.request.len()).ok().filter(|n| usize::from(*n) <= FRAME);
        if length.is_none() {
            self.finish();
        }
        length
    }
    fn rests(&self) -> bool {
        !self.ready && !self.sends && self.free <= self.now
    }
    fn follow_clock(&self) {}
}
