//! The library of the MSP430F5529: which program Start runs, over resets and cuts of power; KEEP values of each.

use emulator::Config;
use lang::part::F5529;
use lang::record::BoardRecord;
use lang::wire::{
    Control, FAULT, FREE_BYTES, KEEPS, LIBRARY, PROFILE_WINDOW, PROGRAM_NUMBER, RUN_STATE,
    RunState, SELECTED, UPLOAD_NUMBER,
};
use pasapas::board::DEFAULT;
use pasapas::torture::power::image;
use pasapas::torture::stand::{Answer, Stand, identity, words};

/// Longest run of the programs here, us.
const RUN_US: u64 = 300_000;

fn board() -> Stand {
    Stand::new(DEFAULT, &Config::default()).expect("the shipped image")
}

/// Brings a program as that number; it keeps values or not.
fn bring(stand: &mut Stand, number: u16, script: &str) {
    assert!(matches!(stand.write(UPLOAD_NUMBER, &[number]), Answer::Reply(_)));
    stand.upload(&image(script).expect("sound"), script.contains("KEEP")).expect("it is taken");
}

fn select(stand: &mut Stand, number: u16) -> bool {
    matches!(stand.write(SELECTED, &[number]), Answer::Reply(_))
}

/// Starts and waits for the end; outputs behind it.
fn run(stand: &mut Stand) -> u16 {
    stand.control(Control::Start);
    stand.board.run_us(RUN_US);
    assert_eq!(stand.read(RUN_STATE), Some(RunState::Ready as u16));
    stand.read(lang::wire::CHAR_OUT).expect("the board answers") & 0xFF
}

/// Programs 1 to `count`, of which each sends its number.
fn several(count: u16) -> Stand {
    let mut stand = board();
    (1..=count).for_each(|n| bring(&mut stand, n, &format!("Send {}\n", 64 + n)));
    stand
}

#[test]
fn start_runs_the_selected_program_over_any_reset() {
    let mut stand = several(3);
    assert_eq!(run(&mut stand), 65, "the first that came");
    for number in [3, 2, 3, 1] {
        assert!(select(&mut stand, number));
        assert!(stand.power_cycle());
        assert_eq!(stand.read(SELECTED), Some(number));
        assert_eq!(run(&mut stand), 64 + number);
        assert_eq!(stand.read(PROGRAM_NUMBER), Some(number));
    }
    for none in [0, 4, 64, 65, 256, 257] {
        assert!(!select(&mut stand, none), "{none}");
    }
    assert_eq!(run(&mut stand), 65);
}

#[test]
fn none_is_selected_while_one_runs_and_an_erased_one_is_not_run() {
    let mut stand = several(2);
    bring(&mut stand, 3, "Wait 99s\n");
    assert!(select(&mut stand, 3));
    stand.control(Control::Start);
    stand.board.run_us(RUN_US);
    assert_eq!(stand.write(SELECTED, &[1]), Answer::Exception(6));
    stand.control(Control::Stop);
    stand.board.run_us(RUN_US);
    stand.write(UPLOAD_NUMBER, &[3]);
    stand.erase();
    for _ in 0..2 {
        assert_eq!(stand.read(RUN_STATE), Some(RunState::Empty as u16));
        assert_eq!(
            stand.write(lang::wire::RUN_CONTROL, &[Control::Start as u16]),
            Answer::Exception(4)
        );
        assert!(stand.power_cycle());
        assert_eq!(stand.read(SELECTED), Some(0), "two are left: neither is run unasked");
    }
    assert!(select(&mut stand, 2));
    assert_eq!(run(&mut stand), 66);
}

#[test]
fn each_program_keeps_its_own_values_and_its_next_version_has_them() {
    let mut stand = board();
    let counter = |by: u16| format!("KEEP n\nn = n + {by}\n");
    bring(&mut stand, 1, &counter(1));
    bring(&mut stand, 2, &counter(10));
    let counted = |stand: &mut Stand, number: u16| {
        assert!(select(stand, number));
        stand.control(Control::Start);
        stand.board.run_us(RUN_US);
        stand.read(KEEPS)
    };
    assert_eq!(counted(&mut stand, 1), Some(1));
    assert_eq!(counted(&mut stand, 2), Some(10));
    assert_eq!(counted(&mut stand, 1), Some(2));
    bring(&mut stand, 2, &counter(100));
    assert!(stand.power_cycle());
    assert_eq!(counted(&mut stand, 2), Some(110), "declared alike");
    bring(&mut stand, 2, "KEEP holes\nholes = holes + 5\n");
    assert_eq!(counted(&mut stand, 2), Some(5), "declared otherwise");
    assert_eq!(counted(&mut stand, 1), Some(3));
}

#[test]
fn a_selection_cut_anywhere_is_the_old_one_or_the_new() {
    let mut stand = several(2);
    // With more and more selections before it, up to the erase of their segment and beyond.
    let mut cuts = 0;
    for before in 0..20 {
        assert!(select(&mut stand, 1 + before % 2));
        let (old, new) = (1 + before % 2, 2 - before % 2);
        for operation in 1.. {
            let mut cut = stand.clone();
            cut.board.cut_at_flash_operation(operation, operation * 7 + u64::from(before));
            if select(&mut cut, new) {
                break;
            }
            cuts += 1;
            let resets: Vec<_> = (0..2)
                .map(|_| {
                    assert!(cut.power_cycle());
                    cut.read(SELECTED).expect("it answers")
                })
                .collect();
            assert_eq!(resets[0], resets[1], "it wavers");
            // Where their segment is erased there may be none, and then nothing starts.
            let allowed = [old, new, 0].contains(&resets[0]);
            assert!(allowed && (resets[0] != 0 || operation > 1 || before >= 15), "{resets:?}");
            assert!(select(&mut cut, new));
            assert_eq!(run(&mut cut), 64 + new);
        }
    }
    assert!(cuts >= 20, "{cuts} cuts");
}

#[test]
fn the_last_fault_outlives_selections() {
    let mut stand = several(2);
    bring(&mut stand, 3, "DIM n\nn = 1 / n\n");
    assert!(select(&mut stand, 3));
    stand.control(Control::Start);
    stand.board.run_us(RUN_US);
    stand.control(Control::Acknowledge);
    for n in 0..40 {
        assert!(select(&mut stand, 1 + n % 3));
    }
    assert!(stand.power_cycle());
    assert_eq!([stand.read(FAULT), stand.read(SELECTED)], [Some(2), Some(1)]);
    // And the selection outlives faults.
    assert!(select(&mut stand, 3));
    for _ in 0..20 {
        stand.control(Control::Start);
        stand.board.run_us(RUN_US);
        stand.control(Control::Acknowledge);
    }
    assert!(stand.power_cycle());
    assert_eq!([stand.read(FAULT), stand.read(SELECTED)], [Some(2), Some(3)]);
}

#[test]
fn sixty_four_programs_are_listed_and_a_large_one_finds_no_place() {
    let mut stand = board();
    let empty = stand.read(FREE_BYTES).expect("it answers");
    for n in 1..=64 {
        bring(&mut stand, n, &format!("Send {}\n", 33 + n));
    }
    let one = image("Send 34\n").expect("sound");
    let entry = |stand: &mut Stand, n: u16| {
        let first = LIBRARY + 16 * (n - 1);
        [stand.read(first), stand.read(first + 1)]
    };
    let (length, crc) = identity(&one);
    assert_eq!(entry(&mut stand, 1), [Some(length), Some(crc)]);
    assert_eq!(entry(&mut stand, 64)[0], Some(length));
    let free = stand.read(FREE_BYTES).expect("it answers");
    assert_eq!(empty - free, 64 * 512);
    let large = image(&"Send 65\n".repeat(3000)).expect("sound");
    stand.write(UPLOAD_NUMBER, &[5]);
    assert!(stand.upload(&large, false).is_err());
    assert_eq!(entry(&mut stand, 5)[0], Some(length), "nothing is lost");
    assert!(stand.power_cycle());
    assert!(select(&mut stand, 64));
    assert_eq!(run(&mut stand), 97);
    assert_eq!(
        usize::from(empty) + lang::part::slot_head(F5529.programs),
        512 * usize::from(F5529.segments)
    );
}

/// Gives the board a profile with such inputs.
fn with_inputs(stand: &mut Stand, select: u8) {
    let record = BoardRecord { sequence: 1, select, lamp: 16, ..BoardRecord::DEFAULT }.sealed();
    for (n, part) in words(&record.to_bytes()).chunks(16).enumerate() {
        stand.write(PROFILE_WINDOW + 16 * n as u16, part);
    }
    assert!(stand.power_cycle());
}

#[test]
fn inputs_choose_the_program_that_start_runs() {
    let mut stand = several(5);
    // select_1 to select_3 at inputs 4, 5 and 6.
    with_inputs(&mut stand, 4 | 3 << 5);
    assert!(select(&mut stand, 2));
    for (levels, number) in [(1, 1), (3, 3), (5, 5), (4, 4), (0, 2)] {
        (0..3).for_each(|n| stand.board.plant_mut().set_input(4 + n, levels >> n & 1 != 0));
        stand.board.run_us(50_000);
        assert_eq!(run(&mut stand), 64 + number);
        assert_eq!([stand.read(PROGRAM_NUMBER), stand.read(SELECTED)], [Some(number), Some(2)]);
    }
    // There is none of that number.
    (0..3).for_each(|n| stand.board.plant_mut().set_input(4 + n, n > 0));
    stand.board.run_us(50_000);
    stand.control(Control::Start);
    stand.board.run_us(50_000);
    assert_eq!(
        [stand.read(RUN_STATE), stand.read(FAULT)],
        [Some(RunState::Fault as u16), Some(21)]
    );
}

#[test]
fn a_button_chooses_the_next_program_and_the_lamp_blinks_its_number() {
    let mut stand = several(3);
    bring(&mut stand, 9, "Wait 99s\n");
    with_inputs(&mut stand, 7 | BoardRecord::NEXT << 5);
    let press = |stand: &mut Stand| {
        for down in [true, false] {
            stand.board.plant_mut().set_input(7, down);
            stand.board.run_us(30_000);
        }
    };
    for number in [2, 3] {
        press(&mut stand);
        assert_eq!(stand.read(SELECTED), Some(number));
        let lit = |stand: &Stand| stand.board.plant().outputs() >> 15 & 1;
        let (mut before, mut flashes) = (lit(&stand), 0);
        for _ in 0..300 {
            stand.board.run_us(10_000);
            let now = lit(&stand);
            flashes += u16::from(now > before);
            before = now;
        }
        // It is lit again behind them.
        assert_eq!((flashes, before), (number + 1, 1), "program {number}");
        assert_eq!(run(&mut stand), 64 + number);
    }
    press(&mut stand);
    assert_eq!(stand.read(SELECTED), Some(9));
    stand.control(Control::Start);
    press(&mut stand);
    assert_eq!(stand.read(SELECTED), Some(9), "while it runs the button does nothing");
    stand.control(Control::Stop);
    stand.board.run_us(RUN_US);
    press(&mut stand);
    assert_eq!(stand.read(SELECTED), Some(1), "behind the last the first");
}
