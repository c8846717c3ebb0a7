//! A chip of the emulator: the MSP430G2553 with 56 KB of flash and 4 KB of RAM.

pub mod clock;
pub mod flash;
pub mod line;
pub mod pins;
pub mod ports;
mod reg;
pub mod timer;

/// What it runs.
pub const PART: lang::part::Part = lang::part::VIRTUAL;

/// Start of the program area.
pub const AREA: u16 = 0xF200;
/// Segment D: the last faults.
pub const LOG: u16 = 0x1000;
/// Segments of the information memory that the firmware writes.
pub const INFORMATION: core::ops::Range<u16> = 0x1000..0x10C0;

/// The section of handlers that may have to run while flash is busy: the processor stands still then.
macro_rules! handlers {
    ($name:literal) => {
        concat!(".section .text.", $name, ",\"ax\",@progbits")
    };
}
pub(crate) use handlers;

/// The boot loader's key word: its entry by pins stays possible, a wrong password erases nothing.
#[unsafe(link_section = ".bslkey")]
#[used]
static BSL_KEY: u16 = 0x0000;

// The names that the vectors' table has for the handlers.
core::arch::global_asm!(
    r#"
    .global USCIAB0RX, USCIAB0TX, TIMER0_A0, TIMER0_A1, TIMER1_A0, TIMER1_A1, PORT1
    .set USCIAB0RX, pasapas_receive
    .set USCIAB0TX, pasapas_transmit
    .set TIMER0_A0, pasapas_millisecond
    .set TIMER0_A1, pasapas_silence
    .set TIMER1_A0, pasapas_event
    .set TIMER1_A1, pasapas_channels
    .set PORT1, pasapas_pins
    "#
);
