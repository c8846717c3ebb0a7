//! Commands: [`commands`] by rustc and as micro-code, from any state and with any arguments.

mod found;

use firmware::rules::commands::{self, Commands};
use firmware::rules::coords::Stands;
use firmware::rules::{Answer, Axis, home};
use lang::fault::Fault;
use lang::record::{AxisRecord, MachineRecord};
use lang::wire::Exception;

use super::{Entry, Twin, proved};
use crate::chip::Chip;
use crate::coords::value;
use crate::lockstep::{OnChip, runner};
use crate::machine::mill;
use crate::verify::Elf;
use found::found;

/// Words of a command.
const WORDS: u16 = 21;
/// Bit of MOTION: it goes on while the host speaks.
const HELD: u8 = 32;
/// Flags of a reference run.
const INVERT: u8 = 0x40;
const BY_COMMAND: u8 = 0x80;
/// A run by command 102 of an axis that has not homed.
const FAR: u32 = 0x2000;
/// Bytes of a statement or command: its flags, and axes that have steps to make.
pub const FLAGS: u16 = 0;
pub const RAMPS: u16 = 1;

/// The address of a command's word, from 0: the first two stand apart.
pub fn place(chip: &Chip, n: u16) -> u16 {
    let first = if n < 2 { chip.at("COMMAND_HEAD") } else { chip.at("POOL_END") - 2 * WORDS };
    first + 2 * n
}

impl Twin {
    /// The address of a command's word, from 0.
    fn word_at(&self, n: u16) -> u16 {
        place(&self.chip, n)
    }

    fn word(&self, n: u16) -> u16 {
        self.chip.board.peek16(self.word_at(n))
    }

    fn argument_long(&self, n: u16) -> i32 {
        (u32::from(self.word(n + 1)) << 16 | u32::from(self.word(n))) as i32
    }

    fn set_argument(&mut self, n: u16, value: i32) {
        let at = self.word_at(n);
        self.chip.board.poke16(at, value as u16);
        self.chip.board.poke16(at + 2, (value >> 16) as u16);
    }

    /// A field of command 106's record.
    fn set_field(&mut self, at: usize, value: u16) {
        let at = place(&self.chip, 2) - 8 + at as u16;
        self.chip.board.poke16(at, value);
    }

    pub fn statement_byte(&self, at: u16) -> u8 {
        self.chip.board.peek8(self.chip.at("BYTES") + at)
    }

    pub fn set_statement_byte(&mut self, at: u16, value: u8) {
        let at = self.chip.at("BYTES") + at;
        self.chip.board.poke8(at, value);
    }

    /// A routine of the chip; r13:r12 behind it.
    pub fn calls(&mut self, routine: &str, acc: u32) -> u32 {
        self.chip.call(routine, &[(12, acc as u16), (13, (acc >> 16) as u16)]);
        self.chip.result()
    }
}

fn answer(r12: u16) -> Answer {
    match r12 {
        0 => Ok(()),
        3 => Err(Exception::IllegalValue),
        other => panic!("{other}"),
    }
}

impl Commands for Twin {
    fn command(&self) -> u16 {
        self.word(0)
    }
    fn argument(&self) -> u16 {
        self.word(1)
    }
    fn next(&mut self) -> i32 {
        let at = self.next;
        self.next += 2;
        self.argument_long(at)
    }
    fn next_thousandths(&mut self) -> i32 {
        let at = self.word_at(self.next);
        self.next += 2;
        self.chip.call("command_float", &[(5, at)]);
        self.chip.result() as i32
    }
    fn force(&mut self, n: u8) -> Answer {
        self.chip.call("force_input", &[(12, n.into()), (4, self.word(2))]);
        answer(self.chip.reg(12))
    }
    fn control(&mut self, code: u8) {
        self.calls("control", code.into());
    }
    fn is_active(&self) -> bool {
        firmware::rules::Machine::is_active(&super::State(&self.chip))
    }
    fn has_program(&self) -> bool {
        self.chip.word("VM_CODE") != 0
    }
    fn blocking(&self) -> u8 {
        firmware::rules::Machine::blocking(&super::State(&self.chip))
    }
    fn is_held(&self) -> bool {
        self.chip.byte("MOTION") & HELD != 0
    }
    fn set_held(&mut self) {
        self.bits_of("MOTION", 0, HELD);
    }
    fn effect(&self) -> u8 {
        self.chip.byte("EFFECT")
    }
    fn set_effect(&mut self, code: u8) {
        self.chip.set_byte("EFFECT", code);
    }
    fn first_phase(&mut self) {
        let phase = self.chip.byte("PHASE");
        self.chip.set_byte("PHASE", phase.wrapping_add(1));
    }
    fn forget(&mut self) {
        self.chip.set_word("EFFECT", 0);
    }
    fn set_homing_failed(&mut self, axis: Axis) {
        self.bits_of("HOMING_ERROR", 0, axis.bit());
    }
    fn set_homing(&mut self, axis: Axis) {
        self.bits_of("HOMING_ERROR", axis.bit(), 0);
    }
    fn set_probe_failed(&mut self, axis: Axis) {
        self.bits_of("PROBE_ERROR", 0, axis.bit());
    }
    fn set_probing(&mut self, axis: Axis) {
        self.bits_of("PROBE_ERROR", axis.bit(), 0);
    }
    fn is_there(&self, axis: Axis) -> bool {
        axis.n() < 3 && self.axis_record(axis).flags & AxisRecord::PRESENT != 0
    }
    fn is_homed(&self, axis: Axis) -> bool {
        self.chip.byte("HOMED") & axis.bit() != 0
    }
    fn is_moving(&self, axis: Axis) -> bool {
        self.chip.byte("MOVING") & axis.bit() != 0
    }
    fn moving(&self) -> u8 {
        self.chip.byte("MOVING")
    }
    fn in_the_way(&self) -> u8 {
        self.chip.byte("MOVING")
    }
    fn set_axes(&mut self, axes: u8) {
        self.chip.set_byte("TEMP", axes);
    }
    fn is_meant(&self, axis: Axis) -> bool {
        self.chip.byte("TEMP") & axis.bit() != 0
    }
    fn brake(&mut self, _: Axis) {
        self.calls("motion_stop", 0);
    }
    fn brake_all(&mut self) {
        self.calls("motion_stop", 0);
    }
    fn set_offset(&mut self, axis: Axis, um: i32) {
        self.chip.set_long("OFFSET", 4 * u16::from(axis.n()), um as u32);
    }
    fn start(&self) -> i32 {
        self.chip.long("V2", 0) as i32
    }
    fn set_start(&mut self, steps: i32) {
        self.chip.set_long("V2", 0, steps as u32);
    }
    fn aim_steps(&mut self, axis: Axis, steps: i32) -> Result<(), Fault> {
        self.chip.set_byte("FRAME_OF", 4 | 16);
        firmware::rules::coords::aim_place(self, axis, steps)
    }
    fn go(&mut self, axis: Axis) {
        firmware::rules::coords::command(self, axis);
        self.of_axis("begin_axis", axis, 0);
    }
    fn go_in_line(&mut self) {
        self.calls("command_axes", 0);
        let ramps = self.statement_byte(RAMPS);
        self.calls("line_begin", ramps.into());
    }
    fn set_flags(&mut self, flags: u8) {
        self.set_statement_byte(FLAGS, flags);
    }
    fn is_named(&self, axis: Axis) -> bool {
        self.statement_byte(FLAGS) & axis.bit() != 0
    }
    fn counts_from_here(&self) -> bool {
        self.statement_byte(FLAGS) & 64 != 0
    }
    fn set_feed(&mut self, feed: i32) {
        self.chip.set_long("FEED", 0, feed as u32);
    }
    fn ramp(&self) -> i32 {
        self.argument_long(2)
    }
    fn set_ramp_down(&mut self, ramp: i32) {
        self.set_argument(6, ramp);
    }
    fn speed(&self) -> i32 {
        self.argument_long(4)
    }
    fn set_speed(&mut self, speed: i32) {
        self.set_argument(4, speed);
    }
    fn set_far(&mut self) {
        let low = self.chip.long("LEFT", 0) & 0xFFFF;
        self.chip.set_long("LEFT", 0, FAR << 16 | low);
    }
    fn set_far_to(&mut self, steps: i32) {
        self.chip.set_long("LEFT", 0, steps as u32);
    }
    fn far(&self) -> i32 {
        self.chip.long("LEFT", 0) as i32
    }
    fn travel_begin(&self, axis: Axis) -> i32 {
        self.axis_record(axis).min
    }
    fn travel_end(&self, axis: Axis) -> i32 {
        self.axis_record(axis).max
    }
    fn travel_steps(&self, axis: Axis, um: i32) -> i32 {
        self.to_steps(axis, um).expect("the tests' travels fit")
    }
    fn set_target(&mut self, axis: Axis, steps: i32) {
        self.chip.set_long("STEPS", 4 * u16::from(axis.n()), steps as u32);
    }
    fn run(&mut self, axis: Axis) {
        self.of_axis("begin_axis", axis, 0);
    }
    fn work_position(&self) -> i32 {
        self.argument_long(2)
    }
    fn nothing(&self) -> u16 {
        self.word(2)
    }
    fn switch(&self) -> u16 {
        self.word(3)
    }
    fn set_switch(&mut self, input: u16) {
        self.chip.set_byte("BITS", (input as u8).wrapping_add(BY_COMMAND + 1));
    }
    fn closed_level(&self) -> u16 {
        self.word(4)
    }
    fn set_inverted(&mut self) {
        self.bits_of("BITS", 0, INVERT);
    }
    fn home_side(&self) -> u16 {
        self.word(5)
    }
    fn set_way(&mut self, flags: u8) {
        self.set_field(std::mem::offset_of!(AxisRecord, flags), flags.into());
    }
    fn home_rate(&self, which: Axis) -> i32 {
        self.argument_long(6 + 2 * u16::from(which.n()))
    }
    fn take_plan(&mut self, _: Axis) {
        let (slow, wait) = (self.word(8), self.word(16));
        for (at, value) in [
            (std::mem::offset_of!(AxisRecord, steps), 1),
            (std::mem::offset_of!(AxisRecord, um), 1),
            (std::mem::offset_of!(AxisRecord, home_slow), slow),
            (std::mem::offset_of!(AxisRecord, home_pause), wait),
        ] {
            self.set_field(at, value);
        }
    }
    fn home_stroke(&self) -> i32 {
        self.argument_long(14)
    }
    fn set_stroke(&mut self, steps: i32) {
        let at = AxisRecord::SIZE - 12;
        self.set_field(at, steps as u16);
        self.set_field(at + 2, (steps >> 16) as u16);
    }
    fn home_clearance(&self) -> i32 {
        self.argument_long(19)
    }
    fn set_clearance(&mut self, steps: i32) {
        self.set_argument(19, steps);
    }
    fn plan(&mut self, n: u8) -> Result<(), Fault> {
        home::by_profile(self, n);
        Ok(())
    }
    fn probe_input(&self) -> u16 {
        self.word(2)
    }
    fn probe_level(&self) -> u16 {
        self.word(3)
    }
    fn and(&self) -> i32 {
        self.argument_long(2)
    }
    fn xor(&self) -> i32 {
        self.argument_long(4)
    }
}

/// r12 of a request.
fn exception(answer: Answer) -> Option<u32> {
    Some(answer.map_or_else(|exception| exception as u32, |()| 0))
}

#[test]
fn commands_do_the_same_by_rustc_and_as_micro_code() {
    let base = OnChip::of(&Chip::new(), &Elf::of("whole"), true);
    let result = runner(1_500).run(&(found(), 0u8..3, value()), |(found, n, place)| {
        let mut machine = MachineRecord { ..mill() };
        let axis = Axis::new(n);
        let put = |chip: &mut Chip| found.put(chip);
        let free = AxisRecord { min: -(1 << 30), max: 1 << 30, ..AxisRecord::FREE };
        if n == 2 {
            machine.axes[2].flags = 0;
        }
        let same = |label, entry, rule: &dyn Fn(&mut Twin) -> Option<u32>| {
            proved(&base, label, &machine, &put, &entry, &|m| {
                if !found.program {
                    m.machine.axes = [free; 3];
                }
                rule(m)
            });
        };
        let scratch = &[("V2", 4)];
        let entry = Entry { scratch, ..Entry::default() };
        same("command_execute", entry, &|m| exception(commands::execute(m)));
        let of_axis = Entry { axis: Some(axis), acc: place as u32, ..entry };
        same("work_position_is", of_axis, &|m| exception(commands::position_is(m, axis, place)));
        same("abandon", entry, &|m| {
            commands::abandon(m);
            None
        });
        same("command_done", Entry { acc: (n & 1).into(), ..entry }, &|m| {
            commands::done(m, n & 1);
            None
        });
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}
