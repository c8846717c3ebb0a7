//! The judges of `pasapas torture` that `torture.rs` does not show: each counts a loss for a fault
//! that is seeded, and none without it.

use std::time::Duration;

use emulator::{Board, Config, Rng};
use lang::part::{F5529, SEGMENT};
use lang::record::BoardRecord;
use pasapas::board::{BUILDS, Build, DEFAULT};
use pasapas::torture::generate::generate;
use pasapas::torture::line::cable;
use pasapas::torture::power::{self, Counted, Failure};
use pasapas::torture::programs::{Made, make, tape};
use pasapas::torture::stand::{Fresh, Stand};
use pasapas::torture::{Length, Settings, Verdict, host, stack, time};

const SETTINGS: Settings =
    Settings { length: Length::Short, count: Some(40), seed: 11, from: 0, builds: &BUILDS };

/// The program area of [`DEFAULT`].
const AREA: u16 = 0xFE00 - (SEGMENT * F5529.segments as usize) as u16;

/// The first program of a kind that compiles.
fn any_program(fault: &str) -> Made {
    (0..20).find_map(|n| make(generate(&tape(&SETTINGS, fault, n)))).expect("one compiles")
}

fn fresh() -> Fresh {
    Fresh::new(Stand::new(DEFAULT, &Config::default()).expect("the shipped image"))
}

/// A bit of each segment of the program area is another one.
fn spoil_programs(board: &mut Board) {
    for segment in (AREA..0xFE00).step_by(SEGMENT) {
        let at = segment + 100;
        let byte = board.peek8(at);
        board.poke8(at, byte ^ 1);
    }
}

#[test]
fn stack_finds_a_watermark_that_lies_and_a_stack_without_a_margin() {
    let made = any_program("stack");
    let fresh = fresh();
    let tried = |stand: Stand| stack::try_out(DEFAULT, stand, &made, Rng::new(1));
    let [_, left] = tried(fresh.copy()).expect("the shipped firmware holds");
    // The lowest byte of the stack is not the paint any more: the watermark tells 0 bytes.
    let mut marked = fresh.copy();
    let end = ["POOL_END", "_edata"].iter().find_map(|name| marked.board.symbol(name));
    let end = end.expect("the image says where its stack ends");
    marked.board.poke8(end, 0);
    assert!(tried(marked).is_err(), "a watermark of 0 where {left} bytes were left");
    // A stack that was once deeper by what is left, less 8 bytes, and its trace of it.
    let mut deep = fresh.copy();
    (end + 8..end + left).for_each(|at| deep.board.poke8(at, 0));
    let sp = deep.board.reg(1);
    deep.board.set_reg(1, end + 10);
    let pc = deep.board.reg(0);
    // push r4; back to where it was.
    let code = [deep.board.peek16(pc), deep.board.peek16(pc + 2)];
    deep.board.poke16(pc, 0x1204);
    deep.board.step();
    deep.board.poke16(pc, code[0]);
    deep.board.set_reg(0, pc);
    deep.board.set_reg(1, sp);
    assert!(tried(deep).is_err(), "8 bytes of stack were left");
}

#[test]
fn host_finds_a_body_that_fails_panics_or_takes_too_long() {
    let seeds: &[&[u8]] = &[b"a seed of some bytes"];
    let lost = |body: host::Body, patience| {
        host::against(&SETTINGS, "a seeded fault", body, seeds, patience).lost
    };
    let long = Duration::from_secs(20);
    assert_eq!(lost(|_| Ok(()), long), 0);
    assert_ne!(lost(|data| if data.len() > 20 { Err("long".to_owned()) } else { Ok(()) }, long), 0);
    let panics: host::Body = |data| match data.get(12) {
        Some(b'm') => Ok(()),
        other => panic!("{other:?}"),
    };
    assert_ne!(lost(panics, long), 0);
    let waits: host::Body = |_| {
        std::thread::sleep(Duration::from_millis(3));
        Ok(())
    };
    assert_ne!(lost(waits, Duration::from_millis(2)), 0);
}

#[test]
fn cable_finds_a_program_that_a_pulled_plug_damaged_and_one_that_was_never_written() {
    for build in BUILDS {
        assert!(cable::pulled(build, 100, &|_| {}).is_ok());
        assert!(cable::noisy(build, Rng::new(3), &|_| {}).is_ok());
    }
    assert!(cable::pulled(DEFAULT, 100, &erase).is_err(), "no program is left");
    let found = (0..20).any(|n| cable::noisy(DEFAULT, Rng::new(n), &erase).is_err());
    assert!(found, "the client says that the program is there");
}

/// The program area as it is behind an erase, and the board behind a reset.
fn erase(board: &mut Board) {
    (AREA..0xFE00).for_each(|at| board.poke8(at, 0xFF));
    board.reset_pin();
    board.run_us(200_000);
}

#[test]
fn random_cuts_find_a_damaged_program_and_a_board_that_starts_by_itself() {
    let made = any_program("cut");
    let fresh = fresh();
    let cut = |spoil: &dyn Fn(&mut Stand)| {
        power::random_cut(fresh.copy(), &made, &mut Rng::new(5), spoil)
    };
    assert_eq!(cut(&|_| {}), Verdict::Survived);
    assert!(matches!(cut(&|stand| erase(&mut stand.board)), Verdict::Lost(_)));
    let reset = BoardRecord { sequence: 9, reset_on: 1, ..BoardRecord::DEFAULT }.sealed();
    let lit = |stand: &mut Stand| {
        // Output 1 goes on at power-up: the first copy of the profile.
        (F5529.profiles[0]..)
            .zip(reset.to_bytes())
            .for_each(|(at, byte)| stand.board.poke8(at, byte));
    };
    assert!(matches!(cut(&lit), Verdict::Lost(_)));
}

#[test]
fn power_finds_what_a_brown_out_damaged() {
    let writes = power::writes(DEFAULT).expect("the shipped image");
    let upload = &writes[0];
    assert_eq!(upload.fail(Failure::Dip, 20, 1, &|_| {}), Some(Verdict::Survived));
    let spoilt = upload.fail(Failure::Dip, 20, 1, &|stand| spoil_programs(&mut stand.board));
    assert!(matches!(spoilt, Some(Verdict::Lost(_))));
}

#[test]
fn wear_finds_a_flash_that_forgets_and_one_that_is_worn_unevenly() {
    let settings = Settings { count: Some(400), ..SETTINGS };
    assert_eq!(power::wear(&settings, false, &|_| {}).lost, 0);
    assert_eq!(power::wear(&settings, true, &|_| {}).lost, 0);
    assert_ne!(power::wear(&settings, false, &Counted::forget).lost, 0);
    assert_ne!(power::wear(&settings, false, &Counted::wear_out).lost, 0);
}

fn moving(build: &Build, flags: u16) -> Stand {
    let script = "DO\nSetOut 1, ON\nG1 X40 Y30 F3000\nSetOut 2, ON\nG1 X0 Y0\nLOOP";
    let record = BoardRecord { sequence: 1, flags, ..BoardRecord::DEFAULT };
    time::board(build, script, Some(record)).expect("it is taken").copy()
}

#[test]
fn hang_finds_a_board_without_a_watchdog_and_autorun_one_that_starts_by_itself() {
    let chain = BoardRecord::CHAIN;
    for build in BUILDS {
        let mut stand = moving(build, chain);
        stand.board.run_us(100_000);
        assert_eq!(time::hung(&mut stand, &mut Rng::new(1), &time::hang), Ok(()));
        let mut stand = moving(build, chain);
        stand.board.run_us(100_000);
        // It holds the watchdog for ever: mov #WDTPW|WDTHOLD, &WDTCTL; jmp back.
        let held = |stand: &mut Stand| {
            for (at, word) in (0xFDF6..).step_by(2).zip([0x40B2, 0x5A80, 0x0120, 0x3FFC]) {
                stand.board.poke16(at, word);
            }
            stand.board.set_reg(0, 0xFDF6);
        };
        assert!(time::hung(&mut stand, &mut Rng::new(1), &held).is_err(), "no watchdog");
        let mut stand = moving(build, chain | BoardRecord::AUTORUN);
        assert_eq!(time::autorun(&mut stand, &mut Rng::new(1), &time::hang), Ok(()));
        // A reset by power instead: it starts, which behind a watchdog's it may not.
        let mut stand = moving(build, chain | BoardRecord::AUTORUN);
        let cut = |stand: &mut Stand| {
            time::hang(stand);
            stand.board.power_cut();
            stand.board.power_up();
        };
        assert!(time::autorun(&mut stand, &mut Rng::new(1), &cut).is_err(), "it starts by itself");
    }
}
