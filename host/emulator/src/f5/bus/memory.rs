//! Reads and writes by address.

use super::{BLOCK_BITS, BLOCKS, BYTES, Block, Bus};
use crate::reset::Reset;
use crate::warn::Kind;

/// What reads of vacant and protected addresses give: the code of `JMP $`.
const VACANT: u16 = 0x3FFF;
/// First address behind the peripherals.
const PERIPHERALS_END: u32 = 0x1000;
/// Protected flash of the boot loader, and the boot code behind the device descriptor.
const PROTECTED: [std::ops::Range<u32>; 2] = [0x1000..0x1800, 0x1B00..0x1C00];
/// Device descriptor.
const DESCRIPTOR: std::ops::Range<u32> = 0x1A00..0x1B00;

/// Place of an address of RAM or flash in what is kept of memory.
#[inline(always)]
fn place(addr: u32) -> usize {
    addr as usize & (BYTES - 1)
}

impl Bus {
    #[inline(always)]
    fn block(&self, addr: u32) -> Block {
        self.map[(addr >> BLOCK_BITS) as usize & (BLOCKS - 1)]
    }

    /// Whether `addr` is in flash or information memory.
    #[inline]
    pub fn is_flash(&self, addr: u32) -> bool {
        self.block(addr) == Block::Flash
    }

    /// Whether code in RAM has a flash operation under way.
    #[inline(always)]
    pub fn flash_is_busy(&self) -> bool {
        self.now < self.flash.busy_until
    }

    /// Reads a code word of the first 64 KB.
    pub fn fetch(&mut self, addr: u16) -> u16 {
        self.fetch_code(addr.into())
    }

    /// Reads a code word.
    pub fn fetch_code(&mut self, addr: u32) -> u16 {
        match self.block(addr) {
            Block::Slow => VACANT,
            Block::Flash if self.flash_is_busy() => self.busy_read(addr),
            _ => self.word(addr),
        }
    }

    /// An instruction at `pc`: true when the part resets instead of executing it.
    #[inline]
    pub fn fetch_fault(&mut self, pc: u32) -> bool {
        if self.block(pc) != Block::Slow {
            return false;
        }
        self.pc = pc;
        if pc < PERIPHERALS_END {
            self.warn(Kind::FetchFault, pc);
            self.now += self.cycle;
            self.ask_reset(Reset::Fetch);
            return true;
        }
        self.warn(Kind::Unmapped, pc);
        false
    }

    /// A word of memory as it is.
    pub fn word(&self, addr: u32) -> u16 {
        let at = place(addr & !1);
        u16::from_le_bytes([self.mem[at], self.mem[at | 1]])
    }

    /// All of memory as it is; peripherals are not in it.
    pub fn memory(&self) -> &[u8] {
        &self.mem[..self.part.end()]
    }

    /// Memory for loaders and tests. Code may have changed afterwards.
    pub fn memory_mut(&mut self) -> &mut [u8] {
        self.code_changed = Some((0, BYTES as u32 - 1));
        self.attention = true;
        &mut self.mem[..self.part.end()]
    }

    /// Reads a byte as an instruction does.
    #[inline(always)]
    pub fn read8(&mut self, addr: u32) -> u8 {
        match self.block(addr) {
            Block::Ram => self.mem[place(addr)],
            Block::Flash if !self.flash_is_busy() => self.mem[place(addr)],
            _ => (self.slow_read(addr, true) >> (8 * (addr & 1))) as u8,
        }
    }

    /// Reads a word as an instruction does.
    #[inline(always)]
    pub fn read16(&mut self, addr: u32) -> u16 {
        if addr & 1 != 0 {
            self.warn(Kind::Unaligned, addr);
        }
        match self.block(addr) {
            Block::Ram => self.word(addr),
            Block::Flash if !self.flash_is_busy() => self.word(addr),
            _ => self.slow_read(addr & !1, false),
        }
    }

    /// Writes a byte as an instruction does.
    #[inline(always)]
    pub fn write8(&mut self, addr: u32, value: u8) {
        if self.block(addr) == Block::Ram {
            self.mem[place(addr)] = value;
        } else {
            let shift = 8 * (addr & 1);
            self.slow_write(addr, u16::from(value) << shift, 0xFF << shift);
        }
    }

    /// Writes a word as an instruction does.
    #[inline(always)]
    pub fn write16(&mut self, addr: u32, value: u16) {
        if addr & 1 != 0 {
            self.warn(Kind::Unaligned, addr);
        }
        let addr = addr & !1;
        if self.block(addr) == Block::Ram {
            let at = place(addr);
            self.mem[at] = value as u8;
            self.mem[at | 1] = (value >> 8) as u8;
        } else {
            self.slow_write(addr, value, 0xFFFF);
        }
    }

    /// The stack pointer went down to `sp`.
    #[inline(always)]
    pub fn check_stack(&mut self, sp: u32) {
        if sp < self.stack_limit {
            self.warn(Kind::Stack, sp);
        }
    }

    /// Brings the peripherals up to date before a register is touched.
    #[inline]
    pub(super) fn catch_up(&mut self) {
        if self.next_event <= self.now {
            self.service();
        }
    }

    /// Vacant memory: the flag, and the warning.
    fn vacant(&mut self, addr: u32) {
        self.warn(Kind::Unmapped, addr);
        self.sys.ifg |= crate::f5::periph::sys::VMA;
        self.update();
    }

    /// The word at the even address of what is neither RAM nor readable flash. `byte` is the width
    /// of the access.
    fn slow_read(&mut self, addr: u32, byte: bool) -> u16 {
        if self.is_flash(addr) {
            return self.busy_read(addr);
        }
        self.catch_up();
        if addr < PERIPHERALS_END {
            return self.read_register(addr as u16, byte).unwrap_or_else(|| {
                self.warn(Kind::Unmapped, addr);
                0
            });
        }
        if DESCRIPTOR.contains(&addr) {
            return self.word(addr);
        }
        if !PROTECTED.iter().any(|range| range.contains(&addr)) {
            self.vacant(addr);
        }
        VACANT
    }

    fn slow_write(&mut self, addr: u32, value: u16, mask: u16) {
        if self.is_flash(addr) {
            return self.write_flash(addr, value, mask);
        }
        self.catch_up();
        if addr < PERIPHERALS_END {
            self.write_register(addr as u16, value, mask);
        } else {
            self.vacant(addr);
        }
    }

    /// A read or fetch of flash while it is busy.
    #[cold]
    pub(super) fn busy_read(&mut self, addr: u32) -> u16 {
        let (first, last) = self.flash.busy_range;
        if !(first..=last).contains(&addr) {
            return self.word(addr);
        }
        self.warn(Kind::FlashBusy, addr);
        if self.flash.row.is_some() {
            self.flash.abort_block();
        }
        VACANT
    }
}
