//! Runs: [`session`] by rustc and as micro-code, in any state, with a program that may run and without.

mod found;

pub use found::{found, program};

use std::mem::offset_of;

use firmware::rules::session::{self, AT_END, AT_FAULT, AT_PAUSE, Runs};
use lang::fault::Fault;
use lang::image::{HEADER, at};
use lang::isa::Op;
use lang::part::slot_head;
use lang::profile::Profile;
use lang::record::{MachineRecord, OutputStates};
use lang::wire::{End, RunState, TraceKind};
use proptest::prelude::*;

use super::effects::progress;
use super::{Entry, Twin, proved};
use crate::chip::Chip;
use crate::lockstep::{OnChip, runner};
use crate::machine::mill;
use crate::rig::{Rig, SLOT, T_FULL, T_HEARD, T_ON};
use crate::verify::Elf;

/// BUTTON: Stop is held.
const STOP: u8 = 1;
/// MOTION: brake to a pause; lines go on through their ends; the next one waits.
const PAUSE: u8 = 1;
const THROUGH: u8 = 4;
const NEXT: u8 = 8;
/// RUN_FLAGS: WaitStart; TIMEDOUT; courses are taken; the chip resets.
const WAITING: u8 = 1;
const TIMED_OUT: u8 = 4;
const COURSES: u8 = 64;
const RESTART: u8 = 128;
/// TRACING: program and profile are locked.
const LOCKED: u8 = 128;
/// WATCH: a pin has stopped the steps.
const TRIPPED: u8 = 0xFF;
/// RUNNING while a program runs.
const RUNS_MARK: &str = "RUNS_MARK";

impl Twin {
    /// r12 and Z of a routine that changes nothing.
    fn asks(&self, routine: &str, r12: u16) -> (u16, bool) {
        let mut chip = self.chip.clone();
        chip.call(routine, &[(12, r12)]);
        (chip.reg(12), chip.reg(2) & 2 != 0)
    }

    /// The state of a run.
    fn run(&self) -> u8 {
        self.chip.byte("RUN")
    }

    /// Where the stored image lies.
    fn image(&self) -> u16 {
        self.chip.word("STORED") + slot_head(1) as u16
    }

    /// The stack's end.
    fn stack_at(&mut self, end: u16) {
        self.chip.set_word("VM_SP", end);
        self.chip.set_word("VM_BASE", end);
    }
}

impl Runs for Twin {
    fn set_state(&mut self, state: u8) {
        self.chip.set_byte("RUN", state);
    }
    fn is_active(&self) -> bool {
        self.run() & RunState::Running as u8 != 0
    }
    fn executes(&self) -> bool {
        self.run() == RunState::Running as u8
    }
    fn is_paused(&self) -> bool {
        self.run() == RunState::Paused as u8
    }
    fn is_fault(&self) -> bool {
        self.run() == RunState::Fault as u8
    }
    fn is_ready(&self) -> bool {
        self.run() == RunState::Ready as u8
    }
    fn is_stored(&self) -> bool {
        self.chip.word("STORED") != 0
    }
    fn ending(&self) -> u8 {
        self.chip.byte("ENDING")
    }
    fn set_ending(&mut self, how: u8) {
        self.chip.set_byte("ENDING", how);
    }
    fn ends_by_fault(&self) -> bool {
        self.chip.byte("ENDING") == End::Fault as u8
    }
    fn set_last_end(&mut self, how: u8) {
        self.chip.set_byte("LAST_END", how);
    }
    fn set_number(&mut self, n: u8) {
        self.chip.set_byte("N", n);
    }
    fn holds_stop(&self) -> bool {
        self.chip.byte("BUTTON") & STOP != 0
    }
    fn blocking(&self) -> u8 {
        self.asks("blocking", 0).0 as u8
    }
    fn has_tripped(&self) -> bool {
        self.chip.byte("WATCH") == TRIPPED
    }
    fn emergency_now(&self) -> u8 {
        self.asks("emergency_now", 0).0 as u8
    }
    fn note_emergency(&mut self) {
        let n = self.emergency_now();
        self.chip.set_byte("FAULT_IN", n);
    }
    fn brake_to_pause(&mut self) {
        self.chip.set_word("SPIN_APART", 0);
        self.bits_of("MOTION", 0, PAUSE);
    }
    fn brake_all(&mut self) {
        self.chip.call("motion_stop", &[]);
    }
    fn give_up(&mut self) {
        self.chip.call("abandon", &[]);
    }
    fn halt(&mut self) {
        self.chip.call("motion_halt", &[]);
    }
    fn unwatch(&mut self) {
        self.chip.set_byte("WATCH", 0);
    }
    fn forget_homes(&mut self) {
        self.chip.set_byte("HOMED", 0);
    }
    fn goes_on_alone(&mut self) -> bool {
        false
    }
    fn rests(&self) -> bool {
        self.asks("motion_rests", 0).1
    }
    fn goes_through(&self) -> bool {
        self.chip.byte("MOTION") & THROUGH != 0
    }
    fn seeks(&self) -> bool {
        (Op::Probe as u8..=Op::HomeQuery as u8).contains(&self.chip.byte("EFFECT"))
    }
    fn go_on(&mut self) {
        self.chip.call("run_goes", &[]);
    }
    fn set_outputs_at(&mut self, occasion: u8) {
        let record = self.board_record();
        let OutputStates { keep, on } = match occasion {
            AT_PAUSE => record.pause,
            AT_END => record.end,
            AT_FAULT => record.fault,
            occasion => panic!("no occasion {occasion}"),
        };
        self.set_outputs(self.outputs() & keep | on);
    }
    fn exchange(&mut self) {
        self.chip.call("io_exchange", &[]);
    }
    fn outputs(&self) -> u16 {
        self.chip.word("OUTPUT")
    }
    fn set_outputs(&mut self, outputs: u16) {
        self.chip.set_word("OUTPUT", outputs);
    }
    fn resume_outputs(&self) -> u16 {
        self.chip.word("RESUME_OUTPUT")
    }
    fn set_resume(&mut self, outputs: u16) {
        self.chip.set_word("RESUME_OUTPUT", outputs);
    }
    fn spindle(&self) -> u8 {
        let n = self.board_record().spindle;
        u8::from(n != 0 && self.outputs() >> (n - 1) & 1 != 0)
    }
    fn spin_up(&self) -> u16 {
        self.board_record().spin_up
    }
    fn spin(&self) -> u16 {
        self.chip.word("SPIN_APART")
    }
    fn set_spin(&mut self, ms: u16) {
        self.chip.set_word("SPIN_APART", ms);
    }
    fn fault(&self) -> u8 {
        self.chip.byte("VM_FAULT")
    }
    fn latch(&mut self, fault: u8) {
        self.chip.set_byte("VM_FAULT", fault);
        self.chip.set_word("VM_FAULT_PC", self.chip.word("EFFECT_PC"));
    }
    fn forget_fault(&mut self) {
        self.chip.set_byte("VM_FAULT", 0);
    }
    fn log(&mut self) {
        self.chip.call("fault_log", &[]);
    }
    fn has_next_line(&self) -> bool {
        self.chip.byte("MOTION") & NEXT != 0
    }
    fn drop_line(&mut self) {
        self.chip.set_long("LEFT", 0, 0);
    }
    fn release(&mut self) {
        self.bits_of("RUN_FLAGS", WAITING, 0);
    }
    fn before_start(&self) -> u8 {
        self.chip.byte("MOVING")
    }
    fn attach(&mut self) -> bool {
        self.chip.call("program_attach", &[]);
        self.chip.word("VM_CODE") != 0
    }
    fn refuse(&mut self) {
        self.chip.call("fail", &[(12, Fault::ImageRefused.number().into())]);
    }
    fn enter(&mut self) {
        self.chip.call("clear_run", &[]);
        self.stack_at(self.chip.at("POOL_END"));
        self.chip.set_word("VM_CALLS", self.chip.at("POOL"));
        let (image, code) = (self.image(), self.chip.word("VM_CODE"));
        let byte = |at: u16| self.chip.board.peek8(image + at);
        let word = |at: u16| u16::from_le_bytes([byte(at), byte(at + 1)]);
        let (cells, entry) = (byte(at::CELLS as u16), word(at::ENTRY as u16));
        let feed = HEADER as u16 + offset_of!(MachineRecord, default_feed) as u16;
        let feed = u32::from(word(feed + 2)) << 16 | u32::from(word(feed));
        self.chip.set_byte("VM_CELL_COUNT", cells);
        self.chip.set_long("FEED", 0, feed);
        self.chip.set_word("VM_PC", code.wrapping_add(entry));
        self.bits_of("RUN_FLAGS", WAITING | TIMED_OUT | COURSES, 0);
    }
    fn program_has_courses(&self) -> bool {
        let flags = self.image() + HEADER as u16 + offset_of!(MachineRecord, flags) as u16;
        self.chip.board.peek8(flags) & MachineRecord::COURSES != 0
    }
    fn take_courses(&mut self) {
        self.bits_of("RUN_FLAGS", 0, COURSES);
        self.stack_at(self.chip.at("POOL_END") - firmware::WHOLE.course_pool);
    }
    fn load(&mut self) {
        self.chip.call("keep_load", &[]);
        self.chip.set_word("RUNNING", self.chip.at(RUNS_MARK));
    }
    fn set_stack(&mut self) {
        self.chip.call("stack_end", &[]);
        self.stack_at(self.chip.reg(12));
    }
    fn begin_trace(&mut self) {
        self.bits_of("TRACING", !(*T_ON | *T_HEARD | LOCKED), 0);
    }
    fn halts(&self) -> bool {
        self.chip.byte("TRACING") & *T_ON != 0
    }
    fn halt_first(&mut self) {
        self.bits_of("TRACING", 0, *T_FULL);
    }
    fn begun(&mut self) {
        let runs = self.chip.word("RUNS").wrapping_add(1);
        self.chip.set_word("RUNS", runs);
        self.chip.call("motion_reset", &[]);
    }
    fn tells(&self) -> bool {
        self.chip.byte("TRACING") & *T_FULL != 0
    }
    fn keeps_flash(&self) -> u8 {
        self.chip.byte("LINE_STATE")
    }
    fn save_kept(&mut self) {
        self.chip.call("keep_save", &[]);
    }
    fn leave_courses(&mut self) {
        self.bits_of("RUN_FLAGS", COURSES, 0);
        self.chip.set_byte("JOINS", 0);
        self.chip.set_byte("JOINED", 0);
    }
    fn unmark(&mut self) {
        self.chip.set_word("OPEN", 0);
        self.chip.set_word("RUNNING", 0);
    }
    fn settle_place(&mut self) {}
    fn tell_end(&mut self, fault: i32) {
        self.does("DO_micro_event", &[TraceKind::End as u8], fault as u32);
    }
    fn forget(&mut self) {
        self.chip.set_word("EFFECT", 0);
    }
    fn leave(&mut self) {
        self.chip.set_word("EFFECT", 0);
        let low = self.chip.word("TIME");
        self.chip.set_long("TIME", 0, low.into());
    }
    fn restart(&mut self) {
        self.bits_of("RUN_FLAGS", 0, RESTART);
    }
}

/// The step engine's interrupt is on: steps come.
const ENGINE: (u16, u16) = (0x0182, 1 << 4);

/// Where the VM goes on.
const NEXT_CODE: u16 = SLOT + 0x1E0;

#[test]
fn runs_are_the_same_by_rustc_and_as_micro_code() {
    let images = [program(false), program(true)];
    let profile = Profile::built_in("mill").expect("mill is built in");
    let chip = Rig::with_image(&profile, &images[0]).chip;
    let base = OnChip::of(&chip, &Elf::of("whole"), true);
    let start = (found(), 1u8..8, any::<u8>());
    let result = runner(400).run(&start, |(found, code, number)| {
        let machine = mill();
        let put = |chip: &mut Chip| found.put(chip, &images[usize::from(found.courses)]);
        let same = |label, acc: u8, rule: &dyn Fn(&mut Twin) -> Option<u32>| {
            let entry = Entry { acc: acc.into(), scratch: &[("TEMP", 1)], ..Entry::default() };
            proved(&base, label, &machine, &put, &entry, rule);
        };
        let rule = |label, rule: fn(&mut Twin)| {
            same(label, 0, &|m| {
                rule(m);
                None
            });
        };
        rule("emergency_input", session::watch_emergency);
        rule("run_pause", session::pause);
        rule("run_stop", session::stop);
        rule("run_start", session::start);
        rule("run_stopping", session::stopping);
        // Nothing else is begun by what waits for the engine.
        let plays = |chip: &mut Chip| {
            put(chip);
            chip.board.bus_write16(ENGINE.0, ENGINE.1);
            // What goes on is an effect that waits for a host, or the VM, up to the program's end.
            chip.set_byte("TRACING", *T_FULL);
            chip.set_byte("PHASE", 0);
            chip.board.poke8(NEXT_CODE, Op::End as u8);
            chip.set_word("VM_PC", NEXT_CODE);
            for (name, at) in [("VM_SP", "POOL_END"), ("VM_CELLS", "POOL"), ("VM_CALLS", "POOL")] {
                chip.set_word(name, chip.at(at));
            }
        };
        // The VM puts by how deep the machine stack is.
        let entry = Entry { scratch: &[("TEMP", 12)], ..Entry::default() };
        proved(&base, "run_stopping", &machine, &plays, &entry, &|m| {
            session::stopping(m);
            None
        });
        same("control", code, &|m| {
            session::control(m, code);
            None
        });
        same("fail", number, &|m| {
            session::fail(m, number);
            None
        });
        same("fx_end", 0, &|m| progress(session::end(m)));
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}
