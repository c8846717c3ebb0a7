//! How motions end: [`stops`] by rustc and as micro-code, from any state of the planner.

use emulator::Rng;
use firmware::motion::scaled::Scaled;
use firmware::rules::Axis;
use firmware::rules::coords::Stands;
use firmware::rules::stops::{self, Stops};
use lang::record::MachineRecord;
use proptest::prelude::*;

use super::{Entry, Twin, proved};
use crate::chip::Chip;
use crate::coords::value;
use crate::lockstep::{OnChip, runner};
use crate::machine::mill;
use crate::verify::Elf;

/// Bits of MOTION: it rests in a pause; it brakes, then its rest is forgotten; it ends with the host's silence; the commanded
/// places will be where it ends.
const PAUSE: u8 = 1;
const STOP: u8 = 16;
const JOG: u8 = 32;
const SETTLE: u8 = 64;
/// From a slot to its events.
const EVENTS: u16 = 8;

impl Twin {
    /// A scaled number of the planner.
    pub fn scaled(&self, name: &str) -> Scaled {
        Scaled(self.chip.long(name, 0))
    }

    /// See [`Twin::scaled`].
    pub fn set_scaled(&mut self, name: &str, number: Scaled) {
        self.chip.set_long(name, 0, number.0);
    }
}

impl Stops for Twin {
    fn moving(&self) -> u8 {
        self.chip.byte("MOVING")
    }
    fn set_moving(&mut self, axes: u8) {
        self.chip.set_byte("MOVING", axes);
    }
    fn set_motion(&mut self, flags: u8) {
        self.chip.set_byte("MOTION", flags);
    }
    fn brake_to_stop(&mut self) {
        self.bits_of("MOTION", PAUSE | SETTLE | JOG, STOP);
    }
    fn end_at_once(&mut self) {
        self.chip.set_byte("MOTION", STOP);
    }
    fn brakes_to_stop(&self) -> bool {
        self.chip.byte("MOTION") & STOP != 0
    }
    fn ends_elsewhere(&self) -> bool {
        self.chip.byte("MOTION") & (STOP | SETTLE | JOG) != 0
    }
    fn settle_at_end(&mut self) {
        self.bits_of("MOTION", 0, SETTLE);
    }
    fn keep_pause(&mut self) {
        self.bits_of("MOTION", !PAUSE, 0);
    }
    fn settle_all(&mut self) {
        self.calls("settle_all", 0);
    }
    fn left(&self) -> i32 {
        self.chip.long("LEFT", 0) as i32
    }
    fn set_left(&mut self, events: i32) {
        self.chip.set_long("LEFT", 0, events as u32);
    }
    fn set_end_speed2(&mut self, square: Scaled) {
        self.set_scaled("V2", square);
    }
    fn nominal2(&self) -> Scaled {
        self.scaled("NOMINAL2")
    }
    fn start2(&self) -> Scaled {
        self.scaled("START2")
    }
    fn decel2(&self) -> Scaled {
        self.scaled("DECEL2")
    }
    fn steps(&self, axis: Axis) -> i32 {
        Stands::steps(self, axis)
    }
    fn empty_slots(&mut self) {
        for slot in ["SLOT0", "SLOT1"] {
            let at = self.chip.at(slot) + EVENTS;
            self.chip.board.poke16(at, 0);
        }
    }
    fn rests(&self) -> bool {
        let mut chip = self.chip.clone();
        chip.call("motion_rests", &[]);
        chip.reg(2) & 2 != 0
    }
    fn poll(&mut self) {
        self.calls("motion_poll", 0);
    }
}

/// A scaled number in the planner's range.
pub fn planned(random: &mut Rng) -> Scaled {
    let value = random.bits() as u32 | 1 << 31;
    Scaled::new(value).shifted((random.bits() & 31) as i8 - 40)
}

#[test]
fn motions_end_the_same_by_rustc_and_as_micro_code() {
    let base = OnChip::of(&Chip::new(), &Elf::of("whole"), true);
    let near = || prop_oneof![6 => -20_000..20_000, 1 => Just(0), 1 => value()];
    let places = || [near(), near(), near()];
    let left = prop_oneof![1 => Just(0u32), 3 => 1..2_000u32, 1 => 1..2_000_000u32];
    let bytes = (prop_oneof![1 => Just(0u8), 3 => 1u8..8], any::<u8>());
    let start = (any::<u64>(), places(), places(), bytes, left, near());
    let result = runner(1_500).run(&start, |(seed, here, there, (moving, motion), left, at)| {
        let machine = MachineRecord { ..mill() };
        let put = |chip: &mut Chip| {
            let mut random = Rng::new(seed);
            for name in ["V2", "V", "ACCEL2", "DECEL2", "NOMINAL2", "START2", "TICK"] {
                let number = planned(&mut random);
                chip.set_long(name, 0, number.0);
            }
            for n in 0..3 {
                chip.set_long("ACTUAL", 4 * n, here[usize::from(n)] as u32);
                chip.set_long("STEPS", 4 * n, there[usize::from(n)] as u32);
                chip.set_long("UM", 4 * n, random.bits() as u32);
            }
            chip.set_long("LEFT", 0, left);
            chip.set_byte("MOVING", moving);
            chip.set_byte("MOTION", motion);
            chip.set_byte("NEGATIVE", random.bits() as u8 & 7);
            for slot in ["SLOT0", "SLOT1"] {
                let at = chip.at(slot) + EVENTS;
                chip.board.poke16(at, random.bits() as u16);
            }
            chip.set_word("VM_SP", chip.at("POOL_END"));
        };
        let same = |label, axis, acc: i32, rule: &dyn Fn(&mut Twin)| {
            let scratch = &[("TEMP", 12)];
            let entry = Entry { axis, acc: acc as u32, scratch, ..Entry::default() };
            proved(&base, label, &machine, &put, &entry, &|m| {
                rule(m);
                None
            });
        };
        same("motion_over", None, 0, &|m| stops::over(m));
        same("motion_stop", None, 0, &|m| stops::stop(m));
        same("motion_halt", None, 0, &|m| stops::halt(m));
        for axis in Axis::UP {
            same("motion_hit", Some(axis), at, &|m| stops::hit(m, axis, at));
        }
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}
