//! Levels at the pins: those that the chip drives, those that the world drives, and the listeners for changes.

use super::Bus;
use crate::warn::Kind;

fn bits(list: &[(u8, bool)]) -> u8 {
    list.iter().fold(0, |all, (bit, on)| all | u8::from(*on) << bit)
}

impl Bus {
    /// Peripheral outputs of ports 1 and 2 by PxSEL = 1, PxSEL2 = 0 (SLAS735, "Port schematics").
    fn first_function(&self) -> [u8; 2] {
        let [t0, t1] = [self.timers[0].out, self.timers[1].out];
        [
            bits(&[(1, t0[0]), (2, t0[1]), (5, t0[0]), (6, t0[1])]),
            bits(&[
                (0, t1[0]),
                (1, t1[1]),
                (2, t1[1]),
                (3, t1[0]),
                (4, t1[2]),
                (5, t1[2]),
                (6, t0[1]),
            ]),
        ]
    }

    /// Recomputes the levels at time `at`, tells the plant, and the plant's answer again, until
    /// nothing changes.
    pub(super) fn update_pins(&mut self, at: u64) {
        // A change goes once around; contacts and registers do not oscillate.
        for _ in 0..4 {
            let levels = self.levels(at);
            let old = [self.ports[0].level, self.ports[1].level];
            if levels == old {
                return;
            }
            let changed = levels[0] ^ old[0];
            for (port, level) in self.ports.iter_mut().zip(levels) {
                port.edges(level);
            }
            if changed & 0x04 != 0 {
                self.line.hear(at, levels[0] & 0x04 != 0);
            }
            self.plant.pins(at, u64::from(u16::from_le_bytes(levels)));
            if self.plant.output_changed && self.plant.stop_at_output {
                self.attention = true;
            }
            if changed & 0x02 != 0 {
                let level = self.uart_input();
                self.uart.line(level, at, &self.clock.rates);
            }
            self.capture_inputs(at);
        }
    }

    fn levels(&mut self, at: u64) -> [u8; 2] {
        let world = self.plant.drives(self.line.level);
        let first = self.first_function();
        let second = bits(&[(2, self.uart.tx_level), (5, self.spi.clk), (7, self.spi.simo)]);
        let [driven, world_level] = [world.driven, world.level].map(u64::to_le_bytes);
        let [rest, open] = [world.rest, world.open].map(u64::to_le_bytes);
        let mut levels = [0; 2];
        let wires = &mut self.wires;
        for n in 0..2 {
            let port = &mut self.ports[n];
            let select1 = port.sel & !port.sel2;
            // The USCI decides the direction of its pins; P1.1 and P1.6 are its inputs.
            let usci = if n == 0 { port.sel & port.sel2 } else { 0 };
            // P2.6 and P2.7 belong to the crystal oscillator while both are selected.
            let crystal = if n == 1 && port.sel & 0xC0 == 0xC0 { 0xC0 } else { 0 };
            let chip = (port.dir & !usci | usci & 0xA4) & !crystal;
            let out = port.out & !select1 & !usci | first[n] & select1 | second & usci;
            let free = !chip & !driven[n];
            // The pull resistors do not ask what a pin is used for.
            let pulled = free & port.ren;
            let mut high = pulled & port.out;
            if n == 0 {
                high = wires.up(high, at);
                self.next_wire = wires.next(at);
            }
            port.driven = chip;
            port.floating = free & !pulled & open[n];
            levels[n] =
                chip & out | !chip & driven[n] & world_level[n] | high | free & !pulled & rest[n];
        }
        levels
    }

    fn capture_inputs(&mut self, at: u64) {
        let [p1, p2] = [self.ports[0].level, self.ports[1].level];
        let pin = |port: u8, n: u8| port >> n & 1 != 0;
        let inputs = [
            [(pin(p1, 1), false), (pin(p1, 2), false), (false, false)],
            [(pin(p2, 0), pin(p2, 3)), (pin(p2, 1), pin(p2, 2)), (pin(p2, 4), pin(p2, 5))],
        ];
        for (timer, inputs) in self.timers.iter_mut().zip(inputs) {
            for (n, (a, b)) in inputs.into_iter().enumerate() {
                let level = timer.selected_input(n, a, b);
                timer.input(n, level, at);
            }
        }
    }

    /// Capture inputs after CCISx may have changed.
    pub(super) fn reselect_captures(&mut self) {
        self.capture_inputs(self.now);
    }

    /// Whether nothing defines what the UART receives.
    pub(super) fn uart_floats(&self) -> bool {
        let port = &self.ports[0];
        port.sel & port.sel2 & port.floating & 0x02 != 0
    }

    /// Level that the UART receives.
    pub(super) fn uart_input(&self) -> bool {
        if self.uart.listens_to_itself() {
            return self.uart.tx_level;
        }
        let port = &self.ports[0];
        // Without the pin the receiver sees the line at rest.
        port.sel & port.sel2 & 0x02 == 0 || port.level & 0x02 != 0
    }

    /// Level that the SPI master receives.
    pub(super) fn spi_input(&self) -> bool {
        let port = &self.ports[0];
        port.sel & port.sel2 & 0x40 != 0 && port.level & 0x40 != 0
    }

    /// PxIN of port `n`.
    pub(super) fn read_input(&mut self, n: usize) -> u8 {
        let port = &self.ports[n];
        if port.floating & !port.sel != 0 {
            self.warn(Kind::FloatingInput, 0x20 + 8 * n as u16);
        }
        self.ports[n].level
    }

    /// The world changed: contacts, or the host's line.
    pub fn world_changed(&mut self) {
        let now = self.now;
        // Shift register inputs are no pins: they are looked at even when no pin changed.
        let levels = [self.ports[0].level, self.ports[1].level];
        self.plant.pins(now, u64::from(u16::from_le_bytes(levels)));
        self.update_pins(now);
        self.update();
    }

    /// A disturbance at a pin, so short that only edges are seen.
    pub(crate) fn spike(&mut self, pin: u8) {
        self.ports[usize::from(pin / 8)].spike(1 << (pin % 8));
        self.update();
    }
}
