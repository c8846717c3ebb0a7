//! Peripherals. Each is a state machine that knows when its next event is due, so that nothing
//! needs to be ticked; `bus` brings them up to date before the CPU looks at them.
//!
//! Times are in ticks of the part.

pub mod adc10;
pub mod clock;
pub mod flash;
pub mod port;
pub mod timer;
pub mod usci;
pub mod usci_spi;
pub mod usci_uart;
pub mod watchdog;

/// A time that never comes.
pub const NEVER: u64 = u64::MAX;

/// Ticks of one cycle of each clock that modules can choose.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Rates {
    /// The CPU's clock; it never stops here.
    pub mclk: u64,
    /// SMCLK, 0 when stopped.
    pub smclk: u64,
    /// ACLK, 0 when stopped.
    pub aclk: u64,
    /// The very-low-power oscillator, for watchdogs that choose it; 0 where they can't.
    pub vlo: u64,
    /// A second of a true clock, for what no clock of the chip drives.
    pub second: u64,
}

/// Special function registers and their bits (SLAU144, section 2.2 and data sheet).
pub mod sfr {
    /// IE1, IFG1: watchdog.
    pub const WDT: u8 = 0x01;
    /// IE1, IFG1: oscillator fault.
    pub const OF: u8 = 0x02;
    /// IFG1: power-on reset.
    pub const POR: u8 = 0x04;
    /// IFG1: reset by the RST pin.
    pub const RST: u8 = 0x08;
    /// IE1: flash access violation.
    pub const ACCV: u8 = 0x20;
    /// IE2, IFG2: USCI_A0 receive.
    pub const UCA0RX: u8 = 0x01;
    /// IE2, IFG2: USCI_A0 transmit.
    pub const UCA0TX: u8 = 0x02;
    /// IE2, IFG2: USCI_B0 receive.
    pub const UCB0RX: u8 = 0x04;
    /// IE2, IFG2: USCI_B0 transmit.
    pub const UCB0TX: u8 = 0x08;
}
