//! USCI_B as three-wire SPI master (SLAU144, chapter 16; SLAU208, chapter 37), edge by edge.

use super::usci::{RX, Register, TX};
use super::{NEVER, Rates};

const CKPH: u8 = 0x80;
const CKPL: u8 = 0x40;
const MSB: u8 = 0x20;
const SEVEN: u8 = 0x10;
const MASTER: u8 = 0x08;
const SYNC: u8 = 0x01;
const SWRST: u8 = 0x01;
const OE: u8 = 0x20;
const BUSY: u8 = 0x01;

/// State of a USCI_B module.
#[derive(Debug, Clone)]
pub struct Spi {
    ctl0: u8,
    ctl1: u8,
    br: u16,
    stat: u8,
    rxbuf: u8,
    txbuf: u8,
    tx_full: bool,
    /// I2C registers, stored only.
    other: u8,
    shift_out: u8,
    shift_in: u8,
    /// Clock edges done of the character, `None` when idle.
    edge: Option<u64>,
    start: u64,
    /// Level of the clock line.
    pub clk: bool,
    /// Level of the data output.
    pub simo: bool,
    /// Time of the next clock edge.
    pub next: u64,
}

impl Default for Spi {
    fn default() -> Self {
        Spi {
            ctl0: SYNC,
            ctl1: SWRST,
            br: 0,
            stat: 0,
            rxbuf: 0,
            txbuf: 0,
            tx_full: false,
            other: 0,
            shift_out: 0,
            shift_in: 0,
            edge: None,
            start: 0,
            clk: false,
            simo: false,
            next: NEVER,
        }
    }
}

impl Spi {
    fn bits(&self) -> u64 {
        if self.ctl0 & SEVEN != 0 { 7 } else { 8 }
    }

    /// Ticks of one bit clock.
    fn bit(&self, clock: &Rates) -> u64 {
        let source = match self.ctl1 >> 6 {
            0 => 0,
            1 => clock.aclk,
            _ => clock.smclk,
        };
        source * u64::from(self.br.max(1))
    }

    /// Reads a register.
    pub fn read(&mut self, register: Register, ifg: &mut u8) -> u8 {
        match register {
            Register::Ctl0 => self.ctl0,
            Register::Ctl1 => self.ctl1,
            Register::Br0 => self.br as u8,
            Register::Br1 => (self.br >> 8) as u8,
            Register::Stat => self.stat,
            Register::RxBuf => {
                *ifg &= !RX;
                self.stat &= !OE;
                self.rxbuf
            }
            Register::TxBuf => self.txbuf,
            Register::Mctl | Register::Other(_) => self.other,
        }
    }

    /// Writes a register.
    pub fn write(&mut self, register: Register, value: u8, now: u64, ifg: &mut u8, clock: &Rates) {
        match register {
            Register::Ctl0 => {
                self.ctl0 = value;
                self.idle_clock();
            }
            Register::Ctl1 => {
                self.ctl1 = value;
                if value & SWRST != 0 {
                    self.software_reset(ifg);
                }
            }
            Register::Br0 => self.br = self.br & 0xFF00 | u16::from(value),
            Register::Br1 => self.br = self.br & 0xFF | u16::from(value) << 8,
            Register::Stat => self.stat = self.stat & BUSY | value & !BUSY,
            Register::RxBuf => {}
            Register::TxBuf => {
                self.txbuf = value;
                if self.ctl1 & SWRST == 0 {
                    *ifg &= !TX;
                    self.tx_full = true;
                    if self.edge.is_none() {
                        self.load(now, ifg, clock);
                    }
                }
            }
            Register::Mctl | Register::Other(_) => self.other = value,
        }
    }

    /// Whether the clock edge that is due samples the data input.
    pub fn samples(&self) -> bool {
        self.edge.is_some_and(|edge| edge.is_multiple_of(2) == (self.ctl0 & CKPH != 0))
    }

    fn idle_clock(&mut self) {
        if self.edge.is_none() {
            self.clk = self.ctl0 & CKPL != 0;
        }
    }

    /// UCSWRST.
    pub fn software_reset(&mut self, ifg: &mut u8) {
        *ifg = *ifg & !RX | TX;
        self.stat &= !(OE | BUSY);
        self.edge = None;
        self.tx_full = false;
        self.next = NEVER;
        self.idle_clock();
    }

    fn load(&mut self, now: u64, ifg: &mut u8, clock: &Rates) {
        if self.bit(clock) == 0 || self.ctl0 & MASTER == 0 {
            return;
        }
        self.tx_full = false;
        *ifg |= TX;
        self.shift_out = if self.ctl0 & MSB != 0 {
            self.txbuf << (8 - self.bits())
        } else {
            self.txbuf.reverse_bits()
        };
        self.shift_in = 0;
        self.edge = Some(0);
        self.start = now;
        self.stat |= BUSY;
        if self.ctl0 & CKPH != 0 {
            self.change();
        }
        self.next = now + self.bit(clock) / 2;
    }

    fn change(&mut self) {
        self.simo = self.shift_out & 0x80 != 0;
        self.shift_out <<= 1;
    }

    /// A clock edge is due at `next`; `somi` is the level of the data input before it.
    pub fn event(&mut self, somi: bool, ifg: &mut u8, clock: &Rates) {
        let now = self.next;
        let Some(edge) = self.edge else {
            self.next = NEVER;
            return;
        };
        // UCCKPH: captured on the first edge of a bit and changed on the second; else reversed.
        let first = edge.is_multiple_of(2);
        if first == (self.ctl0 & CKPH != 0) {
            self.shift_in = self.shift_in << 1 | u8::from(somi);
        } else if edge + 1 < 2 * self.bits() || first {
            self.change();
        }
        self.clk = !self.clk;
        let edge = edge + 1;
        if edge < 2 * self.bits() {
            self.edge = Some(edge);
            self.next = self.start + (edge + 1) * self.bit(clock) / 2;
            return;
        }
        if *ifg & RX != 0 {
            self.stat |= OE;
        }
        let bits = self.bits() as u32;
        self.rxbuf = if self.ctl0 & MSB != 0 {
            self.shift_in
        } else {
            self.shift_in.reverse_bits() >> (8 - bits)
        };
        *ifg |= RX;
        self.edge = None;
        self.stat &= !BUSY;
        self.next = NEVER;
        if self.tx_full {
            self.load(now, ifg, clock);
        }
    }
}
