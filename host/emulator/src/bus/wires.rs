//! Wires with a capacity at port 1: a pull-up takes its time to bring an open contact's wire up.

use crate::periph::NEVER;

/// The wires of port 1. Without a pull-up a wire that nobody drives is taken to be empty: the worst.
#[derive(Debug, Clone, Default)]
pub struct Wires {
    /// Ticks from switching a pull-up on, or opening a contact, to a high level at the pin.
    pub delay: u64,
    /// Since when each wire has been pulled up.
    since: [Option<u64>; 8],
}

impl Wires {
    /// All wires are empty.
    pub fn discharge(&mut self) {
        self.since = [None; 8];
    }

    /// Of pins that are pulled up at a time those whose wires are up. The others get empty.
    pub fn up(&mut self, pulled: u8, at: u64) -> u8 {
        if self.delay == 0 {
            return pulled;
        }
        let mut up = 0;
        for (bit, since) in self.since.iter_mut().enumerate() {
            if pulled >> bit & 1 == 0 {
                *since = None;
                continue;
            }
            let since = *since.get_or_insert(at);
            up |= u8::from(at >= since.saturating_add(self.delay)) << bit;
        }
        up
    }

    /// When the next wire comes up behind `at`.
    pub fn next(&self, at: u64) -> u64 {
        if self.delay == 0 {
            return NEVER;
        }
        let ends = self.since.iter().flatten().map(|since| since.saturating_add(self.delay));
        ends.filter(|end| *end > at).min().unwrap_or(NEVER)
    }
}
