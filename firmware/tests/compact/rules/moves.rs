//! F, S, SetPos and what a program asks for: [`moves`] by rustc and as micro-code.

use emulator::Rng;
use firmware::rules::Axis;
use firmware::rules::coords::Stands;
use firmware::rules::moves::{self, Moves};
use lang::fault::Fault;
use lang::isa::Op;
use proptest::prelude::*;

use super::effects::{progress, unit};
use super::{Entry, Twin, proved, statement};
use crate::chip::Chip;
use crate::coords::{axis, value};
use crate::lockstep::{OnChip, runner};
use crate::machine::mill;
use crate::verify::Elf;
use lang::record::MachineRecord;

impl Twin {
    fn has(&self, name: &str, axis: Axis) -> bool {
        self.chip.byte(name) & axis.bit() != 0
    }
}

impl Moves for Twin {
    fn operand(&mut self) -> u8 {
        self.chip.call("operand_byte", &[]);
        self.chip.reg(12) as u8
    }
    fn pop(&mut self) -> i32 {
        self.chip.call("pop_value", &[]);
        self.chip.result() as i32
    }
    fn push_long(&mut self, value: i32) {
        let [low, high] = [value as u16, (value >> 16) as u16];
        self.chip.call("push_value", &[(12, low), (13, high)]);
    }
    fn set_code(&mut self, code: u8) {
        let at = unit(&self.chip);
        self.chip.board.poke8(at, code);
    }
    fn is_spindle(&self) -> bool {
        self.chip.board.peek8(unit(&self.chip)) == Op::Spindle as u8
    }
    fn is_feed(&self) -> bool {
        self.chip.board.peek8(unit(&self.chip)) == Op::Feed as u8
    }
    fn set_power(&mut self, _: i32) -> Result<(), Fault> {
        Ok(())
    }
    fn set_feed(&mut self, feed: i32) {
        self.chip.set_long("FEED", 0, feed as u32);
    }
    fn must_rest(&self, _: Axis) -> Result<(), Fault> {
        Ok(())
    }
    fn um(&self, axis: Axis) -> i32 {
        self.chip.long("UM", 4 * u16::from(axis.n())) as i32
    }
    fn offset(&self, axis: Axis) -> i32 {
        Stands::offset(self, axis)
    }
    fn set_offset(&mut self, axis: Axis, um: i32) {
        self.chip.set_long("OFFSET", 4 * u16::from(axis.n()), um as u32);
    }
    fn set_placed(&mut self, axis: Axis) {
        self.bits_of("PLACED", 0, axis.bit());
    }
    fn position(&self, axis: Axis) -> i32 {
        Stands::position(self, axis)
    }
    fn probed(&self, axis: Axis) -> i32 {
        self.chip.long("PROBED", 4 * u16::from(axis.n())) as i32
    }
    fn to_um(&self, axis: Axis, steps: i32) -> Option<i32> {
        Stands::to_um(self, axis, steps)
    }
    fn has_probed(&self, axis: Axis) -> bool {
        self.has("PROBE_OK", axis)
    }
    fn is_moving(&self, axis: Axis) -> bool {
        self.has("MOVING", axis)
    }
    fn is_homed(&self, axis: Axis) -> bool {
        self.has("HOMED", axis)
    }
    fn port(&self) -> i32 {
        let mut chip = self.chip.clone();
        chip.call("input", &[(12, 17)]);
        i32::from(chip.reg(12)) << 16 | i32::from(self.chip.word("INPUT"))
    }
    fn timer(&self) -> i32 {
        self.chip.long("TIMER_MS", 0) as i32
    }
    fn char_in(&self) -> u8 {
        self.chip.byte("CHAR_IN")
    }
    fn set_char_in(&mut self, c: u8) {
        self.chip.set_byte("CHAR_IN", c);
    }
}

/// Any state, with two values on the stack.
fn put(chip: &mut Chip, seed: u64, values: [i32; 2], operand: u8) {
    let mut random = Rng::new(seed);
    for name in ["UM", "OFFSET", "ACTUAL", "PROBED"] {
        for n in 0..3 {
            let far = random.bits() & 1 == 0;
            let value = random.bits() as i32;
            chip.set_long(name, 4 * n, if far { value } else { value >> 16 } as u32);
        }
    }
    for name in ["PROBE_OK", "MOVING", "HOMED", "PLACED", "CHAR_IN"] {
        chip.set_byte(name, random.bits() as u8);
    }
    chip.set_word("INPUT", random.bits() as u16);
    chip.set_long("TIMER_MS", 0, random.bits() as u32);
    statement(chip, chip.at("POOL_END"), &values, &[operand]);
}

#[test]
fn feeds_zeros_and_looks_are_the_same_by_rustc_and_as_micro_code() {
    let base = OnChip::of(&Chip::new(), &Elf::of("whole"), true);
    let start = (any::<u64>(), [value(), value()], [axis(), axis(), axis()], 0u8..3, 0u8..10);
    let result = runner(500).run(&start, |(seed, values, axes, n, look)| {
        let machine = MachineRecord { axes, ..mill() };
        let same = |label, operand: u8, acc: u8, rule: &dyn Fn(&mut Twin) -> Option<u32>| {
            let scratch = &[("BYTES", 1), ("TEMP", 4), ("V2", 4)];
            let entry = Entry { acc: acc.into(), scratch, ..Entry::default() };
            let put = |chip: &mut Chip| put(chip, seed, values, operand);
            proved(&base, label, &machine, &put, &entry, rule);
        };
        for code in Op::Feed as u8..=Op::Spindle as u8 {
            same("fx_feed", 0, code, &|m| progress(moves::feed(m, code)));
        }
        let code = Op::SetPosZero as u8 + n;
        same("fx_set_pos_zero", 0, code, &|m| progress(moves::set_pos_zero(m, code)));
        same("fx_set_pos", n, 0, &|m| progress(moves::set_pos(m)));
        same("fx_read", look << 2 | n, 0, &|m| progress(moves::read(m)));
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}
