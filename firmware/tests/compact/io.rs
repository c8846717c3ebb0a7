//! Pins of both wirings, and the filter.

use std::cell::RefCell;

use firmware::inputs::Inputs;
use lang::profile::Profile;
use lang::record::BoardRecord;
use lang::wire::RunState;
use proptest::prelude::*;

use crate::chip::Chip;
use crate::rig::Rig;

#[test]
fn the_filter_is_the_twins() {
    let chip = RefCell::new(Chip::new());
    proptest!(|(samples in prop::collection::vec(any::<u8>(), 1..40))| {
        let mut chip = chip.borrow_mut();
        let mut twin = Inputs::new();
        for name in ["INPUT", "INPUT_LOW", "INPUT_HIGH"] {
            chip.set_word(name, 0);
        }
        let address = chip.at("INPUT");
        for pair in samples.windows(2) {
            // Repeated samples are what gets through.
            for raw in [pair[0], pair[0], pair[0] | pair[1], pair[0] & pair[1]] {
                let before = twin.accepted();
                twin.sample(raw.into());
                chip.call("filter", &[(12, raw.into()), (13, address)]);
                prop_assert_eq!(chip.word("INPUT"), twin.accepted());
                prop_assert_eq!(chip.reg(12), twin.accepted() & !before);
                prop_assert_eq!(chip.reg(13), address);
            }
        }
    });
}

#[test]
fn masks_of_numbers() {
    let mut chip = Chip::new();
    for n in 0..=255 {
        chip.call("mask_of", &[(12, n)]);
        let mask = if (1..=16).contains(&n) { 1 << (n - 1) } else { 0 };
        assert_eq!(chip.reg(14), mask, "{n}");
    }
}

#[test]
fn the_direct_wiring_has_two_outputs_and_four_inputs() {
    let text = include_str!("../../../examples/profiles/mill.toml")
        .replace("wiring = \"chain\"", "wiring = \"direct\"");
    let profile = Profile::parse(&text).expect("mill, wired directly");
    let mut rig = Rig::with(
        &profile,
        "DIM n\nSetOut 2, ON\nWaitIn 3, ON\nn = 3\nSetOut 1, ON\nWait 50ms\nSetOut n, ON\n",
    );
    rig.start();
    assert_eq!((rig.output(1), rig.output(2)), (false, true));
    rig.input(3, true);
    assert_eq!((rig.output(1), rig.output(2)), (true, true));
    assert_eq!(rig.chip.word("INPUT") & 0b1111, 0b0100);
    rig.ms(50);
    assert_eq!(rig.chip.byte("VM_FAULT"), 20, "there is no output 3");
    assert_eq!((rig.output(1), rig.output(2)), (false, false));
}

#[test]
fn roles_keep_the_machine_from_working() {
    let text = include_str!("../../../examples/profiles/mill.toml").to_owned()
        + "\n[[input]]\nn = 12\nrole = \"door\"\n\n[[input]]\nn = 13\nrole = \"emergency_stop\"\n";
    let profile = Profile::parse(&text).expect("mill with a door");
    let record = BoardRecord::of(&profile, 1);
    assert_eq!((record.door, record.emergency), ([12, 0], [13, 0, 0, 0]));
    let mut rig = Rig::with(&profile, "Wait 1s\n");
    rig.input(12, true);
    rig.chip.call("blocking", &[]);
    assert_eq!(rig.chip.reg(12), 12);
    rig.start();
    assert_eq!(rig.chip.word("RUNS"), 0, "the door is open");
    rig.input(12, false);
    rig.chip.call("blocking", &[]);
    assert_eq!(rig.chip.reg(12), 0);
    rig.start();
    assert_eq!(rig.chip.word("RUNS"), 1);
    rig.input(12, true);
    assert_eq!(rig.state(), RunState::Paused, "the door was opened");
    rig.start();
    assert_eq!(rig.state(), RunState::Paused);
    rig.input(12, false);
    rig.start();
    assert_eq!(rig.state(), RunState::Running);
    rig.input(13, true);
    assert_eq!(rig.chip.byte("VM_FAULT"), 14);
    assert_eq!(rig.chip.byte("FAULT_IN"), 13);
}

#[test]
fn a_laser_is_off_while_nothing_moves() {
    let mut rig = Rig::new("laser", "Wait 1s\n");
    let profile = Profile::built_in("laser").expect("built in");
    let laser = BoardRecord::of(&profile, 1).laser;
    assert_ne!(laser, 0);
    rig.chip.set_word("OUTPUT", 0xFFFF);
    rig.ms(2);
    let others = rig.chip.board.plant().outputs();
    assert_eq!(others, !(1 << (laser - 1)));
}
