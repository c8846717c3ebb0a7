//! Which way an axis goes that a profile inverts: always the same, whether a program has run or not. And when DIR changes at the
//! pins: never while STEP is active, nor within a driver's hold time.

use std::time::Duration;

use emulator::{Config, Signal, TICKS_PER_SECOND};
use lang::axis::Axis;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::Profile;
use lang::wire::COMMAND;
use pasapas::bench::stand::{self, image_on};
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

/// Ticks for which DIR stands behind the end of a pulse: 1 us.
const HOLD: u64 = TICKS_PER_SECOND / 1_000_000;

/// Changes of DIR behind a step of its axis in a run.
fn turns(build: &Build, script: &str) -> u32 {
    let mut profile = Profile::built_in("mill").expect("built in");
    profile.y.as_mut().expect("Y").start_rate = 1;
    let (_, image) = image_on(&build.part, &profile, script).expect("sound");
    let mut stand = stand::Stand::on(build, &profile).expect("a board");
    stand.rig().borrow_mut().board().plant_mut().switches = [None; 3];
    stand.upload(&image).expect("it is taken");
    let edges =
        stand.run(Duration::from_secs(120)).unwrap_or_else(|error| panic!("{error}\n{script}"));
    let (mut active, mut ended, mut changes) = ([false; 3], [None; 3], 0);
    for edge in edges {
        match edge.signal {
            Signal::Step(axis) => {
                let axis = usize::from(axis);
                active[axis] = edge.level;
                if !edge.level {
                    ended[axis] = Some(edge.cycle);
                }
            }
            Signal::Dir(axis) => {
                let axis = usize::from(axis);
                assert!(
                    !active[axis],
                    "{}: DIR of axis {axis} in a pulse\n{script}",
                    build.part.name
                );
                if let Some(ended) = ended[axis] {
                    let held = edge.cycle - ended;
                    assert!(
                        held >= HOLD,
                        "{}: {held} ticks behind a pulse\n{script}",
                        build.part.name
                    );
                    changes += 1;
                }
            }
            _ => {}
        }
    }
    changes
}

#[test]
fn dir_changes_neither_in_a_pulse_nor_in_the_hold_time_behind_it() {
    let zigzag = {
        let line = |n: u32| format!("G1 X{} Y{:.2}\n", n % 2, 0.05 * f64::from(n));
        format!("G0 X0 Y0 Z0\nF3000\n{}", (1..=40).map(line).collect::<String>())
    };
    let lines = "DIM i\nG0 X0 Y0 Z0\nF600\nFOR i = 1 TO 10\nG1 X1 Y1 Z-1\nWait 0ms\nG1 X0 Y0 Z0\nWait 0ms\nNEXT\n";
    let singles = "DIM i\nFOR i = 1 TO 10\nMoveAxe X, 0.02mm\nMoveAxe X, 0mm\nMoveRel Z, -1mm\nMoveRel Z, 1mm\nNEXT\n";
    for build in [&F5529, &G2553] {
        for (script, least) in [
            // Courses of lines, X turning at each corner at speed.
            (zigzag.as_str(), 35),
            (lines, 50),
            (singles, 30),
        ] {
            let changes = turns(build, script);
            assert!(changes >= least, "{}: {changes} changes\n{script}", build.part.name);
        }
    }
    for script in [
        "G0 X0 Y0\nG2 X2 Y0 I1 J0 F1200\nG3 X0 Y0 I-1 J0\n",
        "DIM i\nFOR i = 1 TO 8\nSTART MoveAxe X, 1mm\nWaitMove X\nSTART MoveAxe X, 0mm\nWaitMove X\nNEXT\n",
    ] {
        assert!(turns(&F5529, script) > 0, "{script}");
    }
}
