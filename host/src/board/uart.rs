//! The UART settings of the emulated chip.

use emulator::{Board, Family, Format, Parity};

/// What the registers of the UART say (user's guides SLAU144, chapter 15, and SLAU208, chapter 36): the
/// nearest of our rates to the divider's, and the parity bits.
pub fn format(board: &mut Board) -> Format {
    // CTL0, BR0 and MCTL of USCI_A0, of USCI_A1.
    let [ctl0, br0, mctl] = match board.part().family {
        Family::Msp430 => [0x60u16, 0x62, 0x64],
        Family::Msp430X => [0x601, 0x606, 0x608],
    };
    let clock = board.smclk_hz();
    let divider = u64::from(board.bus_read8(br0)) | u64::from(board.bus_read8(br0 + 1)) << 8;
    let oversampling = if board.bus_read8(mctl) & 1 != 0 { 16 } else { 1 };
    let divider = (divider * oversampling).max(1);
    let rates = [9_600u32, 19_200, 57_600, 115_200];
    let baud = rates
        .into_iter()
        .min_by_key(|rate| (clock / divider).abs_diff(u64::from(*rate)))
        .unwrap_or(115_200);
    let parity = match board.bus_read8(ctl0) >> 6 {
        0b10 => Parity::Odd,
        0b11 => Parity::Even,
        _ => Parity::None,
    };
    Format { baud, parity }
}
