//! The MSP430 CPU: registers, decoded-instruction cache and interrupt entry.

pub mod cycles;
pub mod decode;
mod exec;
pub mod flags;
pub mod watch;

use crate::bus::Bus;
use crate::stats::Stats;
use decode::{Op, decode};
use flags::{CPUOFF, GIE, SCG0, SCG1};
use watch::Watch;

/// Program counter's register number.
pub const PC: usize = 0;
/// Stack pointer's register number.
pub const SP: usize = 1;
/// Status register's number.
pub const SR: usize = 2;

/// Words of the address space.
const WORDS: usize = 0x8000;

/// An array on the heap that never was on the stack.
fn boxed(op: Op) -> Box<[Op; WORDS]> {
    match vec![op; WORDS].into_boxed_slice().try_into() {
        Ok(array) => array,
        Err(_) => unreachable!("the vector has that length"),
    }
}

/// Registers and instruction cache.
#[derive(Clone)]
pub struct Cpu {
    /// R0 to R15.
    pub r: [u16; 16],
    /// One entry for each word address; entries with `words` 0 are not decoded yet.
    cache: Option<Box<[Op; WORDS]>>,
    /// The instruction after one that sets GIE runs before an interrupt is accepted.
    shadow: bool,
    /// Where bursts stop for an observer.
    pub watch: Watch,
    /// Stack, interrupt and profile measurements.
    pub stats: Stats,
}

impl Cpu {
    /// A CPU with all registers 0.
    pub fn new() -> Cpu {
        Cpu {
            r: [0; 16],
            cache: Some(boxed(Op::NONE)),
            shadow: false,
            watch: Watch::default(),
            stats: Stats::default(),
        }
    }

    /// Bursts stop in front of the instruction at `addr`, in flash, from now on.
    pub fn watch(&mut self, addr: u32) {
        self.watch.add(addr);
        self.invalidate(addr as u16, addr as u16);
    }

    /// Forgets decoded instructions that touch `start..=end`.
    pub fn invalidate(&mut self, start: u16, end: u16) {
        // An instruction reaches at most four bytes beyond its first word.
        let first = usize::from(start.saturating_sub(4) >> 1);
        let last = usize::from(end >> 1);
        if let Some(cache) = &mut self.cache {
            for entry in &mut cache[first..=last] {
                entry.words = 0;
            }
        }
    }

    /// Registers as after a PUC, with the program counter from the reset vector.
    pub fn reset(&mut self, vector: u16) {
        self.r[SR] = 0;
        self.r[PC] = vector & !1;
        self.shadow = false;
        self.watch.reset();
        self.stats.nesting.clear();
    }

    /// Program counter.
    #[inline]
    pub fn pc(&self) -> u32 {
        u32::from(self.r[PC])
    }

    /// Whether the CPU is switched off by its status register.
    #[inline]
    pub fn asleep(&self) -> bool {
        self.r[SR] & CPUOFF != 0
    }

    /// Whether a maskable interrupt is accepted now. Consumes the one-instruction delay after GIE.
    #[inline]
    pub fn accepts(&self) -> bool {
        self.r[SR] & GIE != 0 && (!self.shadow || self.asleep())
    }

    /// Runs until `bus.now` reaches `stop`, or something asks for attention. At least one
    /// instruction is executed.
    pub fn burst(&mut self, bus: &mut Bus, stop: u64) {
        // Taken out for the burst, so that an operation can be borrowed while it is executed.
        let Some(mut cache) = self.cache.take() else { return };
        if self.shadow {
            // One instruction, then the caller looks at interrupts again.
            self.shadow = false;
            self.step(bus, &mut cache);
            // The instruction that it was for has not been executed yet.
            self.shadow |= self.watch.has_trapped();
            bus.attention = true;
        } else {
            loop {
                self.step(bus, &mut cache);
                if bus.now >= stop || bus.attention {
                    break;
                }
            }
        }
        self.cache = Some(cache);
    }

    #[inline(always)]
    fn step(&mut self, bus: &mut Bus, cache: &mut [Op; WORDS]) {
        let pc = self.r[PC];
        let slot = usize::from(pc >> 1);
        if cache[slot].words == 0 {
            let watched = self.watch.has(pc.into());
            if watched && self.watch.stops(pc.into()) {
                bus.attention = true;
                return;
            }
            let op = decode(pc, |at| bus.fetch(at));
            if bus.fetch_fault(pc) {
                return;
            }
            if watched || !bus.is_flash(pc) {
                // Code outside flash may change at any time: it is decoded each time.
                self.begin(bus, pc, &op);
                self.execute(bus, &op);
                return;
            }
            cache[slot] = op;
        }
        let op = &cache[slot];
        self.begin(bus, pc, op);
        self.execute(bus, op);
    }

    #[inline(always)]
    fn begin(&mut self, bus: &mut Bus, pc: u16, op: &Op) {
        bus.pc = pc;
        self.r[PC] = pc.wrapping_add(2 * u16::from(op.words));
        bus.now += bus.cycle * u64::from(op.cycles);
        if self.stats.profiling {
            self.stats.count(pc.into(), op.cycles);
        }
    }

    /// Accepts the interrupt whose vector stands at `vector`.
    pub fn interrupt(&mut self, bus: &mut Bus, vector: u16, since: u64) {
        self.stats.enter(vector, self.r[SP], since, bus.now);
        bus.now += bus.cycle * cycles::INTERRUPT;
        let (pc, sr) = (self.r[PC], self.r[SR]);
        self.push(bus, pc);
        self.push(bus, sr);
        self.shadow = false;
        let old = self.r[SR];
        self.r[SR] &= SCG0;
        if old & (SCG1 | flags::OSCOFF) != 0 {
            bus.set_clock_gates(0);
        }
        self.r[PC] = bus.fetch(vector) & !1;
    }

    fn push(&mut self, bus: &mut Bus, value: u16) {
        self.r[SP] = self.r[SP].wrapping_sub(2);
        self.stats.stack(self.r[SP]);
        bus.check_stack(self.r[SP]);
        bus.write16(self.r[SP], value);
    }

    /// Writes a register as an instruction does, with what the special ones do to it.
    #[inline(always)]
    fn write_reg(&mut self, bus: &mut Bus, reg: u8, value: u16) {
        if reg > 3 {
            self.r[usize::from(reg & 15)] = value;
        } else {
            self.write_special(bus, reg, value);
        }
    }

    fn write_special(&mut self, bus: &mut Bus, reg: u8, value: u16) {
        match usize::from(reg) {
            PC => self.r[PC] = value & !1,
            SP => {
                self.r[SP] = value & !1;
                self.stats.stack(self.r[SP]);
            }
            SR => self.write_sr(bus, value),
            _ => {}
        }
    }

    fn write_sr(&mut self, bus: &mut Bus, value: u16) {
        let old = self.r[SR];
        self.r[SR] = value & 0x1FF;
        let changed = old ^ value;
        if changed & !(flags::C | flags::Z | flags::N | flags::V) != 0 {
            bus.attention = true;
            if changed & value & GIE != 0 {
                self.shadow = true;
            }
            if changed & (SCG1 | flags::OSCOFF) != 0 {
                bus.set_clock_gates(value);
            }
        }
    }
}

impl Default for Cpu {
    fn default() -> Self {
        Cpu::new()
    }
}
