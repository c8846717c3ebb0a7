//! What a command over the link moves comes to rest when anybody stops the machine: by the Stop button, a door, a feed
//! hold, or Stop and Pause over the link. It moves again only by a new command.

use emulator::Config;
use lang::axis::Axis;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::Profile;
use lang::record::BoardRecord;
use lang::wire::{COMMAND, Control, JOG_GOES_ON, JOG_HOLD, PROFILE_WINDOW, RUN_CONTROL, command};
use pasapas::board::{Build, F5529, G2553};
use pasapas::client::orders;
use pasapas::torture::stand::{Answer, Stand};

/// Who stops, and whether he keeps pressing.
#[derive(Clone, Copy, Debug)]
enum Who {
    Button,
    Door,
    Hold,
    Link(Control),
}

const ALL: [Who; 5] =
    [Who::Button, Who::Door, Who::Hold, Who::Link(Control::Stop), Who::Link(Control::Pause)];

/// A mill whose inputs 4 and 5 are a door and a feed hold.
fn machine() -> Profile {
    let mill = include_str!("../../examples/profiles/mill.toml");
    let own = "\n[[input]]\nn = 4\nrole = \"door\"\n[[input]]\nn = 5\nrole = \"hold\"\n";
    Profile::parse(&(mill.to_owned() + own)).expect("a mill")
}

/// A board with that machine, at rest.
fn ready(build: &Build) -> Stand {
    let source = Source::new("t.bas", "MoveAxe X, 1mm\n".to_owned());
    let (program, diags) = compile(&source, ProfileChoice::Given(Box::new(machine())));
    let program = program.unwrap_or_else(|| panic!("{}", diags.render(&source)));
    let image = lang::back::compile(&program).expect("it fits").image;
    let mut stand = Stand::new(build, &Config::default()).expect("the shipped image");
    assert!(stand.answers());
    let record = BoardRecord::of(&machine(), 1).to_bytes();
    let words: Vec<u16> =
        record.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
    for (n, part) in words.chunks(16).enumerate() {
        let written = stand.write(PROFILE_WINDOW + 16 * n as u16, part);
        assert!(matches!(written, Answer::Reply(_)), "{written:?}");
    }
    assert!(stand.power_cycle());
    stand.upload(&image, false).expect("it is taken");
    stand
}

fn stop(stand: &mut Stand, who: Who, on: bool) {
    match who {
        Who::Button => stand.board.plant_mut().press_stop(on),
        Who::Door => stand.board.plant_mut().set_input(4, on),
        Who::Hold => stand.board.plant_mut().set_input(5, on),
        Who::Link(control) if on => {
            assert!(matches!(stand.write(RUN_CONTROL, &[control as u16]), Answer::Reply(_)));
        }
        Who::Link(_) => (),
    }
}

fn steps(stand: &Stand) -> u64 {
    stand.board.plant().motors[0].pulses
}

/// Steps that the axis makes in half a second, while a host looks on.
fn made(stand: &mut Stand) -> u64 {
    let before = steps(stand);
    for _ in 0..5 {
        stand.board.run_us(100_000);
        assert!(stand.answers());
    }
    steps(stand) - before
}

#[test]
fn anybodys_stop_ends_what_a_command_moves() {
    for (name, build) in [("f5529", &F5529), ("g2553", &G2553)] {
        let far = orders::move_to(Axis::X, [25_000; 2], 2_000, 30_000);
        let mut endless = vec![command::MOVE_SPEED, 1];
        endless.extend([25_000, 2_000].map(orders::words).concat());
        // A line of two axes: X and Y by 300 and 100 mm at 1200 mm/min.
        let [speed, x, y] = [1_200f32, 300., 100.].map(|value| {
            let [a, b, c, d] = value.to_le_bytes();
            [u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d])]
        });
        let line = [vec![command::JOG, 64 | 3], [speed, x, y].concat()].concat();
        for (what, order) in [("target", far), ("speed", endless), ("line", line)] {
            for who in ALL {
                let told = format!("{name}, {what}, {who:?}");
                let mut stand = ready(build);
                assert!(matches!(stand.write(COMMAND, &order), Answer::Reply(_)), "{told}");
                assert!(made(&mut stand) > 500, "{told}: it moves");
                stop(&mut stand, who, true);
                // The ramp from 2000 steps/s takes 80 ms, the filter of an input and a button some more.
                stand.board.run_us(200_000);
                assert_eq!(made(&mut stand), 0, "{told}");
                stop(&mut stand, who, false);
                assert_eq!(made(&mut stand), 0, "{told}: nothing goes on by itself");
                let back = orders::move_to(Axis::X, [25_000; 2], 2_000, 0);
                assert!(matches!(stand.write(COMMAND, &back), Answer::Reply(_)), "{told}");
                assert!(made(&mut stand) > 500, "{told}: a new command moves");
            }
        }
    }
}

#[test]
fn a_reference_run_by_command_is_given_up_as_failed() {
    for (name, build) in [("f5529", &F5529), ("g2553", &G2553)] {
        for who in ALL {
            let mut stand = ready(build);
            let home = orders::home(&machine(), Axis::X).expect("a switch");
            assert!(matches!(stand.write(COMMAND, &home), Answer::Reply(_)), "{name}, {who:?}");
            assert!(made(&mut stand) > 100, "{name}, {who:?}: it seeks");
            stop(&mut stand, who, true);
            stand.board.run_us(1_000_000);
            assert_eq!(made(&mut stand), 0, "{name}, {who:?}");
            stop(&mut stand, who, false);
            assert_eq!(made(&mut stand), 0, "{name}, {who:?}: nothing goes on by itself");
        }
    }
}

#[test]
fn a_bound_is_refused_where_nothing_moves() {
    let mut stand = ready(&F5529);
    for value in [1, JOG_GOES_ON] {
        assert_eq!(stand.write(JOG_HOLD, &[value]), Answer::Exception(6), "{value}");
    }
    assert!(matches!(stand.write(JOG_HOLD, &[0]), Answer::Reply(_)));
}
