//! Pins of the desktop's chip, with the plant around them.

use firmware::machine::chip::Pins;
use lang::part::F5529;

use super::Desk;

/// Bit of the first input's pin in the port of inputs.
const FIRST_INPUT: u8 = 4;

impl Desk {
    /// Gives the chip's pins their levels at a time, in ticks of the step timer.
    pub(super) fn set_levels(&self, tick: u64, levels: u64) {
        self.0.levels.set(levels);
        let mut plant = self.0.plant.borrow_mut();
        let at = tick * Desk::plant_ticks(&plant);
        let steps = plant.board().step.iter().fold(0, |pins, pin| pins | 1 << pin);
        plant.pins(at, if self.0.steps_are_low.get() { levels ^ steps } else { levels });
    }

    /// Ticks of the plant in one of the step timer.
    pub(super) fn plant_ticks(plant: &emulator::Plant) -> u64 {
        plant.ticks_per_second() / u64::from(F5529.clock)
    }

    /// Whether the world holds a pin to ground.
    fn is_low(&self, pin: u8) -> bool {
        let drives = self.0.plant.borrow().drives(true);
        (drives.driven & !drives.level) >> pin & 1 != 0
    }

    /// Levels of the port of inputs: bits 4 to 7 are inputs 1 to 4 of the direct wiring, low when closed.
    pub(super) fn port(&self) -> u8 {
        let (drives, pins) = {
            let plant = self.0.plant.borrow();
            (plant.drives(true), plant.board().inputs)
        };
        let low = drives.driven & !drives.level;
        let place = |(n, pin): (u8, u8)| u8::from(low >> pin & 1 == 0) << (FIRST_INPUT + n);
        (0..).zip(pins).map(place).fold(0, |port, bit| port | bit)
    }

    /// Levels at the registers of the chain's inputs, input n in bit n - 1.
    pub(super) fn chain_inputs(&self) -> u16 {
        // The registers load what the contacts say when they are looked at.
        self.set_levels(self.ticks(), self.0.levels.get());
        self.0.plant.borrow().chain.inputs
    }

    /// The pins as they are at a reset: no step, outputs of the chain off.
    pub(super) fn reset_pins(&self) {
        let enable = self.0.plant.borrow().board().enable;
        let chained = self.0.plant.borrow().wiring() == emulator::Wiring::Chain;
        self.set_levels(self.ticks(), if chained { 1 << enable } else { 0 });
    }
}

impl Pins for Desk {
    const PROBE: u8 = 1 << FIRST_INPUT;

    fn exchange(&self, outputs: u16) -> u16 {
        let enable = {
            let mut plant = self.0.plant.borrow_mut();
            plant.chain.latched = outputs;
            plant.board().enable
        };
        self.set_levels(self.ticks(), self.0.levels.get() & !(1 << enable));
        self.0.plant.borrow().chain.inputs
    }
    fn pins(&self, outputs: u16) -> u16 {
        let [first, second] = {
            let plant = self.0.plant.borrow();
            [plant.board().latch, plant.board().enable]
        };
        let levels = self.0.levels.get() & !(1 << first | 1 << second);
        let on = u64::from(outputs & 1) << first | u64::from(outputs >> 1 & 1) << second;
        self.set_levels(self.ticks(), levels | on);
        u16::from(!self.port() >> FIRST_INPUT)
    }
    fn probe(&self) -> bool {
        let pin = self.0.plant.borrow().board().probe;
        self.is_low(pin)
    }
    fn buttons(&self) -> u16 {
        let [stop, start] = {
            let plant = self.0.plant.borrow();
            [plant.board().stop, plant.board().start]
        };
        u16::from(self.is_low(stop)) | u16::from(self.is_low(start)) << 1
    }
    fn analog(&self, n: u8) -> u16 {
        let volts = self.0.plant.borrow().analog;
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
}
