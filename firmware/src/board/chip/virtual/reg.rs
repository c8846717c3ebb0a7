//! The chip's register blocks, by their names in `msp430g2553`.
//!
//! A block is reached by its fixed address instead of through `Peripherals::take`, which would
//! cost a RAM flag. This is sound: the addresses are the chip's, a register access is one
//! volatile instruction, and registers that an interrupt also writes are only written by
//! single `bis`/`bic` instructions or before interrupts are enabled.

use msp430g2553 as pac;

macro_rules! blocks {
    ($($name:ident: $module:ident, $block:ident;)*) => {
        $(
            /// The register block of that peripheral.
            #[inline(always)]
            pub fn $name() -> &'static pac::$module::RegisterBlock {
                // SAFETY: a fixed, always mapped peripheral address.
                unsafe { &*pac::$block::ptr() }
            }
        )*
    };
}

blocks! {
    ports: port_1_2, PORT_1_2;
    clock: system_clock, SYSTEM_CLOCK;
    calibration: calibration_data, CALIBRATION_DATA;
    watchdog: watchdog_timer, WATCHDOG_TIMER;
    special: special_function, SPECIAL_FUNCTION;
    timer0: timer0_a3, TIMER0_A3;
    uart: usci_a0_uart_mode, USCI_A0_UART_MODE;
    spi: usci_b0_spi_mode, USCI_B0_SPI_MODE;
    flash: flash, FLASH;
}

/// Writes all bits of a register.
macro_rules! set {
    ($reg:expr, $bits:expr) => {{
        // SAFETY: every bit pattern written here is one that the user's guide (SLAU144) defines.
        // Registers of which the PAC knows every bit need no `unsafe`, the others do.
        #[allow(unused_unsafe)]
        $reg.write(|w| unsafe { w.bits($bits) });
    }};
}
/// Sets bits of a register in one read-modify-write instruction.
macro_rules! bis {
    ($reg:expr, $bits:expr) => {{
        // SAFETY: as for `set!`.
        #[allow(unused_unsafe)]
        $reg.modify(|r, w| unsafe { w.bits(r.bits() | $bits) });
    }};
}
/// Clears bits of a register in one read-modify-write instruction.
macro_rules! bic {
    ($reg:expr, $bits:expr) => {{
        // SAFETY: as for `set!`.
        #[allow(unused_unsafe)]
        $reg.modify(|r, w| unsafe { w.bits(r.bits() & !$bits) });
    }};
}
pub(crate) use {bic, bis, set};
