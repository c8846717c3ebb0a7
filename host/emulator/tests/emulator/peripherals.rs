//! Timers, ports, watchdog, clocks and ADC10 against the chapters of SLAU144.

use emulator::{Board, Reset};

use crate::asm::{D, RETI, S, op2};
use crate::{CODE, IDLE, WDTCTL, board};

const TACTL: u16 = 0x180;
const TAR: u16 = 0x190;
const TAIV: u16 = 0x11E;
/// SMCLK; modes up, continuous, up/down.
const UP: u16 = 0x0210;
const CONTINUOUS: u16 = 0x0220;
const UP_DOWN: u16 = 0x0230;

fn cctl(n: u16) -> u16 {
    TACTL + 2 + 2 * n
}

fn ccr(n: u16) -> u16 {
    TAR + 2 + 2 * n
}

/// P2.0, P2.1 and P2.4 given to Timer1_A, all plain outputs otherwise.
fn timer_board() -> Board {
    let mut b = board(&IDLE);
    b.bus_write8(0x2E, 0x13);
    b.bus_write8(0x2A, 0xFF);
    b.record(true);
    b
}

/// Time and level of an edge.
type Change = (u64, bool);

/// Edges of P2.0, P2.1 or P2.4 (0, 1, 2) as times since `start`.
fn edges(b: &mut Board, start: u64, unit: u8) -> Vec<Change> {
    b.take_edges()
        .iter()
        .filter(|e| e.signal == emulator::Signal::Step(unit))
        .map(|e| (e.cycle - start, e.level))
        .collect()
}

#[test]
fn up_mode_counts_to_ccr0_and_both_flags_come_one_count_apart() {
    let mut b = board(&IDLE);
    b.bus_write16(ccr(0), 9);
    let start = b.cycles();
    b.bus_write16(TACTL, UP);
    b.run_until(start + 8);
    assert_eq!((b.bus_read16(TAR), b.bus_read16(cctl(0)) & 1, b.bus_read16(TACTL) & 1), (8, 0, 0));
    let mut at_flag = 0;
    let mut at_overflow = 0;
    while at_overflow == 0 {
        b.run_for(1);
        let at = b.cycles() - start;
        if at_flag == 0 && b.bus_read16(cctl(0)) & 1 != 0 {
            at_flag = at;
        }
        if b.bus_read16(TACTL) & 1 != 0 {
            at_overflow = at;
        }
    }
    // The idle loop takes two cycles a turn.
    assert!((9..=10).contains(&at_flag) && (10..=11).contains(&at_overflow));
    b.run_until(start + 10 * 100);
    assert_eq!(b.bus_read16(TAR), 0, "a period is CCR0 + 1 counts");
}

#[test]
fn continuous_mode_wraps_after_65536_counts_with_every_divider() {
    for (bits, divider) in [(0x00, 1), (0x40, 2), (0x80, 4), (0xC0, 8)] {
        let mut b = board(&IDLE);
        let start = b.cycles();
        b.bus_write16(TACTL, CONTINUOUS | bits);
        b.run_until(start + 65_530 * divider);
        assert_eq!(b.bus_read16(TACTL) & 1, 0);
        b.run_until(start + 65_536 * divider);
        assert_eq!(b.bus_read16(TACTL) & 1, 1);
        b.run_until(start + 65_636 * divider);
        assert_eq!(b.bus_read16(TAR), 100);
    }
}

#[test]
fn up_down_mode_has_a_period_of_twice_ccr0() {
    let mut b = timer_board();
    b.bus_write16(ccr(0), 100);
    b.bus_write16(ccr(1), 30);
    // Toggle/set and toggle/reset need EQU0 in between; plain toggle shows both passes.
    b.bus_write16(cctl(1), 4 << 5);
    let start = b.cycles();
    b.bus_write16(TACTL, UP_DOWN);
    b.run_until(start + 400);
    assert_eq!(edges(&mut b, start, 1), [(30, true), (170, false), (230, true), (370, false)]);
    assert_eq!(b.bus_read16(TACTL) & 1, 1);
}

#[test]
fn output_modes_act_at_their_compare_instants() {
    // Mode; level before; edges within two periods of 100 with CCR1 = 30.
    let rows: [(u16, bool, &[Change]); 7] = [
        (1, false, &[(30, true)]),
        (2, false, &[(30, true), (99, false), (130, true), (199, false)]),
        (3, false, &[(30, true), (99, false), (130, true), (199, false)]),
        (4, false, &[(30, true), (130, false)]),
        (5, true, &[(30, false)]),
        (6, true, &[(30, false), (99, true), (130, false), (199, true)]),
        (7, true, &[(30, false), (99, true), (130, false), (199, true)]),
    ];
    for (mode, before, want) in rows {
        let mut b = timer_board();
        b.bus_write16(ccr(0), 99);
        b.bus_write16(ccr(1), 30);
        // Mode 0 sets the level by OUT.
        b.bus_write16(cctl(1), u16::from(before) << 2);
        b.bus_write16(cctl(1), mode << 5);
        b.take_edges();
        let start = b.cycles();
        b.bus_write16(TACTL, UP);
        b.run_until(start + 200);
        assert_eq!(edges(&mut b, start, 1), want, "mode {mode}");
    }
}

#[test]
fn the_step_pulse_pattern_set_by_compare_dropped_by_mode_0() {
    let mut b = timer_board();
    b.bus_write16(TACTL, CONTINUOUS);
    let start = b.cycles();
    for n in 0..3 {
        b.bus_write16(ccr(n), (start + 100 + 10 * u64::from(n)) as u16 - start as u16);
        b.bus_write16(cctl(n), 1 << 5);
    }
    b.run_until(start + 200);
    for n in 0..3 {
        b.bus_write16(cctl(n), 0);
    }
    let all = b.take_edges();
    let of = |unit| -> Vec<(u64, bool)> {
        all.iter()
            .filter(|e| e.signal == emulator::Signal::Step(unit))
            .map(|e| (e.cycle - start, e.level))
            .collect()
    };
    let down = of(0)[1].0;
    assert_eq!(
        [of(0), of(1), of(2)],
        [
            vec![(100, true), (down, false)],
            vec![(110, true), (down, false)],
            vec![(120, true), (down, false)]
        ]
    );
    assert_eq!(b.plant().motors.each_ref().map(|m| m.pulses), [1, 1, 1]);
}

#[test]
fn a_compare_value_that_was_missed_waits_for_the_next_round() {
    let mut b = timer_board();
    let start = b.cycles();
    b.bus_write16(TACTL, CONTINUOUS);
    b.run_until(start + 500);
    b.bus_write16(cctl(0), 1 << 5);
    b.bus_write16(ccr(0), 400);
    b.run_until(start + 65_000);
    assert_eq!(edges(&mut b, start, 0), []);
    b.run_until(start + 66_000);
    assert_eq!(edges(&mut b, start, 0), [(65_936, true)]);
}

#[test]
fn vector_register_gives_the_highest_source_and_resets_its_flag() {
    let mut b = board(&IDLE);
    b.bus_write16(ccr(1), 10);
    b.bus_write16(ccr(2), 20);
    b.bus_write16(cctl(1), 0x10);
    b.bus_write16(cctl(2), 0x10);
    b.bus_write16(TACTL, CONTINUOUS | 0x02);
    b.run_for(70_000);
    assert_eq!([(); 4].map(|()| b.bus_read16(TAIV)), [2, 4, 10, 0]);
}

#[test]
fn capture_takes_the_count_at_the_edge_and_reports_overflow() {
    let mut b = board(&IDLE);
    // Capture on both edges, software input: CCIS switches between ground and Vcc.
    b.bus_write16(TACTL, CONTINUOUS);
    b.bus_write16(cctl(1), 0xC100 | 2 << 12);
    b.run_for(100);
    b.bus_write16(cctl(1), 0xC100 | 3 << 12);
    let count = b.bus_read16(TAR);
    assert_eq!(b.bus_read16(ccr(1)), count);
    assert_eq!(b.bus_read16(cctl(1)) & 0x0B, 0x09, "CCI and CCIFG, no overflow");
    let armed = b.bus_read16(cctl(1));
    b.run_for(50);
    b.bus_write16(cctl(1), armed & !0x1001);
    assert_eq!(b.bus_read16(cctl(1)) & 0x03, 0x01, "the first value was read");
    b.bus_write16(cctl(1), armed & !0x0001);
    assert_eq!(b.bus_read16(cctl(1)) & 0x03, 0x03, "the second was not");
}

#[test]
fn capture_from_a_pin() {
    // Timer0_A CCI1A is P1.2, CCI0A is P1.1: the serial line.
    let mut b = board(&IDLE);
    b.bus_write16(0x160, CONTINUOUS);
    b.bus_write16(0x162, 0x8100);
    let at = b.bus_read16(0x170);
    b.uart_send_raw(&[(true, 1000), (false, 100)]);
    b.run_for(2000);
    assert_eq!(b.bus_read16(0x172), at + 1000);
}

#[test]
fn interrupt_of_ccr0_resets_its_flag_and_wakes_the_cpu() {
    let mut b = board(&[0x4303]);
    // BIS #GIE|CPUOFF, SR at the start; the handler counts in R10 and returns.
    let sleep = op2("bis", false, S::Imm(0x0018), D::R(2), CODE);
    let jump = crate::asm::jump(7, -3);
    for (i, word) in sleep.iter().chain(&[jump]).enumerate() {
        b.poke16(CODE + 2 * i as u16, *word);
    }
    let handler = op2("add", false, S::Cg(1), D::R(10), 0xD000);
    for (i, word) in handler.iter().chain(&[RETI]).enumerate() {
        b.poke16(0xD000 + 2 * i as u16, *word);
    }
    b.poke16(0xFFFA, 0xD000);
    b.set_reg(1, 0x0400);
    b.set_reg(10, 0);
    b.bus_write16(ccr(0), 999);
    b.bus_write16(cctl(0), 0x10);
    b.bus_write16(TACTL, UP);
    b.clear_stats();
    b.run_for(100_500);
    assert_eq!(b.reg(10), 100);
    let stats = b.stats().interrupts[&0xFFFA];
    // Entry 6, ADD 1, RETI 5; asleep there is no latency.
    assert_eq!((stats.count, stats.worst, stats.worst_latency), (100, 12, 0));
    assert_eq!(b.stats().lowest_sp, Some(0x03FC));
}

#[test]
fn the_instruction_after_eint_runs_before_an_interrupt() {
    let mut b = board(&[0xD232, 0x531A, 0x531A]);
    b.poke16(0xFFE4, 0xD000);
    b.set_reg(1, 0x0400);
    b.set_reg(10, 0);
    b.bus_write8(0x25, 1);
    b.bus_write8(0x23, 1);
    b.step();
    b.step();
    assert_eq!((b.reg(0), b.reg(10)), (CODE + 4, 1));
    b.step();
    assert_eq!(b.reg(0), 0xD000);
}

#[test]
fn higher_vectors_go_first() {
    let mut b = board(&IDLE);
    b.set_reg(1, 0x0400);
    for vector in (0xFFE0..0xFFFE).step_by(2) {
        b.poke16(vector, vector & 0x0FFE | 0xD000);
    }
    b.bus_write8(0x25, 1);
    b.bus_write8(0x23, 1);
    b.bus_write8(0x2D, 1);
    b.bus_write8(0x2B, 1);
    b.bus_write16(0x162, 0x11);
    b.bus_write16(cctl(1), 0x11);
    b.bus_write16(cctl(0), 0x11);
    let mut order = Vec::new();
    for _ in 0..5 {
        b.set_reg(2, 8);
        b.step();
        let vector = b.reg(0) & 0x0FFE | 0xF000;
        order.push(vector);
        match vector {
            0xFFF8 => b.bus_write16(cctl(1), 0),
            0xFFE6 => b.bus_write8(0x2B, 0),
            0xFFE4 => b.bus_write8(0x23, 0),
            _ => {}
        }
    }
    assert_eq!(order, [0xFFFA, 0xFFF8, 0xFFF2, 0xFFE6, 0xFFE4]);
}

#[test]
fn port_edges_set_flags_by_their_edge_select() {
    let mut b = board(&IDLE);
    // Pull-ups on Stop, Start and probe; Start closes to ground.
    b.bus_write8(0x21, 0x19);
    b.bus_write8(0x27, 0x19);
    b.bus_write8(0x24, 0x08);
    b.bus_write8(0x23, 0);
    assert_eq!(b.bus_read8(0x20) & 0x08, 0x08);
    b.plant_mut().press_start(true);
    b.run_for(10);
    assert_eq!((b.bus_read8(0x20) & 0x08, b.bus_read8(0x23) & 0x08), (0, 0x08));
    b.bus_write8(0x23, 0);
    b.plant_mut().press_start(false);
    b.run_for(10);
    assert_eq!((b.bus_read8(0x20) & 0x08, b.bus_read8(0x23) & 0x08), (0x08, 0));
    assert!(b.warnings().is_empty());
}

#[test]
fn an_open_contact_without_pull_resistor_is_reported() {
    let mut b = board(&IDLE);
    b.bus_read8(0x20);
    assert_eq!(b.warnings()[0].kind, emulator::WarningKind::FloatingInput);
}

#[test]
fn p2sel_resets_to_the_crystal_pins() {
    let mut b = board(&IDLE);
    assert_eq!(b.bus_read8(0x2E), 0xC0);
    b.bus_write8(0x2A, 0xC0);
    b.bus_write8(0x29, 0xC0);
    b.record(true);
    assert!(b.take_edges().is_empty(), "P2.6 and P2.7 are no outputs yet");
    b.bus_write8(0x2E, 0x00);
    assert_eq!(b.take_edges().len(), 2);
}

#[test]
fn watchdog_resets_after_its_interval_and_says_so() {
    for (select, counts) in [(0, 32_768), (1, 8192), (2, 512), (3, 64)] {
        let mut b = board(&IDLE);
        b.bus_write8(0x02, 0);
        let start = b.cycles();
        b.bus_write16(WDTCTL, 0x5A08 | select);
        b.run_until(start + counts - 4);
        assert_eq!(b.last_reset(), Reset::Pin, "not yet");
        b.run_until(start + counts + 4);
        assert_eq!(b.last_reset(), Reset::Watchdog);
        assert_eq!(b.bus_read8(0x02) & 0x01, 0x01, "WDTIFG tells");
    }
}

#[test]
fn watchdog_from_the_vlo_survives_an_erase() {
    let mut b = board(&IDLE);
    b.bus_write8(0x53, 0x20);
    let start = b.cycles();
    // ACLK / 512 at 12 kHz: 42.7 ms.
    b.bus_write16(WDTCTL, 0x5A0E);
    b.run_until(start + 42 * 16_000);
    assert_eq!(b.last_reset(), Reset::Pin);
    b.run_until(start + 43 * 16_000);
    assert_eq!(b.last_reset(), Reset::Watchdog);
}

#[test]
fn watchdog_key_and_interval_mode() {
    let mut b = board(&IDLE);
    assert_eq!(b.bus_read16(WDTCTL), 0x6980);
    b.bus_write16(WDTCTL, 0x1234);
    b.run_for(100);
    assert_eq!(b.last_reset(), Reset::WatchdogKey);

    let mut b = board(&IDLE);
    b.set_reg(1, 0x0400);
    b.poke16(0xFFF4, 0xD000);
    b.poke16(0xD000, 0x3FFF);
    b.bus_write8(0x02, 0);
    b.bus_write8(0x00, 1);
    b.bus_write16(WDTCTL, 0x5A1A);
    b.set_reg(2, 8);
    b.run_for(600);
    assert_eq!(b.reg(0), 0xD000);
    assert_eq!(b.bus_read8(0x02) & 1, 0, "acceptance resets the flag");
    assert_eq!(b.last_reset(), Reset::Pin);
}

#[test]
fn resets_leave_what_the_guide_says() {
    let mut b = board(&IDLE);
    assert_eq!(b.bus_read8(0x02) & 0x0C, 0x0C, "PORIFG from power-up, RSTIFG from the pin");
    b.bus_write8(0x02, 0);
    b.bus_write8(0x21, 0x41);
    b.bus_write8(0x22, 0x41);
    b.bus_write16(ccr(1), 0x1234);
    b.poke16(0x0200, 0xBEEF);
    b.bus_write16(WDTCTL, 0);
    b.run_for(1);
    b.run_for(100);
    assert_eq!(b.bus_read8(0x02) & 0x0D, 0x01);
    assert_eq!((b.bus_read8(0x21), b.bus_read8(0x22)), (0x41, 0), "PxOUT stays, PxDIR does not");
    assert_eq!(b.bus_read16(ccr(1)), 0x1234, "a PUC leaves the timers");
    assert_eq!(b.peek16(0x0200), 0xBEEF);
    b.reset_pin();
    assert_eq!(b.bus_read16(ccr(1)), 0, "a POR does not");
}

#[test]
fn calibration_constants_give_16_mhz_and_a_valid_checksum() {
    let mut b = Board::new(emulator::Part::G2553, &emulator::Image::default());
    let sum = (0x10C2..0x1100u16).step_by(2).fold(0, |sum, at| sum ^ b.peek16(at));
    assert_eq!(sum.wrapping_add(b.peek16(0x10C0)), 0);
    crate::set_up(&mut b);
    b.poke16(CODE, 0x4303);
    let start = b.cycles();
    b.step();
    assert_eq!(b.cycles() - start, 1);
}

#[test]
fn adc_measures_half_the_supply() {
    for vcc in [3300, 3600, 2400] {
        let config = emulator::Config { vcc, ..emulator::Config::default() };
        let mut b = crate::board_with(&config, &IDLE);
        // 2.5 V reference, ADC10OSC, channel 11, then ENC and ADC10SC.
        b.bus_write16(0x1B2, 11 << 12);
        b.bus_write16(0x1B0, 0x2000 | 0x1800 | 0x70);
        b.bus_write16(0x1B0, 0x2000 | 0x1800 | 0x73);
        assert_eq!(b.bus_read16(0x1B2) & 1, 1);
        b.run_us(20);
        assert_eq!(b.bus_read16(0x1B0) & 4, 4);
        let got = u32::from(b.bus_read16(0x1B4));
        let want = vcc / 2 * 1023 / 2500;
        assert!(got.abs_diff(want) <= 1, "{got} for {vcc} mV");
        assert_eq!(b.bus_read16(0x1B2) & 1, 0);
    }
}
