//! The small chip's ramp generator: [`segments`] by rustc and as micro-code, from any numbers of the planner. Both hand the same
//! registers on, r4 to r8, as the chip's instructions between them take and leave those.

use emulator::Rng;
use firmware::motion::scaled::Scaled;
use firmware::rules::segments::{self, Segments};
use lang::record::MachineRecord;
use proptest::prelude::*;

use super::stops::planned;
use super::{Entry, Twin, proved};
use crate::chip::Chip;
use crate::lockstep::{OnChip, runner};
use crate::machine::mill;
use crate::verify::Elf;

/// Bits of MOTION: a pause, a line that ends at speed, a stop.
const PAUSE: u8 = 1;
const THROUGH: u8 = 4;
const STOP: u8 = 16;
/// In a slot: the change of its interval, its events.
const CHANGE: u16 = 4;
const EVENTS: u16 = 8;
/// From the square to run at to that from rest.
const AT_REST: u16 = 4;

impl Twin {
    /// The register that says which goal and which slot it is.
    fn indexed(&self, name: &str) -> u32 {
        self.chip.long(name, self.chip.reg(8))
    }
}

impl Segments for Twin {
    fn left(&self) -> i32 {
        self.chip.long("LEFT", 0) as i32
    }
    fn brakes(&self) -> bool {
        self.chip.byte("MOTION") & (PAUSE | STOP) != 0
    }
    fn aim_at_rest(&mut self) {
        self.chip.board.set_reg(8, AT_REST);
    }
    fn goal2(&self) -> Scaled {
        Scaled(self.indexed("NOMINAL2"))
    }
    fn start2(&self) -> Scaled {
        self.scaled("START2")
    }
    fn exit2(&self) -> Scaled {
        firmware::rules::planner::Chains::exit2(self)
    }
    fn ends_at_speed(&self) -> bool {
        self.chip.byte("MOTION") & THROUGH != 0
    }
    fn tick(&self) -> Scaled {
        self.scaled("TICK")
    }
    fn accel2(&self) -> Scaled {
        self.scaled("ACCEL2")
    }
    fn decel2(&self) -> Scaled {
        self.scaled("DECEL2")
    }
    fn end_speed(&self) -> Scaled {
        self.scaled("V")
    }
    fn set_end_speed(&mut self, speed: Scaled) {
        self.set_scaled("V", speed);
    }
    fn end_speed2(&self) -> Scaled {
        self.scaled("V2")
    }
    fn set_end_speed2(&mut self, square: Scaled) {
        self.set_scaled("V2", square);
    }
    fn next_speed(&self) -> Scaled {
        Scaled(self.chip.long("TEMP", 0))
    }
    fn set_next_speed(&mut self, speed: Scaled) {
        self.chip.set_long("TEMP", 0, speed.0);
    }
    fn next_speed2(&self) -> Scaled {
        Scaled(self.chip.long("TEMP", 4))
    }
    fn set_next_speed2(&mut self, square: Scaled) {
        self.chip.set_long("TEMP", 4, square.0);
    }
    fn least_next_speed2(&mut self, square: Scaled) -> Scaled {
        let least = self.next_speed2().least(square);
        self.set_next_speed2(least);
        least
    }
    fn sum(&self) -> Scaled {
        Scaled(self.chip.long("TEMP", 8))
    }
    fn set_sum(&mut self, sum: Scaled) {
        self.chip.set_long("TEMP", 8, sum.0);
    }
    fn keep_sign(&mut self, gap: i32) -> i32 {
        self.calls("segment_sign", gap as u32) as i32
    }
    fn is_slow(&self) -> bool {
        self.chip.reg(2) & 4 != 0
    }
    fn events_by_time(&mut self, gap: i32) {
        self.calls("segment_by_time", gap as u32);
    }
    fn cruises(&self, rise: Scaled) -> bool {
        let mut chip = self.chip.clone();
        chip.call("segment_cruises", &[(12, rise.0 as u16), (13, (rise.0 >> 16) as u16)]);
        chip.reg(2) & 1 != 0
    }
    fn events_by_speed(&mut self, gap: i32) {
        self.calls("segment_by_speed", gap as u32);
    }
    fn take_events(&mut self) -> Scaled {
        Scaled(self.calls("segment_take", 0))
    }
    fn divide(&mut self, gap: i32) {
        self.calls("segment_divide", gap as u32);
    }
    fn units(&self, ticks: Scaled) -> i32 {
        let mut chip = self.chip.clone();
        chip.call("segment_scale", &[(12, ticks.0 as u16), (13, (ticks.0 >> 16) as u16)]);
        chip.result() as i32
    }
    fn fastest(&self) -> Scaled {
        Scaled(self.indexed("SLOT0"))
    }
    fn set_fastest(&mut self, speed: Scaled) {
        self.chip.set_long("SLOT0", self.chip.reg(8), speed.0);
    }
    fn interval(&self) -> i32 {
        self.indexed("SLOT0") as i32
    }
    fn set_interval(&mut self, interval: i32) {
        self.chip.set_long("SLOT0", self.chip.reg(8), interval as u32);
    }
    fn set_dif(&mut self, dif: i32) {
        self.chip.set_long("SLOT0", self.chip.reg(8) + CHANGE, dif as u32);
    }
    fn dif_of(&mut self, longer: i32) -> i32 {
        self.calls("segment_change", longer as u32) as i32
    }
    fn first_of(&self, dif: i32) -> i32 {
        let mut chip = self.chip.clone();
        chip.call("segment_half", &[(12, dif as u16), (13, (dif >> 16) as u16)]);
        chip.result() as i32
    }
    fn fill(&mut self) -> bool {
        let at = self.chip.at("SLOT0") + self.chip.reg(6) + EVENTS;
        self.chip.board.poke16(at, self.chip.reg(5));
        true
    }
}

#[test]
fn segments_are_the_same_by_rustc_and_as_micro_code() {
    let base = OnChip::of(&Chip::new(), &Elf::of("whole"), true);
    let machine = MachineRecord { ..mill() };
    let left = prop_oneof![1 => Just(0u32), 4 => 1..2_000u32, 2 => 1..2_000_000u32];
    let start = (any::<u64>(), left, any::<u8>(), 0u8..4, any::<bool>());
    let result = runner(1_500).run(&start, |(seed, left, motion, goal, second)| {
        let put = |chip: &mut Chip| {
            let mut random = Rng::new(seed);
            for name in ["V2", "V", "ACCEL2", "DECEL2", "NOMINAL2", "START2", "TICK", "EXIT2"] {
                let number = planned(&mut random);
                let at = chip.board.symbol(name);
                // The square at a line's end is the pool's.
                let at = at.unwrap_or_else(|| chip.at("POOL_END") - 8);
                chip.board.poke16(at, number.0 as u16);
                chip.board.poke16(at + 2, (number.0 >> 16) as u16);
            }
            // Often at the speed to run at, or as slow as it begins.
            if let Some(name) = ["NOMINAL2", "START2"].get(usize::from(goal)) {
                chip.set_long(name, 0, chip.long("V2", 0));
            }
            chip.set_long("LEFT", 0, left);
            chip.set_byte("MOTION", motion);
            let slot = if second { chip.at("SLOT1") - chip.at("SLOT0") } else { 0 };
            for (register, value) in [(4, 0), (5, 0), (6, slot), (7, 0), (8, 0)] {
                chip.board.set_reg(register, value);
            }
        };
        proved(&base, "segment", &machine, &put, &Entry::default(), &|m| {
            segments::segment(m);
            None
        });
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}
