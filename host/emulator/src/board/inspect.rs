//! What a debugger sees and does: memory, registers, breakpoints, warnings, measurements.

use std::collections::BTreeMap;

use super::Board;
use super::chip::with;
use crate::address::Address;
use crate::periph::watchdog::Kicks;
use crate::stats::Stats;
use crate::warn::Warning;

impl Board {
    /// A byte of memory as it is; peripherals read 0xFF.
    #[must_use]
    pub fn peek8(&self, addr: impl Address) -> u8 {
        with!(&self.chip, c => c.bus.memory()).get(addr.wide() as usize).copied().unwrap_or(0xFF)
    }

    /// A word of memory as it is; the address is rounded down to even.
    #[must_use]
    pub fn peek16(&self, addr: impl Address) -> u16 {
        let addr = addr.wide();
        u16::from_le_bytes([self.peek8(addr & !1), self.peek8(addr | 1)])
    }

    /// Changes a byte of memory, also in flash, without any of the chip's rules.
    pub fn poke8(&mut self, addr: impl Address, value: u8) {
        if let Some(byte) =
            with!(&mut self.chip, c => c.bus.memory_mut()).get_mut(addr.wide() as usize)
        {
            *byte = value;
        }
    }

    /// Changes a word of memory, also in flash, without any of the chip's rules.
    pub fn poke16(&mut self, addr: impl Address, value: u16) {
        let addr = addr.wide();
        let [low, high] = value.to_le_bytes();
        self.poke8(addr & !1, low);
        self.poke8(addr | 1, high);
    }

    /// Reads a byte as an instruction would: peripherals answer, and flags reset themselves.
    pub fn bus_read8(&mut self, addr: impl Address) -> u8 {
        with!(&mut self.chip, c => c.bus.read8(addr.wide() as _))
    }

    /// Reads a word as an instruction would.
    pub fn bus_read16(&mut self, addr: impl Address) -> u16 {
        with!(&mut self.chip, c => c.bus.read16(addr.wide() as _))
    }

    /// Writes a byte as an instruction would.
    pub fn bus_write8(&mut self, addr: impl Address, value: u8) {
        with!(&mut self.chip, c => c.bus.write8(addr.wide() as _, value));
    }

    /// Writes a word as an instruction would.
    pub fn bus_write16(&mut self, addr: impl Address, value: u16) {
        with!(&mut self.chip, c => c.bus.write16(addr.wide() as _, value));
    }

    /// Rate of SMCLK in hertz, 0 while it stands still.
    #[must_use]
    pub fn smclk_hz(&self) -> u64 {
        let ticks = with!(&self.chip, c => c.bus.smclk());
        self.ticks_per_second().checked_div(ticks).unwrap_or(0)
    }

    /// Low 16 bits of register `n` of R0 to R15; 0 for others.
    #[must_use]
    pub fn reg(&self, n: usize) -> u16 {
        self.far_reg(n) as u16
    }

    /// Register `n` of R0 to R15 with all bits that the core has; 0 for others.
    #[must_use]
    pub fn far_reg(&self, n: usize) -> u32 {
        with!(&self.chip, c => c.cpu.r.get(n).copied().map_or(0, u32::from))
    }

    /// Sets register `n` of R0 to R15.
    pub fn set_reg(&mut self, n: usize, value: impl Address) {
        let value = value.wide() & 0xF_FFFF;
        with!(&mut self.chip, c => if let Some(reg) = c.cpu.r.get_mut(n) {
            *reg = value as _;
        });
    }

    /// Stops runs before the instruction at `addr`.
    pub fn set_breakpoint(&mut self, addr: impl Address) {
        self.breakpoints.insert(addr.wide());
    }

    /// Removes a breakpoint.
    pub fn clear_breakpoint(&mut self, addr: impl Address) {
        self.breakpoints.remove(&addr.wide());
    }

    /// Stops runs in front of the instruction at `addr`, in flash, each time that it is reached: for an
    /// observer who lets the board run on. Neither the chip nor the speed of the rest notices.
    pub fn watch(&mut self, addr: impl Address) {
        let addr = addr.wide();
        with!(&mut self.chip, c => c.cpu.watch(addr));
    }

    /// Broken rules so far, one for each kind and instruction.
    #[must_use]
    pub fn warnings(&self) -> &[Warning] {
        with!(&self.chip, c => c.bus.warnings.list())
    }

    /// Forgets the warnings.
    pub fn clear_warnings(&mut self) {
        with!(&mut self.chip, c => c.bus.warnings.clear());
    }

    /// Warns when the stack goes below `addr`, instead of where `program` set it.
    pub fn set_stack_limit(&mut self, addr: impl Address) {
        with!(&mut self.chip, c => c.bus.stack_limit = addr.wide() as _);
    }

    /// Fills `first..=last` with `byte`, to see later what was touched.
    pub fn paint(&mut self, first: impl Address, last: impl Address, byte: u8) {
        let (first, last) = (first.wide(), last.wide());
        let memory = with!(&mut self.chip, c => c.bus.memory_mut());
        if let Some(range) = memory.get_mut(first as usize..=last.max(first) as usize) {
            range.fill(byte);
        }
    }

    /// Bytes from `first` upwards, at most to `last`, that still hold `byte`.
    #[must_use]
    pub fn untouched(&self, first: impl Address, last: impl Address, byte: u8) -> u16 {
        let (first, last) = (first.wide(), last.wide());
        let painted = |addr: &u32| self.peek8(*addr) == byte;
        (first..=last).take_while(painted).count() as u16
    }

    /// Interrupt times, lowest stack pointer, profile.
    #[must_use]
    pub fn stats(&self) -> &Stats {
        with!(&self.chip, c => &c.cpu.stats)
    }

    /// How often the watchdog's counter was cleared, times in ticks ([`Board::ticks_per_second`]).
    #[must_use]
    pub fn kicks(&self) -> Kicks {
        with!(&self.chip, c => c.bus.wdt.kicks)
    }

    /// Starts the measurements anew.
    pub fn clear_stats(&mut self) {
        with!(&mut self.chip, c => {
            c.cpu.stats.clear();
            c.bus.wdt.kicks = Kicks::default();
        });
    }

    /// Counts cycles by address from now on, or no longer.
    pub fn profile(&mut self, on: bool) {
        let words = self.part().end() / 2;
        with!(&mut self.chip, c => c.cpu.stats.enable_profile(on, words));
    }

    /// Cycles of the profile by symbol, most first; what lies below the first symbol is `?`.
    #[must_use]
    pub fn profile_by_symbol(&self) -> Vec<(String, u64)> {
        let mut starts: Vec<(u32, &str)> =
            self.symbols.iter().map(|(name, addr)| (*addr, name.as_str())).collect();
        starts.sort_unstable();
        let mut sums: BTreeMap<&str, u64> = BTreeMap::new();
        for (word, cycles) in self.stats().profile().iter().enumerate().filter(|(_, c)| **c > 0) {
            let addr = (word * 2) as u32;
            let after = starts.partition_point(|(start, _)| *start <= addr);
            let name = after.checked_sub(1).map_or("?", |i| starts[i].1);
            *sums.entry(name).or_default() += cycles;
        }
        let mut list: Vec<(String, u64)> =
            sums.into_iter().map(|(name, cycles)| (name.to_owned(), cycles)).collect();
        list.sort_by_key(|(_, cycles)| std::cmp::Reverse(*cycles));
        list
    }

    /// Address of a symbol of the programmed image in the low 64 KB.
    #[must_use]
    pub fn symbol(&self, name: &str) -> Option<u16> {
        self.far_symbol(name).and_then(|addr| addr.try_into().ok())
    }

    /// Address of a symbol of the programmed image.
    #[must_use]
    pub fn far_symbol(&self, name: &str) -> Option<u32> {
        self.symbols.get(name).copied()
    }
}
