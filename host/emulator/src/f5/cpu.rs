//! The MSP430X CPU: 20-bit registers, decoded-instruction cache and interrupt entry.

mod cycles;
mod decode;
mod exec;
mod extended;
mod operand;

use crate::cpu::flags::{self, CPUOFF, GIE, SCG0, SCG1};
use crate::cpu::watch::Watch;
use crate::cpu::{PC, SP, SR};
use crate::f5::bus::Bus;
use crate::stats::Stats;
use crate::warn::Kind as Warning;
use decode::{ADDRESS, Op, decode};

/// Cycles from an interrupt's acceptance to the first instruction of its handler.
const INTERRUPT: u64 = 6;

/// Registers and instruction cache.
#[derive(Clone)]
pub struct CpuX {
    /// R0 to R15, 20 bits each.
    pub r: [u32; 16],
    /// One entry for each word address below the end of flash; entries with `words` 0 are not
    /// decoded yet.
    cache: Vec<Op>,
    /// The instruction after one that sets GIE runs before an interrupt is accepted.
    shadow: bool,
    /// Where bursts stop for an observer.
    pub watch: Watch,
    /// Stack, interrupt and profile measurements.
    pub stats: Stats,
}

impl CpuX {
    /// A CPU with all registers 0, for memory that ends at `end`.
    pub fn new(end: usize) -> CpuX {
        CpuX {
            r: [0; 16],
            cache: vec![Op::NONE; end / 2],
            shadow: false,
            watch: Watch::default(),
            stats: Stats::default(),
        }
    }

    /// Bursts stop in front of the instruction at `addr`, in flash, from now on.
    pub fn watch(&mut self, addr: u32) {
        self.watch.add(addr);
        self.invalidate(addr, addr);
    }

    /// Forgets decoded instructions that touch `start..=end`.
    pub fn invalidate(&mut self, start: u32, end: u32) {
        // An instruction reaches at most eight bytes beyond its first word: erratum CPU40 looks at
        // the word behind a jump, an extension word has up to three behind it.
        let first = (start.saturating_sub(8) >> 1) as usize;
        let last = (end >> 1) as usize;
        for entry in self.cache.iter_mut().take(last + 1).skip(first) {
            entry.words = 0;
        }
    }

    /// Registers as after a PUC, with the program counter from the reset vector.
    pub fn reset(&mut self, vector: u16) {
        self.r[SR] = 0;
        self.r[PC] = u32::from(vector & !1);
        self.shadow = false;
        self.watch.reset();
        self.stats.nesting.clear();
    }

    /// Bits of the status register.
    #[inline(always)]
    fn sr(&self) -> u16 {
        self.r[SR] as u16
    }

    /// Program counter.
    #[inline]
    pub fn pc(&self) -> u32 {
        self.r[PC]
    }

    /// Whether the CPU is switched off by its status register.
    #[inline]
    pub fn asleep(&self) -> bool {
        self.sr() & CPUOFF != 0
    }

    /// Whether a maskable interrupt is accepted now.
    #[inline]
    pub fn accepts(&self) -> bool {
        self.sr() & GIE != 0 && (!self.shadow || self.asleep())
    }

    /// Runs until `bus.now` reaches `stop`, or something asks for attention. At least one
    /// instruction is executed.
    pub fn burst(&mut self, bus: &mut Bus, stop: u64) {
        // Taken out for the burst, so that an operation can be borrowed while it is executed.
        let mut cache = std::mem::take(&mut self.cache);
        if self.shadow {
            // One instruction, then the caller looks at interrupts again.
            self.shadow = false;
            self.step(bus, &mut cache);
            if self.watch.has_trapped() {
                // The instruction that it was for has not been executed yet.
                self.shadow = true;
            } else if self.sr() & GIE == 0 {
                bus.warn(Warning::InterruptsOnOff, bus.pc);
            }
            bus.attention = true;
        } else {
            loop {
                self.step(bus, &mut cache);
                if bus.now >= stop || bus.attention {
                    break;
                }
            }
        }
        self.cache = cache;
    }

    #[inline(always)]
    fn step(&mut self, bus: &mut Bus, cache: &mut [Op]) {
        let pc = self.r[PC];
        if let Some(op) = cache.get((pc >> 1) as usize)
            && op.words != 0
            && !bus.flash_is_busy()
        {
            self.begin(bus, pc, op);
            self.execute(bus, op);
            return;
        }
        self.step_uncached(bus, cache, pc);
    }

    /// An instruction that is seen for the first time, or does not lie in readable flash.
    fn step_uncached(&mut self, bus: &mut Bus, cache: &mut [Op], pc: u32) {
        let watched = self.watch.has(pc);
        if watched && self.watch.stops(pc) {
            bus.attention = true;
            return;
        }
        if bus.fetch_fault(pc) {
            return;
        }
        let op = decode(pc, |at| bus.fetch_code(at));
        if !watched && bus.is_flash(pc) && !bus.flash_is_busy() {
            if let Some(slot) = cache.get_mut((pc >> 1) as usize) {
                *slot = op;
            }
            if op.cpu40 {
                bus.pc = pc;
                bus.warn(Warning::JumpErratum, pc);
            }
        }
        // Code outside flash may change at any time: it is decoded each time.
        self.begin(bus, pc, &op);
        self.execute(bus, &op);
    }

    #[inline(always)]
    fn begin(&mut self, bus: &mut Bus, pc: u32, op: &Op) {
        bus.pc = pc;
        self.r[PC] = (pc + 2 * u32::from(op.words)) & ADDRESS;
        bus.now += bus.cycle * u64::from(op.cycles);
        if self.stats.profiling {
            self.stats.count(pc, op.cycles);
        }
    }

    /// Accepts the interrupt whose vector stands at `vector`: the program counter's upper bits are
    /// kept in those of the status register's word.
    pub fn interrupt(&mut self, bus: &mut Bus, vector: u16, since: u64) {
        self.stats.enter(vector, self.r[SP] as u16, since, bus.now);
        bus.now += bus.cycle * INTERRUPT;
        bus.in_handler = true;
        let (pc, sr) = (self.r[PC], self.sr());
        self.push(bus, pc as u16);
        self.push(bus, sr | (pc >> 4) as u16 & 0xF000);
        self.shadow = false;
        self.r[SR] &= u32::from(SCG0);
        bus.status = self.sr();
        if sr & (SCG1 | flags::OSCOFF) != 0 {
            bus.set_clock_gates(self.sr());
        }
        let at = bus.vector_address(vector);
        self.r[PC] = u32::from(bus.fetch_code(at) & !1);
    }

    fn push(&mut self, bus: &mut Bus, value: u16) {
        self.r[SP] = self.r[SP].wrapping_sub(2) & ADDRESS;
        self.stats.stack(self.r[SP] as u16);
        bus.check_stack(self.r[SP]);
        bus.write16(self.r[SP], value);
    }

    fn pop(&mut self, bus: &mut Bus) -> u16 {
        let value = bus.read16(self.r[SP]);
        self.r[SP] = (self.r[SP] + 2) & ADDRESS;
        value
    }

    /// Pushes 20 bits: the upper four above the lower sixteen.
    fn push_address(&mut self, bus: &mut Bus, value: u32) {
        self.push(bus, (value >> 16) as u16);
        self.push(bus, value as u16);
    }

    fn pop_address(&mut self, bus: &mut Bus) -> u32 {
        let low = u32::from(self.pop(bus));
        (low | u32::from(self.pop(bus)) << 16) & ADDRESS
    }

    /// Writes a register as an instruction does, with what the special ones do to it.
    #[inline(always)]
    fn write_reg(&mut self, bus: &mut Bus, reg: u8, value: u32) {
        if reg > 3 {
            self.r[usize::from(reg & 15)] = value;
        } else {
            self.write_special(bus, reg, value);
        }
    }

    fn write_special(&mut self, bus: &mut Bus, reg: u8, value: u32) {
        match usize::from(reg) {
            PC => self.r[PC] = value & ADDRESS & !1,
            SP => {
                self.r[SP] = value & ADDRESS & !1;
                self.stats.stack(self.r[SP] as u16);
            }
            SR => self.write_sr(bus, value as u16),
            _ => {}
        }
    }

    fn write_sr(&mut self, bus: &mut Bus, value: u16) {
        let old = self.sr();
        self.r[SR] = u32::from(value & 0x1FF);
        let changed = old ^ value;
        if changed & !(flags::C | flags::Z | flags::N | flags::V) != 0 {
            bus.status = value;
            bus.attention = true;
            if changed & value & GIE != 0 {
                self.shadow = true;
            }
            if changed & (SCG0 | SCG1 | flags::OSCOFF) != 0 {
                bus.set_clock_gates(value);
            }
        }
    }

    /// Flags only.
    #[inline(always)]
    fn set_flags(&mut self, sr: u16) {
        self.r[SR] = u32::from(sr);
    }
}
