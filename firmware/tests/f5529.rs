//! What only the image of the MSP430F5529 has: its crystal and what stands in for it, erasing from RAM, silicon of
//! any kind.

mod rig;

use emulator::{Board, Config, FlashSpeed, Fll, Part, Silicon};
use lang::wire::{self, Control, RunState, Upload};
use rig::{BOOT_US, ask, frame, image, machine, read, write, write_body};

/// A board with a program that waits.
fn on(silicon: Silicon, profile: &lang::profile::Profile) -> Board {
    rig::on(silicon, profile, "SetOut 1, ON\nWait 999s\n")
}

/// Longest erase of a segment, us.
const ERASE_US: u64 = 32_000;

/// Milliseconds that the board counts in a second of the world.
fn milliseconds(board: &mut Board) -> u16 {
    let place = board.symbol("PASAPAS_MILLIS").expect("the milliseconds have a name in the image");
    let before = board.peek16(place);
    board.run_us(1_000_000);
    board.peek16(place).wrapping_sub(before)
}

#[test]
fn its_time_is_the_crystals_and_nothing_is_wrong() {
    for fll in [Fll::AtOnce, Fll::Ramp, Fll::Hunting] {
        let mut board = on(Silicon { fll, ..Silicon::default() }, &machine(""));
        let counted = milliseconds(&mut board);
        assert!(counted.abs_diff(1000) <= 3, "{fll:?}: {counted} ms");
        assert_eq!(read(&mut board, wire::RESET_CAUSE), Some(1 << 2), "{fll:?}");
        assert_eq!(board.warnings(), &[], "{fll:?}");
    }
}

#[test]
fn without_its_crystal_it_runs_from_refo_and_says_so() {
    // 3.5 % either way, the link at its worst.
    for refo_hz in [32_768, 31_950, 33_590] {
        let silicon = Silicon { xt2_fitted: false, refo_hz, ..Silicon::default() };
        let mut board = on(silicon, &machine(""));
        let counted = f64::from(milliseconds(&mut board));
        // At its fastest REFO may not take the processor above 25 MHz.
        let wanted = 1000.0 * 737.0 * refo_hz as f64 / 25e6;
        assert!((counted - wanted).abs() < 4.0, "{refo_hz} Hz: {counted} ms");
        assert_eq!(read(&mut board, wire::RESET_CAUSE), Some(1 << 2 | 1 << 5), "{refo_hz} Hz");
        assert_eq!(board.warnings(), &[], "{refo_hz} Hz");
    }
}

#[test]
fn a_crystal_that_stops_later_takes_neither_the_board_nor_its_link() {
    /// Which pins are crystals' (SLAS590, port 5): XT2's are 2 and 3.
    const P5SEL: u16 = 0x024A;
    let mut board = on(Silicon::default(), &machine(""));
    assert_eq!(read(&mut board, wire::RESET_CAUSE), Some(1 << 2));
    board.bus_write8(P5SEL, 0);
    board.run_us(200_000);
    assert_eq!(read(&mut board, wire::RESET_CAUSE), Some(1 << 2 | 1 << 5));
    let counted = milliseconds(&mut board);
    assert!(counted.abs_diff(966) <= 3, "{counted} ms");
}

#[test]
fn a_supply_that_is_too_low_is_waited_for() {
    let image = image();
    let config = Config { part: Part::F5529, vcc: 2_100, ..Config::default() };
    let mut board = Board::with_config(&config, &image);
    board.run_us(1_000_000);
    assert_eq!(read(&mut board, wire::RUN_STATE), None);
    board.set_supply(3_300);
    board.run_us(BOOT_US);
    assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Empty as u16));
    assert_eq!(board.warnings(), &[]);
}

/// Begins an upload, whose erases take [`ERASE_US`] each, and comes back some way into the first.
fn erasing(board: &mut Board) {
    write(board, wire::UPLOAD_LENGTH, 2_000);
    let erases = board.wear().erases.values().sum::<u32>();
    let end = board.uart_send(&frame(&write_body(wire::UPLOAD_CONTROL, Upload::Begin as u16)));
    board.run_until(end);
    while board.wear().erases.values().sum::<u32>() == erases {
        board.run_us(100);
    }
}

#[test]
fn an_erase_loses_no_character_and_no_millisecond() {
    let stop = "[[input]]\nn = 6\nrole = \"emergency_stop\"\n";
    for flash in [FlashSpeed::Fast, FlashSpeed::Slow] {
        let mut board = on(Silicon { flash, ..Silicon::default() }, &machine(stop));
        let place = board.symbol("PASAPAS_MILLIS").expect("a name");
        let (began, at) = (board.peek16(place), board.cycles());
        let erases = |board: &Board| board.wear().erases.values().sum::<u32>();
        let before = erases(&board);
        // The log of faults is erased when it is full: outside of any request.
        let mut faults = 0;
        while erases(&board) == before {
            write(&mut board, wire::RUN_CONTROL, Control::Start as u16);
            board.plant_mut().set_input(6, true);
            for _ in 0..40 {
                board.run_us(500);
                if erases(&board) != before {
                    break;
                }
            }
            board.plant_mut().set_input(6, false);
            faults += 1;
            assert!(faults < 20, "nothing is erased");
            if erases(&board) == before {
                board.run_us(50_000);
                write(&mut board, wire::RUN_CONTROL, Control::Acknowledge as u16);
            }
        }
        // A request that comes while flash is busy, of which all but the first character would be lost. Its
        // answer follows the erase and what is written behind it.
        let [high, low] = wire::FAULT.to_be_bytes();
        let reply = ask(&mut board, &[1, 3, high, low, 0, 1], ERASE_US + 5_000);
        assert_eq!(reply.get(..5), Some(&[1, 3, 2, 0, 14][..]), "{flash:?}");
        let passed = (board.cycles() - at) / (board.ticks_per_second() / 1000);
        let counted = u64::from(board.peek16(place).wrapping_sub(began));
        assert!(counted.abs_diff(passed) <= 1, "{flash:?}: {counted} ms of {passed}");
        assert_eq!(board.warnings(), &[], "{flash:?}");
    }
}

#[test]
fn an_emergency_stop_switches_outputs_off_in_the_middle_of_an_erase() {
    let role = |n: u8| format!("[[input]]\nn = {n}\nrole = \"emergency_stop\"\n");
    let direct = |n: u8| {
        let mut profile = machine("");
        profile.wiring = lang::profile::Wiring::Direct;
        profile.outputs.truncate(2);
        profile.inputs = machine(&role(n)).inputs;
        profile
    };
    for (profile, input, within_us) in
        [(machine(&role(6)), 6, 1_100), (machine(&role(17)), 17, 100), (direct(2), 2, 100)]
    {
        let mut board = on(Silicon::default(), &profile);
        write(&mut board, wire::OUTPUTS, 0b11);
        assert_eq!(board.plant().outputs() & 0b11, 0b11, "input {input}");
        erasing(&mut board);
        board.plant_mut().set_input(input, true);
        board.run_us(within_us);
        assert_eq!(board.plant().outputs() & 0b11, 0, "input {input}");
        board.run_us(10 * ERASE_US);
        assert_eq!(read(&mut board, wire::FAULT), Some(14), "input {input}");
        assert_eq!(read(&mut board, wire::FAULT_INPUT), Some(input.into()));
        assert_eq!(board.warnings(), &[], "input {input}");
    }
}

#[test]
fn nothing_depends_on_interrupts_while_flash_is_busy() {
    let silicon = Silicon { interrupts_while_busy: true, ..Silicon::default() };
    let mut board = on(silicon, &machine(""));
    erasing(&mut board);
    board.run_us(10 * ERASE_US);
    assert_eq!(read(&mut board, wire::UPLOAD_RESULT), Some(0));
    assert_eq!(board.warnings(), &[]);
}
