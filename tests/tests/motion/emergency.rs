//! The emergency stop as a contact, at pins and in the chain: steps cease at once whatever moves.

use emulator::plant::Contact;
use lang::fault::Fault;
use lang::profile::{Input, InputRole, Profile, Wiring};
use lang::wire::{
    FAULT, FAULT_INPUT, HOMED, MACHINE_POSITIONS, RUN_STATE, RunState, UPLOAD_CONTROL,
    UPLOAD_LENGTH, Upload,
};
use pasapas::bench::stand::fast_mill;
use pasapas::board::{Build, F5529, G2553};
use pasapas::torture::stand::{framed, read_body, write_body};

use crate::lab::{Dice, Lab, MS, Step};

/// How long an interrupt that is under way, and the one of an event that is due before the pin is
/// looked at, keep the pin waiting: 20 us.
const INTERRUPTS: u64 = MS / 50;
/// The chain is read once in a millisecond, on the G2553 behind the segment that it plans.
const CHAIN: [u64; 2] = [2 * MS, MS + INTERRUPTS];

/// What moves when the contact opens, the axes it moves at the rate of their own, and whether the
/// G2553 runs it.
const MOVES: [(&str, bool); 8] = [
    ("MoveAxe X, 200mm, 80mm/s", true),
    ("G1 X190 Y185 Z-70 F36000", true),
    ("G0 X150 Y-3 Z-1", true),
    ("Home X", true),
    ("Probe Y, 150mm, 15mm/s", true),
    ("F2400\nG2 X80 Y80 I80\nG3 X120 Y120 J40\nG1 X190", false),
    (
        "START MoveAxe X, 200mm, 90mm/s\nSTART MoveAxe Y, 170mm, 35mm/s\nMoveAxe Z, -70mm, 9mm/s",
        false,
    ),
    ("MoveSpeed X, 40mm/s\nMoveSpeed Y, -3mm/s\nWait 9s", false),
];

/// A mill with an emergency stop at an input, normally closed.
fn mill(wiring: Wiring, n: i32) -> Profile {
    let mut profile = fast_mill(60_000, 90_000).expect("a profile");
    profile.wiring = wiring;
    let role = Some(InputRole::EmergencyStop);
    profile.inputs.push(Input { n, name: None, role, invert: true, filter_ms: 20 });
    if wiring == Wiring::Direct {
        // The probe has given its pin up.
        let role = Some(InputRole::Probe);
        profile.inputs.push(Input { n: 3, name: None, role, invert: false, filter_ms: 20 });
    } else {
        let role = Some(InputRole::Probe);
        profile.inputs.push(Input { n: 8, name: None, role, invert: false, filter_ms: 20 });
    }
    profile
}

/// A board on its way, with a host that asks it, and the ticks of its steps so far.
fn moving(build: &Build, profile: &Profile, script: &str, dice: &mut Dice) -> Lab {
    let script = format!("SetOut 1, ON\n{script}");
    let mut lab = Lab::new(build, profile, &script);
    let far = |axis, above| Contact { axis, position: if above { 1 } else { -1 } << 20, above };
    lab.board.plant_mut().switches = [Some(far(0, false)), Some(far(1, false)), Some(far(2, true))];
    lab.start();
    lab.run_ms(100 + dice.below(250));
    assert_eq!(lab.read(RUN_STATE), RunState::Running as u16, "{script}");
    lab.board.uart_send(&framed(&read_body(MACHINE_POSITIONS, 6)));
    lab.board.run_us(dice.below(2_500));
    lab
}

/// Steps of an axis before and behind an instant.
fn own(made: &[Step], axis: usize, at: u64) -> (Vec<u64>, Vec<u64>) {
    let times = made.iter().filter(|step| step.by[axis] != 0).map(|step| step.at);
    times.partition(|time| *time <= at)
}

/// A board whose contact opened at `at` makes at most one step of each axis more, `delay` later.
fn ceases(lab: &mut Lab, at: u64, delay: u64, name: &str) {
    lab.run_ms(60);
    lab.stops_abruptly("an emergency stop");
    let made = lab.steps();
    for axis in 0..3 {
        let (before, behind) = own(&made, axis, at);
        let [.., a, b] = before[..] else { continue };
        let late = behind.iter().filter(|time| **time > at + delay).count();
        assert!(late <= 1, "{name}: {late} steps of axis {axis}");
        // An axis that is not the fastest of its line may find its next step sooner or later by one event.
        let period = 2 * (b - a);
        let end = behind.last().map_or(0, |last| last - at);
        assert!(end <= period + delay, "{name}: axis {axis} {end} ticks, a step takes {}", b - a);
    }
    let places = lab.board.plant().motors.each_ref().map(|motor| motor.position);
    assert_eq!(lab.told(), places, "{name}: every step is known");
    assert_eq!(lab.read(FAULT), u16::from(Fault::EmergencyStop.number()), "{name}");
    assert_eq!(lab.read(RUN_STATE), RunState::Fault as u16, "{name}");
    assert_eq!(lab.read(HOMED), 0, "{name}");
    assert_eq!(lab.board.plant().outputs(), 0, "{name}: outputs are safe");
}

fn is_small(build: &Build) -> bool {
    build.part.name == G2553.part.name
}

/// Inputs of an emergency stop, and how long each keeps the board waiting.
fn wirings(build: &Build) -> [(Wiring, i32, u64); 4] {
    [
        (Wiring::Direct, 4, INTERRUPTS),
        (Wiring::Direct, 2, INTERRUPTS),
        (Wiring::Chain, 17, INTERRUPTS),
        (Wiring::Chain, 12, CHAIN[usize::from(!is_small(build))]),
    ]
}

/// Opens the contact while each of the moves is under way.
fn stops(build: &Build, dice: &mut Dice) {
    let small = is_small(build);
    for (wiring, n, delay) in wirings(build) {
        let profile = mill(wiring, n);
        for (script, common) in MOVES {
            if small && !common {
                continue;
            }
            let name = format!("{script} on {}, input {n} {wiring:?}", build.part.name);
            let mut lab = moving(build, &profile, script, dice);
            let at = lab.now();
            lab.board.plant_mut().set_input(n as u8, true);
            ceases(&mut lab, at, delay, &name);
            assert!(lab.pulses() > 100, "{name}: it moved");
            assert_eq!(lab.read(FAULT_INPUT), n as u16, "{name}: the input is named");
        }
    }
}

#[test]
fn a_contact_stops_every_move_within_a_step() {
    stops(&G2553, &mut Dice(21));
    stops(&F5529, &mut Dice(22));
}

#[test]
fn a_disturbance_of_2_us_stops_all_or_nothing() {
    let mut dice = Dice(31);
    let mut stopped = 0;
    for build in [&G2553, &F5529] {
        for (wiring, n, delay) in wirings(build).into_iter().filter(|(_, n, _)| *n != 2) {
            let script = "G1 X40 Y37 Z-9 F9000\nMoveAxe X, 0mm";
            let mut whole = moving(build, &mill(wiring, n), script, &mut dice);
            whole.stops_abruptly("goes on in copies");
            for _ in 0..12 {
                let mut lab = whole.clone();
                lab.board.run_us(dice.below(3_000));
                lab.board.plant_mut().set_input(n as u8, true);
                lab.board.run_us(2);
                lab.board.plant_mut().set_input(n as u8, false);
                let at = lab.now();
                let name = format!("2 us at input {n} {wiring:?} on {}", build.part.name);
                // What was asked is answered.
                lab.run_ms(10);
                if lab.read(FAULT) == u16::from(Fault::EmergencyStop.number()) {
                    ceases(&mut lab, at, delay, &name);
                    stopped += 1;
                    continue;
                }
                lab.settle(100);
                lab.goes_to_its_end();
                let places = lab.board.plant().motors.each_ref().map(|motor| motor.position);
                assert_eq!((lab.told(), places), ([0, 3_700, -900], [0, 3_700, -900]), "{name}");
                assert_eq!(lab.read(FAULT), 0, "{name}");
            }
        }
    }
    assert!(stopped > 0, "some are long enough");
}

/// Behind a flash operation, which holds the processor for 12 ms, the millisecond's interrupts come close
/// together, and each reads the chain: whatever the instant, none finds a contact open that is closed.
#[test]
fn an_upload_never_looks_like_an_open_contact() {
    let profile = mill(Wiring::Chain, 12);
    let idle = Lab::new(&F5529, &profile, "Wait 1ms").board.clone();
    for phase in 0..300 {
        let mut board = idle.clone();
        board.run_us(phase * 7);
        for (at, values) in [(UPLOAD_LENGTH, 200), (UPLOAD_CONTROL, Upload::Begin as u16)] {
            board.uart_send(&framed(&write_body(at, &[values])));
            board.run_us(400_000);
        }
        board.uart_take();
        board.uart_send(&framed(&read_body(FAULT, 1)));
        board.run_us(10_000);
        let reply: Vec<u8> = board.uart_take().into_iter().map(|(_, byte)| byte).collect();
        assert_eq!(reply.get(..5), Some(&[1, 3, 2, 0, 0][..]), "begun {} us later", 7 * phase);
    }
}
