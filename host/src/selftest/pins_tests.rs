//! The test of the pins on a virtual board, which passes it, and on boards with something wrong at a pin, which do not.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use emulator::plant::Jumper;
use emulator::plant::pins::pin;
use lang::profile::Profile;

use super::tests::{ALL, bad, board_of, wires};
use super::{Ask, Plan, Report, Verdict, run};
use crate::board::F5529;
use crate::board::link::InProcess;
use crate::board::rig::Rig;
use crate::client::Client;
use crate::link::{Link, Mode};

const PLAN: Plan = Plan { captures: true, rates: false, listen: Duration::from_millis(200), ..ALL };

/// STEP X, DIR X, PWM; P2.2 to P2.4.
const STEP: u8 = pin(1, 2);
const DIR: u8 = pin(6, 0);
const PWM: u8 = pin(3, 5);
const TIMER: [u8; 3] = [pin(2, 2), pin(2, 3), pin(2, 4)];

/// Something that is done to the board before each request.
type Fault = fn(&mut emulator::Board);

/// A link to a board with a fault, which may tear requests of more than 64 bytes apart.
struct Faulty {
    link: InProcess,
    rig: Rc<RefCell<Rig>>,
    fault: Fault,
    tears: bool,
}

impl Link for Faulty {
    fn send(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        (self.fault)(self.rig.borrow_mut().board());
        if !self.tears {
            return self.link.send(bytes);
        }
        for part in bytes.chunks(64) {
            self.link.send(part)?;
            self.link.pause(Duration::from_millis(8));
        }
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> std::io::Result<usize> {
        self.link.receive(buffer, patience)
    }

    fn now(&self) -> Duration {
        self.link.now()
    }

    fn pause(&mut self, time: Duration) {
        self.link.pause(time);
    }

    fn set_mode(&mut self, mode: Mode) -> std::io::Result<bool> {
        self.link.set_mode(mode)
    }
}

/// Wires the pins that the words name; of the wire from STEP to P2.2 each pulse of `loses` is lost.
fn jumpers(words: &str, rig: &mut Rig, seeded: &Seeded) {
    let &Seeded { loses, dir, .. } = seeded;
    let [count, first, second] = TIMER;
    let plant = rig.board().plant_mut();
    let pins = *plant.board();
    let counted = Jumper::new(STEP, count).losing(loses);
    let wires = match words {
        _ if words.starts_with("STEP X") => {
            vec![counted, Jumper::new(STEP, first), Jumper::new(STEP, second)]
        }
        _ if words.starts_with("DIR X") => vec![Jumper::new(dir, first), Jumper::new(STEP, second)],
        _ if words.starts_with("input 2") => {
            vec![
                Jumper::new(PWM, pins.inputs[1]),
                Jumper::new(PWM, first),
                Jumper::new(STEP, second),
            ]
        }
        // Of the chain.
        _ if words.starts_with("output 1") => {
            vec![Jumper::of_output(1, first), Jumper::new(STEP, second)]
        }
        _ if words.starts_with("the PWM") => {
            vec![Jumper::new(PWM, first), Jumper::new(PWM, second)]
        }
        _ => panic!("a wire that nobody knows: {words}"),
    };
    plant.wire(&wires);
}

struct Seeded {
    fault: Fault,
    tears: bool,
    loses: u32,
    dir: u8,
    /// The profile, of which `pulse_us` is `pulse`.
    profile: &'static str,
    pulse: u8,
}

const WHOLE: Seeded =
    Seeded { fault: |_| {}, tears: false, loses: 0, dir: DIR, profile: "thesis", pulse: 3 };

fn measured(seeded: &Seeded, plan: Plan) -> Report {
    let mut profile = Profile::built_in(seeded.profile).expect("built in");
    profile.pulse_us = seeded.pulse;
    let (rig, client) = board_of(&F5529, &wires(Some), &profile);
    let link = Faulty {
        link: client.into_link(),
        rig: Rc::clone(&rig),
        fault: seeded.fault,
        tears: seeded.tears,
    };
    let mut client = Client::new(link, 1);
    let mut wire = |ask: Ask<'_>| {
        if let Ask::Wire(words) = ask {
            jumpers(words, &mut rig.borrow_mut(), seeded);
        }
    };
    run(&mut client, plan, &mut |_| {}, &mut wire).expect("it is measured")
}

#[test]
fn a_virtual_board_makes_the_pulses_that_it_counts() {
    for profile in ["thesis", "mill"] {
        let report = measured(&Seeded { profile, ..WHOLE }, PLAN);
        assert_eq!(bad(&report), [""; 0], "{profile}: {:#?}", report.rows);
        assert_eq!(report.revision, 0x18);
        let left: Vec<_> =
            report.rows.iter().filter(|row| matches!(row.verdict, Verdict::Left(_))).collect();
        assert_eq!(left.len(), 2, "{profile}: {left:#?}");
        // The chain stops by the millisecond: what it takes lies above the pin's bound.
        let stop = report.rows.iter().find(|row| row.check.starts_with("last step"));
        let ms = stop.and_then(|row| row.found.split(' ').next()?.parse::<f64>().ok());
        let ms = ms.unwrap_or_else(|| panic!("{profile}: {stop:?}"));
        assert!(if profile == "mill" { ms > 0.2 } else { ms <= 0.15 }, "{profile}: {ms} ms");
    }
}

/// Word of the step engine's memory.
fn step_word(board: &mut emulator::Board, place: u16, value: u16) {
    let step = board.symbol("PASAPAS_STEP").expect("the step engine");
    board.poke16(step + place, value);
}

#[test]
fn each_fault_at_a_pin_is_found_by_its_check() {
    let plan = Plan { jumpers: false, ..PLAN };
    let check = |seeded: &Seeded, wanted: &[&str]| {
        let report = measured(seeded, plan);
        assert_eq!(bad(&report), wanted, "{:#?}", report.rows);
    };
    // Pulses that do not leave the chip.
    check(
        &Seeded { loses: 10_000, ..WHOLE },
        &["pulses counted at the pin, X alone", "the same, all axes on their own"],
    );
    // Pulses that are too short, of a profile that wants long ones: 5 us for 8. No pulse can be made shorter than 3 us.
    let short: Fault = |board| step_word(board, 20, 125);
    check(&Seeded { pulse: 8, ..WHOLE }, &[]);
    check(&Seeded { fault: short, pulse: 8, ..WHOLE }, &["width of a pulse"]);
    // DIR comes with STEP.
    let report = measured(&Seeded { dir: STEP, ..WHOLE }, plan);
    assert!(bad(&report).contains(&"from DIR to STEP"), "{:#?}", report.rows);
    // An emergency stop whose interrupt finds nothing, so that the millisecond stops: the jump that passes over the stop when no
    // pin answers is always taken.
    let deaf: Fault = |board| {
        let stops = board.symbol("guard_trips").expect("a name");
        let jump = board.peek16(stops - 2);
        assert!([1, 7].contains(&(jump >> 10 & 7)), "JEQ, or JMP already: {jump:04X}");
        board.poke16(stops - 2, jump | 7 << 10);
    };
    check(&Seeded { fault: deaf, ..WHOLE }, &["last step behind an emergency stop"]);
    // TB0CCR0: another period.
    let slow: Fault = |board| board.bus_write16(0x03D2, 0xC000);
    check(&Seeded { fault: slow, ..WHOLE }, &["pulses and period of the PWM"]);
    // An adapter that pauses between packets of 64 bytes.
    check(&Seeded { tears: true, ..WHOLE }, &["requests of 135 bytes"]);
}

#[test]
fn an_output_that_a_reset_does_not_switch_off_is_found() {
    // A relay that sticks.
    let stuck = crate::sim::world::World::parse(
        "stuck",
        "after_out(1, true, 0, || set_in(1, true));\nafter_out(1, false, 0, || set_in(1, false));\nafter_out(2, true, 0, \
         || set_in(2, true));\n",
    )
    .expect("a world");
    let thesis = Profile::built_in("thesis").expect("built in");
    let (_rig, mut client) = board_of(&F5529, &stuck, &thesis);
    let plan = Plan { captures: false, rates: false, listen: Duration::from_millis(200), ..ALL };
    let report = run(&mut client, plan, &mut |_| {}, &mut |_| {}).expect("it is measured");
    assert!(bad(&report).contains(&"outputs behind a reset"), "{:#?}", report.rows);
}
