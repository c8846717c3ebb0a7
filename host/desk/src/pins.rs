//! Pins of the desktop's chip, with the plant around them.

use emulator::Plant;
use firmware::machine::chip::Pins;
use lang::part::F5529;

use super::{Desk, State};

/// Bit of the first input's pin in the port of inputs.
const FIRST_INPUT: u8 = 4;

impl State {
    /// Gives the chip's pins their levels at a time, in ticks of the step timer.
    pub(super) fn set_levels(&self, plant: &mut Plant, tick: u64, levels: u64) {
        self.levels.set(levels);
        plant.pins(tick * self.unit, levels ^ self.turned.get());
    }

    /// Levels of the port of inputs: bits 4 to 7 are inputs 1 to 4 of the direct wiring, low when closed.
    pub(super) fn port(&self, plant: &Plant) -> u8 {
        let drives = plant.drives(true);
        let low = drives.driven & !drives.level;
        let place = |(n, pin): (u8, u8)| u8::from(low >> pin & 1 == 0) << (FIRST_INPUT + n);
        (0..).zip(self.pins.inputs).map(place).fold(0, |port, bit| port | bit)
    }
}

impl Desk {
    fn set_levels(&self, levels: u64) {
        self.0.set_levels(&mut self.0.plant.borrow_mut(), self.ticks(), levels);
    }

    /// Whether the world holds pins to ground.
    fn are_low<const N: usize>(&self, pins: [u8; N]) -> [bool; N] {
        let drives = self.0.plant.borrow().drives(true);
        pins.map(|pin| (drives.driven & !drives.level) >> pin & 1 != 0)
    }

    /// Levels at the registers of the chain's inputs, input n in bit n - 1.
    pub(super) fn chain_inputs(&self) -> u16 {
        // The registers load what the contacts say when they are looked at.
        self.set_levels(self.0.levels.get());
        self.0.plant.borrow().chain.inputs
    }

    /// The pins as they are at a reset: no step, outputs of the chain off.
    pub(super) fn reset_pins(&self) {
        let chained = self.0.plant.borrow().wiring() == emulator::Wiring::Chain;
        self.set_levels(if chained { 1 << self.0.pins.enable } else { 0 });
    }
}

impl Pins for Desk {
    const PROBE: u8 = 1 << FIRST_INPUT;

    fn exchange(&self, outputs: u16) -> u16 {
        let mut plant = self.0.plant.borrow_mut();
        plant.chain.latched = outputs;
        let levels = self.0.levels.get() & !(1 << self.0.pins.enable);
        self.0.set_levels(&mut plant, self.ticks(), levels);
        plant.chain.inputs
    }
    fn pins(&self, outputs: u16) -> u16 {
        let [first, second] = [self.0.pins.latch, self.0.pins.enable];
        let levels = self.0.levels.get() & !(1 << first | 1 << second);
        let on = u64::from(outputs & 1) << first | u64::from(outputs >> 1 & 1) << second;
        let mut plant = self.0.plant.borrow_mut();
        self.0.set_levels(&mut plant, self.ticks(), levels | on);
        u16::from(!self.0.port(&plant) >> FIRST_INPUT)
    }
    fn probe(&self) -> bool {
        let [low] = self.are_low([self.0.pins.probe]);
        low
    }
    fn buttons(&self) -> u16 {
        let [stop, start] = self.are_low([self.0.pins.stop, self.0.pins.start]);
        u16::from(stop) | u16::from(start) << 1
    }
    fn analog(&self, n: u8) -> u16 {
        let volts = self.0.plant.borrow().volts();
        firmware::analog::sample(volts[usize::from(n) % volts.len()].into())
    }
    // What is at the pins is read when it is asked for.
    fn convert_analog(&self) {}
    fn open_analog(&self, _: u8) {}
    // An erase takes no emergency stop away: the pass after it comes at once.
    fn remember_stop(&self, _: u16) {}
    fn open_pwm(&self, hz: u16) -> (u16, u16) {
        let mut divider = 0;
        let mut top = F5529.clock / u32::from(hz.max(1));
        while top > u32::from(u16::MAX) {
            divider += 1;
            top >>= 1;
        }
        (top as u16 - 1, ((F5529.clock / 1000) >> divider) as u16)
    }
    fn set_pwm(&self, _: u16) {}
    fn gate_pwm(&self, _: bool) {}
    fn open_aout(&self, hz: u16) -> u16 {
        let (top, _) = self.open_pwm(hz);
        top
    }
    fn set_aout(&self, _: u16) {}
    fn darken_aout(&self) {}
}
