//! A cycle-counting MSP430G2553 and MSP430F5529 with the plant around their pins.
//!
//! The firmware image that goes into the chip runs here unchanged: CPU with the documented cycle
//! counts, basic clock, both Timer_A3, ports, USCI_A0 as UART, USCI_B0 as SPI, flash controller,
//! watchdog and ADC10, and outside of the pins motors, switches, probe, buttons and shift registers.
//! The F5529 has the 20-bit MSP430X core, power management, unified clock system with its frequency
//! locked loop and crystal faults, TA0 to TA2 and TB0, eight ports with the port mapping, four USCI
//! modules, flash in banks, MPY32 and the CRC module. What is not known of its silicon, or differs
//! from piece to piece, is an option: [`Silicon`].
//!
//! Time is counted in *ticks* whatever the chip's clocks are set to: 62.5 ns on the G2553, the
//! cycles of a 16 MHz clock, and 100 ps on the F5529 ([`Board::ticks_per_second`]).
//!
//! ```
//! use emulator::{Board, Image, Part, Stop};
//!
//! // P2DIR = 1; loop: P2OUT ^= 1; jmp loop - with the reset vector at its place.
//! let text = "@C000\nF2 43 2A 00 D2 E3 29 00 FD 3F\n@FFFE\n00 C0\nq\n";
//! let mut board = Board::new(Part::G2553, &Image::parse(text.as_bytes()).unwrap());
//! board.record(true);
//! assert_eq!(board.run_us(1000), Stop::Time);
//! assert!(board.plant().motors[0].pulses > 0);
//! assert!(board.take_edges().len() > 100);
//! assert!(board.warnings().is_empty());
//! ```
//!
//! - [`Board`]: power, reset, running by time, memory, serial line, measurements, warnings.
//! - [`plant::Plant`] by [`Board::plant`] and [`Board::plant_mut`]: motors, contacts, inputs, outputs.
//!   The order of bits in the shift registers is written down in [`plant::chain`].
//! - [`Image`]: ELF, Intel HEX, TI-TXT.
//! - [`VcdWriter`]: what [`Board::record`] kept, as a Value Change Dump.
//!
//! What it leaves out: comparator, capacitive touch, I2C, IrDA and multiprocessor modes of the
//! USCI, SPI slave mode, ADC sequences and data transfer, crystals of the G2553, the boot loader in
//! ROM; of the F5529 also DMA, USB, RTC, ADC12, comparator, voltage reference, RAM sectors switched
//! off, fractional and saturating products, and grouped latches of TB0: using one is a warning.
//! A register access takes effect at the end of its instruction.

mod address;
mod board;
mod bus;
mod cpu;
mod f5;
mod line;
mod load;
mod part;
mod periph;
pub mod plant;
mod record;
mod reset;
mod rng;
mod stats;
mod vcd;
mod warn;

/// Ticks in a second of the G2553: cycles of 16 MHz.
pub const TICKS_PER_SECOND: u64 = 16_000_000;

pub use crate::vcd::VcdWriter;
pub use address::Address;
pub use board::{Board, Config, FlashSize, Link, Stop};
pub use f5::silicon::{FlashSpeed, Fll, Silicon};
pub use line::{Format, Parity};
pub use load::{Image, LoadError, Segment};
pub use part::{Family, MAIN_SEGMENT, Part};
pub use periph::flash::Wear;
pub use periph::watchdog::Kicks;
pub use plant::{Plant, Wiring};
pub use record::{Edge, EdgeSink, Signal};
pub use reset::Reset;
pub use rng::Rng;
pub use stats::{InterruptStats, Stats};
pub use warn::{Kind as WarningKind, Warning};
