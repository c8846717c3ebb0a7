//! Lines and single axes of the small chip: [`planner`] by rustc and as micro-code, from rest and in a course.

use emulator::Rng;
use firmware::motion::scaled::Scaled;
use firmware::rules::Axis;
use firmware::rules::planner::{self, Chains, Planner};
use lang::isa::Op;
use lang::record::{AxisRecord, MachineRecord};
use proptest::prelude::*;

use super::pace::paced;
use super::stops::planned;
use super::{Entry, Twin, proved};
use crate::chip::{CLOCK, Chip};
use crate::coords::value;
use crate::line::axis;
use crate::lockstep::{OnChip, runner};
use crate::machine::mill;
use crate::verify::Elf;

/// Bits of MOTION: lines of a course are left; the line ends at speed; it waits for the first segment of the next one.
const COURSE: u8 = 2;
const THROUGH: u8 = 4;
const NEXT: u8 = 8;
/// What a course has of the pool's end, and where in it: changes of the next line's shares, the square at its end, the next
/// entry, lines of the one before.
const COURSE_BYTES: u16 = super::lines::COURSE;
const NEXT_INC: u16 = 8;
const EXIT2: u16 = 20;
const COURSE_AT: u16 = 24;
const COURSE_LINES: u16 = 26;
/// Manner of a motion: a rapid one, a single axis.
const RAPID: u8 = 1;
const LONE: u8 = 0xFF;
/// WATCH: a pin has stopped the steps.
const TRIPPED: u8 = 0xFF;

impl Planner for Twin {
    fn moving(&self) -> u8 {
        self.chip.byte("MOVING")
    }
    fn set_moving(&mut self, axes: u8) {
        self.chip.set_byte("MOVING", axes);
    }
    fn moves(&self, axis: Axis) -> bool {
        self.chip.byte("MOVING") & axis.bit() != 0
    }
    fn stand(&mut self, axis: Axis) {
        self.bits_of("MOVING", axis.bit(), 0);
    }
    fn manner(&self) -> u8 {
        self.chip.byte("HIT")
    }
    fn set_manner(&mut self, manner: u8) {
        self.chip.set_byte("HIT", manner);
    }
    fn hurries(&self) -> bool {
        self.chip.byte("HIT") == RAPID
    }
    fn is_lone(&self) -> bool {
        self.chip.byte("HIT") == LONE
    }
    fn has_tripped(&self) -> bool {
        self.chip.byte("WATCH") == TRIPPED
    }
    fn unwatch(&mut self) {
        self.chip.set_byte("WATCH", 0);
    }
    fn distance(&self, axis: Axis) -> i32 {
        self.at("NEW_STEPS", axis)
    }
    fn set_distance(&mut self, axis: Axis, steps: i32) {
        self.set("NEW_STEPS", axis, steps);
    }
    fn start_of_way(&self, axis: Axis) -> i32 {
        self.at("ACTUAL", axis)
    }
    fn turn(&mut self, axis: Axis, way: i32) {
        self.of_axis("line_direction", axis, way);
    }
    fn left(&self) -> i32 {
        self.chip.long("LEFT", 0) as i32
    }
    fn set_left(&mut self, events: i32) {
        self.chip.set_long("LEFT", 0, events as u32);
    }
    fn feeds_steps(&self) -> bool {
        (self.chip.long("FEED", 0) as i32) < 0
    }
    fn feed(&self) -> i32 {
        self.chip.long("FEED", 0) as i32
    }
    fn tick(&self) -> Scaled {
        self.scaled("TICK")
    }
    fn set_tick(&mut self, length: Scaled) {
        self.set_scaled("TICK", length);
    }
    fn end_speed(&self) -> Scaled {
        self.scaled("V")
    }
    fn set_end_speed(&mut self, speed: Scaled) {
        self.set_scaled("V", speed);
    }
    fn least_start(&mut self, speed: Scaled) {
        self.set_scaled("V", self.scaled("V").least(speed));
    }
    fn start_rate(&self, axis: Axis) -> u16 {
        self.axis_record(axis).start_rate
    }
    fn pace_down(&self) -> Scaled {
        Scaled(self.chip.long("TEMP", 8))
    }
    fn share_of(&self, steps: i32) -> i32 {
        let mut chip = self.chip.clone();
        chip.call("line_fraction", &[(12, steps as u16), (13, (steps >> 16) as u16)]);
        chip.result() as i32
    }
    fn share(&self, axis: Axis) -> i32 {
        self.at("INC", axis)
    }
    fn set_share(&mut self, axis: Axis, share: i32) {
        self.set("INC", axis, share);
    }
    fn begin_axis(&mut self, axis: Axis) {
        self.of_axis("line_origin", axis, 0);
    }
    fn limit(&self) -> Scaled {
        self.scaled("CAUGHT")
    }
    fn set_limit(&mut self, speed: Scaled) {
        self.set_scaled("CAUGHT", speed);
    }
    fn set_accel2(&mut self, growth: Scaled) {
        self.set_scaled("ACCEL2", growth);
    }
    fn set_decel2(&mut self, decline: Scaled) {
        self.set_scaled("DECEL2", decline);
    }
    fn decel2(&self) -> Scaled {
        self.scaled("DECEL2")
    }
    fn nominal2(&self) -> Scaled {
        self.scaled("NOMINAL2")
    }
    fn set_nominal2(&mut self, square: Scaled) {
        self.set_scaled("NOMINAL2", square);
    }
    fn start2(&self) -> Scaled {
        self.scaled("START2")
    }
    fn set_start2(&mut self, square: Scaled) {
        self.set_scaled("START2", square);
    }
    fn least_start2(&mut self, square: Scaled) {
        self.set_scaled("START2", self.scaled("START2").least(square));
    }
    fn end_speed2(&self) -> Scaled {
        self.scaled("V2")
    }
    fn set_end_speed2(&mut self, square: Scaled) {
        self.set_scaled("V2", square);
    }
    fn clock(&self) -> Scaled {
        CLOCK
    }
    fn effect(&self) -> u8 {
        self.chip.byte("EFFECT")
    }
    fn axis(&self) -> Axis {
        Axis::new(self.chip.byte("N"))
    }
    fn override_of_feeds(&self) -> u8 {
        self.chip.byte("OVERRIDE")
    }
    fn override_of_rapids(&self) -> u8 {
        self.chip.board.peek8(self.chip.at("OVERRIDE") + 1)
    }
    fn rests(&self) -> bool {
        firmware::rules::stops::Stops::rests(self)
    }
    fn goes_down(&self, axis: Axis) -> bool {
        self.chip.byte("NEGATIVE") & axis.bit() != 0
    }
}

impl Chains for Twin {
    fn follows(&self) -> bool {
        self.chip.byte("MOTION") & NEXT != 0
    }
    fn change_of(&self, axis: Axis, share: i32) -> i32 {
        share ^ self.at("INC", axis)
    }
    fn set_change(&mut self, axis: Axis, change: i32) {
        let at = self.course() + NEXT_INC + 4 * u16::from(axis.n());
        self.set_long_at(at, change);
    }
    fn end_at_rest(&mut self) {
        self.bits_of("MOTION", THROUGH, 0);
    }
    fn end_at_speed(&mut self) {
        self.bits_of("MOTION", 0, THROUGH);
    }
    fn is_in_course(&self) -> bool {
        self.chip.byte("MOTION") & COURSE != 0
    }
    fn exit2(&self) -> Scaled {
        let at = self.course() + EXIT2;
        let words = [0, 2].map(|half| u32::from(self.chip.board.peek16(at + half)));
        Scaled(words[1] << 16 | words[0])
    }
    fn next_exit(&mut self, fallen: Scaled) {
        self.calls("course_line", fallen.0);
        let joined = self.chip.byte("JOINED");
        self.chip.set_byte("JOINS", joined);
    }
}

/// A motion of which all matters that is planned: where axes stand and go to, how, and what is left of the one before.
#[derive(Clone, Debug)]
struct Found {
    seed: u64,
    here: [i32; 3],
    there: [i32; 3],
    manner: u8,
    motion: u8,
    effect: u8,
    n: u8,
    feed: i32,
}

impl Found {
    fn put(&self, chip: &mut Chip) {
        let mut random = Rng::new(self.seed);
        for name in ["V2", "V", "CAUGHT", "ACCEL2", "DECEL2", "NOMINAL2", "START2", "TICK"] {
            let number = planned(&mut random);
            chip.set_long(name, 0, number.0);
        }
        for (at, down) in [(0, 40), (4, 40), (8, 40)] {
            let number = Scaled::new(random.bits() as u32 | 1 << 31).shifted(10 - down);
            chip.set_long("TEMP", at, number.0);
        }
        for n in 0..3 {
            chip.set_long("ACTUAL", 4 * n, self.here[usize::from(n)] as u32);
            chip.set_long("STEPS", 4 * n, self.there[usize::from(n)] as u32);
            chip.set_long("INC", 4 * n, random.bits() as u32);
        }
        chip.set_long("LEFT", 0, random.bits() as u32 >> 8 | 1);
        chip.set_long("FEED", 0, self.feed as u32);
        let course = chip.at("POOL_END") - COURSE_BYTES;
        for at in (course..course + COURSE_BYTES).step_by(2) {
            chip.board.poke16(at, random.bits() as u16);
        }
        let exit2 = if random.bits() & 3 == 0 { 0 } else { planned(&mut random).0 };
        chip.board.poke16(course + EXIT2, exit2 as u16);
        chip.board.poke16(course + EXIT2 + 2, (exit2 >> 16) as u16);
        // Slow points may lie anywhere: where the machine's record is.
        let at = chip.word("VM_CODE") - 60;
        chip.board.poke16(course + COURSE_AT, at);
        chip.board.poke16(course + COURSE_LINES, random.bits() as u16 & 7);
        let tripped = random.bits() & 3 == 0;
        chip.set_byte("WATCH", if tripped { TRIPPED } else { random.bits() as u8 & 0x7F });
        chip.set_byte("HIT", self.manner);
        chip.set_byte("MOVING", random.bits() as u8 & 7);
        chip.set_byte("NEGATIVE", random.bits() as u8 & 7);
        chip.set_byte("MOTION", self.motion);
        chip.set_byte("EFFECT", self.effect);
        chip.set_byte("N", self.n);
        let percents = chip.at("OVERRIDE");
        chip.board.poke8(percents, 10 + (random.bits() % 191) as u8);
        chip.board.poke8(percents + 1, 10 + (random.bits() % 91) as u8);
    }
}

fn found() -> impl Strategy<Value = Found> {
    let place = || prop_oneof![6 => -20_000..20_000, 2 => Just(0), 1 => value()];
    let places = || [place(), place(), place()];
    let effects = prop_oneof![
        Just(Op::Move as u8),
        Op::Home as u8 - 1..=Op::HomeQuery as u8 + 1,
        any::<u8>()
    ];
    let manner = prop_oneof![Just(0u8), Just(RAPID), Just(LONE)];
    let feed = prop_oneof![Just(0), 1..200_000, -50_000..0, value()];
    let bytes = (manner, any::<u8>(), effects, 0u8..3, feed);
    (any::<u64>(), places(), places(), bytes).prop_map(
        |(seed, here, there, (manner, motion, effect, n, feed))| Found {
            seed,
            here,
            there,
            manner,
            motion,
            effect,
            n,
            feed,
        },
    )
}

/// An axis as machines have them, or with any rates and ramps.
fn axes() -> impl Strategy<Value = [AxisRecord; 3]> {
    let one = || prop_oneof![axis(), paced()];
    [one(), one(), one()]
}

/// A rule by which axes set off.
type Begins = fn(&mut Twin, u8);

#[test]
fn plans_are_the_same_by_rustc_and_as_micro_code() {
    let base = OnChip::of(&Chip::new(), &Elf::of("whole"), true);
    let start = (found(), axes(), 0u8..8, any::<i32>());
    let result = runner(1_500).run(&start, |(found, axes, mask, number)| {
        let machine = MachineRecord { axes, ..mill() };
        let put = |chip: &mut Chip| found.put(chip);
        let same = |label, acc: u32, rule: &dyn Fn(&mut Twin) -> Option<u32>| {
            let scratch = &[("TEMP", 4)];
            let entry = Entry { acc, scratch, ..Entry::default() };
            proved(&base, label, &machine, &put, &entry, rule);
        };
        let begins: [(&str, Begins); 3] = [
            ("line_begin", planner::line),
            ("line_rapid", planner::rapid),
            ("axis_begin", planner::single),
        ];
        for (label, rule) in begins {
            let mask = if label == "axis_begin" { 1 << found.n } else { mask };
            same(label, mask.into(), &|m| {
                rule(m, mask);
                None
            });
        }
        same("motion_nominal", 0, &|m| {
            planner::nominal(m);
            None
        });
        for axis in Axis::UP {
            same("motion_speed", axis.n().into(), &|m| Some(planner::speed(m, axis) as u32));
        }
        let number = Scaled::new(number.unsigned_abs() | 1);
        same("rounded", number.0, &|m| Some(planner::rounded(m, number) as u32));
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}
