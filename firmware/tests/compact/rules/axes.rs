//! Statements that move, stop and wait for axes: [`axes`] by rustc and as micro-code.

use emulator::Rng;
use firmware::motion::scaled::Scaled;
use firmware::rules::axes::{self, Axes, Begins};
use firmware::rules::{Axis, Progress, coords};
use lang::fault::Fault;
use lang::isa::{Op, flags};
use lang::record::MachineRecord;
use proptest::prelude::*;

use super::commands::{FLAGS, RAMPS};
use super::effects::{progress, unit};
use super::pace::paced;
use super::{Entry, Twin, proved, statement};
use crate::chip::Chip;
use crate::coords::value;
use crate::lockstep::{OnChip, runner};
use crate::machine::mill;
use crate::verify::Elf;

/// Bits of FRAME_OF.
const STEPS: u8 = 4;
const RELATIVE: u8 = 16;

impl Axes for Twin {
    fn set_code(&mut self, code: u8) {
        let at = unit(&self.chip);
        self.chip.board.poke8(at, code);
    }
    fn is_move(&self) -> bool {
        self.chip.board.peek8(unit(&self.chip)) == Op::Move as u8
    }
    fn short_flags(&self, code: u8) -> u8 {
        let n = code - Op::MoveTo as u8;
        if n < 3 { n } else { (n - 3) | flags::RELATIVE }
    }
    fn ramps(&self) -> u8 {
        self.statement_byte(RAMPS)
    }
    fn set_ramps(&mut self, flags: u8) {
        self.set_statement_byte(RAMPS, flags);
    }
    fn has_decel(&self) -> bool {
        self.ramps() & flags::DECEL != 0
    }
    fn take_move_frame(&mut self) {
        let bits = self.statement_byte(FLAGS);
        let steps = if bits & flags::STEPS != 0 { STEPS } else { 0 };
        let relative = if bits & flags::RELATIVE != 0 { RELATIVE } else { 0 };
        self.chip.set_byte("FRAME_OF", steps | relative);
    }
    fn aim_move(&mut self, axis: Axis, target: i32) -> Result<(), Fault> {
        coords::aim(self, axis, target)
    }
    fn command_place(&mut self, axis: Axis) -> bool {
        coords::command(self, axis)
    }
    fn is_sent_again(&self, _: Axis) -> bool {
        false
    }
    fn set_out(&mut self, axis: Axis) -> Progress {
        self.of_axis("begin_axis", axis, 0);
        Ok(false)
    }
    fn moving(&self) -> u8 {
        self.chip.byte("MOVING")
    }
    fn goes_on(&mut self) -> bool {
        false
    }
    fn stop_axis(&mut self, _: u8) {}
    fn stop_axes(&mut self) {}
    fn tells_stops(&mut self) -> bool {
        false
    }
    fn await_axis(&mut self, _: u8) -> Result<(), Fault> {
        Ok(())
    }
    fn awaits_move(&self) -> bool {
        false
    }
}

impl Begins for Twin {
    fn begin(&mut self, axis: u8) {
        self.calls("axis_begin", axis.into());
    }
}

/// What a statement finds.
#[derive(Clone, Debug)]
struct Found {
    seed: u64,
    /// Its operands: flags, and those of ramps.
    operands: [u8; 2],
    /// Values on the stack.
    values: [i32; 4],
    moving: u8,
}

impl Found {
    fn put(&self, chip: &mut Chip) {
        let mut random = Rng::new(self.seed);
        for name in ["UM", "STEPS", "OFFSET", "ACTUAL"] {
            for n in 0..3 {
                let far = random.bits() & 7 == 0;
                let value = random.bits() as i32;
                chip.set_long(name, 4 * n, if far { value } else { value >> 14 } as u32);
            }
        }
        for name in ["HOMED", "PLACED", "NEGATIVE", "N", "PHASE"] {
            chip.set_byte(name, random.bits() as u8 & 7);
        }
        chip.set_byte("MOVING", self.moving);
        chip.set_long("BYTES", 0, random.bits() as u32);
        statement(chip, chip.at("POOL_END"), &self.values, &self.operands);
        chip.set_byte("TRACING", if random.bits() & 1 == 0 { *crate::rig::T_ON } else { 0 });
    }
}

fn found() -> impl Strategy<Value = Found> {
    let number = || prop_oneof![6 => 1..20_000, 1 => Just(0), 3 => value()];
    let moving = prop_oneof![Just(0u8), 1u8..8];
    (any::<u64>(), any::<[u8; 2]>(), [number(), number(), number(), number()], moving)
        .prop_map(|(seed, operands, values, moving)| Found { seed, operands, values, moving })
}

#[test]
fn moves_and_stops_are_the_same_by_rustc_and_as_micro_code() {
    let base = OnChip::of(&Chip::new(), &Elf::of("whole"), true);
    let start = (found(), [paced(), paced(), paced()], any::<bool>(), any::<bool>());
    let result = runner(600).run(&start, |(found, axes, homes, first)| {
        let flags = if homes { MachineRecord::REQUIRE_HOMING } else { 0 };
        let machine = MachineRecord { axes, flags, ..mill() };
        let put = |chip: &mut Chip| {
            found.put(chip);
            if first {
                // As the loop that calls it leaves it.
                chip.set_byte("MOVING", 0);
            }
        };
        let same = |label, code: u8, first, rule: &dyn Fn(&mut Twin) -> Option<u32>| {
            let scratch = &[("V2", 4), ("LEFT", 4)];
            let entry = Entry { acc: code.into(), first, scratch, ..Entry::default() };
            proved(&base, label, &machine, &put, &entry, rule);
        };
        for code in Op::MoveTo as u8..=Op::MoveRamp as u8 {
            same("fx_move_axe", code, first, &|m| progress(axes::move_axe(m, code, first)));
        }
        for axis in Axis::UP {
            let entry = Entry { axis: Some(axis), ..Entry::default() };
            let put = |chip: &mut Chip| {
                put(chip);
                for at in [0, 4, 8] {
                    let rate = found.seed as u32 >> at & 0x3FFF;
                    chip.set_long("TEMP", at, Scaled::new(rate + 1).0);
                }
            };
            let begins = |m: &mut Twin| progress(axes::begin_axis(m, axis));
            proved(&base, "begin_axis", &machine, &put, &entry, &begins);
        }
        same("fx_stop_axe", 0, true, &|m| progress(axes::stop_axe(m)));
        same("fx_stop_all", 0, true, &|m| progress(axes::stop_all(m)));
        same("fx_wait_move", 0, true, &|m| progress(axes::wait_move(m)));
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}
