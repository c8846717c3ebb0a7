//! Which way an axis goes that a profile inverts: always the same, whether a program has run or not.

use emulator::Config;
use lang::axis::Axis;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::Profile;
use lang::wire::COMMAND;
use pasapas::board::{Build, F5529, G2553};
use pasapas::client::orders;
use pasapas::torture::stand::Stand;

/// Where the motors of X and Y are after commands to +300 and -200 steps on a board that nothing has run on since
/// power-up, and after the same way back.
fn commanded(build: &'static Build, inverted: [bool; 2]) -> [[i64; 2]; 2] {
    let mut profile = Profile::built_in("mill").expect("built in");
    for (axis, invert) in [&mut profile.x, &mut profile.y].into_iter().zip(inverted) {
        axis.as_mut().expect("it has the axis").invert = invert;
    }
    let source = Source::new("t.bas", "MoveAxe X, 1mm\n".to_owned());
    let (program, _) = compile(&source, ProfileChoice::Given(Box::new(profile)));
    let image = lang::back::compile(&program.expect("sound")).expect("it fits").image;
    let mut stand = Stand::new(build, &Config::default()).expect("the shipped image");
    assert!(stand.answers());
    stand.upload(&image, false).expect("it is taken");
    assert!(stand.power_cycle());
    assert!(stand.answers());
    let mut places = [[0; 2]; 2];
    for (at, places) in [[300, -200], [0, 0]].into_iter().zip(&mut places) {
        for (axis, target) in [Axis::X, Axis::Y].into_iter().zip(at) {
            stand.write(COMMAND, &orders::move_to(axis, [25_000; 2], 2_000, target));
            stand.board.run_us(700_000);
        }
        *places = [0, 1].map(|axis| stand.board.plant().motors[axis].position);
    }
    places
}

#[test]
fn a_command_goes_the_profiles_way_before_any_program_has_run() {
    for build in [&F5529, &G2553] {
        assert_eq!(commanded(build, [false; 2]), [[300, -200], [0, 0]]);
        assert_eq!(commanded(build, [true, false]), [[-300, -200], [0, 0]]);
        assert_eq!(commanded(build, [false, true]), [[300, 200], [0, 0]]);
        assert_eq!(commanded(build, [true; 2]), [[-300, 200], [0, 0]]);
    }
}
