//! Events of the peripherals in the order of their times, and the interrupt lines.

use super::{Bus, usci_vector};
use crate::f5::periph::sys::{ACCV, NMI, OF, VMA, WDT};
use crate::periph::NEVER;
use crate::reset::Reset;

#[derive(Clone, Copy)]
enum Source {
    Timer(usize),
    Receive(usize),
    Line,
    Rs485,
    Transmit(usize),
    Spi(usize),
    Watchdog,
    Clock,
    Supervisor,
    Flash,
    Converter,
}

impl Bus {
    fn earliest(&self) -> (u64, Source) {
        let mut first = (self.timers[0].next, Source::Timer(0));
        let busy = if self.flash.busy_until == 0 { NEVER } else { self.flash.busy_until };
        // Of two at the same time the earlier one in this list goes first.
        for other in [
            (self.timers[1].next, Source::Timer(1)),
            (self.timers[2].next, Source::Timer(2)),
            (self.timers[3].next, Source::Timer(3)),
            (self.usci_a[0].uart.next_rx, Source::Receive(0)),
            (self.usci_a[1].uart.next_rx, Source::Receive(1)),
            (self.line.next, Source::Line),
            (self.rs485.next, Source::Rs485),
            (self.usci_a[0].uart.next_tx, Source::Transmit(0)),
            (self.usci_a[1].uart.next_tx, Source::Transmit(1)),
            (self.usci_b[0].spi.next, Source::Spi(0)),
            (self.usci_b[1].spi.next, Source::Spi(1)),
            (self.wdt.next, Source::Watchdog),
            (self.ucs.next, Source::Clock),
            (self.pmm.next(), Source::Supervisor),
            (busy, Source::Flash),
            (self.adc.next, Source::Converter),
        ] {
            if other.0 < first.0 {
                first = other;
            }
        }
        first
    }

    /// Handles all events up to now.
    pub fn service(&mut self) {
        loop {
            let (at, source) = self.earliest();
            if at > self.now {
                self.next_event = at;
                return;
            }
            self.event(at, source);
            self.update_irq(at);
        }
    }

    fn event(&mut self, at: u64, source: Source) {
        match source {
            Source::Timer(n) => {
                if self.timers[n].event() {
                    self.update_pins(at);
                }
            }
            Source::Line => {
                self.line.event();
                self.update_pins(at);
            }
            Source::Rs485 => {
                self.rs485.event();
                self.update_pins(at);
            }
            Source::Receive(n) => {
                let level = self.uart_input(n);
                let module = &mut self.usci_a[n];
                module.uart.receive_event(level, &mut module.ifg, &self.ucs.rates);
            }
            Source::Transmit(n) => {
                let module = &mut self.usci_a[n];
                module.uart.transmit_event(&mut module.ifg, &self.ucs.rates);
                self.update_pins(at);
            }
            Source::Spi(n) => {
                let somi = self.spi_input(n);
                let module = &mut self.usci_b[n];
                module.spi.event(somi, &mut module.ifg, &self.ucs.rates);
                self.update_pins(at);
            }
            Source::Watchdog => {
                self.wdt.expire();
                if self.wdt.interval_mode() {
                    self.sys.ifg |= WDT;
                } else {
                    self.ask_reset(Reset::Watchdog);
                }
            }
            Source::Clock => {
                self.ucs.event(at);
                self.reclock_at(at);
            }
            Source::Converter => {
                let second = self.part.ticks_per_second;
                self.adc.event(self.plant.volts(), self.vcc, second);
            }
            Source::Supervisor => self.pmm.event(at, self.vcc),
            Source::Flash => {
                self.flash.busy_until = 0;
                self.flash.erasing = None;
                self.attention = true;
            }
        }
    }

    /// After register accesses: next event and interrupt lines anew.
    pub(super) fn update(&mut self) {
        if self.ucs.faults() != 0 {
            // The flag stands as long as a fault does.
            self.sys.ifg |= OF;
        }
        self.next_event = self.earliest().0;
        self.update_irq(self.now);
        self.attention = true;
    }

    fn update_irq(&mut self, at: u64) {
        let (ie, ifg) = (self.sys.ie, self.sys.ifg);
        let unmi = ie & ifg & (NMI | OF) != 0 || (ie & ACCV != 0 && self.flash.violation());
        let snmi = ie & ifg & VMA != 0 || self.pmm.system_interrupt().is_some();
        let dog = ie & ifg & WDT != 0 && self.wdt.interval_mode();
        let port = |n: usize| self.ports[n].ifg & self.ports[n].ie != 0;
        let a = |n: usize| usci_vector(self.usci_a[n].ie, self.usci_a[n].ifg) != 0;
        let b = |n: usize| usci_vector(self.usci_b[n].ie, self.usci_b[n].ifg) != 0;
        // Bit n for the vector at 0xFF80 + 2 n (SLAS590, "Interrupt Vector Addresses").
        let lines = [
            (42, port(1)),
            (43, self.timers[2].irq1()),
            (44, self.timers[2].irq0()),
            (45, b(1)),
            (46, a(1)),
            (47, port(0)),
            (48, self.timers[1].irq1()),
            (49, self.timers[1].irq0()),
            (52, self.timers[0].irq1()),
            (53, self.timers[0].irq0()),
            (55, b(0)),
            (56, a(0)),
            (57, dog),
            (58, self.timers[3].irq1()),
            (59, self.timers[3].irq0()),
            (61, unmi),
            (62, snmi),
        ];
        let irq = lines.iter().fold(0u64, |irq, (n, on)| irq | u64::from(*on) << n);
        let mut new = irq & !self.irq;
        while new != 0 {
            self.irq_since[new.trailing_zeros() as usize] = at;
            new &= new - 1;
        }
        self.irq = irq;
    }

    /// Rates changed by a register: everything that counts a clock gets its new period.
    pub(super) fn reclock(&mut self) {
        let now = self.now;
        self.ucs.update(now);
        self.reclock_at(now);
        self.update();
    }

    fn reclock_at(&mut self, at: u64) {
        let changed = self.cycle != self.ucs.rates.mclk;
        self.cycle = self.ucs.rates.mclk;
        for timer in &mut self.timers {
            timer.reclock(at, &self.ucs.rates);
        }
        self.wdt.reclock(at, &self.ucs.rates);
        if self.ucs.faults() != 0 {
            self.sys.ifg |= OF;
        }
        if changed {
            self.check_speed();
        }
    }

    /// Whether nothing will ever happen by itself again.
    pub fn quiet(&self) -> bool {
        self.next_event == NEVER
    }
}
