//! Reference runs and limits: [`home`] by rustc and as micro-code, in any phase, by the profile and by command 106.

use std::mem::offset_of;

use emulator::Rng;
use firmware::motion::scaled::Scaled;
use firmware::rules::home::{self, Homes, Switches};
use firmware::rules::{Axis, Progress};
use lang::fault::Fault;
use lang::isa::Op;
use lang::record::{AxisRecord, BoardRecord, MachineRecord};
use proptest::prelude::*;

use super::effects::progress;
use super::{Entry, Twin, proved, with_profile};
use crate::chip::Chip;
use crate::coords::converted;
use crate::lockstep::{OnChip, runner};
use crate::machine::{mill, scale};
use crate::rig::PROFILE;
use crate::verify::Elf;

/// Flags of a run: the switch is off when closed, the numbers are a command's.
const INVERT: u8 = 0x40;
const COMMAND: u8 = 0x80;
/// Arguments of command 106, by their words.
const SPEED: u16 = 6;
const UP: u16 = 10;
const DOWN: u16 = 12;
/// Words of a command, and bytes in front of them that its record takes.
const WORDS: u16 = 21;
const IN_FRONT: u16 = 4;

/// Where command 106 has its words, from the pool's beginning.
fn command(chip: &Chip) -> u16 {
    chip.at("POOL_END") - 2 * WORDS - chip.at("POOL")
}

impl Twin {
    fn by_command(&self) -> bool {
        self.chip.byte("BITS") & COMMAND != 0
    }

    fn argument(&self, n: u16) -> Scaled {
        Scaled::new(self.chip.long("POOL", command(&self.chip) + 2 * n))
    }

    /// A field of the record that the run is by; on the chip the last three have no gap in front of them.
    fn field(&self, axis: Axis, at: usize, of: fn(&AxisRecord) -> i32) -> i32 {
        if self.by_command() {
            return self.chip.long("POOL", command(&self.chip) - IN_FRONT + at as u16) as i32;
        }
        of(self.axis_record(axis))
    }

    fn bound(&mut self, at: u16, value: Scaled) {
        let there = Scaled(self.chip.long("TEMP", at));
        self.chip.set_long("TEMP", at, there.least(value).0);
    }

    /// A routine of the chip for an axis.
    pub fn of_axis(&mut self, routine: &str, axis: Axis, acc: i32) {
        let mut chip = self.chip.clone();
        chip.call("axis_select", &[(12, axis.n().into())]);
        let registers = [(8, chip.reg(8)), (9, chip.reg(9)), (12, acc as u16)];
        let registers = registers.into_iter().chain([(13, (acc >> 16) as u16)]);
        self.chip.call(routine, &registers.collect::<Vec<_>>());
    }
}

impl Homes for Twin {
    fn plan(&mut self, n: u8) -> Result<(), Fault> {
        home::by_profile(self, n);
        Ok(())
    }
    fn axis(&self) -> Axis {
        Axis::new(self.chip.byte("N"))
    }
    fn is_there(&self, axis: Axis) -> bool {
        axis.n() < 3 && self.axis_record(axis).flags & AxisRecord::PRESENT != 0
    }
    fn take_pace(&mut self, axis: Axis) {
        self.of_axis("axis_pace", axis, 0);
    }
    fn is_by_command(&self) -> bool {
        self.by_command()
    }
    fn command_speed(&mut self) -> i32 {
        let [speed, up, down] = [SPEED, UP, DOWN].map(|n| self.argument(n));
        self.bound(4, up);
        self.bound(8, down);
        speed.0 as i32
    }
    fn profile_speed(&mut self, axis: Axis) -> i32 {
        Scaled::new(self.axis_record(axis).home_fast.into()).0 as i32
    }
    fn bound_speed(&mut self, speed: i32) {
        self.bound(0, Scaled(speed as u32));
    }
    fn slow_down(&mut self, axis: Axis) {
        let slow = self.field(axis, offset_of!(AxisRecord, home_slow), |r| r.home_slow.into());
        self.bound(0, Scaled::new(u32::from(slow as u16)));
    }
    fn moving(&self) -> u8 {
        self.chip.byte("MOVING")
    }
    fn phase(&self) -> u8 {
        self.chip.byte("PHASE")
    }
    fn set_phase(&mut self, phase: u8) {
        self.chip.set_byte("PHASE", phase);
    }
    fn forget_home(&mut self, axis: Axis) {
        self.bits_of("HOMED", axis.bit(), 0);
    }
    fn set_home(&mut self, axis: Axis) {
        self.bits_of("HOMED", 0, axis.bit());
    }
    fn forget_place(&mut self, axis: Axis) {
        self.bits_of("PLACED", axis.bit(), 0);
    }
    fn set_offset(&mut self, axis: Axis, um: i32) {
        self.chip.set_long("OFFSET", 4 * u16::from(axis.n()), um as u32);
    }
    fn is_closed(&self) -> bool {
        home::closed(&mut self.clone())
    }
    fn way(&self, axis: Axis) -> u8 {
        self.field(axis, offset_of!(AxisRecord, flags), |r| r.flags.into()) as u8
    }
    fn stroke(&self, axis: Axis) -> i32 {
        self.field(axis, AxisRecord::SIZE - 12, |r| r.home_stroke)
    }
    fn place(&self, axis: Axis) -> i32 {
        self.field(axis, AxisRecord::SIZE - 8, |r| r.home_position)
    }
    fn clearance(&self, axis: Axis) -> i32 {
        self.field(axis, AxisRecord::SIZE - 4, |r| r.home_clearance)
    }
    fn pause(&self, axis: Axis) -> u16 {
        self.field(axis, offset_of!(AxisRecord, home_pause), |r| r.home_pause.into()) as u16
    }
    fn planned(&self, axis: Axis, value: i32) -> i32 {
        let of = if self.by_command() { &scale(1, 1) } else { self.axis_record(axis) };
        converted(of, value, true).expect("the tests' numbers fit")
    }
    fn time(&self) -> i32 {
        self.chip.long("TIME", 0) as i32
    }
    fn set_time(&mut self, ms: i32) {
        self.chip.set_long("TIME", 0, ms as u32);
    }
    fn position(&self, axis: Axis) -> i32 {
        self.chip.long("ACTUAL", 4 * u16::from(axis.n())) as i32
    }
    fn seek_to(&mut self, axis: Axis, steps: i32) -> Progress {
        self.chip.set_long("STEPS", 4 * u16::from(axis.n()), steps as u32);
        self.of_axis("begin_axis", axis, 0);
        Ok(false)
    }
    fn rest_at(&mut self, axis: Axis, steps: i32) -> Progress {
        firmware::rules::coords::settle(self, axis, steps);
        self.of_axis("begin_axis", axis, 0);
        Ok(false)
    }
    fn brake(&mut self, _: Axis) {
        self.chip.call("motion_stop", &[]);
    }
    fn catch(&mut self, axis: Axis) {
        let at = Homes::position(self, axis);
        self.chip.set_long("CAUGHT", 0, at as u32);
        self.of_axis("motion_hit", axis, at);
    }
    fn set_place(&mut self, axis: Axis) {
        let on = Homes::position(self, axis).wrapping_sub(self.chip.long("CAUGHT", 0) as i32);
        let at = self.planned(axis, self.place(axis)).wrapping_add(on);
        self.chip.set_long("ACTUAL", 4 * u16::from(axis.n()), at as u32);
    }
    fn settle_here(&mut self, axis: Axis) {
        firmware::rules::coords::settle_here(self, axis);
    }
    fn asks(&self) -> bool {
        self.chip.byte("EFFECT") == Op::HomeQuery as u8
    }
}

impl Switches for Twin {
    fn reference(&self, n: u8) -> u8 {
        self.chip.board.peek8(PROFILE + offset_of!(BoardRecord, reference) as u16 + u16::from(n))
    }
    fn reference_at(&self, axis: Axis) -> u8 {
        self.reference(axis.n())
    }
    fn unfiltered(&self, n: u8) -> u8 {
        let mut chip = self.chip.clone();
        chip.call("unfiltered", &[(12, n.into())]);
        chip.reg(12) as u8
    }
    fn is_inverted(&self) -> bool {
        self.chip.byte("BITS") & INVERT != 0
    }
    fn moving(&self) -> u8 {
        self.chip.byte("MOVING")
    }
    fn is_moving(&self, axis: Axis) -> bool {
        self.chip.byte("MOVING") & axis.bit() != 0
    }
    fn is_negative(&self, axis: Axis) -> bool {
        self.chip.byte("NEGATIVE") & axis.bit() != 0
    }
    fn homes(&self) -> bool {
        (Op::Home as u8..=Op::HomeQuery as u8).contains(&self.chip.byte("EFFECT"))
    }
    fn side(&self, axis: Axis) -> u8 {
        self.axis_record(axis).flags as u8
    }
    fn forget_home(&mut self, axis: Axis) {
        self.bits_of("HOMED", axis.bit(), 0);
    }
    fn set_fault_input(&mut self, n: u8) {
        self.chip.set_byte("FAULT_IN", n);
    }
    fn halt(&mut self) {
        self.chip.call("motion_halt", &[]);
    }
    fn fail_at_limit(&mut self) {
        self.chip.call("fail", &[(12, Fault::LimitSwitch.number().into())]);
    }
}

/// What a run finds: what RAM is made of, its phase, axis and flags, whether axes move.
#[derive(Clone, Copy, Debug)]
struct Found {
    seed: u64,
    phase: u8,
    n: u8,
    bits: u8,
    moving: u8,
    effect: u8,
    time: u32,
}

impl Found {
    fn put(&self, chip: &mut Chip) {
        let mut random = Rng::new(self.seed);
        for name in ["UM", "STEPS", "OFFSET", "ACTUAL", "CAUGHT"] {
            for n in 0..if name == "CAUGHT" { 1 } else { 3 } {
                chip.set_long(name, 4 * n, (random.bits() as i32 >> 12) as u32);
            }
        }
        for name in ["HOMED", "PLACED", "NEGATIVE"] {
            chip.set_byte(name, random.bits() as u8 & 7);
        }
        let levels = random.bits() as u16;
        chip.set_word("RAW", levels);
        let mut record = BoardRecord::DEFAULT;
        record.flags |= BoardRecord::CHAIN;
        record.reference = [3, 4, 5];
        with_profile(chip, &record);
        chip.set_word("VM_PC", crate::area::AREA + 0x1C0);
        chip.board.poke8(crate::area::AREA + 0x1C0, self.n);
        for (name, byte) in [
            ("PHASE", self.phase),
            ("N", self.n),
            ("BITS", self.bits),
            ("MOVING", self.moving),
            ("EFFECT", self.effect),
        ] {
            chip.set_byte(name, byte);
        }
        chip.set_long("TIME", 0, self.time);
        // As command 106 makes them.
        let first = command(chip);
        for n in (SPEED..WORDS - 2).step_by(2) {
            chip.set_long("POOL", first + 2 * n, random.bits() as u32 % 3000 + 1);
        }
        let at = first - IN_FRONT;
        let flags = random.bits() as u32 & u32::from(AxisRecord::HOME_POSITIVE);
        chip.set_long("POOL", at + offset_of!(AxisRecord, flags) as u16, flags | 1 << 16);
        chip.set_long("POOL", at + offset_of!(AxisRecord, um) as u16, 100 << 16 | 1);
        let rates = at + offset_of!(AxisRecord, home_slow) as u16;
        chip.set_long("POOL", rates, random.bits() as u32 & 0xFF_01FF | 64);
    }
}

fn found() -> impl Strategy<Value = Found> {
    let moving = prop_oneof![Just(0u8), 1u8..8];
    let effect = prop_oneof![Just(0), Op::Home as u8..=Op::HomeQuery as u8, any::<u8>()];
    let bits = (0u8..18, 0u8..4).prop_map(|(input, flags)| input | flags << 6);
    let time = prop_oneof![Just(0), any::<u32>()];
    (any::<u64>(), 1u8..=7, 0u8..3, bits, moving, effect, time).prop_map(
        |(seed, phase, n, bits, moving, effect, time)| Found {
            seed,
            phase,
            n,
            bits,
            moving,
            effect,
            time,
        },
    )
}

#[test]
fn reference_runs_and_limits_are_the_same_by_rustc_and_as_micro_code() {
    let base = OnChip::of(&Chip::new(), &Elf::of("whole"), true);
    let ways = (0u8..8, 1u8..8);
    let start = (found(), any::<bool>(), 0u8..4, ways);
    let result = runner(500).run(&start, |(mut found, first, code, (positive, present))| {
        let mut machine = MachineRecord { ..mill() };
        for (n, axis) in machine.axes.iter_mut().enumerate() {
            let flag = |set: u8, flag| if set >> n & 1 != 0 { flag } else { 0 };
            axis.flags = flag(positive, AxisRecord::HOME_POSITIVE)
                | flag(present | found.seed as u8, AxisRecord::PRESENT);
        }
        let axis = Axis::new(found.n);
        if first {
            // As the loop that calls it leaves it.
            found.phase = home::BEGIN;
        }
        let put = |chip: &mut Chip| found.put(chip);
        let same = |label, entry, rule: &dyn Fn(&mut Twin) -> Option<u32>| {
            proved(&base, label, &machine, &put, &entry, rule);
        };
        let code = Op::Home as u8 + code;
        let run = Entry { acc: code.into(), first, scratch: &[("BYTES", 1)], ..Entry::default() };
        same("fx_home", run, &|m| progress(home::home(m, code, first)));
        let of_axis = Entry { axis: Some(axis), ..Entry::default() };
        same("home_missed", of_axis, &|m| {
            home::missed(m, axis);
            None
        });
        // Z is clear when it is closed.
        same("home_closed", Entry::default(), &|m| Some((!home::closed(m)).into()));
        let of_n = Entry { acc: found.n.into(), ..Entry::default() };
        same("home_by_profile", of_n, &|m| {
            home::by_profile(m, found.n);
            None
        });
        same("limits", Entry { scratch: &[("TEMP", 1)], ..Entry::default() }, &|m| {
            home::limits(m);
            None
        });
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}
