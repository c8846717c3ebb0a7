//! Power management, clocks and their faults: the sequences of the part's notes, both ways where
//! the silicon is not known.

use emulator::{Board, Fll, Silicon, WarningKind};

use crate::{CODE, CYCLE, IDLE, board, board_on, full_speed, raise_core, run_from_ram};

const FLLS: [Fll; 3] = [Fll::AtOnce, Fll::Ramp, Fll::Hunting];

/// Ticks of a CPU cycle, by one NOP in RAM.
fn cycle(b: &mut Board) -> u64 {
    run_from_ram(b, 0x4000, &[0x4303]);
    let before = b.cycles();
    b.step();
    b.cycles() - before
}

fn warned(b: &Board, kind: WarningKind) -> bool {
    b.warnings().iter().any(|w| w.kind == kind)
}

#[test]
fn the_cpu_comes_out_of_a_reset_at_about_a_megahertz() {
    let mut b = board(&IDLE);
    b.run_us(40_000);
    assert_eq!(cycle(&mut b), 9537, "32 x REFO");
    assert_ne!(b.bus_read16(0x016E) & 2, 0, "XT1 is selected and does not run");
}

#[test]
fn full_speed_from_xt2_is_25_mhz_however_the_loop_behaves() {
    for fll in FLLS {
        let mut b = board_on(Silicon { fll, ..Silicon::default() }, &IDLE);
        full_speed(&mut b);
        let mean = {
            run_from_ram(&mut b, 0x4000, &[0x3FFF]);
            let (from, mut jumps) = (b.cycles(), 0);
            while b.cycles() - from < 10_000_000 {
                b.step();
                jumps += 1;
            }
            (b.cycles() - from) as f64 / f64::from(2 * jumps)
        };
        assert!((mean / CYCLE as f64 - 1.0).abs() < 0.002, "{fll:?}: {mean}");
        assert!(!warned(&b, WarningKind::Clock), "{fll:?}");
        assert_eq!(b.bus_read16(0x016E) & 0x0B, 0, "no fault stands");
    }
}

#[test]
fn a_missing_xt2_leaves_the_chip_running_and_its_flag_up() {
    let silicon = Silicon { xt2_fitted: false, ..Silicon::default() };
    let mut b = board_on(silicon, &IDLE);
    full_speed(&mut b);
    for _ in 0..5 {
        b.bus_write16(0x016E, 0);
        b.bus_write16(0x0102, 0);
        b.run_us(10_000);
    }
    assert_eq!((b.bus_read16(0x016E) & 8, b.bus_read16(0x0102) & 2), (8, 2));
    // The firmware's way out: REFO as the reference.
    b.bus_write16(0x016C, 0x01CD);
    b.bus_write16(0x0166, 0x0020);
    b.bus_write16(0x0164, 0x02DB);
    b.run_us(40_000);
    b.bus_write16(0x016E, 0);
    b.bus_write16(0x0102, 0);
    assert_eq!((b.bus_read16(0x016E) & 0x0F, b.bus_read16(0x0102) & 2), (0, 0));
    assert_eq!(cycle(&mut b), 417, "23 986 176 Hz, rounded to a tick");
}

#[test]
fn a_fast_refo_at_25_mhz_is_out_of_specification() {
    let set = |hz: u64| {
        let silicon = Silicon { refo_hz: hz, fll: Fll::AtOnce, ..Silicon::default() };
        let mut b = board_on(silicon, &IDLE);
        raise_core(&mut b);
        for (register, value) in
            [(0x0162, 0x60), (0x0166, 0x20), (0x0168, 0x0233), (0x0164, 0x02FA)]
        {
            b.bus_write16(register, value);
        }
        b.run_us(1000);
        warned(&b, WarningKind::Clock)
    };
    assert!(!set(32_768));
    assert!(set(32_768 * 1035 / 1000));
}

#[test]
fn the_core_level_limits_the_clock_and_rises_step_by_step() {
    let mut b = board_on(Silicon { fll: Fll::AtOnce, ..Silicon::default() }, &IDLE);
    for (register, value) in
        [(0x0162, 0x0050), (0x0166, 0x0020), (0x0164, 0x01E7), (0x0168, 0x0233)]
    {
        b.bus_write16(register, value);
    }
    b.run_us(100);
    assert!(warned(&b, WarningKind::Clock), "16 MHz at level 0");
    let mut b = board(&IDLE);
    b.bus_write8(0x0121, 0xA5);
    b.bus_write8(0x0120, 2);
    assert!(warned(&b, WarningKind::CoreLevel));
    let mut b = board(&IDLE);
    b.bus_write16(0x0124, 0x4400);
    assert!(warned(&b, WarningKind::Closed));
    raise_core(&mut b);
    assert_eq!(b.bus_read16(0x0120), 0x9603);
}

#[test]
fn a_supply_too_low_for_a_level_raises_the_monitors_flag() {
    let mut b = board(&IDLE);
    b.set_supply(2_000);
    b.bus_write8(0x0121, 0xA5);
    b.bus_write16(0x0124, 0x4403);
    b.run_us(150);
    assert_eq!(b.bus_read16(0x012C) & 0x30, 0x30);
    // The supervisor resets when it is set above the supply.
    b.set_supply(3_300);
    b.bus_write16(0x0124, 0x4703);
    b.set_supply(2_000);
    b.step();
    let causes: Vec<u16> = (0..4).map(|_| b.bus_read16(0x019E)).collect();
    assert!(causes.contains(&0x0E), "{causes:x?}");
}

#[test]
fn the_frozen_loop_keeps_its_rate_and_no_more_moves() {
    let mut b = board_on(Silicon { fll: Fll::Hunting, ..Silicon::default() }, &IDLE);
    full_speed(&mut b);
    let tap = |b: &mut Board| b.bus_read16(0x0160);
    let moving: Vec<u16> = (0..50).map(|_| (b.run_us(4), tap(&mut b)).1).collect();
    assert!(moving.windows(2).any(|w| w[0] != w[1]));
    // BIS #SCG0,SR and wait.
    for (n, word) in [0xD032u16, 0x0040, 0x3FFF].into_iter().enumerate() {
        b.poke16(CODE + 2 * n as u32, word);
    }
    b.set_reg(0, CODE);
    b.step();
    let still: Vec<u16> = (0..50).map(|_| (b.run_us(4), tap(&mut b)).1).collect();
    assert!(still.windows(2).all(|w| w[0] == w[1]));
}

#[test]
fn a_crystal_needs_its_pins_and_its_time() {
    let mut b = board(&IDLE);
    b.bus_write16(0x016C, 0x00CD);
    b.run_us(10_000);
    b.bus_write16(0x016E, 0);
    assert_ne!(b.bus_read16(0x016E) & 8, 0, "pins not selected");
    b.bus_write8(0x024A, 0x0C);
    b.run_us(1_000);
    b.bus_write16(0x016E, 0);
    assert_ne!(b.bus_read16(0x016E) & 8, 0, "not started yet");
    b.run_us(1_500);
    b.bus_write16(0x016E, 0);
    assert_eq!(b.bus_read16(0x016E) & 8, 0);
}
