//! Places of the axes: [`coords`] by rustc and as micro-code, from the same places and profile.

use firmware::rules::Axis;
use firmware::rules::coords::{self, Commands, Settles, Stands, Targets};
use lang::fault::Fault;
use lang::record::{AxisRecord, MachineRecord};
use proptest::prelude::*;

use super::{Entry, Twin, proved};
use crate::chip::Chip;
use crate::coords::{axis, converted, value};
use crate::lockstep::{OnChip, runner};
use crate::machine::mill;
use crate::verify::Elf;

/// Bits of FRAME_OF.
const STEPS: u8 = 4;
const MACHINE: u8 = 8;
const RELATIVE: u8 = 16;

impl Twin {
    /// The record of an axis.
    pub fn axis_record(&self, axis: Axis) -> &AxisRecord {
        &self.machine.axes[usize::from(axis.n())]
    }

    /// A number of an axis.
    pub fn at(&self, place: &str, axis: Axis) -> i32 {
        self.chip.long(place, 4 * u16::from(axis.n())) as i32
    }

    /// See [`Twin::at`].
    pub fn set(&mut self, place: &str, axis: Axis, value: i32) {
        self.chip.set_long(place, 4 * u16::from(axis.n()), value as u32);
    }

    fn frame(&self, bit: u8) -> bool {
        self.chip.byte("FRAME_OF") & bit != 0
    }
}

impl Stands for Twin {
    fn position(&self, axis: Axis) -> i32 {
        self.at("ACTUAL", axis)
    }
    fn steps(&self, axis: Axis) -> i32 {
        self.at("STEPS", axis)
    }
    fn offset(&self, axis: Axis) -> i32 {
        self.at("OFFSET", axis)
    }
    fn to_steps(&self, axis: Axis, um: i32) -> Option<i32> {
        converted(self.axis_record(axis), um, true)
    }
    fn to_um(&self, axis: Axis, steps: i32) -> Option<i32> {
        converted(self.axis_record(axis), steps, false)
    }
}

impl Settles for Twin {
    fn set_um(&mut self, axis: Axis, um: i32) {
        self.set("UM", axis, um);
    }
    fn set_steps(&mut self, axis: Axis, steps: i32) {
        self.set("STEPS", axis, steps);
    }
}

impl Targets for Twin {
    fn is_there(&self, axis: Axis) -> bool {
        axis.n() < 3 && self.axis_record(axis).flags & AxisRecord::PRESENT != 0
    }
    fn in_steps(&self) -> bool {
        self.frame(STEPS)
    }
    fn is_relative(&self) -> bool {
        self.frame(RELATIVE)
    }
    fn is_machine(&self) -> bool {
        self.frame(MACHINE)
    }
    fn um(&self, axis: Axis) -> i32 {
        self.at("UM", axis)
    }
    fn set_new_um(&mut self, axis: Axis, um: i32) {
        self.set("NEW_UM", axis, um);
    }
    fn set_new_steps(&mut self, axis: Axis, steps: i32) {
        self.set("NEW_STEPS", axis, steps);
    }
    fn is_too_far(&self, axis: Axis) -> bool {
        self.new_steps(axis).checked_sub(self.position(axis)).is_none()
    }
    fn is_homed(&self, axis: Axis) -> bool {
        self.chip.byte("HOMED") & axis.bit() != 0
    }
    fn is_above(&self, axis: Axis) -> bool {
        self.axis_record(axis).max.wrapping_sub(self.new_um(axis)) < 0
    }
    fn is_below(&self, axis: Axis) -> bool {
        self.new_um(axis).wrapping_sub(self.axis_record(axis).min) < 0
    }
    fn is_placed(&self, axis: Axis) -> bool {
        self.chip.byte("PLACED") & axis.bit() != 0
    }
    fn wants_homing(&self) -> bool {
        self.machine.flags & MachineRecord::REQUIRE_HOMING != 0
    }
}

impl Commands for Twin {
    fn new_um(&self, axis: Axis) -> i32 {
        self.at("NEW_UM", axis)
    }
    fn new_steps(&self, axis: Axis) -> i32 {
        self.at("NEW_STEPS", axis)
    }
    fn is_joined(&self) -> bool {
        self.chip.byte("JOINS") != 0
    }
    fn count_joined(&mut self) {
        self.chip.set_byte("JOINS", self.chip.byte("JOINS").wrapping_add(1));
    }
}

/// Places of the axes, and whether they have homed or were placed.
fn put(chip: &mut Chip, places: [[i32; 3]; 6], bytes: [u8; 3]) {
    for (name, places) in
        ["UM", "STEPS", "OFFSET", "ACTUAL", "NEW_UM", "NEW_STEPS"].iter().zip(places)
    {
        for (n, place) in (0..).zip(places) {
            chip.set_long(name, 4 * n, place as u32);
        }
    }
    for (name, byte) in ["HOMED", "PLACED", "FRAME_OF"].iter().zip(bytes) {
        chip.set_byte(name, byte);
    }
}

/// r12 of a statement that ended.
pub fn fault(result: Result<(), Fault>) -> u32 {
    result.map_or_else(|fault| u32::from(micro::isa::FAULTED) | u32::from(fault.number()), |()| 0)
}

#[test]
fn places_and_targets_are_the_same_by_rustc_and_as_micro_code() {
    let axes = [axis(), axis(), axis()];
    let longs = || [value(), value(), value()];
    let places = [longs(), longs(), longs(), longs(), longs(), longs()];
    let start = (axes, places, any::<[u8; 3]>(), 0u8..3, value());
    let base = OnChip::of(&Chip::new(), &Elf::of("whole"), true);
    let result = runner(400).run(&start, |(axes, places, bytes, n, target)| {
        let flags = if bytes[2] & 1 != 0 { MachineRecord::REQUIRE_HOMING } else { 0 };
        let machine = MachineRecord { axes, flags, ..mill() };
        let place = |chip: &mut Chip| put(chip, places, bytes);
        let n = Axis::new(n);
        let same = |label, acc: i32, rule: &dyn Fn(&mut Twin) -> Option<u32>| {
            let entry = Entry { axis: Some(n), acc: acc as u32, ..Entry::default() };
            proved(&base, label, &machine, &place, &entry, rule);
        };
        same("work_steps", n.n().into(), &|m| Some(coords::work_steps(m, n) as u32));
        same("target_steps", n.n().into(), &|m| Some(coords::target_steps(m, n) as u32));
        same("offset_steps", 0, &|m| Some(coords::offset_steps(m, n) as u32));
        same("aim", target, &|m| Some(fault(coords::aim(m, n, target))));
        same("aim_place", target, &|m| Some(fault(coords::aim_place(m, n, target))));
        same("command", 0, &|m| Some(coords::command(m, n).into()));
        same("settle", target, &|m| {
            coords::settle(m, n, target);
            None
        });
        same("settle_here", 0, &|m| {
            coords::settle_here(m, n);
            None
        });
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}
