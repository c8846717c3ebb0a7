//! The virtual board: chip, plant and serial line, run by time.

mod flash;
mod inspect;
mod outside;

use std::collections::{BTreeMap, BTreeSet};

use crate::TICKS_PER_SECOND;
use crate::bus::{Bus, Reset};
use crate::cpu::{Cpu, PC, cycles};
use crate::load::Image;
use crate::part::Part;
use crate::plant::{Plant, Wiring};
use crate::rng::Rng;

pub use flash::FlashSize;

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
    /// Bits that a power cut caught in the middle of a write or an erase read as 0 or 1 anew at
    /// each power-up, until they are written again or erased; else as they fell at the cut.
    pub unstable_bits: bool,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            part: Part::G2553,
            wiring: Wiring::default(),
            vlo_hz: 12_000,
            vcc: 3_300,
            seed: 1,
            unstable_bits: false,
        }
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
    /// A flash operation was completed, and `stop_at_flash` is set.
    Flash,
    /// Power failed during a flash operation, or the board is switched off.
    NoPower,
}

/// A board under power, or without.
///
/// A clone is a board of its own in the very same state, with what is still on the serial line, so
/// that one run can be tried out in many ways from the same instant. Only the edge sink is not
/// copied.
#[derive(Clone)]
pub struct Board {
    cpu: Cpu,
    bus: Bus,
    powered: bool,
    breakpoints: BTreeSet<u16>,
    symbols: BTreeMap<String, u16>,
    noise: Rng,
    unstable_bits: bool,
    stop_at_flash: bool,
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
            noise: Rng::new(config.seed),
            unstable_bits: config.unstable_bits,
            stop_at_flash: false,
            world_changed: false,
            last_reset: Reset::Power,
        };
        board.program(image);
        board.power_up();
        board
    }

    /// Programs `image` as a flash tool does, without the controller's rules, and takes over its
    /// symbols. The chip is not reset. The stack limit is the end of `.bss` when the image says
    /// where that is, else the start of RAM.
    pub fn program(&mut self, image: &Image) {
        let memory = self.bus.memory_mut();
        for segment in &image.segments {
            let start = usize::from(segment.addr);
            for (at, byte) in memory.iter_mut().skip(start).zip(&segment.data) {
                *at = *byte;
            }
        }
        self.symbols.clone_from(&image.symbols);
        let ram = self.bus.part().ram.clone();
        let data_end = ["_edata", "_ebss"].iter().filter_map(|name| image.symbol(name));
        let in_ram = data_end.filter(|end| ram.contains(end)).max();
        self.bus.stack_limit = in_ram.unwrap_or(*ram.start());
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
            if std::mem::take(&mut bus.power_lost) {
                self.power_cut();
                return Some(Stop::NoPower);
            }
            if !self.powered {
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
            if std::mem::take(&mut bus.flash_written) && self.stop_at_flash {
                return Some(Stop::Flash);
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

    /// Changes the supply voltage, in millivolts; only the ADC sees it.
    pub fn set_supply(&mut self, vcc: u32) {
        self.bus.vcc = vcc;
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

    /// Switches the supply off: no pin is driven any more. Flash, wear and the mechanics of the
    /// plant stay.
    pub fn power_cut(&mut self) {
        self.powered = false;
        self.bus.power_off();
    }

    /// Switches the supply on, after `power_cut` or a power failure: RAM holds noise, the chip starts
    /// from its reset vector.
    pub fn power_up(&mut self) {
        self.powered = true;
        let ram = self.bus.part().ram.clone();
        let noise = &mut self.noise;
        for byte in &mut self.bus.memory_mut()[usize::from(*ram.start())..=usize::from(*ram.end())]
        {
            *byte = noise.bits() as u8;
        }
        self.power_back();
    }

    /// The supply comes back, behind a failure, before RAM has lost its content: a brown-out.
    pub fn power_back(&mut self) {
        self.powered = true;
        let noise = &mut self.noise;
        self.bus.power_up(self.unstable_bits.then_some(noise));
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
}
