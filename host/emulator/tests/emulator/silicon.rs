//! What silicon does and a plain model forgets: each as an option or a warning.

use emulator::WarningKind as Kind;
use emulator::{Config, TICKS_PER_SECOND, Wiring};

use crate::{IDLE, board_with};

const P1IN: u16 = 0x20;
const P1OUT: u16 = 0x21;
const P1IFG: u16 = 0x23;
const P1REN: u16 = 0x27;
const P2OUT: u16 = 0x29;

fn kinds(board: &emulator::Board) -> Vec<Kind> {
    board.warnings().iter().map(|warning| warning.kind).collect()
}

#[test]
fn shift_registers_hold_anything_at_power_up() {
    let shown = |seed| {
        let mut board = board_with(&Config { seed, ..Config::default() }, &IDLE);
        // The output enable goes low before anything was sent.
        board.bus_write8(0x2E, 0);
        board.bus_write8(P2OUT, 0);
        board.bus_write8(0x2A, 1 << 5);
        board.plant().outputs()
    };
    let all = [1, 2, 3, 4].map(shown);
    assert!(all.iter().all(|outputs| *outputs != 0), "{all:04X?}");
    assert!(all.windows(2).all(|pair| pair[0] != pair[1]), "{all:04X?}");
    assert_eq!(shown(2), all[1], "a seed repeats a run");
}

#[test]
fn a_wire_with_a_capacity_comes_up_late() {
    let config = Config { wiring: Wiring::Direct, pull_up_us: 500, ..Config::default() };
    let mut board = board_with(&config, &IDLE);
    board.bus_write8(P1OUT, 0xFF);
    board.bus_write8(P1REN, 0xFF);
    assert_eq!(board.bus_read8(P1IN) & 0xF9, 0);
    board.run_us(499);
    assert_eq!(board.bus_read8(P1IN) & 0xF9, 0);
    board.run_us(2);
    assert_eq!(board.bus_read8(P1IN) & 0xF9, 0xF9);
    // Stop pulls its own down at once and lets it rise as late.
    board.plant_mut().press_stop(true);
    board.run_us(1);
    assert_eq!(board.bus_read8(P1IN) & 0xF9, 0xF8);
    board.plant_mut().press_stop(false);
    board.run_us(490);
    assert_eq!(board.bus_read8(P1IN) & 0xF9, 0xF8);
    board.run_us(20);
    assert_eq!(board.bus_read8(P1IN) & 0xF9, 0xF9);
}

#[test]
fn a_spike_is_an_edge_that_no_read_sees() {
    let mut board = board_with(&Config { wiring: Wiring::Direct, ..Config::default() }, &IDLE);
    board.bus_write8(P1OUT, 0xFF);
    board.bus_write8(P1REN, 0xFF);
    board.bus_write8(0x24, 0xF0);
    board.bus_write8(P1IFG, 0);
    board.spike(2);
    assert_eq!(board.bus_read8(P1IFG), 1 << 5);
    assert_eq!(board.bus_read8(P1IN) & 0xF0, 0xF0);
}

#[test]
fn a_receive_pin_without_cable_and_pull_up_floats() {
    let floats = |ren: u8| {
        let mut board = board_with(&Config::default(), &IDLE);
        board.plant_mut().unplug(true);
        board.bus_write8(P1OUT, ren);
        board.bus_write8(P1REN, ren);
        board.bus_write8(0x26, 0x06);
        board.bus_write8(0x41, 0x06);
        board.run_us(1);
        board.bus_write8(0x61, 0x80);
        (kinds(&board).contains(&Kind::FloatingInput), board.bus_read8(P1IN) & 2 != 0)
    };
    assert_eq!(floats(0), (true, false));
    assert_eq!(floats(2), (false, true));
}

#[test]
fn spi_waits_for_the_registers_delay() {
    let warned = |divider: u8| {
        let mut board = board_with(&Config { wiring: Wiring::Chain, ..Config::default() }, &IDLE);
        board.bus_write8(0x26, 0xE0);
        board.bus_write8(0x41, 0xE0);
        board.bus_write8(0x2E, 0);
        board.bus_write8(P2OUT, 0);
        board.bus_write8(0x2A, 0x24);
        board.plant_mut().set_input(2, true);
        board.plant_mut().set_input(5, true);
        board.run_us(1);
        board.bus_write8(P2OUT, 0x04);
        for (register, value) in [(0x69, 0xC1), (0x68, 0xA9), (0x6A, divider), (0x69, 0xC0)] {
            board.bus_write8(register, value);
        }
        board.bus_write8(0x6F, 0);
        board.run_us(20);
        (kinds(&board).contains(&Kind::SpiSetup), board.bus_read8(0x6E))
    };
    // 8 MHz: 125 ns are less than the register's 60 and the chip's 75.
    assert_eq!(warned(2), (true, 0x12));
    assert_eq!(warned(4), (false, 0x12));
}

#[test]
fn a_processor_too_fast_for_the_supply_is_told() {
    let warned = |vcc, supply_rise_us| {
        let config = Config { vcc, supply_rise_us, ..Config::default() };
        kinds(&board_with(&config, &IDLE)).contains(&Kind::Supply)
    };
    assert!(!warned(3_300, 0));
    assert!(warned(2_700, 0));
    assert!(warned(3_300, 5_000), "it still rises");
    let mut board = board_with(&Config::default(), &IDLE);
    board.set_supply(2_500);
    assert!(kinds(&board).contains(&Kind::Supply), "it sags");
}

#[test]
fn a_dco_that_is_off_hears_and_clocks_accordingly() {
    for ppm in [-30_000, 30_000] {
        let mut board = board_with(&Config { dco_ppm: ppm, ..Config::default() }, &IDLE);
        // Ten bits at 9600 of a true clock, in ticks of this one.
        let begin = board.cycles();
        board.set_uart_format(emulator::Format { baud: 9_600, ..Default::default() });
        let ticks = board.uart_send(b"x") - begin;
        let true_second =
            i64::try_from(TICKS_PER_SECOND).expect("small") * (1_000_000 + i64::from(ppm));
        let wanted = u64::try_from(true_second / 1_000_000 * 10 / 9_600).expect("positive");
        assert!(ticks.abs_diff(wanted) <= 2, "{ticks} for {wanted}");
        board.set_dco_ppm(0);
        let begin = board.uart_free();
        assert!((board.uart_send(b"x") - begin).abs_diff(16_666) <= 2, "it drifts back");
    }
}
