//! USCI_A in UART mode (SLAU144, chapter 15; SLAU208, chapter 36), bit by bit.

use super::usci::{RX, Register, TX};
use super::{NEVER, Rates};

const PEN: u8 = 0x80;
const PAR_EVEN: u8 = 0x40;
const MSB: u8 = 0x20;
const SEVEN: u8 = 0x10;
const SPB: u8 = 0x08;
const RXEIE: u8 = 0x20;
const BRKIE: u8 = 0x10;
const TXBRK: u8 = 0x02;
const SWRST: u8 = 0x01;
const LISTEN: u8 = 0x80;
const FE: u8 = 0x40;
const OE: u8 = 0x20;
const PE: u8 = 0x10;
const BRK: u8 = 0x08;
const RXERR: u8 = 0x04;
const BUSY: u8 = 0x01;
const OS16: u8 = 0x01;

/// Second-stage modulation UCBRSx: bit i of a row is m[i] (SLAU144, table 15-2).
const MODULATION: [u8; 8] = [
    0b0000_0000,
    0b0000_0010,
    0b0010_0010,
    0b0010_1010,
    0b1010_1010,
    0b1010_1110,
    0b1110_1110,
    0b1111_1110,
];

/// A character being sent, bit 0 first.
#[derive(Debug, Clone, Copy)]
struct Sending {
    bits: u32,
    count: u32,
    index: u32,
}

/// A character being received.
#[derive(Debug, Clone, Copy)]
struct Receiving {
    bits: u32,
    index: u32,
    /// Start of the bit being received.
    edge: u64,
}

/// State of a USCI_A module.
#[derive(Debug, Clone)]
pub struct Uart {
    ctl0: u8,
    ctl1: u8,
    br: u16,
    mctl: u8,
    stat: u8,
    rxbuf: u8,
    txbuf: u8,
    tx_full: bool,
    sending: Option<Sending>,
    receiving: Option<Receiving>,
    /// Other registers (IrDA and auto baud rate), stored only.
    other: [u8; 3],
    /// Level of the transmit line.
    pub tx_level: bool,
    /// When the transmitter's bit ends.
    pub next_tx: u64,
    /// When the receiver samples next.
    pub next_rx: u64,
    /// Characters that were overwritten before they were read, since the module's reset.
    pub overruns: u64,
}

impl Default for Uart {
    fn default() -> Self {
        Uart {
            ctl0: 0,
            ctl1: SWRST,
            br: 0,
            mctl: 0,
            stat: 0,
            rxbuf: 0,
            txbuf: 0,
            tx_full: false,
            sending: None,
            receiving: None,
            other: [0; 3],
            tx_level: true,
            next_tx: NEVER,
            next_rx: NEVER,
            overruns: 0,
        }
    }
}

impl Uart {
    /// Ticks of one BRCLK cycle; 0 when it stands still.
    fn period(&self, clock: &Rates) -> u64 {
        match self.ctl1 >> 6 {
            0 => 0,
            1 => clock.aclk,
            // The USCI asks for SMCLK when it needs it, whatever the low-power mode.
            _ => clock.smclk.max(u64::from(clock.smclk == 0) * clock.mclk),
        }
    }

    /// Ticks of bit `i` of a character (sections 15.3.10 and 15.3.11).
    fn bit(&self, i: u32, clock: &Rates) -> u64 {
        let row = MODULATION[usize::from(self.mctl >> 1 & 7)];
        let second = u64::from(row >> (i % 8) & 1);
        let n = u64::from(self.br);
        let counts = if self.mctl & OS16 != 0 {
            (16 + second) * n + u64::from(self.mctl >> 4)
        } else {
            n + second
        };
        counts.max(1) * self.period(clock)
    }

    fn data_bits(&self) -> u32 {
        if self.ctl0 & SEVEN != 0 { 7 } else { 8 }
    }

    fn parity_of(&self, data: u32) -> u32 {
        let odd_ones = data.count_ones() & 1;
        if self.ctl0 & PAR_EVEN != 0 { odd_ones } else { odd_ones ^ 1 }
    }

    fn in_line_order(&self, data: u32) -> u32 {
        if self.ctl0 & MSB != 0 { data.reverse_bits() >> (32 - self.data_bits()) } else { data }
    }

    /// Reads a register.
    pub fn read(&mut self, register: Register, ifg: &mut u8) -> u8 {
        match register {
            Register::Ctl0 => self.ctl0,
            Register::Ctl1 => self.ctl1,
            Register::Br0 => self.br as u8,
            Register::Br1 => (self.br >> 8) as u8,
            Register::Mctl => self.mctl,
            Register::Stat => self.stat,
            Register::RxBuf => {
                *ifg &= !RX;
                self.stat &= LISTEN | BUSY;
                self.rxbuf
            }
            Register::TxBuf => self.txbuf,
            Register::Other(n) => self.other[usize::from(n).min(2)],
        }
    }

    /// Writes a register.
    pub fn write(&mut self, register: Register, value: u8, now: u64, ifg: &mut u8, clock: &Rates) {
        match register {
            Register::Ctl0 => self.ctl0 = value,
            Register::Ctl1 => {
                self.ctl1 = value;
                if value & SWRST != 0 {
                    self.software_reset(ifg);
                }
            }
            Register::Br0 => self.br = self.br & 0xFF00 | u16::from(value),
            Register::Br1 => self.br = self.br & 0xFF | u16::from(value) << 8,
            Register::Mctl => self.mctl = value,
            Register::Stat => self.stat = self.stat & BUSY | value & !BUSY,
            Register::RxBuf => {}
            Register::TxBuf => {
                self.txbuf = value;
                if self.ctl1 & SWRST == 0 {
                    *ifg &= !TX;
                    self.tx_full = true;
                    if self.sending.is_none() {
                        self.load(now, ifg, clock);
                    }
                }
            }
            Register::Other(n) => self.other[usize::from(n).min(2)] = value,
        }
    }

    /// Whether UCLISTEN feeds the transmitter's level to the receiver.
    pub fn listens_to_itself(&self) -> bool {
        self.stat & LISTEN != 0
    }

    /// UCSWRST: flags and state machines as section 15.3.1 has them.
    pub fn software_reset(&mut self, ifg: &mut u8) {
        *ifg = *ifg & !RX | TX;
        self.stat &= LISTEN;
        self.sending = None;
        self.receiving = None;
        self.tx_full = false;
        self.tx_level = true;
        self.next_tx = NEVER;
        self.next_rx = NEVER;
    }

    /// Moves the buffer to the shift register, which begins with its start bit.
    fn load(&mut self, now: u64, ifg: &mut u8, clock: &Rates) {
        if self.period(clock) == 0 {
            return;
        }
        self.tx_full = false;
        *ifg |= TX;
        let n = self.data_bits();
        let data = u32::from(self.txbuf) & ((1 << n) - 1);
        let mut count = 1 + n;
        let mut bits = self.in_line_order(data) << 1;
        if self.ctl0 & PEN != 0 {
            bits |= self.parity_of(data) << count;
            count += 1;
        }
        let stops = if self.ctl0 & SPB != 0 { 2 } else { 1 };
        if self.ctl1 & TXBRK != 0 {
            // A break: everything low for one character and its stop bit, then one bit high.
            self.ctl1 &= !TXBRK;
            bits = 0;
            count += 1;
        }
        bits |= ((1 << stops) - 1) << count;
        count += stops;
        self.sending = Some(Sending { bits, count, index: 0 });
        self.stat |= BUSY;
        self.tx_level = false;
        self.next_tx = now + self.bit(0, clock);
    }

    /// The transmitter's bit ended at `next_tx`.
    pub fn transmit_event(&mut self, ifg: &mut u8, clock: &Rates) {
        let now = self.next_tx;
        let Some(mut sending) = self.sending else {
            self.next_tx = NEVER;
            return;
        };
        sending.index += 1;
        if sending.index < sending.count {
            self.tx_level = sending.bits >> sending.index & 1 != 0;
            self.next_tx = now + self.bit(sending.index, clock);
            self.sending = Some(sending);
            return;
        }
        self.sending = None;
        self.next_tx = NEVER;
        self.tx_level = true;
        self.busy();
        if self.tx_full {
            self.load(now, ifg, clock);
        }
    }

    fn busy(&mut self) {
        let active = self.sending.is_some() || self.receiving.is_some();
        self.stat = self.stat & !BUSY | u8::from(active);
    }

    /// The receive line changed at `now`.
    pub fn line(&mut self, level: bool, now: u64, clock: &Rates) {
        if level || self.receiving.is_some() || self.ctl1 & SWRST != 0 || self.period(clock) == 0 {
            return;
        }
        self.receiving = Some(Receiving { bits: 0, index: 0, edge: now });
        self.next_rx = now + self.bit(0, clock) / 2;
        self.stat |= BUSY;
    }

    /// The receiver samples `level` at `next_rx`, the middle of a bit.
    pub fn receive_event(&mut self, level: bool, ifg: &mut u8, clock: &Rates) {
        self.next_rx = NEVER;
        let Some(mut receiving) = self.receiving.take() else {
            return;
        };
        let Receiving { bits, index, edge } = receiving;
        let parity = u32::from(self.ctl0 & PEN != 0);
        let stop = 1 + self.data_bits() + parity;
        if index == 0 && level {
            // No start bit, a glitch.
            self.busy();
            return;
        }
        receiving.bits = bits | u32::from(level) << index;
        if index < stop {
            receiving.edge = edge + self.bit(index, clock);
            receiving.index = index + 1;
            self.next_rx = receiving.edge + self.bit(index + 1, clock) / 2;
            self.receiving = Some(receiving);
            return;
        }
        self.complete(receiving.bits, stop, ifg);
        self.busy();
    }

    /// All bits of a character up to its first stop bit are in.
    fn complete(&mut self, bits: u32, stop: u32, ifg: &mut u8) {
        let n = self.data_bits();
        let line = bits >> 1 & ((1 << n) - 1);
        let data = self.in_line_order(line);
        let framing = bits >> stop & 1 == 0;
        let parity = self.ctl0 & PEN != 0 && bits >> (1 + n) & 1 != self.parity_of(data);
        if bits == 0 {
            self.stat |= BRK;
            if self.ctl1 & BRKIE != 0 {
                *ifg |= RX;
            }
        }
        if framing || parity {
            // Without UCRXEIE erroneous characters vanish (section 15.3.6).
            if self.ctl1 & RXEIE == 0 {
                return;
            }
            self.stat |= RXERR | if framing { FE } else { 0 } | if parity { PE } else { 0 };
        }
        if *ifg & RX != 0 {
            self.stat |= OE | RXERR;
            self.overruns += 1;
        }
        self.rxbuf = data as u8;
        *ifg |= RX;
    }
}
