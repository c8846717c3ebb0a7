//! Commands of the link (InterpCNC V3 Modbus protocol, Commands) mean the same on every part.

use emulator::{Config, Wiring};
use lang::axis::Axis;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::{Input, InputRole, Profile};
use lang::record::BoardRecord;
use lang::wire::{COMMAND, Exception, PROFILE_WINDOW, command};
use pasapas::board::{BUILDS, Build};
use pasapas::client::orders;
use pasapas::torture::stand::{Answer, Stand};

/// Ramps up and down, steps/s2.
const RAMPS: [u32; 2] = [25_000; 2];

fn stand(build: &Build) -> Stand {
    let source = Source::new("t.bas", "MoveAxe X, 1mm\n".to_owned());
    let (program, _) = compile(&source, ProfileChoice::built_in());
    let image = lang::back::compile(&program.expect("sound")).expect("it fits").image;
    let mut stand = Stand::new(build, &Config { wiring: Wiring::Chain, ..Config::default() })
        .expect("the shipped image");
    assert!(stand.answers());
    stand.upload(&image, false).expect("it is taken");
    stand
}

fn order(stand: &mut Stand, words: &[u16]) -> Option<u8> {
    match stand.write(COMMAND, words) {
        Answer::Reply(_) => None,
        Answer::Exception(exception) => Some(exception),
        other => panic!("{other:?}"),
    }
}

/// Command 102 with a ramp of 25 000 steps/s2.
fn run(speed: u16) -> [u16; 6] {
    [command::MOVE_SPEED, 1, 25_000, 0, speed, 0]
}

#[test]
fn whatever_keeps_the_machine_from_working_keeps_commands_from_moving() {
    for build in BUILDS {
        for role in [InputRole::Stop, InputRole::Hold, InputRole::Door, InputRole::EmergencyStop] {
            let mut stand = stand(build);
            let mut mill = Profile::built_in("mill").expect("built in");
            let input = Input { n: 12, name: None, role: Some(role), invert: false, filter_ms: 5 };
            mill.inputs.push(input);
            let words = BoardRecord::of(&mill, 2).sealed().to_bytes();
            let words = words.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
            let words = words.collect::<Vec<_>>();
            stand.write(PROFILE_WINDOW, &words[..16]);
            stand.write(PROFILE_WINDOW + 16, &words[16..]);
            assert!(stand.power_cycle());
            let go = |target| orders::move_to(Axis::X, RAMPS, 2_000, target);
            assert_eq!(order(&mut stand, &go(100)), None, "{} {role:?}", build.part.name);
            stand.board.run_us(500_000);
            stand.board.plant_mut().set_input(12, true);
            stand.board.run_us(50_000);
            let busy = Some(Exception::Busy as u8);
            assert_eq!(order(&mut stand, &go(200)), busy, "{} {role:?}", build.part.name);
        }
    }
}

#[test]
fn what_the_host_need_not_hold_goes_on_behind_what_it_held() {
    for build in BUILDS {
        let mut stand = stand(build);
        assert_eq!(order(&mut stand, &run(1_000)), None);
        stand.board.run_us(300_000);
        assert_eq!(order(&mut stand, &run(0)), None);
        stand.board.run_us(300_000);
        assert_eq!(order(&mut stand, &orders::move_to(Axis::X, RAMPS, 1_000, 6_000)), None);
        // 2 s of silence end a held motion.
        stand.board.run_us(4_000_000);
        let before = stand.board.plant().motors[0].pulses;
        stand.board.run_us(500_000);
        let made = stand.board.plant().motors[0].pulses - before;
        assert!(made > 400, "{}: {made} steps in half a second", build.part.name);
    }
}
