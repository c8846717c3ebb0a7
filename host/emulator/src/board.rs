//! The virtual board: chip, plant and serial line, run by time.

mod chip;
mod flash;
mod inspect;
mod outside;

use std::collections::{BTreeMap, BTreeSet};

use crate::bus::{Bus, Supply};
use crate::cpu::Cpu;
use crate::f5::bus::Bus as BusX;
use crate::f5::cpu::CpuX;
use crate::f5::silicon::Silicon;
use crate::load::Image;
use crate::part::{Family, Part};
use crate::plant::{Plant, Wiring};
use crate::reset::Reset;
use crate::rng::Rng;
use crate::warn::Kind as Rule;

pub use flash::FlashSize;
pub use outside::Link;

use chip::{Chip, Msp430, Msp430X, with};

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
    /// Microseconds that the supply takes from the chip's start, at about 1.4 V, to there; of
    /// the G2553, as are the two that follow.
    pub supply_rise_us: u64,
    /// How far the DCO is off at all its settings, in millionths; the data sheet allows 30 000 from 0
    /// to 85 degrees Celsius. A tick stays a cycle of 16 MHz as the chip has it.
    pub dco_ppm: i32,
    /// Microseconds that the chip's pull-ups take to bring the wire of an open contact up.
    pub pull_up_us: u64,
    /// Seed of what RAM holds at power-up.
    pub seed: u64,
    /// Bits that a power cut caught in the middle of a write or an erase read as 0 or 1 anew at
    /// each power-up, until they are written again or erased; else as they fell at the cut.
    pub unstable_bits: bool,
    /// What differs from piece to piece of an MSP430x5xx, or is not known of it.
    pub silicon: Silicon,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            part: Part::G2553,
            wiring: Wiring::default(),
            vlo_hz: 12_000,
            vcc: 3_300,
            supply_rise_us: 0,
            dco_ppm: 0,
            pull_up_us: 0,
            seed: 1,
            unstable_bits: false,
            silicon: Silicon::default(),
        }
    }
}

/// Why a run came back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The time was reached.
    Time,
    /// The program counter reached a breakpoint; the instruction has not been executed.
    Breakpoint(u32),
    /// The program counter reached an address of [`Board::watch`]; the instruction has not been
    /// executed, and will be when the board runs on.
    Watched(u32),
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
    chip: Chip,
    powered: bool,
    breakpoints: BTreeSet<u32>,
    symbols: BTreeMap<String, u32>,
    noise: Rng,
    unstable_bits: bool,
    stop_at_flash: bool,
    world_changed: bool,
    last_reset: Reset,
}

impl Board {
    /// A board with the default wiring, programmed with `image` and powered up.
    #[must_use]
    pub fn new(part: Part, image: &Image) -> Board {
        Board::with_config(&Config { part, ..Config::default() }, image)
    }

    /// A board as `config` says, programmed with `image` and powered up.
    #[must_use]
    pub fn with_config(config: &Config, image: &Image) -> Board {
        let part = config.part.clone();
        let plant = Plant::around(&part, config.wiring);
        let chip = match part.family {
            Family::Msp430 => {
                let supply = Supply::new(config.vcc, config.supply_rise_us);
                let delay = config.pull_up_us.saturating_mul(part.ticks_per_second / 1_000_000);
                let mut bus = Bus::new(part, plant, config.vlo_hz, supply);
                bus.wires.delay = delay;
                bus.set_dco(config.dco_ppm);
                Chip::Msp430(Box::new(Msp430 { cpu: Cpu::new(), bus }))
            }
            Family::Msp430X => Chip::Msp430X(Box::new(Msp430X {
                cpu: CpuX::new(part.end()),
                bus: BusX::new(part, plant, config.vlo_hz, config.vcc, config.silicon.clone()),
            })),
        };
        let mut board = Board {
            chip,
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
        let memory = with!(&mut self.chip, c => c.bus.memory_mut());
        let mut outside = None;
        for segment in &image.segments {
            let start = segment.addr as usize;
            for (at, byte) in memory.iter_mut().skip(start).zip(&segment.data) {
                *at = *byte;
            }
            if start + segment.data.len() > memory.len() {
                outside = Some(segment.addr);
            }
        }
        if let Some(addr) = outside {
            with!(&mut self.chip, c => c.bus.warn_far(Rule::Unmapped, addr));
        }
        self.symbols.clone_from(&image.symbols);
        let ram = self.part().ram.clone();
        let data_end = ["_edata", "_ebss"].iter().filter_map(|name| image.symbol(name));
        let in_ram = data_end.filter(|end| ram.contains(end)).max();
        self.set_stack_limit(in_ram.unwrap_or(*ram.start()));
    }

    /// The part on the board.
    #[must_use]
    pub fn part(&self) -> &Part {
        with!(&self.chip, c => c.bus.part())
    }

    /// Ticks in a second of this board: every time that it takes or tells is counted in them.
    #[must_use]
    pub fn ticks_per_second(&self) -> u64 {
        self.part().ticks_per_second
    }

    /// Ticks since the first power-up.
    #[must_use]
    pub fn cycles(&self) -> u64 {
        with!(&self.chip, c => c.bus.now)
    }

    /// Runs for a number of ticks.
    pub fn run_for(&mut self, ticks: u64) -> Stop {
        self.run_until(self.cycles().saturating_add(ticks))
    }

    /// Runs for `us` microseconds.
    pub fn run_us(&mut self, us: u64) -> Stop {
        self.run_for(us.saturating_mul(self.ticks_per_second() / 1_000_000))
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
            let idle = with!(&mut self.chip, c => {
                let until = c.bus.next_event.min(limit);
                if c.cpu.asleep() {
                    c.bus.now = c.bus.now.max(until);
                    until == u64::MAX
                } else if self.breakpoints.is_empty() {
                    c.cpu.burst(&mut c.bus, until);
                    false
                } else {
                    let pc = c.cpu.pc();
                    if !resumed && self.breakpoints.contains(&pc) {
                        return Stop::Breakpoint(pc);
                    }
                    c.cpu.burst(&mut c.bus, 0);
                    false
                }
            });
            if idle {
                // Nothing will ever happen again.
                return Stop::Time;
            }
            resumed = false;
            if let Some(addr) = with!(&mut self.chip, c => c.cpu.watch.take()) {
                return Stop::Watched(addr);
            }
        }
    }

    /// Executes one instruction, or sleeps to the next event, or accepts an interrupt.
    pub fn step(&mut self) -> Stop {
        if let Some(stop) = self.attend(u64::MAX) {
            return stop;
        }
        if !self.interrupt() {
            with!(&mut self.chip, c => {
                if !c.cpu.asleep() {
                    c.cpu.burst(&mut c.bus, 0);
                } else if !c.bus.quiet() {
                    c.bus.now = c.bus.now.max(c.bus.next_event);
                }
            });
            if let Some(addr) = with!(&mut self.chip, c => c.cpu.watch.take()) {
                return Stop::Watched(addr);
            }
        }
        Stop::Time
    }

    /// Everything that is due between two instructions. `Some` ends the run.
    fn attend(&mut self, limit: u64) -> Option<Stop> {
        loop {
            let world_changed = std::mem::take(&mut self.world_changed);
            let reset = with!(&mut self.chip, c => {
                let bus = &mut c.bus;
                if world_changed {
                    bus.world_changed();
                }
                bus.attention = false;
                if let Some((start, end)) = bus.code_changed.take() {
                    c.cpu.invalidate(start, end);
                }
                if std::mem::take(&mut bus.power_lost) {
                    self.powered = false;
                    bus.power_off();
                    return Some(Stop::NoPower);
                }
                if !self.powered {
                    if limit != u64::MAX {
                        bus.now = bus.now.max(limit);
                    }
                    return Some(Stop::NoPower);
                }
                let reset = bus.reset.take();
                if reset.is_none() {
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
                reset
            });
            if let Some(reset) = reset {
                self.reset(reset);
            }
        }
    }

    fn interrupt(&mut self) -> bool {
        with!(&mut self.chip, c => {
            if c.bus.irq == 0 {
                return false;
            }
            let Some((vector, since)) = c.bus.pending(c.cpu.accepts()) else {
                return false;
            };
            c.cpu.interrupt(&mut c.bus, vector, since);
            c.bus.accepted(vector);
            true
        })
    }

    fn reset(&mut self, reset: Reset) {
        self.last_reset = reset;
        with!(&mut self.chip, c => {
            c.bus.apply_reset(reset);
            let vector = c.bus.fetch(0xFFFE);
            c.cpu.reset(vector);
            c.bus.now += crate::cpu::cycles::RESET * c.bus.cycle;
        });
    }

    /// Changes the supply voltage, in millivolts: the ADC of the G2553 sees it, and a rate that is too
    /// high for it is a warning; supervisors and flash of the MSP430x5xx see it.
    pub fn set_supply(&mut self, vcc: u32) {
        with!(&mut self.chip, c => c.bus.set_supply(vcc));
    }

    /// The DCO of the G2553 drifts: it is off by so many millionths from now on. The F5529's is locked
    /// to its reference.
    pub fn set_dco_ppm(&mut self, ppm: i32) {
        if let Chip::Msp430(chip) = &mut self.chip {
            chip.bus.set_dco(ppm);
        }
    }

    /// A disturbance of a few nanoseconds at the pin that carries input `n`: an edge there and one
    /// back. Inputs in the chain see none.
    pub fn spike(&mut self, n: u8) {
        with!(&mut self.chip, c => {
            let plant = &c.bus.plant;
            if let Some(pin) = plant.board().input(plant.wiring(), n) {
                c.bus.spike(pin);
            }
        });
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
        with!(&mut self.chip, c => c.bus.power_off());
    }

    /// Switches the supply on, after `power_cut` or a power failure: RAM holds noise, the chip starts
    /// from its reset vector.
    pub fn power_up(&mut self) {
        self.powered = true;
        let (ram, usb) = (self.part().ram.clone(), self.part().usb_ram.clone());
        let memory = with!(&mut self.chip, c => c.bus.memory_mut());
        let noise = &mut self.noise;
        for range in [Some(ram), usb].into_iter().flatten() {
            for byte in &mut memory[*range.start() as usize..=*range.end() as usize] {
                *byte = noise.bits() as u8;
            }
        }
        self.power_back();
    }

    /// The supply comes back, behind a failure, before RAM has lost its content: a brown-out.
    pub fn power_back(&mut self) {
        self.powered = true;
        let noise = &mut self.noise;
        with!(&mut self.chip, c => c.bus.power_up(noise, self.unstable_bits));
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
