//! G0 and G1: [`lines`] by rustc and as micro-code, from rest and in a course.

use emulator::Rng;
use firmware::rules::lines::{self, Courses, Lines, Together};
use firmware::rules::{Axis, coords};
use lang::fault::Fault;
use lang::isa::{Op, SHORT_AXES, flags};
use lang::record::{AxisRecord, MachineRecord};
use lang::wire::TraceKind;
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

/// Bits of MOTION: a line ends at speed; it waits for the first segment of the next one.
const THROUGH: u8 = 4;
const NEXT: u8 = 8;
/// What a course has of the pool's end.
pub const COURSE: u16 = 28;

impl Twin {
    /// Where a course has its part of the pool.
    pub fn course(&self) -> u16 {
        self.chip.at("POOL_END") - COURSE
    }

    /// Writes 32 bits at an address.
    pub fn set_long_at(&mut self, at: u16, value: i32) {
        self.chip.board.poke16(at, value as u16);
        self.chip.board.poke16(at + 2, (value >> 16) as u16);
    }
}

impl Together for Twin {
    fn is_named(&self, axis: Axis) -> bool {
        self.statement_byte(FLAGS) & axis.bit() != 0
    }
    fn command_place(&mut self, axis: Axis) -> bool {
        coords::command(self, axis)
    }
    fn going(&self) -> u8 {
        self.statement_byte(RAMPS)
    }
    fn set_going(&mut self, axes: u8) {
        self.set_statement_byte(RAMPS, axes);
    }
    fn add_going(&mut self, axis: Axis) {
        self.set_going(self.going() | axis.bit());
    }
    fn remove_going(&mut self, axis: Axis) {
        self.set_going(self.going() & !axis.bit());
    }
}

impl Lines for Twin {
    fn has_to_wait(&mut self) -> bool {
        false
    }
    fn operand(&mut self) -> u8 {
        firmware::rules::effects::Effects::operand(self)
    }
    fn pop(&mut self) -> i32 {
        firmware::rules::effects::Effects::pop(self)
    }
    fn set_code(&mut self, code: u8) {
        let at = unit(&self.chip);
        self.chip.board.poke8(at, code);
    }
    fn is_mixed(&self) -> bool {
        self.chip.board.peek8(unit(&self.chip)) == Op::LinearMixed as u8
    }
    fn short_flags(&self, code: u8) -> u8 {
        let n = usize::from(code - Op::Rapid as u8);
        let rapid = if n < SHORT_AXES.len() { flags::RAPID } else { 0 };
        SHORT_AXES[n % SHORT_AXES.len()].0 | rapid
    }
    fn keep_flags(&mut self, flags: u8) {
        self.set_statement_byte(FLAGS, flags);
    }
    fn take_frames(&mut self, flags: u8) {
        let frames = firmware::rules::effects::Effects::operand(self);
        let frame = |n: u8| (frames >> (2 * n) & 3) << 3 | (flags >> (5 + n) & 1) << 2;
        self.frames = (0..3).map(frame).collect();
    }
    fn next_frame(&mut self) {
        let frame = self.frames.pop().expect("a word for each axis");
        self.chip.set_byte("FRAME_OF", frame);
    }
    fn take_frame_of_all(&mut self) {
        let frame = self.statement_byte(FLAGS) >> 3 & 0x1C;
        self.chip.set_byte("FRAME_OF", frame);
    }
    fn aim_word(&mut self, axis: Axis, target: i32) -> Result<(), Fault> {
        coords::aim(self, axis, target)
    }
    fn is_rapid(&self) -> bool {
        self.statement_byte(FLAGS) & flags::RAPID != 0
    }
    fn tell_way(&mut self, kind: TraceKind, value: i32) {
        self.does("DO_micro_event", &[kind as u8], value as u32);
    }
    fn begin_line(&mut self, axes: u8) {
        self.calls("line_begin", axes.into());
    }
    fn begin_rapid(&mut self, axes: u8) {
        self.calls("line_rapid", axes.into());
    }
    fn second(&self) -> u8 {
        self.chip.byte("N")
    }
    fn set_second(&mut self, axes: u8) {
        self.chip.set_byte("N", axes);
    }
    fn wants_z_apart(&self) -> bool {
        self.machine.flags & MachineRecord::RAPID_Z_APART != 0
    }
    fn side(&self, axis: Axis) -> u8 {
        self.axis_record(axis).flags as u8
    }
    fn way_of(&self, axis: Axis) -> i32 {
        self.end_of_line(axis).wrapping_sub(coords::Stands::position(self, axis))
    }
    fn moving(&self) -> u8 {
        self.chip.byte("MOVING")
    }
    fn is_taken(&self) -> bool {
        false
    }
}

impl Courses for Twin {
    fn is_under_way(&self) -> bool {
        self.chip.byte("MOVING") & 7 != 0
    }
    fn follow(&mut self) {
        self.bits_of("MOTION", 0, NEXT);
    }
    fn set_next_directions(&mut self, none: i32) {
        self.set_long_at(self.course(), none);
    }
    fn set_next_counts(&mut self, none: i32) {
        self.set_long_at(self.course() + 4, none);
    }
    fn end_of_line(&self, axis: Axis) -> i32 {
        coords::Stands::steps(self, axis)
    }
    fn set_start_of_line(&mut self, axis: Axis, steps: i32) {
        self.chip.set_long("ACTUAL", 4 * u16::from(axis.n()), steps as u32);
    }
    fn left(&self) -> i32 {
        self.chip.long("LEFT", 0) as i32
    }
    fn set_left(&mut self, events: i32) {
        self.chip.set_long("LEFT", 0, events as u32);
    }
    fn make_segments(&mut self) {
        self.calls("motion_poll", 0);
    }
    fn ends_at_speed(&self) -> bool {
        self.chip.byte("MOTION") & THROUGH != 0
    }
    fn waits_to_begin(&self) -> bool {
        self.chip.byte("MOTION") & NEXT != 0
    }
}

/// What a line finds.
#[derive(Clone, Debug)]
struct Found {
    seed: u64,
    /// Its operands: flags, and frames of its words.
    operands: [u8; 2],
    /// Values on the stack.
    values: [i32; 3],
    /// Axes that move, how the motion goes on, axes of a second line.
    bytes: [u8; 3],
    /// Nothing, much or little is left.
    left: u32,
}

impl Found {
    fn put(&self, chip: &mut Chip, places: [[i32; 3]; 4]) {
        let mut random = Rng::new(self.seed);
        for (name, places) in ["UM", "STEPS", "OFFSET", "ACTUAL"].into_iter().zip(places) {
            for (n, place) in (0..).zip(places) {
                chip.set_long(name, 4 * n, place as u32);
            }
        }
        for name in ["HOMED", "PLACED", "NEGATIVE", "PHASE"] {
            chip.set_byte(name, random.bits() as u8 & 7);
        }
        for (name, byte) in ["MOVING", "MOTION", "N"].into_iter().zip(self.bytes) {
            chip.set_byte(name, byte);
        }
        chip.set_long("BYTES", 0, random.bits() as u32);
        chip.set_long("LEFT", 0, self.left);
        let feeds = [0, 500, 50_000, -2_000, random.bits() as i32];
        chip.set_long("FEED", 0, feeds[(random.bits() % 5) as usize] as u32);
        // A course has the end of the pool.
        let end = chip.at("POOL_END") - COURSE;
        // Its directions, counts and increments of the next line, and how fast the line may end.
        for at in (end..end + 24).step_by(2) {
            chip.board.poke16(at, random.bits() as u16);
        }
        statement(chip, end, &self.values, &self.operands);
        chip.set_byte("TRACING", if random.bits() & 1 == 0 { *crate::rig::T_ON } else { 0 });
    }
}

fn found() -> impl Strategy<Value = Found> {
    let number = || prop_oneof![6 => -20_000..20_000, 1 => Just(0), 1 => value()];
    let moving = prop_oneof![2 => Just(0u8), 1 => 1u8..8];
    let second = prop_oneof![Just(0u8), 1u8..8];
    let bytes = (moving, 0u8..128, second).prop_map(|(a, b, c)| [a, b, c]);
    let left = prop_oneof![Just(0u32), 1..100_000u32];
    (any::<u64>(), any::<[u8; 2]>(), [number(), number(), number()], bytes, left).prop_map(
        |(seed, operands, values, bytes, left)| Found { seed, operands, values, bytes, left },
    )
}

/// Places from each of which others are often not far away.
fn places() -> impl Strategy<Value = [[i32; 3]; 4]> {
    let place = || prop_oneof![6 => -20_000..20_000, 1 => Just(0), 1 => value()];
    let all = || [place(), place(), place()];
    [all(), all(), all(), all()]
}

/// A machine whose axes are there more often than not.
fn axes() -> impl Strategy<Value = [AxisRecord; 3]> {
    let there = || {
        (paced(), 0u8..8, any::<bool>()).prop_map(|(mut axis, absent, positive)| {
            axis.flags = if absent == 0 { 0 } else { AxisRecord::PRESENT };
            axis.flags |= if positive { AxisRecord::HOME_POSITIVE } else { 0 };
            axis
        })
    };
    [there(), there(), there()]
}

#[test]
fn lines_are_the_same_by_rustc_and_as_micro_code() {
    let base = OnChip::of(&Chip::new(), &Elf::of("whole"), true);
    let start = (found(), places(), axes(), 0u8..4, any::<bool>());
    let result = runner(600).run(&start, |(found, places, axes, wants, first)| {
        let apart = if wants & 1 != 0 { MachineRecord::RAPID_Z_APART } else { 0 };
        let homes = if wants == 2 { MachineRecord::REQUIRE_HOMING } else { 0 };
        let machine = MachineRecord { axes, flags: apart | homes, ..mill() };
        let put = |chip: &mut Chip| found.put(chip, places);
        let same = |label, code: u8, rule: &dyn Fn(&mut Twin) -> Option<u32>| {
            let entry = Entry { acc: code.into(), first, ..Entry::default() };
            proved(&base, label, &machine, &put, &entry, rule);
        };
        for code in Op::Linear as u8..Op::MoveTo as u8 {
            same("fx_linear", code, &|m| progress(lines::linear(m, code, first)));
        }
        same("command_axes", 0, &|m| {
            lines::command_axes(m);
            None
        });
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}
