//! USCI_A0 as UART and USCI_B0 as SPI, against the wire.

use emulator::{Board, Config, Format, Parity, Wiring};

use crate::{IDLE, board, board_with};

const IFG2: u16 = 0x03;
const CTL0: u16 = 0x60;
const CTL1: u16 = 0x61;
const STAT: u16 = 0x65;
const RXBUF: u16 = 0x66;
const TXBUF: u16 = 0x67;
/// Ticks of a bit at 115 200 baud, rounded.
const BIT: u64 = 139;

/// P1.1 and P1.2 given to the USCI, rate by UCBR and UCMCTL.
fn uart(br: u16, mctl: u8, ctl0: u8) -> Board {
    let mut b = board(&IDLE);
    b.bus_write8(0x26, 0x06);
    b.bus_write8(0x41, 0x06);
    b.bus_write8(CTL1, 0x81);
    b.bus_write8(CTL0, ctl0);
    b.bus_write8(0x62, br as u8);
    b.bus_write8(0x63, (br >> 8) as u8);
    b.bus_write8(0x64, mctl);
    b.bus_write8(CTL1, 0x80);
    b
}

/// Divider 138 with UCBRS = 7: the low-frequency setting for 115 200 from 16 MHz.
fn at_115200() -> Board {
    uart(138, 7 << 1, 0)
}

fn bytes(board: &mut Board) -> Vec<u8> {
    board.uart_take().into_iter().map(|(_, byte)| byte).collect()
}

#[test]
fn both_divider_modes_reach_the_host() {
    // 16 MHz / 115 200 = 138.9; with oversampling 8 * 16 + 11 = 139.
    for (br, mctl) in [(138, 7 << 1), (8, 11 << 4 | 1)] {
        let mut b = uart(br, mctl, 0);
        for byte in [0x00, 0x55, 0xFF, 0xA3] {
            b.bus_write8(TXBUF, byte);
            b.run_us(100);
            assert_eq!(bytes(&mut b), [byte]);
            b.uart_send(&[byte]);
            b.run_us(100);
            assert_eq!(b.bus_read8(IFG2) & 1, 1);
            assert_eq!(b.bus_read8(RXBUF), byte);
        }
        assert_eq!(b.uart_errors(), 0);
    }
}

#[test]
fn bit_lengths_follow_the_modulation() {
    let edges = |br, mctl| {
        let mut b = uart(br, mctl, 0);
        b.record(true);
        b.bus_write8(TXBUF, 0x55);
        b.run_us(200);
        let times: Vec<u64> = b.take_edges().iter().map(|e| e.cycle).collect();
        times.windows(2).map(|w| w[1] - w[0]).collect::<Vec<_>>()
    };
    // 0x55: an edge at every bit. UCBRS = 5 lengthens bits 1, 2, 3, 5 and 7 (table 15-2).
    assert_eq!(edges(100, 5 << 1), [100, 101, 101, 101, 100, 101, 100, 101, 100]);
    assert_eq!(edges(100, 0), [100; 9]);
    // Oversampling: 16 * UCBR + UCBRF, and a whole UCBR more for UCBRS.
    assert_eq!(edges(8, 11 << 4 | 1), [139; 9]);
    assert_eq!(edges(8, 11 << 4 | 1 << 1 | 1), [139, 147, 139, 139, 139, 139, 139, 139, 139]);
}

#[test]
fn transmitter_is_double_buffered() {
    let mut b = at_115200();
    b.bus_write8(TXBUF, 1);
    assert_eq!(b.bus_read8(IFG2) & 2, 2, "the first moves on at once");
    b.bus_write8(TXBUF, 2);
    assert_eq!(b.bus_read8(IFG2) & 2, 0, "the second waits");
    assert_eq!(b.bus_read8(STAT) & 1, 1);
    b.run_for(10 * BIT + 5);
    assert_eq!(b.bus_read8(IFG2) & 2, 2);
    b.run_for(10 * BIT + 5);
    assert_eq!(b.bus_read8(STAT) & 1, 0);
    let got = b.uart_take();
    assert_eq!(got.iter().map(|(_, byte)| *byte).collect::<Vec<_>>(), [1, 2]);
    // Back to back: the stop bits are one character apart.
    let apart = got[1].0 - got[0].0;
    assert!((10 * BIT - 5..=10 * BIT + 5).contains(&apart), "{apart}");
}

#[test]
fn receive_flag_comes_in_the_stop_bit_and_reading_clears_it() {
    let mut b = at_115200();
    b.uart_send(&[0x42]);
    b.run_for(9 * BIT);
    assert_eq!(b.bus_read8(IFG2) & 1, 0);
    b.run_for(BIT);
    assert_eq!(b.bus_read8(IFG2) & 1, 1);
    assert_eq!(b.bus_read8(RXBUF), 0x42);
    assert_eq!(b.bus_read8(IFG2) & 1, 0);
}

#[test]
fn overrun_keeps_the_later_character() {
    let mut b = at_115200();
    b.uart_send(&[1, 2]);
    b.run_us(300);
    assert_eq!(b.bus_read8(STAT) & 0x24, 0x24, "UCOE and UCRXERR");
    assert_eq!(b.bus_read8(RXBUF), 2);
    assert_eq!(b.bus_read8(STAT), 0, "reading the buffer clears the errors");
}

#[test]
fn errors_need_ucrxeie() {
    for (eie, want_flag) in [(0x00, 0), (0x20, 1)] {
        let mut b = at_115200();
        b.bus_write8(CTL1, 0x80 | eie);
        // A character whose stop bit is low.
        b.uart_send_raw(&[(false, BIT), (true, 8 * BIT), (false, BIT), (true, BIT)]);
        b.run_us(200);
        assert_eq!(b.bus_read8(IFG2) & 1, want_flag);
        assert_eq!(b.bus_read8(STAT) & 0x44, if eie != 0 { 0x44 } else { 0 });
    }
    // Parity: the chip wants even, the host sends odd.
    let mut b = uart(138, 7 << 1, 0xC0);
    b.bus_write8(CTL1, 0xA0);
    b.set_uart_format(Format { baud: 115_200, parity: Parity::Odd });
    b.uart_send(&[0x31]);
    b.run_us(200);
    assert_eq!(b.bus_read8(STAT) & 0x14, 0x14);
    b.bus_read8(RXBUF);
    b.set_uart_format(Format { baud: 115_200, parity: Parity::Even });
    b.uart_send(&[0x31, 0x32]);
    b.run_us(100);
    assert_eq!((b.bus_read8(RXBUF), b.bus_read8(STAT) & 0x14), (0x31, 0));
    b.bus_write8(TXBUF, 0x37);
    b.run_us(200);
    assert_eq!(bytes(&mut b), [0x37]);
    assert_eq!(b.uart_errors(), 0);
}

#[test]
fn a_glitch_is_no_start_bit_and_a_break_is_one() {
    let mut b = at_115200();
    b.uart_send_raw(&[(false, BIT / 4), (true, 20 * BIT)]);
    b.run_us(300);
    assert_eq!(b.bus_read8(IFG2) & 1, 0);
    b.uart_send_raw(&[(false, 12 * BIT), (true, 2 * BIT)]);
    b.run_us(300);
    assert_eq!(b.bus_read8(STAT) & 0x08, 0x08);
    b.uart_send(&[0x77]);
    b.run_us(100);
    assert_eq!(b.bus_read8(RXBUF), 0x77, "it finds the next start bit");
}

#[test]
fn a_wrong_rate_is_garbage_and_a_slightly_wrong_one_is_not() {
    let text: Vec<u8> = (0..64u8).map(|i| i.wrapping_mul(37)).collect();
    let receive = |baud| {
        let mut b = at_115200();
        b.set_uart_format(Format { baud, parity: Parity::None });
        let mut got = Vec::new();
        for byte in &text {
            b.uart_send(&[*byte]);
            let end = b.uart_free() + 200;
            b.run_until(end);
            if b.bus_read8(IFG2) & 1 != 0 {
                got.push(b.bus_read8(RXBUF));
            }
        }
        got
    };
    assert_eq!(receive(115_200), text);
    assert_eq!(receive(117_500), text);
    assert_eq!(receive(113_000), text);
    assert_ne!(receive(57_600), text);
    assert_ne!(receive(125_000), text);
}

#[test]
fn noise_is_repeatable() {
    let run = |seed| {
        let mut b = at_115200();
        b.set_uart_noise(seed, 20_000);
        let mut got = Vec::new();
        for byte in 0..=255 {
            b.bus_write8(TXBUF, byte);
            b.run_us(100);
            got.extend(bytes(&mut b));
        }
        got
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
    assert_ne!(run(1), (0..=255).collect::<Vec<u8>>());
}

#[test]
fn software_reset_clears_what_the_guide_says() {
    let mut b = at_115200();
    b.uart_send(&[1, 2]);
    b.run_us(300);
    b.bus_write8(CTL1, 0x81);
    assert_eq!(b.bus_read8(IFG2) & 3, 2);
    assert_eq!(b.bus_read8(STAT), 0);
}

/// One exchange of bytes on the SPI with the registers of the chain behind it.
fn chain_exchange(b: &mut Board, send: [u8; 2]) -> [u8; 2] {
    // Latch low and high: the 165s load, then shift.
    b.bus_write8(0x29, 0x00);
    b.bus_write8(0x29, 0x04);
    let got = send.map(|byte| {
        b.bus_write8(0x6F, byte);
        b.run_us(20);
        assert_eq!(b.bus_read8(IFG2) & 4, 4);
        b.bus_read8(0x6E)
    });
    b.bus_write8(0x29, 0x00);
    b.bus_write8(0x29, 0x04);
    got
}

fn chain(divider: u8) -> Board {
    let mut b = board_with(&Config { wiring: Wiring::Chain, ..Config::default() }, &IDLE);
    b.bus_write8(0x26, 0xE0);
    b.bus_write8(0x41, 0xE0);
    b.bus_write8(0x2E, 0x00);
    b.bus_write8(0x29, 0x04);
    b.bus_write8(0x2A, 0x24);
    b.bus_write8(0x69, 0xC1);
    b.bus_write8(0x68, 0xA9);
    b.bus_write8(0x6A, divider);
    b.bus_write8(0x69, 0xC0);
    b
}

#[test]
fn shift_registers_carry_inputs_and_outputs() {
    for divider in [1, 2, 3, 16] {
        let mut b = chain(divider);
        for n in [1, 3, 8, 9, 16] {
            b.plant_mut().set_input(n, true);
        }
        // The first byte sent holds outputs 9 to 16.
        let got = chain_exchange(&mut b, [0x80, 0x05]);
        assert_eq!(got, [0x85, 0x81], "divider {divider}");
        let on: Vec<u8> = (1..=16).filter(|n| b.plant().output(*n)).collect();
        assert_eq!(on, [1, 3, 16]);
        // Output enable high: everything off.
        b.bus_write8(0x29, 0x24);
        assert_eq!(b.plant().outputs(), 0);
    }
}

#[test]
fn references_stand_at_inputs_9_to_11() {
    let mut b = chain(2);
    b.plant_mut().switches[1] =
        Some(emulator::plant::Contact { axis: 1, position: 0, above: false });
    assert_eq!(chain_exchange(&mut b, [0, 0]), [0x00, 0x02]);
    assert!(b.plant().input(10));
}

#[test]
fn an_spi_byte_takes_eight_bit_clocks() {
    let mut b = chain(4);
    let start = b.cycles();
    b.bus_write8(0x6F, 0xA5);
    b.run_until(start + 8 * 4 - 3);
    assert_eq!(b.bus_read8(IFG2) & 4, 0);
    b.run_until(start + 8 * 4);
    assert_eq!(b.bus_read8(IFG2) & 4, 4);
}
