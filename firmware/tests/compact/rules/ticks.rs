//! Milliseconds: [`ticks`] by rustc and as micro-code, with whatever counts in time.

use emulator::Rng;
use firmware::rules::ticks::{self, Starts, Ticks};
use lang::isa::{Op, first};
use lang::profile::Profile;
use lang::record::BoardRecord;
use proptest::prelude::*;

use super::session::{found, program};
use super::{Entry, Twin, proved, with_profile};
use crate::chip::Chip;
use crate::lockstep::{OnChip, runner};
use crate::machine::mill;
use crate::rig::{Rig, T_FULL, T_HEARD, T_ON};
use crate::verify::Elf;

/// RUN_FLAGS: half a second has passed; a host has spoken.
const BOOTED: u8 = 2;
const HOST: u8 = 8;
/// MOTION: brake when the host falls silent.
const JOG: u8 = 32;
/// TRACING: a quarter of a second.
const QUARTER: u8 = 16;

impl Starts for Twin {
    fn has_booted(&self) -> bool {
        self.chip.byte("RUN_FLAGS") & BOOTED != 0
    }
    fn boots(&self) -> bool {
        self.chip.word("MILLIS") < 500
    }
    fn set_booted(&mut self) {
        self.bits_of("RUN_FLAGS", 0, BOOTED);
    }
    fn has_host(&self) -> bool {
        self.chip.byte("RUN_FLAGS") & HOST != 0
    }
    fn wants_autorun(&self) -> bool {
        self.board_record().flags & BoardRecord::AUTORUN != 0
    }
    fn was_powered_up(&self) -> bool {
        self.chip.byte("CAUSE") == 4
    }
}

impl Ticks for Twin {
    fn set_lamp(&mut self) {
        let n = self.board_record().lamp;
        self.chip.call("set_output", &[(12, n.into()), (13, self.high)]);
    }
    fn quarter(&self) -> u8 {
        self.chip.byte("TICKS_DONE")
    }
    fn has_reader(&self) -> bool {
        self.chip.byte("TRACING") & *T_HEARD != 0
    }
    fn count_quarter(&mut self) {
        let tracing = self.chip.byte("TRACING");
        self.chip.set_byte("TRACING", tracing.wrapping_sub(QUARTER));
    }
    fn end_trace(&mut self) {
        self.bits_of("TRACING", *T_ON | *T_FULL, 0);
    }
    fn is_held(&self) -> bool {
        self.chip.byte("MOTION") & JOG != 0
    }
    fn counts(&self) -> bool {
        (Op::Home as u8..=Op::Wait as u8).contains(&self.chip.byte("EFFECT"))
    }
    fn is_pulse(&self) -> bool {
        self.chip.byte("EFFECT") == first::Pulse
    }
    fn time_less_one(&self) -> i32 {
        (self.chip.long("TIME", 0) as i32).wrapping_sub(1)
    }
    fn set_time(&mut self, ms: i32) {
        self.chip.set_long("TIME", 0, ms as u32);
    }
    fn number(&self) -> u8 {
        self.chip.byte("N")
    }
    fn end_pulse(&mut self, n: u8) {
        self.chip.call("output_off", &[(12, n.into())]);
    }
    fn listen(&mut self) {
        self.chip.call("event_tick", &[]);
    }
}

#[test]
fn milliseconds_are_the_same_by_rustc_and_as_micro_code() {
    let image = program(false);
    let profile = Profile::built_in("mill").expect("mill is built in");
    let base = OnChip::of(&Rig::with_image(&profile, &image).chip, &Elf::of("whole"), true);
    let effect = prop_oneof![Just(0), Op::Probe as u8..=Op::Wait as u8 + 1, any::<u8>()];
    let time = prop_oneof![Just(0), Just(-1), Just(1), any::<i32>()];
    let start = (found(), effect, time, prop_oneof![498u16..503, any::<u16>()], any::<u64>());
    let result = runner(600).run(&start, |(found, effect, time, millis, seed)| {
        let put = |chip: &mut Chip| {
            found.put(chip, &image);
            let mut random = Rng::new(seed);
            let mut record = BoardRecord::of(&profile, 1);
            record.flags = if seed & 1 == 0 { record.flags } else { random.bits() as u16 };
            record.lamp = random.bits() as u8 % 18;
            with_profile(chip, &record);
            chip.set_word("MILLIS", millis);
            chip.set_byte("TICKS_DONE", if seed & 2 == 0 { 0 } else { millis as u8 });
            chip.set_byte("CAUSE", if random.bits() & 1 == 0 { 4 } else { random.bits() as u8 });
            chip.set_byte("RUN_FLAGS", if seed & 4 == 0 { 0 } else { random.bits() as u8 });
            chip.set_byte("EFFECT", effect);
            chip.set_long("TIME", 0, time as u32);
        };
        let level = seed as u32 & 1 << 16;
        let entry = Entry { acc: level, scratch: &[("TEMP", 1)], ..Entry::default() };
        proved(&base, "ticks_rest", &mill(), &put, &entry, &|m| {
            ticks::tick(m);
            None
        });
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}
