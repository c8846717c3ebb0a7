//! Probing: [`probe`] by rustc and as micro-code, in any phase, at any inputs.

use emulator::Rng;
use firmware::motion::scaled::Scaled;
use firmware::rules::Axis;
use firmware::rules::coords;
use firmware::rules::effects::Effects;
use firmware::rules::probe::{self, Probes, Watches};
use lang::fault::Fault;
use lang::isa::flags;
use lang::record::{AxisRecord, BoardRecord, MachineRecord};
use proptest::prelude::*;

use super::commands::{FLAGS, RAMPS};
use super::effects::progress;
use super::{Entry, Twin, proved, statement, with_profile};
use crate::chip::Chip;
use crate::coords::{axis, value};
use crate::lockstep::{OnChip, runner};
use crate::machine::mill;
use crate::verify::Elf;

/// Bits of BITS: input 17 counts.
const COUNTS_17: u8 = 1;
/// The pin of input 17.
const WATCHES_17: u8 = 1 << 4;
/// Bit of IDLE: the step that is caught is the last.
const ENDS: u8 = 1;

impl Probes for Twin {
    fn comes_later(&mut self, _: Axis) -> bool {
        false
    }
    fn take_sensor(&mut self) {
        let bits = self.operand();
        self.set_statement_byte(RAMPS, bits);
    }
    fn has_masks(&self) -> bool {
        self.statement_byte(RAMPS) & flags::MASK != 0
    }
    fn has_sensor(&self) -> bool {
        self.statement_byte(RAMPS) & flags::SENSOR != 0
    }
    fn sensor(&self) -> u8 {
        self.board_record().probe
    }
    fn await_off(&mut self, inputs: i32) {
        self.calls("probe_xor", inputs as u32);
        self.off = self.chip.reg(7);
    }
    fn await_of(&mut self, inputs: i32) {
        let high = (inputs >> 16) as u16;
        self.chip.call("probe_and", &[(12, inputs as u16), (13, high), (7, self.off)]);
    }
    fn await_input(&mut self, n: u8) {
        self.calls("probe_input", n.into());
    }
    fn begin_probe(&mut self, axis: Axis) -> bool {
        self.of_axis("probe_begin", axis, 0);
        self.chip.reg(2) & 2 != 0
    }
    fn moving_of(&self, _: Axis) -> u8 {
        self.chip.byte("MOVING")
    }
    fn axis(&self) -> Axis {
        Axis::new(self.chip.byte("N"))
    }
    fn has_speed(&self) -> bool {
        self.statement_byte(FLAGS) & flags::SPEED != 0
    }
    fn feed(&self) -> i32 {
        self.chip.long("FEED", 0) as i32
    }
    fn take_frame(&mut self) {
        let frame = self.statement_byte(FLAGS) & 0x1C;
        self.chip.set_byte("FRAME_OF", frame);
    }
    fn aim_at(&mut self, axis: Axis, limit: i32) -> Result<(), Fault> {
        coords::aim(self, axis, limit)
    }
    fn phase(&self) -> u8 {
        self.chip.byte("PHASE")
    }
    fn set_phase(&mut self, phase: u8) {
        self.chip.set_byte("PHASE", phase);
    }
    fn next_phase(&mut self) {
        let phase = self.chip.byte("PHASE");
        self.chip.set_byte("PHASE", phase.wrapping_add(1));
    }
    fn hit(&self) -> u8 {
        self.chip.byte("HIT")
    }
    fn caught(&mut self, axis: Axis) -> i32 {
        self.of_axis("motion_caught", axis, 0);
        self.chip.result() as i32
    }
    fn answers(&self) -> bool {
        let mut chip = self.chip.clone();
        chip.call("probe_answers", &[]);
        chip.reg(2) & 2 == 0
    }
    fn probed(&self, axis: Axis) -> i32 {
        self.chip.long("PROBED", 4 * u16::from(axis.n())) as i32
    }
    fn set_probed(&mut self, axis: Axis, steps: i32) {
        self.chip.set_long("PROBED", 4 * u16::from(axis.n()), steps as u32);
    }
    fn set_answered(&mut self, axis: Axis) {
        self.bits_of("PROBE_OK", 0, axis.bit());
    }
    fn brake_from(&mut self, axis: Axis, steps: i32) {
        self.of_axis("motion_hit", axis, steps);
    }
    fn watch_nothing(&mut self) {}
    fn is_asked(&self) -> bool {
        self.bits() & flags::QUERY != 0
    }
}

impl Watches for Twin {
    fn forget_answer(&mut self, axis: Axis) {
        self.bits_of("PROBE_OK", axis.bit(), 0);
    }
    fn set_off(&mut self, axis: Axis) {
        coords::command(self, axis);
        self.of_axis("begin_axis", axis, 0);
    }
    fn set_hit(&mut self, hit: u8) {
        self.chip.set_byte("HIT", hit);
    }
    fn pins(&mut self) -> u8 {
        self.calls("probe_pins", 0) as u8
    }
    fn watch(&mut self, pins: u8) {
        self.chip.set_byte("WATCH", pins);
    }
    fn is_chained(&self) -> bool {
        self.board_record().flags & BoardRecord::CHAIN != 0
    }
    fn counting(&self) -> u16 {
        self.chip.word("TIME")
    }
    fn counts_17(&self) -> bool {
        self.bits() & COUNTS_17 != 0
    }
    fn watch_17(&mut self) {
        self.chip.set_byte("WATCH", WATCHES_17);
    }
    fn end_there(&mut self) {
        self.bits_of("IDLE", 0, ENDS);
    }
    fn go_on_there(&mut self) {
        self.bits_of("IDLE", ENDS, 0);
    }
    fn is_faster_than_start(&self) -> bool {
        let [start, nominal] = ["START2", "NOMINAL2"].map(|name| self.chip.long(name, 0) as i32);
        start.wrapping_sub(nominal) < 0
    }
}

/// What a probe finds.
#[derive(Clone, Copy, Debug)]
struct Found {
    seed: u64,
    /// Its operands: flags, and of what it waits for.
    operands: [u8; 2],
    /// Values on the stack.
    values: [i32; 4],
    feed: i32,
    phase: u8,
    /// Axes that move, pins that answered.
    bytes: [u8; 2],
    n: u8,
}

impl Found {
    fn put(&self, chip: &mut Chip) {
        let mut random = Rng::new(self.seed);
        for name in ["UM", "STEPS", "OFFSET", "ACTUAL", "PROBED"] {
            for n in 0..3 {
                chip.set_long(name, 4 * n, (random.bits() as i32 >> 14) as u32);
            }
        }
        for name in ["HOMED", "PLACED", "NEGATIVE", "PROBE_OK"] {
            chip.set_byte(name, random.bits() as u8 & 7);
        }
        let mut record = BoardRecord::DEFAULT;
        if random.bits() & 1 == 0 {
            record.flags |= BoardRecord::CHAIN;
        }
        record.probe = random.bits() as u8 % 18;
        with_profile(chip, &record);
        statement(chip, chip.at("POOL_END"), &self.values, &self.operands);
        chip.set_word("OVERRIDE", 0x6464);
        chip.set_word("CAUGHT", random.bits() as u16);
        // Often none answers.
        let levels = if random.bits() & 3 == 0 { random.bits() as u16 } else { 0 };
        chip.set_word("RAW", levels);
        chip.set_long("FEED", 0, self.feed as u32);
        let bits = random.bits() as u8 & 7 | random.bits() as u8 & flags::QUERY;
        let names = ["PHASE", "MOVING", "HIT", "N", "BITS"];
        let bytes = [self.phase, self.bytes[0], self.bytes[1], self.n, bits];
        for (name, byte) in names.into_iter().zip(bytes) {
            chip.set_byte(name, byte);
        }
        chip.set_byte("TRACING", if random.bits() & 1 == 0 { *crate::rig::T_ON } else { 0 });
        chip.set_long("TIME", 0, random.bits() as u32 & 0xF_000F);
        for (name, at) in [("TEMP", 0), ("TEMP", 4), ("TEMP", 8)] {
            chip.set_long(name, at, Scaled::new(random.bits() as u32 % 20_000 + 1).0);
        }
        // Flags of a statement that begins by a command.
        chip.set_byte("BYTES", random.bits() as u8 & flags::QUERY | self.n);
    }
}

fn found() -> impl Strategy<Value = Found> {
    let masks = prop_oneof![Just(flags::MASK), Just(flags::SENSOR), Just(0)];
    let rate = || prop_oneof![8 => 1..20_000, 1 => Just(0), 1 => value()];
    let values = (0..18i32, rate(), -50_000..50_000, value());
    let moving = prop_oneof![2 => Just(0u8), 1 => 1u8..8];
    let hit = prop_oneof![2 => Just(0u8), 1 => 1u8..=255];
    let bytes = (moving, hit).prop_map(|(moving, hit)| [moving, hit]);
    let feed = prop_oneof![4 => 1..20_000, 2 => -20_000..0, 1 => Just(0)];
    (any::<u64>(), any::<u8>(), masks, values, feed, 1u8..4, bytes, 0u8..3).prop_map(
        |(seed, bits, masks, (a, b, c, d), feed, phase, bytes, n)| {
            let values = [a, b, c, d];
            let operands = [bits & !flags::AXIS | n, masks];
            Found { seed, operands, values, feed, phase, bytes, n }
        },
    )
}

#[test]
fn probes_are_the_same_by_rustc_and_as_micro_code() {
    let base = OnChip::of(&Chip::new(), &Elf::of("whole"), true);
    let start = (found(), any::<bool>(), [axis(), axis(), axis()], any::<bool>());
    let result = runner(1_000).run(&start, |(mut found, first, axes, wide)| {
        let mut machine = MachineRecord { ..mill() };
        if wide {
            machine.axes = axes;
        }
        machine.axes[usize::from(found.n)].flags |= AxisRecord::PRESENT;
        let axis = Axis::new(found.n);
        if first {
            // As the loop that calls it leaves it.
            found.phase = probe::MOVES;
            found.bytes[0] = 0;
        }
        let put = |chip: &mut Chip| found.put(chip);
        let same = |label, entry, rule: &dyn Fn(&mut Twin) -> Option<u32>| {
            proved(&base, label, &machine, &put, &entry, rule);
        };
        let run = Entry { first, ..Entry::default() };
        same("fx_probe", run, &|m| progress(probe::probe(m, first)));
        let of_axis = Entry { axis: Some(axis), ..Entry::default() };
        same("probe_begin", of_axis, &|m| Some(probe::begin(m, axis).into()));
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}
