//! A button that is held: what a command moves goes on as long as its register is written, and rests by
//! itself 300 ms later.

use emulator::Config;
use lang::axis::Axis;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::wire::{COMMAND, JOG_GOES_ON, JOG_HOLD, JOG_HOLD_MS, command};
use pasapas::board::{F5529, G2553};
use pasapas::client::orders;
use pasapas::torture::stand::{Answer, Stand};

/// A board with a mill's program whose X goes a long way at 2000 steps/s.
fn moving() -> Stand {
    let source = Source::new("t.bas", "MoveAxe X, 1mm\n".to_owned());
    let (program, _) = compile(&source, ProfileChoice::built_in());
    let image = lang::back::compile(&program.expect("sound")).expect("it fits").image;
    let mut stand = Stand::new(&F5529, &Config::default()).expect("the shipped image");
    assert!(stand.answers());
    stand.upload(&image, false).expect("it is taken");
    stand.write(COMMAND, &orders::move_to(Axis::X, [25_000; 2], 2_000, 30_000));
    stand
}

fn steps(stand: &Stand) -> u64 {
    stand.board.plant().motors[0].pulses
}

#[test]
fn a_held_jog_ends_by_itself_behind_its_last_write() {
    let mut stand = moving();
    for _ in 0..12 {
        stand.write(JOG_HOLD, &[1]);
        let before = steps(&stand);
        stand.board.run_us(100_000);
        // At 2000 steps/s, before any program has run.
        let made = steps(&stand) - before;
        assert!((50..=230).contains(&made), "{made} steps in 0.1 s and an exchange");
    }
    // The ramp from 2000 steps/s takes 80 ms.
    stand.board.run_us((u64::from(JOG_HOLD_MS) + 100) * 1_000);
    let rest = steps(&stand);
    stand.board.run_us(500_000);
    assert_eq!(steps(&stand), rest);
    assert!(rest < 30_000);
}

/// Whoever holds the button has looked before the Stop, and orders the next piece of the way behind it.
#[test]
fn what_somebody_has_stopped_does_not_go_on() {
    for stop in [vec![command::STOP_AXES, 7], vec![command::STOP_AXIS, 1]] {
        let mut stand = moving();
        stand.write(JOG_HOLD, &[1]);
        stand.board.run_us(200_000);
        assert!(matches!(stand.write(JOG_HOLD, &[JOG_GOES_ON]), Answer::Reply(_)));
        assert!(matches!(stand.write(COMMAND, &stop), Answer::Reply(_)));
        stand.write(COMMAND, &orders::move_to(Axis::X, [25_000; 2], 2_000, 29_000));
        assert_eq!(stand.write(JOG_HOLD, &[JOG_GOES_ON]), Answer::Exception(6), "{stop:?}");
    }
}

#[test]
fn without_the_register_a_command_goes_its_way() {
    let mut stand = moving();
    stand.write(JOG_HOLD, &[1]);
    stand.write(JOG_HOLD, &[0]);
    stand.board.run_us(16_000_000);
    assert_eq!(steps(&stand), 30_000);
    // A bound that was put at rest says nothing about the next move.
    stand.write(JOG_HOLD, &[1]);
    stand.board.run_us(10_000);
    stand.write(COMMAND, &orders::move_to(Axis::X, [25_000; 2], 2_000, 29_000));
    stand.board.run_us(2_000_000);
    assert_eq!(steps(&stand), 31_000);
}

#[test]
fn a_part_without_the_register_says_so() {
    let mut stand = Stand::new(&G2553, &Config::default()).expect("the shipped image");
    assert!(stand.answers());
    // The helm's bounded moves are all that a hold has there.
    assert_eq!(stand.write(JOG_HOLD, &[1]), Answer::Exception(2));
}
