//! Events of the peripherals in the order of their times, and the interrupt lines.

use super::Bus;
use crate::periph::sfr;
use crate::periph::usci_spi::Spi;
use crate::periph::{NEVER, Rates, adc10};
use crate::reset::Reset;
use crate::warn::Kind;

#[derive(Clone, Copy)]
enum Source {
    Timer0,
    Timer1,
    Line,
    Receive,
    Transmit,
    Spi,
    Watchdog,
    Adc,
    Wire,
}

impl Bus {
    fn earliest(&self) -> (u64, Source) {
        let mut first = (self.timers[1].next, Source::Timer1);
        // Of two at the same time the earlier one in this list goes first.
        for other in [
            (self.timers[0].next, Source::Timer0),
            (self.uart.next_rx, Source::Receive),
            (self.line.next, Source::Line),
            (self.uart.next_tx, Source::Transmit),
            (self.spi.next, Source::Spi),
            (self.wdt.next, Source::Watchdog),
            (self.adc.next, Source::Adc),
            (self.next_wire, Source::Wire),
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
            Source::Timer0 => {
                if self.timers[0].event() {
                    self.update_pins(at);
                }
            }
            Source::Timer1 => {
                if self.timers[1].event() {
                    self.update_pins(at);
                }
            }
            Source::Line => {
                self.line.event();
                self.update_pins(at);
            }
            Source::Receive => {
                let level = self.uart_input();
                self.uart.receive_event(level, &mut self.ifg[1], &self.clock.rates);
            }
            Source::Transmit => {
                self.uart.transmit_event(&mut self.ifg[1], &self.clock.rates);
                self.update_pins(at);
            }
            Source::Spi => {
                if self.spi.samples() && self.plant.unsettled(at, self.clock.rates.second) {
                    self.warn(Kind::SpiSetup, 0x6E);
                }
                let somi = self.spi_input();
                self.with_spi_flags(|spi, ifg, rates| spi.event(somi, ifg, rates));
                self.update_pins(at);
            }
            Source::Watchdog => {
                self.wdt.expire();
                if self.wdt.interval_mode() {
                    self.ifg[0] |= sfr::WDT;
                } else {
                    self.ask_reset(Reset::Watchdog);
                }
            }
            Source::Adc => self.adc.finish(self.supply.at(at)),
            Source::Wire => {
                self.next_wire = NEVER;
                self.update_pins(at);
            }
        }
    }

    /// Lets USCI_B0 act on its flags, which IFG2 holds two bits above those of USCI_A0.
    pub(super) fn with_spi_flags<T>(
        &mut self,
        act: impl FnOnce(&mut Spi, &mut u8, &Rates) -> T,
    ) -> T {
        const SHIFT: u8 = 2;
        let own = (sfr::UCB0RX | sfr::UCB0TX) >> SHIFT;
        let mut flags = self.ifg[1] >> SHIFT & own;
        let result = act(&mut self.spi, &mut flags, &self.clock.rates);
        self.ifg[1] = self.ifg[1] & !(own << SHIFT) | (flags & own) << SHIFT;
        result
    }

    /// After register accesses: next event and interrupt lines anew.
    pub fn update(&mut self) {
        self.next_event = self.earliest().0;
        self.update_irq(self.now);
        self.attention = true;
    }

    fn update_irq(&mut self, at: u64) {
        let [ie1, ie2] = self.ie;
        let [ifg1, ifg2] = self.ifg;
        let usci = ie2 & ifg2;
        let adc = self.adc.ctl0 & (adc10::IE | adc10::IFG) == adc10::IE | adc10::IFG;
        let dog = ie1 & ifg1 & sfr::WDT != 0 && self.wdt.interval_mode();
        let nmi = ie1 & ifg1 & sfr::OF != 0 || (ie1 & sfr::ACCV != 0 && self.flash.violation());
        let port = |n: usize| self.ports[n].ifg & self.ports[n].ie != 0;
        let lines = [
            (2, port(0)),
            (3, port(1)),
            (5, adc),
            (6, usci & (sfr::UCA0TX | sfr::UCB0TX) != 0),
            (7, usci & (sfr::UCA0RX | sfr::UCB0RX) != 0),
            (8, self.timers[0].irq1()),
            (9, self.timers[0].irq0()),
            (10, dog),
            (12, self.timers[1].irq1()),
            (13, self.timers[1].irq0()),
            (14, nmi),
        ];
        let irq = lines.iter().fold(0u16, |irq, (n, on)| irq | u16::from(*on) << n);
        let mut new = irq & !self.irq;
        while new != 0 {
            self.irq_since[new.trailing_zeros() as usize] = at;
            new &= new - 1;
        }
        self.irq = irq;
    }

    /// Rates changed: everything that counts a clock gets its new period.
    pub(super) fn reclock(&mut self) {
        self.clock.update();
        self.cycle = self.clock.rates.mclk;
        let now = self.now;
        for timer in &mut self.timers {
            timer.reclock(now, &self.clock.rates);
        }
        self.wdt.reclock(now, &self.clock.rates);
        self.line.ticks_per_second = self.clock.rates.second;
        self.update();
    }

    /// The DCO is off by so many millionths from now on.
    pub(crate) fn set_dco(&mut self, ppm: i32) {
        self.clock.dco_ppm = ppm;
        self.reclock();
    }

    /// Whether nothing will ever happen by itself again.
    pub fn quiet(&self) -> bool {
        self.next_event == NEVER
    }
}
