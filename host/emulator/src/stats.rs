//! Measurements that a debugger could not make: interrupt times, stack depth, cycles by address.

use std::collections::BTreeMap;

/// What is known of one interrupt vector. Times in ticks.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct InterruptStats {
    /// How often it was accepted.
    pub count: u64,
    /// Longest time from acceptance to the end of RETI, interrupts nested in it included.
    pub worst: u64,
    /// Sum of those times.
    pub total: u64,
    /// Longest time from the flag to the acceptance.
    pub worst_latency: u64,
}

/// Nested handlers that are remembered; deeper ones are not measured.
const NESTING: usize = 64;

/// Counters of the CPU.
#[derive(Debug, Clone, Default)]
pub struct Stats {
    /// By vector address.
    pub interrupts: BTreeMap<u16, InterruptStats>,
    /// Handlers being executed: vector and time of acceptance.
    pub(crate) nesting: Vec<(u16, u64)>,
    /// Lowest stack pointer seen since the last reset of the measurement.
    pub lowest_sp: Option<u16>,
    /// The same outside interrupts.
    pub lowest_outside: Option<u16>,
    /// Most bytes of stack that an interrupt took, with those nested in it.
    pub deepest_interrupt: u16,
    /// Stack pointer where the outermost interrupt was accepted.
    accepted_at: u16,
    /// Whether cycles are counted by address.
    pub(crate) profiling: bool,
    profile: Vec<u64>,
}

impl Stats {
    #[inline]
    pub(crate) fn stack(&mut self, sp: u16) {
        if self.lowest_sp.is_none_or(|low| sp < low) {
            self.lowest_sp = Some(sp);
        }
        if !self.nesting.is_empty() {
            let depth = self.accepted_at.wrapping_sub(sp);
            self.deepest_interrupt = self.deepest_interrupt.max(depth);
        } else if self.lowest_outside.is_none_or(|low| sp < low) {
            self.lowest_outside = Some(sp);
        }
    }

    pub(crate) fn enter(&mut self, vector: u16, sp: u16, since: u64, now: u64) {
        if self.nesting.is_empty() {
            self.accepted_at = sp;
        }
        let stats = self.interrupts.entry(vector).or_default();
        stats.count += 1;
        stats.worst_latency = stats.worst_latency.max(now.saturating_sub(since));
        if self.nesting.len() < NESTING {
            self.nesting.push((vector, now));
        }
    }

    pub(crate) fn leave(&mut self, now: u64) {
        if let Some((vector, start)) = self.nesting.pop() {
            let stats = self.interrupts.entry(vector).or_default();
            let time = now - start;
            stats.worst = stats.worst.max(time);
            stats.total += time;
        }
    }

    pub(crate) fn enable_profile(&mut self, on: bool, words: usize) {
        self.profiling = on;
        if on && self.profile.is_empty() {
            self.profile = vec![0; words];
        }
    }

    #[inline]
    pub(crate) fn count(&mut self, pc: u32, cycles: u8) {
        if let Some(counter) = self.profile.get_mut((pc >> 1) as usize) {
            *counter += u64::from(cycles);
        }
    }

    /// Instruction cycles spent at each word address (index: address / 2), empty when never
    /// enabled. Flash stalls and interrupt entries are not in it.
    #[must_use]
    pub fn profile(&self) -> &[u64] {
        &self.profile
    }

    /// Forgets interrupt times, stack depth and the profile.
    pub fn clear(&mut self) {
        self.interrupts.clear();
        self.lowest_sp = None;
        self.lowest_outside = None;
        self.deepest_interrupt = 0;
        self.profile.fill(0);
    }
}
