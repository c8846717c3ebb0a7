//! The rules that both chips share: what rustc makes of a function against the micro-code that `lower` has made of it,
//! from the same random state; and what stands in the repository against what `lower` makes now.

mod axes;
mod commands;
mod coords;
mod effects;
mod handlers;
mod home;
mod lines;
mod moves;
mod pace;
mod planner;
mod probe;
mod segments;
mod session;
mod stops;
mod ticks;

use firmware::rules::{Axis, Machine, status};
use lang::isa::Op;
use lang::record::{AxisRecord, BoardRecord, MachineRecord};
use lang::wire::RunState;
use micro::isa::{CALLED, Gives, ROUTINES};
use micro::run::{End, Flags, Registers, World, run};
use proptest::prelude::*;

use crate::chip::Chip;
use crate::lockstep::{OnChip, runner};
use crate::machine::{install, mill};
use crate::rig::PROFILE;
use crate::verify::Elf;

/// The chip's state as a rule sees it. Leaves that are routines are the chip's own.
struct State<'a>(&'a Chip);

impl State<'_> {
    /// A routine on a copy of the chip: r12 and Z behind it.
    fn leaf(&self, routine: &str, r12: u16) -> (u16, bool) {
        let mut chip = self.0.clone();
        chip.call(routine, &[(12, r12)]);
        (chip.reg(12), chip.reg(2) & 2 != 0)
    }

    fn input(&self, n: u8) -> bool {
        self.leaf("input", n.into()).0 != 0
    }

    fn record(&self) -> BoardRecord {
        BoardRecord::from_bytes(&std::array::from_fn(|at| self.0.board.peek8(PROFILE + at as u16)))
    }
}

impl Machine for State<'_> {
    fn is_active(&self) -> bool {
        self.0.byte("RUN") & RunState::Running as u8 != 0
    }
    fn effect_pc(&self) -> u16 {
        self.0.word("EFFECT_PC")
    }
    fn fault_pc(&self) -> u16 {
        self.0.word("VM_FAULT_PC")
    }
    fn code(&self) -> u16 {
        self.0.word("VM_CODE")
    }
    fn traces(&self) -> bool {
        self.0.byte("TRACING") & 1 != 0
    }
    fn blocking(&self) -> u8 {
        self.leaf("blocking", 0).0 as u8
    }
    fn input_17(&self) -> u8 {
        self.input(17).into()
    }
    fn is_fault(&self) -> bool {
        self.0.byte("RUN") == RunState::Fault as u8
    }
    fn is_paused(&self) -> bool {
        self.0.byte("RUN") == RunState::Paused as u8
    }
    fn jogs(&self) -> bool {
        self.0.byte("MOTION") & 32 != 0
    }
    fn is_idle(&self) -> bool {
        self.leaf("idle", 0).1
    }
    fn door(&self) -> bool {
        self.record().door.iter().any(|n| self.input(*n))
    }
    fn emergency(&self) -> bool {
        self.leaf("emergency_now", 0).0 != 0
    }
    fn effect(&self) -> u8 {
        self.0.byte("EFFECT")
    }
    fn axis(&self) -> Axis {
        Axis::new(self.0.byte("N"))
    }
    fn homing_failed(&self) -> u8 {
        self.0.byte("HOMING_ERROR")
    }
    fn reference_closed(&self, axis: Axis) -> bool {
        self.input(self.record().reference[usize::from(axis.n())])
    }
    fn home_positive(&self, axis: Axis) -> bool {
        let machine = self.0.word("VM_CODE") - MachineRecord::SIZE as u16;
        let axes = machine + std::mem::offset_of!(MachineRecord, axes) as u16;
        let at = axes + u16::from(axis.n()) * AxisRecord::SIZE as u16;
        let flags = self.0.board.peek16(at + std::mem::offset_of!(AxisRecord, flags) as u16);
        flags & AxisRecord::HOME_POSITIVE != 0
    }
}

/// What the rules look at.
#[derive(Clone, Debug)]
pub struct Seen {
    bytes: [u8; 6],
    levels: [u16; 2],
    roles: [u8; 9],
    positive: u8,
}

/// Any of it; effects and roles often those that matter.
pub fn seen() -> impl Strategy<Value = Seen> {
    let effect = prop_oneof![
        Just(0),
        Op::Home as u8 - 1..Op::HomeQuery as u8 + 2,
        Just(Op::Probe as u8),
        any::<u8>()
    ];
    let bytes = (0u8..7, any::<u8>(), effect, 0u8..3, any::<u8>(), 0u8..2);
    let roles = prop::array::uniform9(prop_oneof![3 => 0u8..19, 1 => Just(0xFF)]);
    (bytes, any::<[u16; 2]>(), roles, 0u8..8).prop_map(|(bytes, levels, roles, positive)| {
        let (run, motion, effect, n, failed, moving) = bytes;
        Seen { bytes: [run, motion, effect, n, failed, moving], levels, roles, positive }
    })
}

impl Seen {
    /// Puts it into a chip.
    pub fn put(&self, chip: &mut Chip) {
        let mut axes = mill().axes;
        for (n, axis) in axes.iter_mut().enumerate() {
            let positive = self.positive >> n & 1 != 0;
            axis.flags = if positive { AxisRecord::HOME_POSITIVE } else { 0 } | AxisRecord::PRESENT;
        }
        install(chip, &MachineRecord { axes, ..mill() });
        let roles = self.roles.map(|n| if n > 18 { 0 } else { n });
        let mut record = BoardRecord::DEFAULT;
        record.door = [roles[0], roles[1]];
        record.reference = [roles[2], roles[3], roles[4]];
        record.emergency = [roles[5], roles[6], roles[7], roles[8]];
        with_profile(chip, &record);
        let names = ["RUN", "MOTION", "EFFECT", "N", "HOMING_ERROR", "MOVING"];
        for (name, byte) in names.into_iter().zip(self.bytes) {
            chip.set_byte(name, byte);
        }
        chip.set_word("INPUT", self.levels[0]);
        chip.set_word("RAW", self.levels[1]);
        chip.set_word("EFFECT_PC", self.levels[0]);
        chip.set_word("VM_FAULT_PC", self.levels[1]);
        chip.set_byte("TRACING", self.bytes[4]);
        chip.set_word("TEMP", self.levels[0] ^ self.levels[1]);
    }
}

/// Puts a board's profile into a chip.
pub fn with_profile(chip: &mut Chip, record: &BoardRecord) {
    for (at, byte) in (PROFILE..).zip(record.to_bytes()) {
        chip.board.poke8(at, byte);
    }
    chip.set_word("BOARD", PROFILE);
}

/// Where the operands of a statement are.
const OPERANDS: u16 = crate::area::AREA + 0x1C0;

/// A statement begins with these values on a stack that ends at an address, the first one on top, and these operands.
pub fn statement(chip: &mut Chip, end: u16, values: &[i32], operands: &[u8]) {
    let pool = chip.at("POOL");
    for (name, value) in [
        ("BOARD", PROFILE),
        ("VM_PC", OPERANDS),
        ("VM_SP", end - 24),
        ("VM_BASE", end),
        ("VM_CALLS", pool),
        ("VM_CELLS", pool + 16),
    ] {
        chip.set_word(name, value);
    }
    chip.set_long("VM_TOP", 0, values[0] as u32);
    for (n, value) in (0..).zip(&values[1..]) {
        chip.set_long("POOL", end - 24 - pool + 4 * n, *value as u32);
    }
    for (at, byte) in (OPERANDS..).zip(operands) {
        chip.board.poke8(at, *byte);
    }
}

/// r12 behind a routine of micro-code in the interpreter, and C.
fn made(on: &OnChip, label: &str) -> (u16, Option<bool>) {
    let mut here = OnChip::of(&on.chip, &on.elf, true);
    let at = here.chip.at(label);
    let mut registers =
        Registers { flags: Flags::of(false, false, true, false), ..Registers::default() };
    let end = run(&mut here, at, &mut registers).unwrap_or_else(|trap| panic!("{label}: {trap}"));
    assert_eq!(end, End::Returned);
    (registers.acc as u16, registers.flags.c)
}

/// A rule that makes a word.
type Rule = fn(&State<'_>) -> u16;

#[test]
fn rules_say_the_same_by_rustc_and_as_micro_code() {
    let elf = Elf::of("whole");
    let base = Chip::new();
    let words: [(&str, Rule); 11] = [
        ("map_blocking", |m| status::blocking(m)),
        ("map_program_counter", |m| status::program_counter(m)),
        ("map_fault_pc", |m| status::fault_pc(m)),
        ("map_trace_mode", |m| status::trace_mode(m)),
        ("map_probe_input", |m| status::probe_input(m)),
        ("map_command_room", |m| status::command_room(m)),
        ("map_plc_status", |m| status::plc_status(m)),
        ("map_cnc_state", |m| status::cnc_state(m)),
        ("map_limit_switches", |m| status::limit_switches(m)),
        ("map_probing", |m| status::probing(m)),
        ("map_homing", |m| status::homing(m)),
    ];
    let result = runner(150).run(&seen(), |seen| {
        let mut on = OnChip::of(&base, &elf, true);
        seen.put(&mut on.chip);
        for (label, rule) in words {
            prop_assert_eq!(made(&on, label).0, rule(&State(&on.chip)), "{}", label);
        }
        // Carry says that none homes.
        prop_assert_eq!(made(&on, "map_homes").1, Some(!status::homes(&State(&on.chip))));
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}

/// A chip that rules change as rustc has made them.
#[derive(Clone)]
pub struct Twin {
    /// The chip.
    pub chip: Chip,
    /// The record of its stored program.
    pub machine: MachineRecord,
    /// The word of a command's next argument.
    pub next: u16,
    /// High half of the inputs that a probe wants off.
    pub off: u16,
    /// Units and frames of a line's words, the next one last.
    pub frames: Vec<u8>,
    /// r13 where the rule begins.
    pub high: u16,
}

impl Twin {
    /// With a copy of a chip that has this machine stored.
    pub fn of(chip: &Chip, machine: &MachineRecord) -> Twin {
        let mut chip = chip.clone();
        install(&mut chip, machine);
        Twin { chip, machine: *machine, next: 2, off: 0, frames: Vec::new(), high: 0 }
    }
}

/// `call #..`.
const CALL: u16 = 0x12B0;
/// RAM that both must have alike: below the machine stack.
const RAM: std::ops::Range<u16> = 0x0200..0x03B8;

/// How a rule begins.
#[derive(Clone, Copy, Debug, Default)]
pub struct Entry {
    /// The axis in r8, its record in r9.
    pub axis: Option<Axis>,
    /// r13:r12.
    pub acc: u32,
    /// Z: it is the first call of a statement.
    pub first: bool,
    /// The result is a number, also where Z tells something: whether it is 0.
    pub number: bool,
    /// Where micro-code puts something by, and how many bytes.
    pub scratch: &'static [(&'static str, u16)],
}

/// The rule that has this label leaves the same by rustc and as micro-code: memory, and its result as its row
/// promises it (of a condition Z, set when it holds). Both begin with what `put` makes of a chip with this machine.
pub fn proved(
    base: &OnChip,
    label: &str,
    machine: &MachineRecord,
    put: &dyn Fn(&mut Chip),
    entry: &Entry,
    rule: &dyn Fn(&mut Twin) -> Option<u32>,
) {
    let begin = || {
        let mut twin = Twin::of(&base.chip, machine);
        put(&mut twin.chip);
        twin
    };
    let mut twin = begin();
    twin.high = (entry.acc >> 16) as u16;
    let result = rule(&mut twin);
    let mut here = OnChip::of(&begin().chip, &base.elf, true);
    let mut registers = Registers { acc: entry.acc, ..Registers::default() };
    registers.flags = Flags::of(entry.first, false, true, false);
    if let Some(axis) = entry.axis {
        let mut chip = here.chip.clone();
        chip.call("axis_select", &[(12, axis.n().into())]);
        (registers.axis, registers.record) = (chip.reg(8), chip.reg(9));
    }
    // Behind the call of the machine, where instructions come to it.
    let at = here.chip.at(label);
    let mut calls = (at..at + 6).step_by(2).filter(|at| here.chip.board.peek16(*at) == CALL);
    let at = calls.next().filter(|at| at & 1 == 0).map_or(at, |at| at + 4);
    // A command's arguments: the next one, and the second.
    let command = commands::place(&here.chip, 2);
    let second = here.chip.board.peek16(command);
    here.chip.board.set_reg(5, command);
    here.chip.board.set_reg(4, second);
    let end = run(&mut here, at, &mut registers).unwrap_or_else(|trap| panic!("{label}: {trap}"));
    if let End::Instructions(at) = end {
        here.call(at, at, &mut registers);
    }
    let scratch = entry.scratch.iter().map(|(name, bytes)| (base.chip.at(name), *bytes));
    let scratch = scratch.collect::<Vec<_>>();
    let counts =
        |at: &u16| !scratch.iter().any(|(first, bytes)| (*first..first + bytes).contains(at));
    for at in RAM.filter(counts) {
        let (a, b) = (twin.chip.board.peek8(at), here.chip.board.peek8(at));
        assert_eq!(a, b, "{label}: the byte at {at:04x}, by rustc and as micro-code");
    }
    let Some(result) = result else { return };
    let row = ROUTINES.iter().chain(CALLED).find(|row| row.label == label);
    match row {
        Some(row) if row.flags == "Z" && entry.number => {
            assert_eq!((registers.acc, registers.flags.z), (result, Some(result == 0)), "{label}")
        }
        Some(row) if row.flags == "Z" => {
            assert_eq!(registers.flags.z, Some(result != 0), "{label}")
        }
        Some(row) if row.gives == Gives::Long => assert_eq!(registers.acc, result, "{label}"),
        _ => assert_eq!(registers.acc & 0xFFFF, result, "{label}: r12"),
    }
}

#[test]
fn what_lower_has_made_is_what_it_makes() {
    let firmware = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let made = lower::of_firmware(firmware).unwrap_or_else(|error| panic!("{error}"));
    for made in made {
        let path = firmware.join(format!("g2553/generated/{}.s", made.name));
        let there = std::fs::read_to_string(&path)
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert_eq!(made.text, there, "run `cargo run -p lower`");
    }
}
