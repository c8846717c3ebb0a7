//! Levels at the pins: port registers, module functions, the port mapping, and what the world
//! drives (SLAS590, "Terminal Functions" and port schematics).

use super::Bus;
use crate::f5::periph::pmap::Function;
use crate::plant::pins::{high, pin};
use crate::warn::Kind;

/// Pins of timer outputs by timer and channel, and their capture inputs: TA0, TA1, TA2.
const TIMER_A: [(usize, usize, u8); 11] = [
    (0, 0, pin(1, 1)),
    (0, 1, pin(1, 2)),
    (0, 2, pin(1, 3)),
    (0, 3, pin(1, 4)),
    (0, 4, pin(1, 5)),
    (1, 0, pin(1, 7)),
    (1, 1, pin(2, 0)),
    (1, 2, pin(2, 1)),
    (2, 0, pin(2, 3)),
    (2, 1, pin(2, 4)),
    (2, 2, pin(2, 5)),
];
/// Pins of the channels of TB0, apart from those of the port mapping.
const TIMER_B: [u8; 7] =
    [pin(5, 6), pin(5, 7), pin(7, 4), pin(7, 5), pin(7, 6), pin(3, 5), pin(3, 6)];
const TB0: usize = 3;
/// A high level at this selected pin switches all outputs of TB0 off.
const TB0_OUT_H: u8 = pin(3, 7);
const UCA0_TX: u8 = pin(3, 3);
const UCA0_RX: u8 = pin(3, 4);
const UCB0_SIMO: u8 = pin(3, 0);
const UCB0_SOMI: u8 = pin(3, 1);
const UCB0_CLK: u8 = pin(3, 2);
/// The mapped port.
const P4: u8 = pin(4, 0);
/// Crystals: while selected the port drives nothing there.
const CRYSTALS: u64 = 0x3C << pin(5, 0);
/// Pins with a digital module function when they are selected: all of P1 to P4, crystals and TB0 of
/// P5, TB0 and clocks of P7. P6 and P7.0 to P7.3 are analog, P8 has none.
const FUNCTIONS: u64 = 0x00F0_00FC_FFFF_FFFF;

/// Pins that the smallest package of the family lacks: P3.5 to P3.7, P5.6, P5.7, P7 and P8 (SLAS590, port schematics).
pub(super) const NOT_IN_EVERY_PACKAGE: u64 =
    0x07 << pin(3, 5) | 0x03 << pin(5, 6) | 0xFF << pin(7, 0) | 0xFF << pin(8, 0);

/// Module functions at the pins: which pins a module drives, and to what.
#[derive(Clone, Copy, Default)]
struct Outputs {
    driven: u64,
    level: u64,
    /// Pins that a module takes from the port without driving them.
    inputs: u64,
}

impl Outputs {
    fn drive(&mut self, pin: u8, level: bool) {
        self.driven |= 1 << pin;
        self.level |= u64::from(level) << pin;
    }
}

impl Bus {
    /// All of a register of the ports as one word.
    fn gather(&self, field: impl Fn(&crate::periph::port::Port) -> u8) -> u64 {
        u64::from_le_bytes(std::array::from_fn(|n| field(&self.ports[n])))
    }

    fn module_outputs(&self, sel: u64, dir: u64) -> Outputs {
        let mut o = Outputs::default();
        for (timer, channel, pin) in TIMER_A {
            if high(sel & dir, pin) {
                o.drive(pin, self.timers[timer].out[channel]);
            }
        }
        let mut off = high(sel & self.levels, TB0_OUT_H);
        for n in 0..8 {
            let pin = P4 + n as u8;
            if !high(sel, pin) {
                continue;
            }
            match self.pmap.function(n) {
                Function::Uca1Tx => o.drive(pin, self.usci_a[1].uart.tx_level),
                Function::Ucb1Simo => o.drive(pin, self.usci_b[1].spi.simo),
                Function::Ucb1Clk => o.drive(pin, self.usci_b[1].spi.clk),
                Function::Uca1Rx | Function::Ucb1Somi => o.inputs |= 1 << pin,
                Function::Tb0OutH => off |= high(self.levels, pin),
                Function::Tb0(_) | Function::None => {}
            }
        }
        if !off {
            for (channel, pin) in TIMER_B.into_iter().enumerate() {
                if high(sel & dir, pin) {
                    o.drive(pin, self.timers[TB0].out[channel]);
                }
            }
            for n in 0..8 {
                let pin = P4 + n as u8;
                if let Function::Tb0(channel) = self.pmap.function(n)
                    && high(sel & dir, pin)
                {
                    o.drive(pin, self.timers[TB0].out[usize::from(channel)]);
                }
            }
        }
        // The USCI decides the direction of its pins.
        for (pin, level) in [
            (UCA0_TX, self.usci_a[0].uart.tx_level),
            (UCB0_SIMO, self.usci_b[0].spi.simo),
            (UCB0_CLK, self.usci_b[0].spi.clk),
        ] {
            if high(sel, pin) {
                o.drive(pin, level);
            }
        }
        o.inputs |= sel & (1 << UCA0_RX | 1 << UCB0_SOMI | CRYSTALS);
        o
    }

    /// Recomputes the levels at time `at`, tells the plant, and the plant's answer again, until
    /// nothing changes.
    pub(super) fn update_pins(&mut self, at: u64) {
        // A change goes once around; contacts and registers do not oscillate.
        for _ in 0..4 {
            let levels = self.compute_levels();
            let changed = levels ^ self.levels;
            self.levels = levels;
            for n in 0..2 {
                let level = self.uart_input(n);
                if std::mem::replace(&mut self.usci_a[n].rx, level) != level {
                    self.usci_a[n].uart.line(level, at, &self.ucs.rates);
                }
            }
            if changed == 0 {
                return;
            }
            for (port, level) in self.ports.iter_mut().zip(levels.to_le_bytes()) {
                port.edges(level);
            }
            let tx = self.plant.board().tx;
            if high(changed, tx) {
                self.line.hear(at, high(levels, tx));
            }
            if high(changed, UCA0_TX) {
                self.rs485.hear(at, high(levels, UCA0_TX));
            }
            self.plant.pins(at, levels);
            if self.plant.output_changed && self.plant.stop_at_output {
                self.attention = true;
            }
            self.capture_inputs(at);
        }
    }

    fn compute_levels(&mut self) -> u64 {
        let mut world = self.plant.drives(self.line.level);
        world.driven |= 1 << UCA0_RX;
        world.level |= u64::from(self.rs485.level) << UCA0_RX;
        world.rest |= 1 << UCA0_TX;
        let [dir, sel, out, ren] = [
            self.gather(|p| p.dir),
            self.gather(|p| p.sel),
            self.gather(|p| p.out),
            self.gather(|p| p.ren),
        ];
        let module = self.module_outputs(sel, dir);
        let plain = dir & !sel;
        let chip = (plain | module.driven) & !(module.inputs & !module.driven) | self.held_low;
        let value = (out & plain | module.level & module.driven) & !self.held_low;
        let free = !chip & !world.driven;
        let pulled = free & ren & !dir;
        let floating = (free & !pulled & world.open).to_le_bytes();
        let driven = chip.to_le_bytes();
        for (n, port) in self.ports.iter_mut().enumerate() {
            port.driven = driven[n];
            port.floating = floating[n];
        }
        chip & value
            | !chip & world.driven & world.level
            | pulled & out
            | free & !pulled & world.rest
    }

    /// Capture inputs follow the levels at their pins, while those are selected as inputs.
    pub(super) fn capture_inputs(&mut self, at: u64) {
        let usable = self.gather(|p| p.sel) & !self.gather(|p| p.dir);
        let level = self.levels & usable;
        let mut feed = |timer: usize, channel: usize, pin: u8| {
            let timer = &mut self.timers[timer];
            let level = timer.selected_input(channel, high(level, pin), false);
            timer.input(channel, level, at);
        };
        for (timer, channel, pin) in TIMER_A {
            feed(timer, channel, pin);
        }
        for (channel, pin) in TIMER_B.into_iter().enumerate() {
            feed(TB0, channel, pin);
        }
    }

    /// Level that the receiver of USCI_An sees: the line at rest without a pin.
    pub(super) fn uart_input(&self, n: usize) -> bool {
        let uart = &self.usci_a[n].uart;
        if uart.listens_to_itself() {
            return uart.tx_level;
        }
        let sel = self.gather(|p| p.sel);
        if n == 0 {
            return !high(sel, UCA0_RX) || high(self.levels, UCA0_RX);
        }
        self.mapped(sel, Function::Uca1Rx).is_none_or(|pin| high(self.levels, pin))
    }

    /// Level that the SPI master of USCI_Bn receives.
    pub(super) fn spi_input(&self, n: usize) -> bool {
        let sel = self.gather(|p| p.sel);
        if n == 0 {
            return high(sel & self.levels, UCB0_SOMI);
        }
        self.mapped(sel, Function::Ucb1Somi).is_some_and(|pin| high(self.levels, pin))
    }

    /// The selected pin of P4 that has this function.
    fn mapped(&self, sel: u64, function: Function) -> Option<u8> {
        (0..8)
            .find(|n| high(sel, P4 + *n as u8) && self.pmap.function(*n) == function)
            .map(|n| P4 + n as u8)
    }

    /// A selected output pin without a function there.
    pub(super) fn check_functions(&mut self) {
        let (sel, dir) = (self.gather(|p| p.sel), self.gather(|p| p.dir));
        let wrong = sel & dir & !FUNCTIONS;
        if wrong != 0 {
            let pin = wrong.trailing_zeros();
            // The PxSEL register of the pin's port.
            let port = pin / 8;
            self.warn(Kind::PinFunction, 0x020A + port / 2 * 0x20 + port % 2);
        }
    }

    /// The world changed: contacts, or a line.
    pub fn world_changed(&mut self) {
        let now = self.now;
        // Shift register inputs are no pins: they are looked at even when no pin changed.
        self.plant.pins(now, self.levels);
        self.update_pins(now);
        self.update();
    }

    /// A disturbance at a pin, so short that only edges are seen.
    pub(crate) fn spike(&mut self, pin: u8) {
        self.ports[usize::from(pin / 8)].spike(1 << (pin % 8));
        self.update();
    }
}
