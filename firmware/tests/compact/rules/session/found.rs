//! What a run finds: any state, a program that may run and one that may not.

use std::mem::offset_of;

use emulator::Rng;
use lang::image::{HEADER, seal};
use lang::isa::Op;
use lang::profile::Profile;
use lang::record::{BoardRecord, MachineRecord};
use proptest::prelude::*;

use super::TRIPPED;
use crate::chip::Chip;
use crate::rig::{IMAGE, PROFILE, SLOT, image_of};

/// A program with a value that is kept; with `courses` it says that it has some.
pub fn program(courses: bool) -> Vec<u8> {
    let mill = Profile::built_in("mill").expect("mill is built in");
    let mut image = image_of(&mill, "DIM a, b\nKEEP k\nk = k + 1\na = b\nWait 10ms\n");
    if courses {
        image[HEADER + offset_of!(MachineRecord, flags)] |= MachineRecord::COURSES;
        seal(&mut image);
    }
    image
}

/// What a run finds.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// What RAM is made of.
    seed: u64,
    run: u8,
    ending: u8,
    /// Code of the effect under way.
    effect: u8,
    /// What is 0 as often as not: axes that move, what the line does, the slots and events that are left, what holds
    /// or stops the machine, the watch.
    moving: u8,
    line: u8,
    plays: u8,
    button: u8,
    levels: Option<bool>,
    watch: u8,
    /// A program is stored, it is sound, it has courses.
    stored: bool,
    sound: bool,
    /// See `stored`.
    pub courses: bool,
}

impl Found {
    /// Puts it into a chip with this program.
    pub fn put(&self, chip: &mut Chip, image: &[u8]) {
        let mut random = Rng::new(self.seed);
        let bytes = [
            "PHASE",
            "N",
            "BITS",
            "MOTION",
            "TRACING",
            "RUN_FLAGS",
            "VM_FAULT",
            "LAST_END",
            "HOMED",
            "PLACED",
            "FAULT_IN",
            "VM_POLL",
            "PRINT_OPEN",
            "HIT",
            "NEGATIVE",
        ];
        for name in bytes {
            chip.set_byte(name, random.bits() as u8);
        }
        let words = [
            "OUTPUT",
            "RESUME_OUTPUT",
            "SPIN_APART",
            "EFFECT_PC",
            "OPEN",
            "RUNNING",
            "VM_FAULT_PC",
            "RUNS",
            "TIME",
            "UPLOAD",
        ];
        for name in words {
            chip.set_word(name, random.bits() as u16);
        }
        chip.set_long("TIME", 0, random.bits() as u32);
        for name in ["INPUT", "RAW"] {
            let any = random.bits() as u16;
            chip.set_word(name, self.levels.map_or(any, |on| if on { 0xFFFF } else { 0 }));
        }
        for (name, byte) in [
            ("RUN", self.run),
            ("ENDING", self.ending),
            ("EFFECT", self.effect),
            ("MOVING", self.moving),
            ("LINE_STATE", self.line),
            ("BUTTON", self.button),
            ("WATCH", self.watch),
        ] {
            chip.set_byte(name, byte);
        }
        let events = u16::from(self.plays);
        for slot in ["SLOT0", "SLOT1"] {
            let at = chip.at(slot) + 8;
            chip.board.poke16(at, events);
        }
        chip.set_long("LEFT", 0, events.into());
        for (at, &byte) in (IMAGE..).zip(image) {
            chip.board.poke8(at, byte);
        }
        if !self.sound {
            let last = IMAGE + image.len() as u16 - 1;
            let byte = chip.board.peek8(last);
            chip.board.poke8(last, byte & byte.wrapping_sub(1));
        }
        let code = IMAGE + (HEADER + MachineRecord::SIZE) as u16;
        chip.set_word("VM_CODE", code);
        chip.set_word("STORED", if self.stored { SLOT } else { 0 });
        let mut record = BoardRecord::of(&Profile::built_in("mill").expect("mill"), 1);
        record.spindle = random.bits() as u8 % 17;
        record.spin_up = random.bits() as u16;
        for (at, byte) in (PROFILE..).zip(record.to_bytes()) {
            chip.board.poke8(at, byte);
        }
        chip.set_word("BOARD", PROFILE);
    }
}

/// Any of it.
pub fn found() -> impl Strategy<Value = Found> {
    fn often<T: Clone + std::fmt::Debug + 'static>(
        value: T,
        other: impl Strategy<Value = T> + 'static,
    ) -> impl Strategy<Value = T> {
        prop_oneof![Just(value), other]
    }
    let run = prop_oneof![0u8..5, Just(6)];
    let effect = prop_oneof![Just(0), Op::Probe as u8..=Op::HomeQuery as u8, any::<u8>()];
    let zeroes = (
        often(0, 0u8..8),
        often(0, any::<u8>()),
        often(0, any::<u8>()),
        often(0, any::<u8>()),
        often(Some(false), any::<Option<bool>>()),
        often(0, often(TRIPPED, any::<u8>())),
    );
    let stored = [any::<bool>(), any::<bool>(), any::<bool>()];
    (any::<u64>(), run, 0u8..4, effect, zeroes, stored).prop_map(
        |(
            seed,
            run,
            ending,
            effect,
            (moving, line, plays, button, levels, watch),
            [stored, sound, courses],
        )| Found {
            seed,
            run,
            ending,
            effect,
            moving,
            line,
            plays,
            button,
            levels,
            watch,
            stored,
            sound,
            courses,
        },
    )
}
