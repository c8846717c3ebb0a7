//! The virtual board: chip, plant and serial line, run by time.

use std::collections::{BTreeMap, BTreeSet};

use crate::TICKS_PER_SECOND;
use crate::bus::{Bus, Reset};
use crate::cpu::{Cpu, PC, cycles};
use crate::line::Format;
use crate::load::Image;
use crate::part::Part;
use crate::periph::flash::Wear;
use crate::plant::{Plant, Wiring};
use crate::record::{Edge, EdgeSink};
use crate::rng::Rng;
use crate::stats::Stats;
use crate::warn::Warning;

/// What a board is made of.
#[derive(Debug, Clone)]
pub struct Config {
    /// The chip.
    pub part: Part,
    /// What hangs on its pins.
    pub wiring: Wiring,
    /// Rate of the VLO in hertz; the data sheet allows 4000 to 20 000.
    pub vlo_hz: u64,
    /// Supply voltage in millivolts.
    pub vcc: u32,
    /// Seed of what RAM holds at power-up.
    pub seed: u64,
}

impl Default for Config {
    fn default() -> Self {
        Config { part: Part::G2553, wiring: Wiring::default(), vlo_hz: 12_000, vcc: 3_300, seed: 1 }
    }
}

/// Why a run came back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The time was reached.
    Time,
    /// The program counter reached a breakpoint; the instruction has not been executed.
    Breakpoint(u16),
    /// An output changed while `Plant::stop_at_output` is set.
    Output,
    /// Power failed during a flash operation, or the board is switched off.
    NoPower,
}

/// A board under power, or without.
pub struct Board {
    cpu: Cpu,
    bus: Bus,
    powered: bool,
    breakpoints: BTreeSet<u16>,
    symbols: BTreeMap<String, u16>,
    ram: Rng,
    world_changed: bool,
    last_reset: Reset,
}

impl Board {
    /// A G2553 board with the default wiring, programmed with `image` and powered up.
    #[must_use]
    pub fn new(part: Part, image: &Image) -> Board {
        Board::with_config(&Config { part, ..Config::default() }, image)
    }

    /// A board as `config` says, programmed with `image` and powered up.
    #[must_use]
    pub fn with_config(config: &Config, image: &Image) -> Board {
        let plant = Plant::new(config.wiring);
        let mut board = Board {
            cpu: Cpu::new(),
            bus: Bus::new(config.part.clone(), plant, config.vlo_hz, config.vcc),
            powered: false,
            breakpoints: BTreeSet::new(),
            symbols: BTreeMap::new(),
            ram: Rng::new(config.seed),
            world_changed: false,
            last_reset: Reset::Power,
        };
        board.program(image);
        board.power_up();
        board
    }

    /// Programs `image` as a flash tool does, without the controller's rules, and takes over its
    /// symbols. The chip is not reset.
    pub fn program(&mut self, image: &Image) {
        let memory = self.bus.memory_mut();
        for segment in &image.segments {
            let start = usize::from(segment.addr);
            for (at, byte) in memory.iter_mut().skip(start).zip(&segment.data) {
                *at = *byte;
            }
        }
        self.symbols.clone_from(&image.symbols);
    }

    /// Ticks of 62.5 ns since the first power-up: cycles at 16 MHz.
    #[must_use]
    pub fn cycles(&self) -> u64 {
        self.bus.now
    }

    /// Runs for `ticks` of 62.5 ns.
    pub fn run_for(&mut self, ticks: u64) -> Stop {
        self.run_until(self.bus.now.saturating_add(ticks))
    }

    /// Runs for `us` microseconds.
    pub fn run_us(&mut self, us: u64) -> Stop {
        self.run_for(us.saturating_mul(TICKS_PER_SECOND / 1_000_000))
    }

    /// Runs until `cycles()` reaches `limit`. The instruction under way is finished, so the time
    /// may be a little later. A board without power lets the time pass.
    pub fn run_until(&mut self, limit: u64) -> Stop {
        let mut resumed = true;
        loop {
            if let Some(stop) = self.attend(limit) {
                return stop;
            }
            if self.interrupt() {
                continue;
            }
            let bus = &mut self.bus;
            let until = bus.next_event.min(limit);
            if self.cpu.asleep() {
                if until == u64::MAX {
                    // Nothing will ever happen again.
                    return Stop::Time;
                }
                bus.now = bus.now.max(until);
            } else if self.breakpoints.is_empty() {
                self.cpu.burst(bus, until);
            } else {
                let pc = self.cpu.r[PC];
                if !resumed && self.breakpoints.contains(&pc) {
                    return Stop::Breakpoint(pc);
                }
                self.cpu.burst(bus, 0);
            }
            resumed = false;
        }
    }

    /// Executes one instruction, or sleeps to the next event, or accepts an interrupt.
    pub fn step(&mut self) -> Stop {
        if let Some(stop) = self.attend(u64::MAX) {
            return stop;
        }
        if !self.interrupt() {
            if self.cpu.asleep() {
                if !self.bus.quiet() {
                    self.bus.now = self.bus.now.max(self.bus.next_event);
                }
            } else {
                self.cpu.burst(&mut self.bus, 0);
            }
        }
        Stop::Time
    }

    /// Everything that is due between two instructions. `Some` ends the run.
    fn attend(&mut self, limit: u64) -> Option<Stop> {
        loop {
            let bus = &mut self.bus;
            if std::mem::take(&mut self.world_changed) {
                bus.world_changed();
            }
            bus.attention = false;
            if let Some((start, end)) = bus.code_changed.take() {
                self.cpu.invalidate(start, end);
            }
            if bus.power_lost || !self.powered {
                bus.power_lost = false;
                self.powered = false;
                if limit != u64::MAX {
                    bus.now = bus.now.max(limit);
                }
                return Some(Stop::NoPower);
            }
            if let Some(reset) = bus.reset.take() {
                self.reset(reset);
                continue;
            }
            if bus.next_event <= bus.now {
                bus.service();
                continue;
            }
            if std::mem::take(&mut bus.plant.output_changed) && bus.plant.stop_at_output {
                return Some(Stop::Output);
            }
            return (bus.now >= limit).then_some(Stop::Time);
        }
    }

    fn interrupt(&mut self) -> bool {
        if self.bus.irq == 0 {
            return false;
        }
        let Some((vector, since)) = self.bus.pending(self.cpu.accepts()) else {
            return false;
        };
        self.cpu.interrupt(&mut self.bus, vector, since);
        self.bus.accepted(vector);
        true
    }

    fn reset(&mut self, reset: Reset) {
        self.last_reset = reset;
        self.bus.apply_reset(reset);
        let vector = self.bus.fetch(0xFFFE);
        self.cpu.reset(vector);
        self.bus.now += cycles::RESET * self.bus.cycle;
    }

    /// Pulls the RST pin low for an instant.
    pub fn reset_pin(&mut self) {
        if self.powered {
            self.reset(Reset::Pin);
        }
    }

    /// The supply dips below the brown-out level and comes back; RAM keeps its content.
    pub fn brown_out(&mut self) {
        if self.powered {
            self.reset(Reset::Power);
        }
    }

    /// Switches the supply off. Flash, wear and the mechanics of the plant stay.
    pub fn power_cut(&mut self) {
        self.powered = false;
    }

    /// Switches the supply on, after `power_cut` or a power failure: RAM holds noise, the chip starts
    /// from its reset vector.
    pub fn power_up(&mut self) {
        self.powered = true;
        self.bus.power_lost = false;
        self.bus.reset = None;
        let ram = self.bus.part().ram.clone();
        let noise = &mut self.ram;
        for byte in &mut self.bus.memory_mut()[usize::from(*ram.start())..=usize::from(*ram.end())]
        {
            *byte = noise.bits() as u8;
        }
        self.bus.plant.power_up();
        self.reset(Reset::Power);
    }

    /// Whether the board has power.
    #[must_use]
    pub fn powered(&self) -> bool {
        self.powered
    }

    /// What caused the latest reset.
    #[must_use]
    pub fn last_reset(&self) -> Reset {
        self.last_reset
    }

    /// Lets power fail during a flash operation: the first from now has number 1. A write leaves each
    /// of its bits done or not, an erase leaves a half erased segment, both as `seed` decides.
    pub fn cut_at_flash_operation(&mut self, number: u64, seed: u64) {
        self.bus.flash.cut = Some((self.bus.flash.wear.operations + number, seed));
    }

    /// Erase counts of the segments and the number of flash operations so far.
    #[must_use]
    pub fn wear(&self) -> &Wear {
        &self.bus.flash.wear
    }

    /// Information memory and main flash, lowest address first: what survives power-off.
    #[must_use]
    pub fn flash_contents(&self) -> Vec<u8> {
        let (info, main) = self.flash_ranges();
        let memory = self.bus.memory();
        [&memory[info], &memory[main]].concat()
    }

    /// Puts back what `flash_contents` gave.
    ///
    /// # Errors
    /// When the length is not that of the part's flash.
    pub fn set_flash_contents(&mut self, content: &[u8]) -> Result<(), FlashSize> {
        let (info, main) = self.flash_ranges();
        let want = info.len() + main.len();
        if content.len() != want {
            return Err(FlashSize { want, got: content.len() });
        }
        let (a, b) = content.split_at(info.len());
        let memory = self.bus.memory_mut();
        memory[info].copy_from_slice(a);
        memory[main].copy_from_slice(b);
        Ok(())
    }

    fn flash_ranges(&self) -> (std::ops::Range<usize>, std::ops::Range<usize>) {
        let part = self.bus.part();
        let range =
            |r: &std::ops::RangeInclusive<u16>| usize::from(*r.start())..usize::from(*r.end()) + 1;
        (range(&part.info), range(&part.flash))
    }

    /// The world around the pins; changes take effect at the present time.
    pub fn plant_mut(&mut self) -> &mut Plant {
        self.world_changed = true;
        &mut self.bus.plant
    }

    /// The world around the pins.
    #[must_use]
    pub fn plant(&self) -> &Plant {
        &self.bus.plant
    }

    /// Sets rate and parity of the host's port.
    pub fn set_uart_format(&mut self, format: Format) {
        self.bus.line.format = format;
    }

    /// Queues characters on the line to the chip, at the host's rate and behind what is queued
    /// already. Returns the time when the last of them has left.
    pub fn uart_send(&mut self, bytes: &[u8]) -> u64 {
        let end = self.bus.line.send(bytes, self.bus.now);
        self.world_changed = true;
        end
    }

    /// Queues raw levels on the line to the chip, each for a number of ticks: glitches, breaks.
    pub fn uart_send_raw(&mut self, levels: &[(bool, u64)]) {
        self.bus.line.send_raw(levels, self.bus.now);
        self.world_changed = true;
    }

    /// When everything queued on the line has left.
    #[must_use]
    pub fn uart_free(&self) -> u64 {
        self.bus.line.free().max(self.bus.now)
    }

    /// Characters that the chip sent, each with the time of its stop bit.
    pub fn uart_take(&mut self) -> Vec<(u64, u8)> {
        self.bus.line.take(self.bus.now)
    }

    /// Characters from the chip that had wrong parity or no stop bit.
    #[must_use]
    pub fn uart_errors(&self) -> u64 {
        self.bus.line.errors
    }

    /// Flips `per_million` of all bits on the line in both directions; 0 ends it.
    pub fn set_uart_noise(&mut self, seed: u64, per_million: u32) {
        self.bus.line.set_noise(seed, per_million);
    }

    /// Keeps edges from now on, or no longer.
    pub fn record(&mut self, on: bool) {
        self.bus.plant.recorder.on = on;
    }

    /// Edges since the last call.
    pub fn take_edges(&mut self) -> Vec<Edge> {
        std::mem::take(&mut self.bus.plant.recorder.edges)
    }

    /// Tells `sink` of every edge as it happens; `None` ends that.
    pub fn set_edge_sink(&mut self, sink: Option<EdgeSink>) {
        self.bus.plant.recorder.sink = sink;
    }

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

    /// Warns when the stack goes below `addr`.
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

/// Flash content of the wrong length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FlashSize {
    /// Bytes that the part has.
    pub want: usize,
    /// Bytes that were given.
    pub got: usize,
}

impl std::fmt::Display for FlashSize {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "flash content of {} bytes, but the part has {}", self.got, self.want)
    }
}

impl std::error::Error for FlashSize {}
