//! What a debugger sees and does: memory, registers, breakpoints, warnings, measurements.

use std::collections::BTreeMap;

use super::Board;
use crate::stats::Stats;
use crate::warn::Warning;

impl Board {
    /// A byte of memory as it is; peripherals read 0xFF.
    #[must_use]
    pub fn peek8(&self, addr: u16) -> u8 {
        self.bus.memory()[usize::from(addr)]
    }

    /// A word of memory as it is; the address is rounded down to even.
    #[must_use]
    pub fn peek16(&self, addr: u16) -> u16 {
        self.bus.word(addr)
    }

    /// Changes a byte of memory, also in flash, without any of the chip's rules.
    pub fn poke8(&mut self, addr: u16, value: u8) {
        self.bus.memory_mut()[usize::from(addr)] = value;
    }

    /// Changes a word of memory, also in flash, without any of the chip's rules.
    pub fn poke16(&mut self, addr: u16, value: u16) {
        let [low, high] = value.to_le_bytes();
        self.poke8(addr & !1, low);
        self.poke8(addr | 1, high);
    }

    /// Reads a byte as an instruction would: peripherals answer, and flags reset themselves.
    pub fn bus_read8(&mut self, addr: u16) -> u8 {
        self.bus.read8(addr)
    }

    /// Reads a word as an instruction would.
    pub fn bus_read16(&mut self, addr: u16) -> u16 {
        self.bus.read16(addr)
    }

    /// Writes a byte as an instruction would.
    pub fn bus_write8(&mut self, addr: u16, value: u8) {
        self.bus.write8(addr, value);
    }

    /// Writes a word as an instruction would.
    pub fn bus_write16(&mut self, addr: u16, value: u16) {
        self.bus.write16(addr, value);
    }

    /// Register `n` of R0 to R15; 0 for others.
    #[must_use]
    pub fn reg(&self, n: usize) -> u16 {
        self.cpu.r.get(n).copied().unwrap_or(0)
    }

    /// Sets register `n` of R0 to R15.
    pub fn set_reg(&mut self, n: usize, value: u16) {
        if let Some(reg) = self.cpu.r.get_mut(n) {
            *reg = value;
        }
    }

    /// Stops runs before the instruction at `addr`.
    pub fn set_breakpoint(&mut self, addr: u16) {
        self.breakpoints.insert(addr);
    }

    /// Removes a breakpoint.
    pub fn clear_breakpoint(&mut self, addr: u16) {
        self.breakpoints.remove(&addr);
    }

    /// Broken rules so far, one for each kind and instruction.
    #[must_use]
    pub fn warnings(&self) -> &[Warning] {
        self.bus.warnings.list()
    }

    /// Forgets the warnings.
    pub fn clear_warnings(&mut self) {
        self.bus.warnings.clear();
    }

    /// Warns when the stack goes below `addr`, instead of where `program` set it.
    pub fn set_stack_limit(&mut self, addr: u16) {
        self.bus.stack_limit = addr;
    }

    /// Fills `first..=last` with `byte`, to see later what was touched.
    pub fn paint(&mut self, first: u16, last: u16, byte: u8) {
        let memory = self.bus.memory_mut();
        for at in &mut memory[usize::from(first)..=usize::from(last.max(first))] {
            *at = byte;
        }
    }

    /// Bytes from `first` upwards, at most to `last`, that still hold `byte`.
    #[must_use]
    pub fn untouched(&self, first: u16, last: u16, byte: u8) -> u16 {
        let painted = |addr: &u16| self.peek8(*addr) == byte;
        (first..=last).take_while(painted).count() as u16
    }

    /// Interrupt times, lowest stack pointer, profile.
    #[must_use]
    pub fn stats(&self) -> &Stats {
        &self.cpu.stats
    }

    /// Starts the measurements anew.
    pub fn clear_stats(&mut self) {
        self.cpu.stats.clear();
    }

    /// Counts cycles by address from now on, or no longer.
    pub fn profile(&mut self, on: bool) {
        self.cpu.stats.enable_profile(on);
    }

    /// Cycles of the profile by symbol, most first; what lies below the first symbol is `?`.
    #[must_use]
    pub fn profile_by_symbol(&self) -> Vec<(String, u64)> {
        let mut starts: Vec<(u16, &str)> =
            self.symbols.iter().map(|(name, addr)| (*addr, name.as_str())).collect();
        starts.sort_unstable();
        let mut sums: BTreeMap<&str, u64> = BTreeMap::new();
        for (word, cycles) in self.cpu.stats.profile().iter().enumerate().filter(|(_, c)| **c > 0) {
            let addr = (word * 2) as u16;
            let after = starts.partition_point(|(start, _)| *start <= addr);
            let name = after.checked_sub(1).map_or("?", |i| starts[i].1);
            *sums.entry(name).or_default() += cycles;
        }
        let mut list: Vec<(String, u64)> =
            sums.into_iter().map(|(name, cycles)| (name.to_owned(), cycles)).collect();
        list.sort_by_key(|(_, cycles)| std::cmp::Reverse(*cycles));
        list
    }

    /// Address of a symbol of the programmed image.
    #[must_use]
    pub fn symbol(&self, name: &str) -> Option<u16> {
        self.symbols.get(name).copied()
    }
}
