//! Timers, ports and their mapping, USCI, multiplier and CRC by their registers.

use emulator::{Board, Config, Image, Link, Part, Rng, Signal, VcdWriter, WarningKind, Wiring};

use crate::{CODE, CYCLE, IDLE, US, board, full_speed};

fn ready() -> Board {
    let mut b = board(&IDLE);
    full_speed(&mut b);
    b
}

#[test]
fn four_step_outputs_make_their_edges_at_their_ticks() {
    let mut b = ready();
    b.record(true);
    b.bus_write8(0x0204, 0x3C);
    b.bus_write8(0x020A, 0x3C);
    // Set at the compare value, in continuous mode from SMCLK.
    for n in 1..5u32 {
        b.bus_write16(0x0352 + 2 * n, 1000 * n as u16);
        b.bus_write16(0x0342 + 2 * n, 0x0020);
    }
    b.take_edges();
    b.bus_write16(0x0340, 0x0224);
    let from = b.cycles();
    b.run_us(1000);
    let edges = b.take_edges();
    let at =
        |n| edges.iter().find(|e| e.signal == Signal::Step(n)).map(|e| (e.cycle - from) / CYCLE);
    assert_eq!([at(0), at(1), at(2)], [Some(1000), Some(2000), Some(3000)]);
    assert_eq!(b.plant().motors[0].pulses, 1);
    assert_ne!(b.bus_read8(0x0200) & 0x20, 0, "TA0.4 too");
    // The same edges in a file, in units of 100 ps.
    let mut file = Vec::new();
    let signals = b.plant().signals();
    let mut vcd = VcdWriter::new(&mut file, &signals, 0, b.ticks_per_second()).expect("in memory");
    vcd.write(&edges).expect("in memory");
    let text = String::from_utf8(file).expect("text");
    let x = edges.iter().find(|e| e.signal == Signal::Step(0)).expect("the edge");
    assert!(text.contains(&format!("#{}\n", x.cycle)), "{text}");
}

#[test]
fn timer_vectors_and_dividers_are_those_of_the_part() {
    let mut b = ready();
    b.bus_write16(0x0360, 4);
    b.bus_write16(0x0340, 0x02E6);
    b.run_for(40 * 7 * CYCLE);
    assert_eq!(b.bus_read16(0x0350), 7, "8 x 5 cycles a count");
    for n in 1..5u32 {
        b.bus_write16(0x0342 + 2 * n, 0x0011);
    }
    b.bus_write16(0x0340, 0x0003);
    let vectors: Vec<u16> = (0..6).map(|_| b.bus_read16(0x036E)).collect();
    assert_eq!(vectors, [2, 4, 6, 8, 0x0E, 0]);
}

#[test]
fn latches_of_tb0_load_when_they_should() {
    // CLLD; what the output's duty is before and after the period's end.
    for (clld, at_once) in [(0u16, true), (1, false)] {
        let mut b = ready();
        b.bus_write16(0x03D2, 99);
        b.bus_write16(0x03D4, 50);
        b.bus_write16(0x03C4, 0x00E0 | clld << 9);
        b.bus_write16(0x03C0, 0x0214);
        b.run_for(250 * CYCLE);
        // In the middle of a period: a new compare value in front of the counter.
        let count = b.bus_read16(0x03D0);
        assert!(count < 90, "{count}");
        b.bus_write16(0x03C4, 0x00E0 | clld << 9);
        b.bus_write16(0x03D4, count + 5);
        b.run_for(6 * CYCLE);
        let flagged = b.bus_read16(0x03C4) & 1 != 0;
        assert_eq!(flagged, at_once, "CLLD {clld}");
        b.run_for(100 * CYCLE);
        assert_ne!(b.bus_read16(0x03C4) & 1, 0);
    }
    let mut b = ready();
    b.bus_write16(0x03C0, 0x2214);
    assert!(b.warnings().iter().any(|w| w.kind == WarningKind::Unsupported), "groups");
}

#[test]
fn pwm_of_tb0_stops_in_hardware() {
    let mut b = ready();
    b.bus_write8(0x0224, 0x20);
    b.bus_write8(0x022A, 0xA0);
    b.bus_write16(0x03D2, 999);
    b.bus_write16(0x03DC, 500);
    b.bus_write16(0x03CC, 0x00E0);
    b.bus_write16(0x03C0, 0x0214);
    let share = |b: &mut Board| {
        (0..1000).filter(|_| (b.run_for(7 * CYCLE), b.bus_read8(0x0220) & 0x20 != 0).1).count()
    };
    b.run_for(3000 * CYCLE);
    let on = share(&mut b);
    assert!((450..550).contains(&on), "{on}");
    // TB0OUTH: P3.7 selected and high, here by its own pull-up.
    b.bus_write8(0x0226, 0x80);
    b.bus_write8(0x0222, 0x80);
    assert_eq!(share(&mut b), 0);
}

#[test]
fn a_capture_sees_a_pin_from_the_moment_that_it_is_selected() {
    // P2.3 high by its own pull-up; TA2.0 captures rises, from SMCLK.
    let high = || {
        let mut b = ready();
        b.bus_write8(0x0207, 0x08);
        b.bus_write8(0x0203, 0x08);
        b.bus_write16(0x0400, 0x0224);
        b
    };
    // Selected while it captures, the input of the timer rises then, not when another pin changes.
    let mut b = high();
    b.bus_write16(0x0402, 0x4900);
    assert_eq!(b.bus_read16(0x0402) & 1, 0);
    b.bus_write8(0x020B, 0x08);
    assert_eq!(b.bus_read16(0x0402) & 1, 1);
    // Selected before, there is no edge.
    let mut b = high();
    b.bus_write8(0x020B, 0x08);
    b.bus_write16(0x0402, 0x4900);
    b.bus_write8(0x0204, 0x01);
    b.bus_write8(0x0202, 0x01);
    assert_eq!(b.bus_read16(0x0402) & 1, 0);
}

#[test]
fn ports_answer_by_byte_and_by_word_and_flag_edges() {
    let mut b = ready();
    b.bus_write16(0x0204, 0x0101);
    b.bus_write16(0x0202, 0x0100);
    assert_eq!((b.bus_read8(0x0202), b.bus_read8(0x0203)), (0, 1));
    assert_eq!(b.bus_read8(0x0201) & 1, 1);
    // S2 at P1.1 with a pull-up: falling edge.
    b.bus_write8(0x0206, 0x02);
    b.bus_write8(0x0202, 0x02);
    b.bus_write8(0x0218, 0x02);
    b.bus_write8(0x021A, 0x02);
    b.bus_write8(0x021C, 0);
    b.plant_mut().press_stop(true);
    b.run_us(1);
    assert_eq!((b.bus_read16(0x020E), b.bus_read16(0x020E)), (4, 0));
}

#[test]
fn a_function_that_a_pin_does_not_have_is_named() {
    for (sel, dir, bit, bad) in [(0x026B, 0x0265, 2, true), (0x020A, 0x0204, 4, false)] {
        let mut b = ready();
        b.bus_write8(dir, bit);
        b.bus_write8(sel, bit);
        assert_eq!(b.warnings().iter().any(|w| w.kind == WarningKind::PinFunction), bad);
    }
}

#[test]
fn the_port_mapping_opens_with_its_key_once() {
    let mut b = ready();
    b.bus_write8(0x01E0, 5);
    assert!(b.warnings().iter().any(|w| w.kind == WarningKind::Closed));
    assert_eq!(b.bus_read8(0x01E0), 13);
    b.bus_write16(0x01C0, 0x2D52);
    b.bus_write8(0x01E0, 5);
    b.bus_write16(0x01C0, 0);
    assert_eq!((b.bus_read8(0x01E0), b.bus_read16(0x01C2) & 1), (5, 1));
    b.bus_write16(0x01C0, 0x2D52);
    b.bus_write8(0x01E0, 7);
    assert_eq!(b.bus_read8(0x01E0), 5, "only once");
    // TB0.1 appears at P4.0.
    b.bus_write8(0x0225, 1);
    b.bus_write8(0x022B, 1);
    b.bus_write16(0x03C4, 0x0004);
    assert_eq!(b.bus_read8(0x0221) & 1, 1);
}

/// USCI_A1 at 115 200 as the part's notes set it, on its mapped pins.
fn back_channel(b: &mut Board) {
    b.bus_write8(0x022B, 0x30);
    b.bus_write8(0x0600, 0x81);
    b.bus_write8(0x0606, 217);
    b.bus_write8(0x0607, 0);
    b.bus_write8(0x0600, 0x80);
}

#[test]
fn the_back_channel_sends_and_receives() {
    let mut b = ready();
    back_channel(&mut b);
    for byte in [0x00u8, 0x55, 0xA7, 0xFF] {
        let end = b.uart_send(&[byte]) + 2 * US;
        b.run_until(end);
        b.bus_write8(0x061C, 3);
        assert_eq!(b.bus_read16(0x061E), 2);
        assert_eq!(b.bus_read8(0x060C), byte);
        b.bus_write8(0x060E, byte);
        b.run_us(100);
        let back: Vec<u8> = b.uart_take().into_iter().map(|(_, byte)| byte).collect();
        assert_eq!(back, [byte]);
    }
    assert_eq!(b.uart_errors(), 0);
}

#[test]
fn both_lines_work_side_by_side() {
    let mut b = ready();
    back_channel(&mut b);
    b.bus_write8(0x022A, 0x18);
    b.bus_write8(0x05C0, 0x81);
    b.bus_write16(0x05C6, 217);
    b.bus_write8(0x05C0, 0x80);
    let now = b.cycles();
    b.uart_send(b"H");
    b.uart_send_on(Link::Rs485, now, b"R");
    b.run_us(200);
    assert_eq!((b.bus_read8(0x060C), b.bus_read8(0x05CC)), (b'H', b'R'));
    b.bus_write8(0x05CE, b'x');
    b.run_us(200);
    let heard: Vec<u8> = b.uart_take_on(Link::Rs485).into_iter().map(|(_, byte)| byte).collect();
    assert_eq!((heard, b.uart_take().len()), (vec![b'x'], 0));
}

#[test]
fn the_chain_is_read_and_written_through_ucb0() {
    let config = Config { part: Part::F5529, wiring: Wiring::Chain, ..Config::default() };
    let image = Image::from_bytes(CODE, &[0xFF, 0x3F]).expect("code");
    let mut b = Board::with_config(&config, &image);
    b.bus_write16(crate::WDTCTL, crate::WDT_HOLD);
    b.set_reg(0, CODE);
    full_speed(&mut b);
    b.bus_write8(0x022A, 0x07);
    b.bus_write8(0x05E0, 0x81);
    b.bus_write8(0x05E1, 0xA9);
    b.bus_write16(0x05E6, 4);
    b.bus_write8(0x05E0, 0x80);
    // Latch P1.6 low, then high; outputs on by P6.3 low.
    b.bus_write8(0x0204, 0x40);
    b.bus_write8(0x0245, 0x08);
    b.plant_mut().set_input(3, true);
    b.bus_write8(0x0243, 0x00);
    b.bus_write8(0x0202, 0x00);
    b.run_us(1);
    b.bus_write8(0x0202, 0x40);
    let mut word = 0u16;
    for out in [0x12u8, 0x34] {
        b.bus_write8(0x05EE, out);
        b.run_us(5);
        word = word << 8 | u16::from(b.bus_read8(0x05EC));
    }
    b.bus_write8(0x0202, 0x00);
    b.bus_write8(0x0202, 0x40);
    assert_eq!((word, b.plant().outputs()), (0x0400, 0x1234));
}

#[test]
fn the_multiplier_agrees_with_the_host() {
    let mut b = ready();
    let mut rng = Rng::new(5);
    for _ in 0..2000 {
        let (x, y) = (rng.bits() as u32, rng.bits() as u32);
        let mut write = |at: u32, value: u32| b.bus_write16(at, value as u16);
        let signed = x & 1 != 0;
        let base = if signed { 0x04D4 } else { 0x04D0 };
        write(base, x);
        write(base + 2, x >> 16);
        write(0x04E0, y);
        write(0x04E2, y >> 16);
        let want = if signed {
            (i64::from(x.cast_signed()) * i64::from(y.cast_signed())).cast_unsigned()
        } else {
            u64::from(x) * u64::from(y)
        };
        b.run_for(20 * CYCLE);
        let got =
            (0..4).fold(0, |sum, n| sum | u64::from(b.bus_read16(0x04E4 + 2 * n)) << (16 * n));
        assert_eq!(got, want, "{x:x} {y:x}");
    }
}

#[test]
fn a_hasty_multiplication_is_noticed() {
    let notices = |code: &[u16], kind: WarningKind| {
        let mut b = board(code);
        b.set_reg(5, 0x04CA);
        for _ in 0..code.len() {
            b.step();
        }
        b.warnings().iter().any(|w| w.kind == kind)
    };
    // MOV R4,&OP2 and MOV @R5,R6, or MOV &RESLO,R6.
    assert!(notices(&[0x4482, 0x04C8, 0x4526], WarningKind::MultiplierEarly));
    assert!(!notices(&[0x4482, 0x04C8, 0x4216, 0x04CA], WarningKind::MultiplierEarly));
}

#[test]
fn a_multiplication_in_a_handler_that_may_interrupt_another_is_noticed() {
    // EINT and NOP or DINT and NOP, MOV R4,&MPY or nothing, EINT, NOP, JMP $; the handler of P1 multiplies, too.
    let multiply = [0x4482, 0x04C0];
    let shared = |first: u16, outside: &[u16]| {
        let mut b = board(&[&[first, 0x4303], outside, &[0xD232, 0x4303, 0x3FFF]].concat());
        b.poke16(0xFFDE, 0x5000);
        for (n, word) in multiply.into_iter().chain([0x1300]).enumerate() {
            b.poke16(0x5000 + 2 * n as u32, word);
        }
        for _ in 0..8 {
            b.step();
        }
        b.bus_write8(0x021A, 1);
        b.bus_write8(0x021C, 1);
        for _ in 0..8 {
            b.step();
        }
        b.warnings().iter().any(|w| w.kind == WarningKind::MultiplierShared)
    };
    assert!(shared(0xD232, &multiply), "interrupts are on");
    assert!(!shared(0xC232, &multiply), "interrupts are off");
    assert!(!shared(0xD232, &[]), "nothing but the handler multiplies");
}

#[test]
fn random_register_accesses_are_survived() {
    for seed in 0..60 {
        let mut rng = Rng::new(seed);
        let mut b = board(&IDLE);
        for _ in 0..300 {
            let addr = rng.below(0x1000) as u32;
            let key = [0x5A00, 0xA500, 0, 0][rng.below(4) as usize];
            let value = rng.bits() as u16;
            match rng.below(4) {
                0 => b.bus_write8(addr, value as u8),
                1 => b.bus_write16(addr & !1, key | value & 0xFF),
                2 => drop(b.bus_read8(addr)),
                _ => drop(b.bus_read16(addr & !1)),
            }
            b.run_us(rng.below(50));
        }
    }
}

#[test]
fn random_programs_run() {
    for seed in 0..40 {
        let mut rng = Rng::new(seed);
        let data: Vec<u8> = (0..0x2_0000).map(|_| rng.bits() as u8).collect();
        let mut image = Image::from_bytes(CODE, &data).expect("noise");
        image.segments.push(emulator::Segment {
            addr: 0xFFFE,
            data: vec![rng.bits() as u8, 0x44 | rng.bits() as u8],
        });
        let config = Config { part: Part::F5529, ..Config::default() };
        let mut b = Board::with_config(&config, &image);
        for _ in 0..10 {
            b.uart_send(&[rng.bits() as u8]);
            let target = b.cycles() + 200 * US;
            b.run_until(target);
            assert!(b.cycles() >= target);
        }
        b.reset_pin();
        b.run_us(1000);
    }
}
