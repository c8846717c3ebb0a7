//! Resets, supply, crystal, flash and PWM of the MSP430F5529 on pieces of silicon that have their errata, and the pin plan.

mod rig;

use std::collections::BTreeMap;

use emulator::plant::pins::{Pins, pin};
use emulator::{Board, FlashSpeed, Signal, Silicon};
use lang::part::pins::{self, Pin};
use lang::record::BoardRecord;
use lang::wire::{self, Control, RunState};
use rig::{BOOT_US, ask, machine, off, on, read, wired, write, write_body};

/// The last program of boards whose program is of no matter.
const WAITS: &str = "Wait 999s\n";

#[test]
fn the_emulated_board_has_the_pins_of_the_plan() {
    let at = |plan: Pin| pin(plan.port, plan.bit);
    let wanted = Pins {
        step: pins::STEP.map(at),
        dir: pins::DIR.map(at),
        start: at(pins::START[0]),
        stop: at(pins::STOP[0]),
        rx: at(pins::LINK[1]),
        tx: at(pins::LINK[0]),
        inputs: pins::INPUTS.map(at),
        probe: at(pins::INPUTS[0]),
        clk: at(pins::CHAIN[2]),
        somi: at(pins::CHAIN[1]),
        simo: at(pins::CHAIN[0]),
        latch: at(pins::LATCH),
        enable: at(pins::ENABLE),
        pwm: Some(at(pins::PWM)),
        aout: Some(at(pins::ANALOG_OUT)),
        rs485: Some([at(pins::RS485[0]), at(pins::DRIVE)]),
    };
    assert_eq!(Pins::F5529, wanted);
}

#[test]
fn each_header_pin_has_one_use() {
    for chain in [false, true] {
        let mut places = BTreeMap::new();
        for row in pins::ROWS.iter().chain(pins::RESERVED) {
            let words = if chain && row.chain != pins::SAME { row.chain } else { row.direct };
            for pin in row.pins.iter().filter(|_| !words.is_empty()) {
                let before = places.insert((pin.port, pin.bit), words);
                assert_eq!(before, None, "P{}.{}: {words}", pin.port, pin.bit);
            }
        }
    }
}

#[test]
fn step_and_dir_are_driven_within_the_first_instructions() {
    const P1DIR: u16 = 0x0204;
    const P6DIR: u16 = 0x0245;
    let mut board = off(Silicon::default(), &machine(""), WAITS);
    for reset in ["power-up", "RST", "the watchdog"] {
        match reset {
            "power-up" => board.power_up(),
            "RST" => board.reset_pin(),
            // A write without its password.
            _ => board.bus_write16(0x015C_u16, 0),
        }
        for _ in 0..32 {
            board.step();
        }
        let (step, dir) = (pins::mask(&pins::STEP), pins::mask(&pins::DIR));
        assert_eq!(board.bus_read8(P1DIR), step, "{reset}");
        assert_eq!(board.bus_read8(P6DIR), dir, "{reset}");
        board.run_us(BOOT_US);
        assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Ready as u16), "{reset}");
    }
}

/// Optocouplers of drivers want 10 to 16 mA: STEP, DIR and the pins of outputs 1 and 2, which latch and enable the chain, are of
/// full strength from the first instructions on, whatever a run does then; no other pin of the two ports is.
#[test]
fn step_dir_and_the_outputs_pins_have_full_drive_strength_from_reset_on() {
    const STRENGTHS: [u16; 2] = [0x0208, 0x0249];
    let mut full = [pins::mask(&pins::STEP), pins::mask(&pins::DIR)];
    for pin in [pins::LATCH, pins::ENABLE] {
        full[usize::from(pin.port != 1)] |= 1 << pin.bit;
    }
    for wiring in ["chain", "direct"] {
        let script = "SetOut 1, ON\nMoveRel X, 1mm\nMoveRel Y, -1mm\nSetOut 2, ON\n";
        let mut board = off(Silicon::default(), &wired(wiring, ""), script);
        for reset in ["power-up", "RST", "the watchdog"] {
            match reset {
                "power-up" => board.power_up(),
                "RST" => board.reset_pin(),
                // A write without its password.
                _ => board.bus_write16(0x015C_u16, 0),
            }
            for _ in 0..32 {
                board.step();
            }
            let strengths = |board: &mut Board| STRENGTHS.map(|at| board.bus_read8(at));
            assert_eq!(strengths(&mut board), full, "{wiring}, {reset}");
            board.run_us(BOOT_US);
            write(&mut board, wire::RUN_CONTROL, Control::Start as u16);
            board.run_us(500_000);
            assert_eq!(strengths(&mut board), full, "{wiring}, {reset}, behind a run");
        }
    }
}

/// Edges of outputs to a level from now on, for some time.
fn edges_to(board: &mut Board, level: bool, us: u64) -> Vec<(u64, Signal)> {
    board.run_us(us);
    let edges = board.take_edges().into_iter();
    let own = edges.filter(|edge| edge.level == level && matches!(edge.signal, Signal::Out(_)));
    own.map(|edge| (edge.cycle, edge.signal)).collect()
}

#[test]
fn step_rests_high_from_reset_on_where_the_profile_says_so() {
    let mut board = off(Silicon::default(), &machine(""), WAITS);
    let record = BoardRecord::of(&machine(""), 1);
    let low = BoardRecord { flags: record.flags | BoardRecord::STEP_LOW, sequence: 2, ..record };
    // The other copy, which is the newer one.
    let place = lang::part::F5529.profiles[0];
    (place..).zip(low.sealed().to_bytes()).for_each(|(at, byte)| board.poke8(at, byte));
    for reset in ["power-up", "RST"] {
        board.record(true);
        board.take_edges();
        if reset == "RST" {
            board.reset_pin();
        } else {
            board.power_up();
        }
        board.run_us(BOOT_US);
        let edges = board.take_edges();
        let steps: Vec<bool> = edges
            .iter()
            .filter(|edge| edge.signal == Signal::Step(0))
            .map(|edge| edge.level)
            .collect();
        // While nobody drives it the emulated board's resistors pull it down.
        let before = if reset == "RST" { &[false, true][..] } else { &[true] };
        assert_eq!(steps, before, "{reset}");
    }
}

/// Of both polarities: STEP is never driven to its active level, from the first instruction after a reset to the main loop,
/// and is driven to its level at rest within the first instructions.
#[test]
fn step_is_never_driven_active_from_the_first_cycle_on() {
    const P1OUT: u16 = 0x0202;
    const P1DIR: u16 = 0x0204;
    const P1SEL: u16 = 0x020A;
    let mask = pins::mask(&pins::STEP);
    for active_low in [false, true] {
        let mut board = off(Silicon::default(), &machine(""), WAITS);
        let record = BoardRecord::of(&machine(""), 1);
        let flags = record.flags | if active_low { BoardRecord::STEP_LOW } else { 0 };
        // Both copies, as after two writes.
        for (place, sequence) in lang::part::F5529.profiles.into_iter().zip([2, 1]) {
            let copy = BoardRecord { flags, sequence, ..record }.sealed();
            (place..).zip(copy.to_bytes()).for_each(|(at, byte)| board.poke8(at, byte));
        }
        for reset in ["power-up", "RST"] {
            match reset {
                "power-up" => board.power_up(),
                _ => board.reset_pin(),
            }
            let rest = if active_low { mask } else { 0 };
            // Painting RAM takes some 30 000 instructions, the rest of the set-up fewer.
            for n in 0..100_000_u32 {
                board.step();
                let [out, dir, timer] = [P1OUT, P1DIR, P1SEL].map(|at| board.bus_read8(at));
                let what = format!("active low: {active_low}, {reset}, instruction {n}");
                // The timer's outputs are at rest, too: `step_rests_high_from_reset_on_where_the_profile_says_so`.
                let driven = dir & mask & !timer;
                assert_eq!((out ^ rest) & driven, 0, "{what}: P1OUT {out:02X}, P1DIR {dir:02X}");
                assert!(n < 64 || dir & mask == mask, "{what}: P1DIR {dir:02X}");
            }
            board.run_us(BOOT_US);
            assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Ready as u16), "{reset}");
        }
    }
}

#[test]
fn a_reset_button_that_bounces_switches_nothing_on() {
    let silicon = Silicon { port16: true, ..Silicon::default() };
    // Outputs that are on: RST takes them away, and nothing shows what the registers hold.
    let mut board = on(silicon.clone(), &machine(""), WAITS);
    write(&mut board, wire::OUTPUTS, 0xFFFF);
    assert_eq!(board.plant().outputs(), 0xFFFF);
    board.record(true);
    board.take_edges();
    board.reset_pin();
    assert_eq!(edges_to(&mut board, true, BOOT_US), [], "chain");
    assert_eq!(board.plant().outputs(), 0);
    // Relays that are on when low, with their resistors to 3.3 V.
    let relays = "[[output]]\nn = 1\ninvert = true\n[[output]]\nn = 2\ninvert = true\n";
    let profile = wired("direct", relays);
    let mut board = off(silicon, &profile, WAITS);
    board.plant_mut().pull_outputs_up();
    board.power_up();
    board.run_us(BOOT_US);
    assert_eq!(board.plant().outputs(), 0b11, "both are high, that is off");
    board.record(true);
    board.take_edges();
    board.reset_pin();
    assert_eq!(edges_to(&mut board, false, BOOT_US), [], "direct");
}

#[test]
fn full_speed_begins_at_2700_mv_and_ends_there() {
    let mut board = off(Silicon::default(), &machine(""), WAITS);
    board.set_supply(2_500);
    board.power_up();
    board.run_us(1_000_000);
    assert_eq!(read(&mut board, wire::RUN_STATE), None, "2.5 V are too low for 25 MHz");
    board.set_supply(3_300);
    board.run_us(BOOT_US);
    assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Ready as u16));
    // A sag below the monitor's level in the middle of a run.
    write(&mut board, wire::RUN_CONTROL, Control::Start as u16);
    board.run_us(100_000);
    assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Running as u16));
    board.set_supply(2_600);
    board.run_us(500_000);
    assert!(board.smclk_hz() < 2_000_000, "{} Hz at 2.6 V", board.smclk_hz());
    assert_eq!(read(&mut board, wire::RUN_STATE), None);
    board.set_supply(3_300);
    board.run_us(BOOT_US);
    assert_eq!(read(&mut board, wire::RESET_CAUSE), Some(1 << 2), "as a power-up");
    assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Ready as u16));
    assert_eq!(board.warnings(), &[]);
}

#[test]
fn a_spark_at_the_crystal_is_over_after_a_tenth_of_a_second() {
    /// Which pins are crystals' (SLAS590, port 5): XT2's are 2 and 3.
    const P5SEL: u16 = 0x024A;
    let mut board = on(Silicon::default(), &machine(""), WAITS);
    for _ in 0..2 {
        board.bus_write8(P5SEL, 0);
        board.run_us(100);
        board.bus_write8(P5SEL, pins::mask(&pins::CRYSTAL));
        board.run_us(20_000);
        assert_eq!(read(&mut board, wire::RESET_CAUSE), Some(1 << 2 | 1 << 5), "REFO");
        board.run_us(200_000);
        assert_eq!(read(&mut board, wire::RESET_CAUSE), Some(1 << 2 | 1 << 6), "the crystal again");
        let hz = board.smclk_hz();
        assert!(hz.abs_diff(25_000_000) < 100_000, "{hz} Hz");
    }
    assert_eq!(board.warnings(), &[]);
}

#[test]
fn slow_flash_loses_no_character_while_values_are_kept() {
    let silicon = Silicon { flash: FlashSpeed::Slow, ..Silicon::default() };
    let names = ["a", "b", "c", "d", "e", "f", "g", "h"];
    let mut script: String = names.iter().map(|name| format!("KEEP {name}\n")).collect();
    script += "DO\n";
    script.extend(names.iter().map(|name| format!("{name} = {name} + 1\n")));
    script += "Wait 5ms\nLOOP\n";
    let mut board = on(silicon, &machine(""), &script);
    ask(&mut board, &write_body(wire::RUN_CONTROL, Control::Start as u16), 100_000);
    // Another board's requests without end: each character is read before the next one is complete.
    let (first, overruns) = (board.wear().operations, board.uart_overruns());
    while board.wear().operations < first + 400 {
        let end = board.uart_send(&[9; 64]);
        board.run_until(end);
    }
    assert_eq!(board.uart_overruns(), overruns);
    assert_eq!(board.warnings(), &[]);
    board.run_us(50_000);
    assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Running as u16));
}

#[test]
fn a_fault_without_its_program_has_no_place_and_reads_no_register() {
    let mut board = off(Silicon::default(), &machine(""), WAITS);
    // As the log has a fault at 177A of a program that is there no more.
    let words: [u16; 3] = [2, 0x177A, 7];
    let sum = words.iter().fold(0, |sum, word| sum ^ word);
    (0x1800_u16..).step_by(2).zip(words.into_iter().chain([sum])).for_each(|(at, word)| {
        board.poke16(at, word);
    });
    board.power_up();
    board.run_us(BOOT_US);
    assert_eq!(read(&mut board, wire::FAULT_PC), Some(0x177A), "with its program it has");
    ask(&mut board, &write_body(wire::UPLOAD_CONTROL, wire::Upload::Erase as u16), 500_000);
    assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Empty as u16));
    for _ in 0..2 {
        let [high, low] = wire::FAULT.to_be_bytes();
        board.uart_take();
        let end = board.uart_send(&rig::frame(&[1, 3, high, low, 0, 4]));
        board.run_until(end);
        board.run_us(20_000);
        let reply = board.uart_take();
        let bytes: Vec<u8> = reply.iter().map(|(_, byte)| *byte).collect();
        assert_eq!(bytes.get(..9), Some(&[1, 3, 8, 0, 2, 0, 0, 0, 0][..]), "F02 and no place");
        let most = reply.windows(2).map(|pair| pair[1].0 - pair[0].0).max().unwrap_or(0);
        let us = most / (board.ticks_per_second() / 1_000_000);
        assert!(us < 120, "the reply has a gap of {us} us");
        // What a power-up finds in the log is as good.
        board.power_cut();
        board.power_up();
        board.run_us(BOOT_US);
    }
    assert_eq!(board.warnings(), &[]);
}

/// A laser's lines with two powers in turns, at this frequency: its pulses' widths in us, and how many periods between the
/// first and the last had none.
fn laser(tb25: bool, hz: u32, [low, high]: [u32; 2]) -> (BTreeMap<u64, u32>, u64) {
    let own = format!(
        "[pwm]\noutput = 1\nkind = \"laser\"\nfrequency_hz = {hz}\n[[output]]\nn = 1\nrole = \"laser\"\n"
    );
    let mut script = String::from("G1 F3000\nM3\n");
    for n in 1..=100 {
        let power = if n % 2 == 0 { high } else { low };
        script += &format!("G1 X{} S{power}\n", f64::from(n) * 0.2);
    }
    script += "M5\n";
    let silicon = Silicon { tb25, ..Silicon::default() };
    let mut board = on(silicon, &wired("direct", &own), &script);
    board.record(true);
    board.take_edges();
    write(&mut board, wire::RUN_CONTROL, Control::Start as u16);
    board.run_us(1_000_000);
    assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Ready as u16));
    assert_eq!(board.warnings(), &[]);
    let us = board.ticks_per_second() / 1_000_000;
    let (mut widths, mut rose, mut fell, mut dark) = (BTreeMap::new(), 0, None, 0_u64);
    for edge in board.take_edges().iter().filter(|edge| edge.signal == Signal::Pwm) {
        if edge.level {
            rose = edge.cycle;
            continue;
        }
        if rose == 0 {
            continue;
        }
        *widths.entry((edge.cycle - rose) / us).or_insert(0) += 1;
        // A pulse ends with its period, but for the last one, which M5 ends.
        let period = 1_000_000 * us / u64::from(hz);
        let passed: u64 = fell.map_or(1, |last: u64| (edge.cycle - last + period / 2) / period);
        dark += passed.saturating_sub(1);
        fell = Some(edge.cycle);
    }
    (widths, dark)
}

#[test]
fn each_period_of_a_lasers_line_has_its_pulse_with_erratum_tb25_and_without() {
    for tb25 in [false, true] {
        for (hz, powers) in [(1_000, [300, 900]), (5_000, [10, 1000]), (20_000, [500, 1000])] {
            let (widths, dark) = laser(tb25, hz, powers);
            let all: u32 = widths.values().sum();
            assert!(all > hz / 3, "TB25 {tb25}, {hz} Hz: {widths:?}");
            assert_eq!(dark, 0, "TB25 {tb25}, {hz} Hz: {widths:?}");
            let [least, most] = powers.map(|power| u64::from(1_000_000 / hz * power / 1000));
            // A period in which the power changes lies between.
            let outside: u32 = widths
                .iter()
                .filter(|(us, _)| **us + 1 < least || **us > most)
                .map(|(_, n)| n)
                .sum();
            assert_eq!(outside, 0, "TB25 {tb25}, {hz} Hz: {widths:?}");
            let between: u32 = widths
                .iter()
                .filter(|(us, _)| **us > least + 1 && **us + 1 < most)
                .map(|(_, n)| n)
                .sum();
            assert!(between <= 2 * 100, "TB25 {tb25}, {hz} Hz: {widths:?}");
        }
    }
}

#[test]
fn a_stop_at_any_time_of_a_millisecond_leaves_the_pwm_dark() {
    /// Control of the PWM's channel: 0 keeps the pin low.
    const TB0CCTL5: u16 = 0x03CC;
    /// The main loop may be about to let the pin go as the stop comes; it looks for one right after, and takes that back.
    const DARK_US: u64 = 60;
    let own = "[pwm]\noutput = 1\nkind = \"spindle\"\nfrequency_hz = 20000\n\
               [[output]]\nn = 1\nrole = \"spindle\"\n\
               [[input]]\nn = 4\nrole = \"emergency_stop\"\n";
    let mut board = on(Silicon::default(), &wired("direct", own), "M3 S900\nWait 999s\n");
    write(&mut board, wire::RUN_CONTROL, Control::Start as u16);
    board.run_us(200_000);
    assert_ne!(board.bus_read16(TB0CCTL5) >> 5 & 7, 0, "it runs");
    let cycle = board.ticks_per_second() / 25_000_000;
    for offset in (0..25_000).step_by(7) {
        let mut board = board.clone();
        board.run_for(offset * cycle);
        board.plant_mut().set_input(4, true);
        board.run_us(DARK_US);
        for us in DARK_US..1_200 {
            assert_eq!(board.bus_read16(TB0CCTL5) >> 5 & 7, 0, "{offset} cycles later, {us} us");
            board.run_us(1);
        }
    }
}

/// What a file has at an offset, low byte first.
fn number(file: &[u8], at: usize, bytes: usize) -> usize {
    file[at..at + bytes].iter().rev().fold(0, |sum, byte| sum << 8 | usize::from(*byte))
}

#[test]
fn a_programmer_that_takes_the_files_as_they_are_writes_nothing_but_the_flash() {
    let files: [(&str, &[u8], usize); 4] = [
        ("f5529", include_bytes!("../image/pasapas-f5529.elf"), 0x4400),
        ("g2553", include_bytes!("../image/pasapas-g2553.elf"), 0xC000),
        ("g2553-handlers", include_bytes!("../image/pasapas-g2553-handlers.elf"), 0xC000),
        ("whole", include_bytes!("../image/pasapas-whole.elf"), 0x8000),
    ];
    for (name, file, flash) in files {
        let (first, size, count) =
            (number(file, 0x1C, 4), number(file, 0x2A, 2), number(file, 0x2C, 2));
        let mut written = 0;
        for header in (0..count).map(|n| &file[first + n * size..]) {
            // PT_LOAD, with the address that it is loaded at and its bytes in the file.
            let [kind, address, bytes] = [0, 12, 16].map(|at| number(header, at, 4));
            if kind == 1 && bytes != 0 {
                assert!(address >= flash, "{name}: {bytes} bytes at {address:04X}");
                written += bytes;
            }
        }
        assert!(written > 10_000, "{name}: {written} bytes");
    }
}
