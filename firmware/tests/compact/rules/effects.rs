//! Statements that move nothing: [`effects`] by rustc and as micro-code, called for the first time or again.

use emulator::Rng;
use firmware::rules::Progress;
use firmware::rules::effects::{self, Effects};
use lang::fault::Fault;
use lang::isa::{first, flags, last};
use lang::record::BoardRecord;
use lang::wire::TraceKind;
use proptest::prelude::*;
use std::ops::RangeInclusive;

use super::{Entry, Twin, proved, statement, with_profile};
use crate::chip::Chip;
use crate::lockstep::{OnChip, runner};
use crate::machine::mill;
use crate::rig::PROFILE;
use crate::verify::Elf;

/// Where code of one operation stands, at an odd place.
const CODE: u16 = crate::area::AREA + 0x1E1;
/// Bits of RUN_FLAGS.
const WAITING: u8 = 1;
const TIMED_OUT: u8 = 4;

/// The third of the bytes of a statement.
pub fn unit(chip: &Chip) -> u16 {
    chip.at("BYTES") + 2
}

impl Twin {
    /// Runs one operation of micro-code on the chip: its number is that of the symbol `DO_..`.
    pub fn does(&mut self, name: &str, bytes: &[u8], acc: u32) -> u32 {
        let ops = [&[self.chip.at(name) as u8], bytes, &[self.chip.at("DO_micro_return") as u8]];
        for (at, byte) in (CODE..).zip(ops.concat()) {
            self.chip.board.poke8(at, byte);
        }
        self.chip.call_at(CODE, name, &[(12, acc as u16), (13, (acc >> 16) as u16)]);
        self.chip.result()
    }

    /// Changes the bits of a byte.
    pub fn bits_of(&mut self, name: &str, off: u8, on: u8) {
        let byte = self.chip.byte(name) & !off | on;
        self.chip.set_byte(name, byte);
    }

    /// The board's profile.
    pub fn board_record(&self) -> BoardRecord {
        let byte = |at| self.chip.board.peek8(PROFILE + at as u16);
        BoardRecord::from_bytes(&std::array::from_fn(byte))
    }
}

impl Effects for Twin {
    fn operand(&mut self) -> u8 {
        self.chip.call("operand_byte", &[]);
        self.chip.reg(12) as u8
    }
    fn pop(&mut self) -> i32 {
        self.chip.call("pop_value", &[]);
        self.chip.result() as i32
    }
    fn pop_number(&mut self, least: u8, most: u8) -> Result<u8, Fault> {
        let n = self.pop();
        if n < least.into() || n > most.into() { Err(Fault::ValueRange) } else { Ok(n as u8) }
    }
    fn pop_input(&mut self) -> Result<u8, Fault> {
        self.pop_number(1, 17)
    }
    fn pop_time(&mut self) -> Result<i32, Fault> {
        let time = self.pop();
        self.chip.set_long("TIME", 0, time as u32);
        if time < 0 { Err(Fault::ValueRange) } else { Ok(time) }
    }
    fn pop_level(&mut self) {
        let level = u8::from(self.pop() != 0);
        self.set_level(level);
    }
    fn push(&mut self, value: u8) {
        self.chip.call("push_small", &[(12, value.into())]);
    }
    fn is_over(&self) -> bool {
        self.chip.long("TIME", 0) == 0
    }
    fn begin_wait(&mut self) -> Result<(), Fault> {
        let bits = self.operand();
        self.set_bits(bits);
        self.chip.set_long("TIME", 0, u32::MAX);
        if bits & flags::TIMEOUT != 0 {
            self.pop_time()?;
        }
        Ok(())
    }
    fn level(&self) -> u8 {
        self.chip.board.peek8(unit(&self.chip))
    }
    fn set_level(&mut self, level: u8) {
        let at = unit(&self.chip);
        self.chip.board.poke8(at, level);
    }
    fn number(&self) -> u8 {
        self.chip.byte("N")
    }
    fn set_number(&mut self, n: u8) {
        self.chip.set_byte("N", n);
    }
    fn next_number(&mut self) {
        self.set_number(self.number() + 1);
    }
    fn bits(&self) -> u8 {
        self.chip.byte("BITS")
    }
    fn set_bits(&mut self, bits: u8) {
        self.chip.set_byte("BITS", bits);
    }
    fn has_level(&self) -> bool {
        self.bits() & flags::LEVEL != 0
    }
    fn has_input(&self) -> bool {
        self.bits() & flags::INPUT_ON_STACK != 0
    }
    fn is_query(&self) -> bool {
        self.bits() & flags::WAIT_QUERY != 0
    }
    fn wants_edge(&self) -> bool {
        self.bits() & 2 != 0
    }
    fn forget_edge(&mut self) {
        self.bits_of("BITS", 2, 0);
    }
    fn want_level(&mut self) {
        self.bits_of("BITS", 3, self.level());
    }
    fn input(&self, n: u8) -> u8 {
        let mut chip = self.chip.clone();
        chip.call("input", &[(12, n.into())]);
        chip.reg(12) as u8
    }
    fn output(&self, n: u8) -> u8 {
        let mut chip = self.chip.clone();
        chip.call("output", &[(12, n.into())]);
        chip.reg(12) as u8
    }
    fn drive(&mut self, n: u8) -> bool {
        let level = self.level() & 1;
        self.chip.call("set_output", &[(12, n.into()), (13, level.into())]);
        self.chip.reg(2) & 2 == 0
    }
    fn enable(&self) -> u8 {
        self.board_record().enable
    }
    fn lamp(&self) -> u8 {
        self.board_record().lamp
    }
    fn tells(&self) -> bool {
        self.chip.byte("TRACING") & *crate::rig::T_FULL != 0
    }
    fn was_told(&self) -> bool {
        false
    }
    fn tell(&mut self, kind: TraceKind, value: i32) {
        self.does("DO_micro_event", &[kind as u8], value as u32);
    }
    fn tell_met(&mut self, kind: TraceKind, value: i32) {
        self.does("DO_micro_event_ok", &[kind as u8], value as u32);
    }
    fn has_timed_out(&self) -> bool {
        self.chip.byte("RUN_FLAGS") & TIMED_OUT != 0
    }
    fn set_timed_out(&mut self) {
        self.bits_of("RUN_FLAGS", 0, TIMED_OUT);
    }
    fn set_in_time(&mut self) {
        self.bits_of("RUN_FLAGS", TIMED_OUT, 0);
    }
    fn char_in(&self) -> u8 {
        self.chip.byte("CHAR_IN")
    }
    fn set_char_in(&mut self, c: u8) {
        self.chip.set_byte("CHAR_IN", c);
    }
    fn send(&mut self, c: u8) {
        let count = (self.chip.word("CHAR_OUT") >> 8) as u8;
        self.chip.set_word("CHAR_OUT", u16::from_le_bytes([c, count.wrapping_add(1)]));
    }
    fn await_start(&mut self) {
        self.bits_of("RUN_FLAGS", 0, WAITING);
    }
    fn awaits_start(&mut self) -> bool {
        self.chip.byte("RUN_FLAGS") & WAITING != 0
    }
}

/// r12 of a statement.
pub fn progress(progress: Progress) -> Option<u32> {
    Some(match progress {
        Ok(true) => 0,
        Ok(false) => micro::isa::NOT_YET.into(),
        Err(fault) => u32::from(micro::isa::FAULTED) | u32::from(fault.number()),
    })
}

/// What a statement finds.
#[derive(Clone, Debug)]
struct Found {
    seed: u64,
    /// Values on the stack.
    values: [i32; 2],
    /// Its number, its flags, the operand, flags of the run, a character.
    bytes: [u8; 5],
    time: i32,
    traces: bool,
    /// The outputs of enable and lamp.
    roles: [u8; 2],
}

fn found() -> impl Strategy<Value = Found> {
    let value = || prop_oneof![4 => 0i32..20, 2 => 30i32..130, 1 => any::<i32>()];
    let bytes = (0u8..20, any::<u8>(), any::<u8>(), any::<u8>(), 0u8..20);
    let time = prop_oneof![Just(0), Just(-1), any::<i32>()];
    let roles = [0u8..10, 0u8..10];
    (any::<u64>(), [value(), value()], bytes, time, any::<bool>(), roles).prop_map(
        |(seed, values, (n, bits, operand, run, c), time, traces, roles)| Found {
            seed,
            values,
            bytes: [n, bits, operand, run, c],
            time,
            traces,
            roles,
        },
    )
}

impl Found {
    fn put(&self, chip: &mut Chip) {
        let mut random = Rng::new(self.seed);
        for name in ["INPUT", "RAW", "OUTPUT", "RESUME_OUTPUT", "CHAR_OUT"] {
            chip.set_word(name, random.bits() as u16);
        }
        chip.board.poke8(unit(chip), random.bits() as u8);
        let mut record = BoardRecord::DEFAULT;
        [record.enable, record.lamp] = self.roles;
        if self.seed & 1 == 0 {
            record.flags |= BoardRecord::CHAIN;
        }
        with_profile(chip, &record);
        let operands = [0, 1, 2, 3].map(|at| self.bytes[2].wrapping_add(at));
        statement(chip, chip.at("POOL_END"), &self.values, &operands);
        let names = ["N", "BITS", "RUN_FLAGS", "CHAR_IN"];
        let [n, bits, _, run, c] = self.bytes;
        for (name, byte) in names.into_iter().zip([n, bits, run, if run & 8 == 0 { n } else { c }])
        {
            chip.set_byte(name, byte);
        }
        chip.set_long("TIME", 0, self.time as u32);
        chip.set_byte("TRACING", if self.traces { *crate::rig::T_ON } else { 0 });
        chip.set_byte("PHASE", 1);
    }
}

/// A rule by rustc, for a code, called for the first time or again.
type Rule = fn(&mut Twin, u8, bool) -> Progress;

/// The rules that are effects: the label, the codes, the rule.
macro_rules! by_rustc {
    ($module:ident { $($first:ident $last:ident $rule:ident($($with:ident)*);)* }) => {
        const RULES: &[(&str, RangeInclusive<u8>, Rule)] = &[$((
            concat!("fx_", stringify!($rule)),
            first::$first..=last::$last,
            |m, code, first| by_rustc!(@ m code first $module $rule $($with)*),
        ),)*];
    };
    (@ $m:ident $code:ident $again:ident $module:ident $rule:ident) => {{
        let _ = ($code, $again);
        $module::$rule($m)
    }};
    (@ $m:ident $code:ident $again:ident $module:ident $rule:ident code) => {{
        let _ = $again;
        $module::$rule($m, $code)
    }};
    (@ $m:ident $code:ident $again:ident $module:ident $rule:ident first) => {{
        let _ = $code;
        $module::$rule($m, $again)
    }};
}
firmware::effect_rows!(by_rustc);

#[test]
fn statements_do_the_same_by_rustc_and_as_micro_code() {
    let base = OnChip::of(&Chip::new(), &Elf::of("whole"), true);
    let start = (found(), any::<bool>(), 0u8..16);
    let result = runner(250).run(&start, |(found, first, nth)| {
        let machine = mill();
        let put = |chip: &mut Chip| found.put(chip);
        for (label, codes, rule) in RULES {
            let code = codes.start() + nth % (codes.end() - codes.start() + 1);
            let entry = Entry { acc: code.into(), first, ..Entry::default() };
            proved(&base, label, &machine, &put, &entry, &|m| progress(rule(m, code, first)));
        }
        let entry = Entry { acc: 3, first, ..Entry::default() };
        let rule = |m: &mut Twin| progress(effects::output(m, 3).map(|()| true));
        proved(&base, "fx_output", &machine, &put, &entry, &rule);
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}
