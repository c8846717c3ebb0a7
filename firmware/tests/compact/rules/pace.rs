//! Rates and paces: [`pace`] by rustc and as micro-code, of any numbers.

use emulator::Rng;
use firmware::motion::scaled::Scaled;
use firmware::rules::Axis;
use firmware::rules::pace::{self, OwnPaces, Paces};
use lang::isa::flags;
use lang::record::{AxisRecord, MachineRecord};
use proptest::prelude::*;
use std::mem::offset_of;

use super::commands::FLAGS;
use super::effects::unit;
use super::{Entry, Twin, proved};
use crate::chip::Chip;
use crate::coords::{axis, value};
use crate::lockstep::{OnChip, runner};
use crate::machine::mill;
use crate::verify::Elf;

/// Flags that say that there is a rate: of ramps up and down and of a speed.
const RATES: u8 = flags::ACCEL | flags::DECEL | flags::SPEED;
/// Those that say steps.
const STEPS: u8 = flags::ACCEL_STEPS | flags::DECEL_STEPS | flags::SPEED_STEPS;

impl Twin {
    /// A field of an axis's record; of no axis what stands behind the last one in flash.
    fn of_record(&self, axis: Axis, offset: usize, of: fn(&AxisRecord) -> u32) -> u32 {
        if axis.n() < 3 {
            return of(self.axis_record(axis));
        }
        let at = self.chip.word("VM_CODE") + offset as u16;
        u32::from(self.chip.board.peek16(at + 2)) << 16 | u32::from(self.chip.board.peek16(at))
    }

    fn least(&mut self, at: u16, rate: Scaled) -> Scaled {
        let least = Scaled(self.chip.long("TEMP", at)).least(rate);
        self.chip.set_long("TEMP", at, least.0);
        least
    }

    fn unit_flags(&self) -> u8 {
        self.chip.board.peek8(unit(&self.chip))
    }
}

impl Paces for Twin {
    fn flags(&self) -> u8 {
        self.statement_byte(FLAGS)
    }
    fn keep_flags(&mut self, flags: u8) {
        self.set_statement_byte(FLAGS, flags);
    }
    fn set_unit(&mut self, flags: u8) {
        let at = unit(&self.chip);
        self.chip.board.poke8(at, flags);
    }
    fn brings_rate(&self) -> bool {
        self.unit_flags() & RATES != 0
    }
    fn counts_steps(&self) -> bool {
        self.unit_flags() & STEPS != 0
    }
    fn count_in_steps(&mut self) {
        self.set_unit(flags::ACCEL_STEPS);
    }
    fn count_in_um(&mut self) {
        self.set_unit(0);
    }
    fn steps_of(&self, axis: Axis) -> u16 {
        self.of_record(axis, offset_of!(AxisRecord, steps), |axis| axis.steps.into()) as u16
    }
    fn um_of(&self, axis: Axis) -> u16 {
        self.of_record(axis, offset_of!(AxisRecord, um), |axis| axis.um.into()) as u16
    }
    fn take_pace(&mut self, axis: Axis) {
        pace::axis_pace(self, axis);
    }
    fn least_up(&mut self, rate: Scaled) -> Scaled {
        self.least(4, rate)
    }
    fn least_speed(&mut self, rate: Scaled) -> Scaled {
        self.least(0, rate)
    }
    fn least_down(&mut self, rate: Scaled) -> Scaled {
        self.least(8, rate)
    }
    fn pace_up(&self) -> Scaled {
        Scaled(self.chip.long("TEMP", 4))
    }
    fn pace_speed(&self) -> Scaled {
        Scaled(self.chip.long("TEMP", 0))
    }
}

impl OwnPaces for Twin {
    fn top_rate(&self, axis: Axis) -> i32 {
        self.of_record(axis, offset_of!(AxisRecord, top_rate), |axis| axis.top_rate) as i32
    }
    fn ramp_up(&self, axis: Axis) -> i32 {
        self.of_record(axis, offset_of!(AxisRecord, accel), |axis| axis.accel) as i32
    }
    fn ramp_down(&self, axis: Axis) -> i32 {
        self.of_record(axis, offset_of!(AxisRecord, decel), |axis| axis.decel) as i32
    }
    fn set_pace_speed(&mut self, speed: Scaled) {
        self.chip.set_long("TEMP", 0, speed.0);
    }
    fn set_pace_up(&mut self, ramp: Scaled) {
        self.chip.set_long("TEMP", 4, ramp.0);
    }
    fn set_pace_down(&mut self, ramp: Scaled) {
        self.chip.set_long("TEMP", 8, ramp.0);
    }
}

/// An axis with any rates and ramps.
pub fn paced() -> impl Strategy<Value = AxisRecord> {
    let rate = || prop_oneof![1..2_000_000u32, 1..=u32::MAX];
    (axis(), rate(), rate(), rate()).prop_map(|(axis, top_rate, accel, decel)| AxisRecord {
        top_rate,
        accel,
        decel,
        ..axis
    })
}

/// A pace, flags, and a value on the stack.
fn put(chip: &mut Chip, seed: u64, flags: u8, value: i32) {
    let mut random = Rng::new(seed);
    for at in [0, 4, 8] {
        chip.set_long("TEMP", at, Scaled::new(random.bits() as u32 >> (random.bits() & 31)).0);
    }
    chip.set_long("BYTES", 0, random.bits() as u32);
    let at = chip.at("BYTES") + FLAGS;
    chip.board.poke8(at, flags);
    let (end, pool) = (chip.at("POOL_END"), chip.at("POOL"));
    for (name, word) in [("VM_SP", end - 24), ("VM_BASE", end), ("VM_CELLS", pool + 16)] {
        chip.set_word(name, word);
    }
    chip.set_word("VM_CALLS", pool);
    chip.set_long("VM_TOP", 0, value as u32);
}

#[test]
fn rates_and_paces_are_the_same_by_rustc_and_as_micro_code() {
    let base = OnChip::of(&Chip::new(), &Elf::of("whole"), true);
    let axes = [paced(), paced(), paced()];
    let start = (any::<u64>(), any::<u8>(), value(), axes, 0u8..4);
    let result = runner(600).run(&start, |(seed, bits, value, axes, n)| {
        let machine = MachineRecord { axes, ..mill() };
        let n = Axis::new(n);
        let put = |chip: &mut Chip| put(chip, seed, bits, value);
        let same = |label, axis, acc: u32, rule: &dyn Fn(&mut Twin) -> Option<u32>| {
            let entry = Entry { axis, acc, number: true, ..Entry::default() };
            proved(&base, label, &machine, &put, &entry, rule);
        };
        let rate = Scaled::new(value.unsigned_abs());
        same("rate", Some(n), bits.into(), &|m| Some(pace::rate(m, n, bits).0));
        same("rate_of", Some(n), value as u32, &|m| Some(pace::rate_of(m, n, value).0));
        same("axis_pace", Some(n), 0, &|m| {
            pace::axis_pace(m, n);
            None
        });
        same("axis_flags", None, bits.into(), &|m| {
            let axis = pace::axis_flags(m, bits);
            assert_eq!(axis.n(), bits & flags::AXIS);
            None
        });
        same("speed_flags", Some(n), 0, &|m| Some(pace::speed_flags(m, n).0));
        same("speed_least", Some(n), rate.0, &|m| Some(pace::speed_least(m, rate).0));
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn the_small_chips_pace_is_the_larger_ones() {
    let base = Chip::new();
    let result = runner(100).run(&([paced(), paced(), paced()], 0u8..3), |(axes, n)| {
        let machine = MachineRecord { axes, ..mill() };
        let mut twin = Twin::of(&base, &machine);
        pace::axis_pace(&mut twin, Axis::new(n));
        let pace = firmware::motion::Pace::of(&axes[usize::from(n)]);
        prop_assert_eq!(twin.pace_speed(), pace.speed);
        prop_assert_eq!(twin.pace_up(), pace.accel);
        prop_assert_eq!(Scaled(twin.chip.long("TEMP", 8)), pace.decel);
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}
