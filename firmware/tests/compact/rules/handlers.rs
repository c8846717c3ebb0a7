//! Faults of the program: [`handlers`] by rustc and as micro-code, with an error handler and without.

use emulator::Rng;
use firmware::rules::handlers::{self, Handles};
use lang::fault::Fault;
use lang::profile::Profile;
use lang::vm::flag;
use proptest::prelude::*;

use super::session::{found, program};
use super::{Entry, Twin, proved};
use crate::chip::Chip;
use crate::lockstep::{OnChip, runner};
use crate::machine::mill;
use crate::rig::Rig;
use crate::verify::Elf;

/// TRACING: the host knows of the line that is being printed; it does not fit.
const ANNOUNCED: u8 = 4;
const DROPPED: u8 = 8;

impl Handles for Twin {
    fn note(&mut self, fault: u8) {
        self.chip.set_byte("VM_FAULT", fault);
        self.chip.set_word("VM_FAULT_PC", self.chip.word("EFFECT_PC"));
    }
    fn forget(&mut self) {
        self.chip.set_word("EFFECT", 0);
    }
    // An instruction in front of the rule has cleared the byte that counts it.
    fn abandon_print(&mut self) {
        self.bits_of("TRACING", ANNOUNCED | DROPPED, 0);
    }
    fn leave_statement(&mut self) {
        self.bits_of("VM_FLAGS", flag::MORE | flag::WITHIN, 0);
    }
    fn is_beyond_handlers(&self) -> bool {
        self.chip.byte("VM_FAULT") == Fault::Stack.number()
    }
    fn is_in_handler(&self) -> bool {
        self.chip.byte("VM_FLAGS") & flag::ERROR != 0
    }
    fn has_handler(&self) -> bool {
        self.chip.word("VM_HANDLER") != 0
    }
    fn open_handler(&mut self) -> bool {
        self.chip.call("handler_open", &[]);
        self.chip.reg(2) & 2 == 0
    }
    fn fail(&mut self) {
        self.chip.call("fail", &[(12, self.chip.byte("VM_FAULT").into())]);
    }
    fn enter_handler(&mut self) {
        self.bits_of("VM_FLAGS", 0, flag::ERROR);
        self.chip.set_word("VM_PC", self.chip.word("VM_HANDLER"));
    }
    fn put_feed_aside(&mut self) {
        let feed = self.chip.long("FEED", 0);
        // Where an upload stands without a run.
        self.chip.set_long("OPEN", 0, feed);
        self.chip.set_long("FEED", 0, 0);
    }
    fn unwind(&mut self) {
        self.chip.call("run_unwind", &[]);
    }
}

#[test]
fn faults_are_the_same_by_rustc_and_as_micro_code() {
    let image = program(false);
    let profile = Profile::built_in("mill").expect("mill is built in");
    let base = OnChip::of(&Rig::with_image(&profile, &image).chip, &Elf::of("whole"), true);
    let fault = prop_oneof![Just(Fault::Stack.number()), any::<u8>()];
    let start = (found(), fault, any::<u64>());
    let result = runner(400).run(&start, |(found, fault, seed)| {
        let put = |chip: &mut Chip| {
            found.put(chip, &image);
            let mut random = Rng::new(seed);
            chip.set_byte("VM_FLAGS", if seed & 1 == 0 { 0 } else { random.bits() as u8 });
            chip.set_word("VM_HANDLER", if seed & 2 == 0 { 0 } else { random.bits() as u16 });
            chip.set_long("FEED", 0, random.bits() as u32);
            let (pool, end) = (chip.at("POOL"), chip.at("POOL_END"));
            let calls = pool + 2 * (random.bits() as u16 & 3);
            let stack = end - 4 * (random.bits() as u16 & 3);
            for (name, at) in [
                ("VM_CALLS", calls),
                ("VM_CELLS", pool + 6),
                ("VM_BASE", stack),
                ("VM_SP", stack - 4 * (random.bits() as u16 & 3)),
            ] {
                chip.set_word(name, at);
            }
            chip.set_long("VM_TOP", 0, random.bits() as u32);
            // A table of statements, or none.
            let features = chip.word("VM_CODE") + 1 - (image_of_code() as u16);
            chip.board.poke8(features, random.bits() as u8);
        };
        let entry = Entry { acc: fault.into(), ..Entry::default() };
        proved(&base, "raise", &mill(), &put, &entry, &|m| {
            handlers::raise(m, fault);
            None
        });
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}

/// Bytes of an image in front of its code.
const fn image_of_code() -> usize {
    lang::image::HEADER + lang::record::MachineRecord::SIZE
}
