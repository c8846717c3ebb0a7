//! Command 110: what an input is forced to is what everything sees that looks at it, so that a program with sensors can be
//! run dry.

use emulator::plant::Contact;
use emulator::{Config, Wiring};
use lang::axis::Axis;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::wire::{COMMAND, Control, FAULT, command};
use pasapas::board::{BUILDS, Build, F5529};
use pasapas::client::orders;
use pasapas::torture::stand::{Answer, Stand};

/// Frees an input.
const FREE: u16 = 0xFFFF;

fn stand(build: &Build, wiring: Wiring, script: &str) -> Stand {
    let source = Source::new("t.bas", script.to_owned());
    let (program, _) = compile(&source, ProfileChoice::built_in());
    let image = lang::back::compile(&program.expect("sound")).expect("it fits").image;
    let config = Config { wiring, ..Config::default() };
    let mut stand = Stand::new(build, &config).expect("the shipped image");
    assert!(stand.answers());
    stand.upload(&image, false).expect("it is taken");
    stand
}

fn force(stand: &mut Stand, input: u16, level: u16) {
    let answer = stand.write(COMMAND, &[command::FORCE_INPUT, input - 1, level]);
    assert!(matches!(answer, Answer::Reply(_)), "{answer:?}");
}

/// Command 107: X by at most 2000 steps at 1000 steps/s until an input has a level.
fn probe(stand: &mut Stand, input: u16, level: u16) {
    let mut order = vec![command::PROBE, 1, input - 1, level];
    for value in [25_000, 1_000, 25_000, 2_000] {
        order.extend(orders::words(value));
    }
    let answer = stand.write(COMMAND, &order);
    assert!(matches!(answer, Answer::Reply(_)), "{answer:?}");
}

fn steps(stand: &Stand) -> u64 {
    stand.board.plant().motors[0].pulses
}

#[test]
fn a_forced_input_ends_a_probe_and_a_real_one_behind_it_does_not() {
    for build in BUILDS {
        let mut stand = stand(build, Wiring::Chain, "MoveAxe X, 1mm\n");
        let name = build.part.name;
        probe(&mut stand, 3, 1);
        stand.board.run_us(300_000);
        force(&mut stand, 3, 1);
        stand.board.run_us(3_000_000);
        let made = steps(&stand);
        assert!((200..600).contains(&made), "{name}: {made}");
        // It answers already.
        probe(&mut stand, 3, 1);
        stand.board.run_us(300_000);
        assert_eq!(steps(&stand), made, "{name}");
        // A contact that closes says nothing while its input is forced off.
        force(&mut stand, 3, 0);
        stand.board.plant_mut().set_input(3, true);
        probe(&mut stand, 3, 1);
        stand.board.run_us(4_000_000);
        assert_eq!(steps(&stand) - made, 2_000, "{name}");
        force(&mut stand, 3, FREE);
        stand.board.run_us(100_000);
        let made = steps(&stand);
        probe(&mut stand, 3, 1);
        stand.board.run_us(300_000);
        assert_eq!(steps(&stand), made, "{name}: it answers again");
    }
}

/// In the direct wiring the step interrupt looks at the pin itself.
#[test]
fn a_probe_at_a_pin_sees_what_its_input_is_forced_to() {
    for build in BUILDS {
        let name = build.part.name;
        let mut stand = direct(build, "MoveAxe X, 1mm\n");
        force(&mut stand, 4, 0);
        let contact = Contact { axis: 0, position: 500, above: true };
        stand.board.plant_mut().probes[0] = Some(contact);
        probe(&mut stand, 4, 1);
        stand.board.run_us(4_000_000);
        assert_eq!(steps(&stand), 2_000, "{name}: forced off before it began");
    }
    // On the small part the pins are chosen when the probe begins.
    let mut stand = direct(&F5529, "MoveAxe X, 1mm\n");
    stand.board.plant_mut().probes[0] = Some(Contact { axis: 0, position: 1_000, above: true });
    probe(&mut stand, 4, 1);
    stand.board.run_us(300_000);
    force(&mut stand, 4, 0);
    stand.board.run_us(4_000_000);
    assert_eq!(steps(&stand), 2_000, "forced off on its way");
}

/// A board in the direct wiring.
fn direct(build: &Build, script: &str) -> Stand {
    use lang::profile::{Profile, Wiring as Own};
    use lang::record::BoardRecord;
    use lang::wire::PROFILE_WINDOW;
    let mut stand = stand(build, Wiring::Direct, script);
    let mut mill = Profile::built_in("mill").expect("built in");
    mill.wiring = Own::Direct;
    mill.inputs.retain(|input| input.n <= 4);
    mill.outputs.retain(|output| output.n <= 2);
    for input in &mut mill.inputs {
        input.role = None;
    }
    let words = BoardRecord::of(&mill, 2).sealed().to_bytes();
    let words: Vec<u16> =
        words.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
    stand.write(PROFILE_WINDOW, &words[..16]);
    stand.write(PROFILE_WINDOW + 16, &words[16..]);
    assert!(stand.power_cycle());
    stand
}

#[test]
fn a_reference_run_by_command_sees_a_forced_switch() {
    for build in BUILDS {
        let mut stand = stand(build, Wiring::Chain, "MoveAxe X, 1mm\n");
        let name = build.part.name;
        // At input 3, which has no role.
        let mut order = vec![command::HOME, Axis::X.index() as u16 + 1, 0, 2, 1, 0];
        for value in [1_000, 200, 25_000, 25_000, 5_000] {
            order.extend(orders::words(value));
        }
        order.push(50);
        order.extend(orders::words(0));
        order.extend(orders::words(0));
        let answer = stand.write(COMMAND, &order);
        assert!(matches!(answer, Answer::Reply(_)), "{name}: {answer:?}");
        stand.board.run_us(500_000);
        force(&mut stand, 3, 1);
        stand.board.run_us(1_000_000);
        let made = steps(&stand);
        assert!(made < 1_000, "{name}: {made}");
        force(&mut stand, 3, 0);
        stand.board.run_us(2_000_000);
        assert!(steps(&stand) < 1_500, "{name}");
        let homed = stand.read(lang::wire::HOMED);
        assert_eq!(homed, Some(1), "{name}");
    }
}

#[test]
fn a_program_that_probes_can_be_run_dry() {
    let script = "F600\nProbe? X, 20mm, 10mm/s, 3, ON\nIF PROBEOK(X) THEN Send 89 ELSE Send 78\n";
    for build in BUILDS {
        let mut stand = stand(build, Wiring::Chain, script);
        stand.control(Control::Start);
        stand.board.run_us(500_000);
        force(&mut stand, 3, 1);
        stand.board.run_us(2_000_000);
        let sent = stand.read(lang::wire::CHAR_OUT).map(|word| word & 0xFF);
        assert_eq!((stand.read(FAULT), sent), (Some(0), Some(89)), "{}", build.part.name);
    }
}
