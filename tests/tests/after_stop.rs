//! A run that is paused and then ended leaves nothing behind: what commands, jogs, reference runs and the next program
//! move afterwards moves.

use emulator::Config;
use emulator::plant::Contact;
use lang::axis::Axis;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::Profile;
use lang::wire::{COMMAND, Control, FAULT, POSITIONS, RUN_COUNT, RUN_STATE, RunState, command};
use pasapas::board::{BUILDS, Build, F5529, G2553};
use pasapas::client::orders;
use pasapas::torture::stand::{Answer, Stand};

const RAMPS: [u32; 2] = [25_000; 2];

/// A board with this program; X's switch lies 1000 steps below where it stands.
fn stand(build: &Build, script: &str) -> Stand {
    let source = Source::new("t.bas", script.to_owned());
    let (program, _) = compile(&source, ProfileChoice::built_in());
    let image = lang::back::compile(&program.expect("sound")).expect("it fits").image;
    let mut stand = Stand::new(build, &Config::default()).expect("the shipped image");
    assert!(stand.answers());
    stand.upload(&image, false).expect("it is taken");
    stand.board.plant_mut().switches[0] = Some(Contact { axis: 0, position: -1_000, above: false });
    stand
}

fn pulses(stand: &Stand) -> u64 {
    stand.board.plant().motors[0].pulses
}

/// Runs until 0.4 s pass without a step, at most 20 s; how many steps X has made since it had made `first`.
fn rest(stand: &mut Stand, first: u64, what: &str) -> u64 {
    for _ in 0..50 {
        let last = pulses(stand);
        stand.board.run_us(400_000);
        if pulses(stand) == last {
            return last - first;
        }
    }
    panic!("{what}: X does not come to rest");
}

/// A command; how many steps X makes of it.
fn moves(stand: &mut Stand, order: &[u16], what: &str) -> u64 {
    let first = pulses(stand);
    let answer = stand.write(COMMAND, order);
    assert!(matches!(answer, Answer::Reply(_)), "{what}, {order:?}: {answer:?}");
    if order[0] == command::MOVE_SPEED {
        stand.board.run_us(300_000);
        stand.write(COMMAND, &[command::STOP_AXES, 7]);
    }
    rest(stand, first, what)
}

/// Pauses the run, lets it rest and ends it by `codes`.
fn pause_and_end(stand: &mut Stand, codes: &[Control]) {
    stand.control(Control::Start);
    stand.board.run_us(300_000);
    stand.control(Control::Pause);
    stand.board.run_us(600_000);
    assert_eq!(stand.read(RUN_STATE), Some(RunState::Paused as u16));
    for &code in codes {
        stand.control(code);
        stand.board.run_us(300_000);
    }
    assert_eq!(stand.read(RUN_STATE), Some(RunState::Ready as u16));
}

#[test]
fn whatever_ends_a_pause_axes_move_by_command_and_program_again() {
    let mill = Profile::built_in("mill").expect("built in");
    let [speed, way] = [600f32, 5.].map(|value| {
        let [a, b, c, d] = value.to_le_bytes();
        [u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d])]
    });
    let line = [command::JOG, 64 | 1, speed[0], speed[1], way[0], way[1]];
    let stop: &[Control] = &[Control::Stop];
    let emergency: &[Control] = &[Control::EmergencyStop, Control::Acknowledge];
    let scripts = [
        (&F5529, "MoveAxe X, 100mm\n"),
        (&F5529, "MoveRel X, 100mm\n"),
        (&F5529, "MoveSpeed X, 10mm/s\nWait 1min\n"),
        (&F5529, "Wait 1min\n"),
        (&F5529, "START MoveAxe X, 100mm\nWaitMove X\n"),
        (&F5529, "F600\nG1 X100\n"),
        (&F5529, "Home X\nHome X\n"),
        (&G2553, "MoveAxe X, 100mm\n"),
        (&G2553, "F600\nG1 X100\n"),
        (&G2553, "Wait 1min\n"),
    ];
    for (build, script) in scripts {
        for codes in [stop, emergency] {
            let mut stand = stand(build, script);
            let what = format!("{} {script:?} {codes:?}", build.part.name);
            pause_and_end(&mut stand, codes);
            let here = pulses(&stand);
            assert_eq!(rest(&mut stand, here, &what), 0, "{what}: it moves by itself");

            let place = stand.read_long(POSITIONS).expect("a place");
            let to = orders::move_to(Axis::X, RAMPS, 2_000, i64::from(place) + 100);
            assert_eq!(moves(&mut stand, &to, &what), 100, "{what}: 103");
            let mut by = orders::move_to(Axis::X, RAMPS, 2_000, -100);
            by[0] = command::MOVE_BY;
            assert_eq!(moves(&mut stand, &by, &what), 100, "{what}: 104");
            let run = [command::MOVE_SPEED, 1, 25_000, 0, 1_000, 0];
            assert!(moves(&mut stand, &run, &what) > 100, "{what}: 102");
            let probe = orders::probe(&mill, Axis::X, 1_000, 50).expect("it has one");
            assert_eq!(moves(&mut stand, &probe, &what), 50, "{what}: 107");
            assert_eq!(moves(&mut stand, &line, &what), 500, "{what}: 1111");
            let home = orders::home(&mill, Axis::X).expect("it has a switch");
            assert!(moves(&mut stand, &home, &what) > 100, "{what}: 106");
            let home = [command::HOME_PROFILE, 1];
            let made = moves(&mut stand, &home, &what);
            assert!(made > 0, "{what}: 1110");
            stand.control(Control::Start);
            stand.board.run_us(300_000);
            assert_eq!((stand.read(RUN_COUNT), stand.read(FAULT)), (Some(2), Some(0)), "{what}");
        }
    }
    // The handlers' image is the small chip's, too.
    assert!(BUILDS.len() == 3, "a further build has its scripts, too");
}
