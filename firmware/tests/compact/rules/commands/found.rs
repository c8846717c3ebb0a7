//! States that a command finds, and commands that are often sound.

use emulator::Rng;
use lang::isa::Op;
use lang::record::BoardRecord;
use lang::wire::command;
use proptest::prelude::*;

use super::{HELD, WORDS, place};
use crate::chip::Chip;
use crate::coords::value;
use crate::rig::PROFILE;

/// What a command finds.
#[derive(Clone, Debug)]
pub struct Found {
    /// What RAM is made of.
    pub seed: u64,
    /// The command and its arguments.
    pub words: Vec<u16>,
    /// Run state, effect, axes that move, roles that are on.
    pub bytes: [u8; 4],
    /// A program is stored.
    pub program: bool,
}

impl Found {
    /// Puts it into a chip.
    pub fn put(&self, chip: &mut Chip) {
        let mut random = Rng::new(self.seed);
        for name in ["UM", "STEPS", "OFFSET", "ACTUAL"] {
            for n in 0..3 {
                chip.set_long(name, 4 * n, (random.bits() as i32 >> 12) as u32);
            }
        }
        for name in ["HOMED", "PLACED", "NEGATIVE", "HOMING_ERROR", "PROBE_ERROR", "PROBE_OK"] {
            chip.set_byte(name, random.bits() as u8 & 7);
        }
        let [run, effect, moving, roles] = self.bytes;
        for (name, byte) in
            [("RUN", run), ("EFFECT", effect), ("MOVING", moving), ("N", random.bits() as u8 % 3)]
        {
            chip.set_byte(name, byte);
        }
        chip.set_byte("PHASE", if effect == 0 { 0 } else { 3 });
        chip.set_byte("MOTION", random.bits() as u8 & HELD);
        let mut record = BoardRecord::DEFAULT;
        record.flags |= BoardRecord::CHAIN;
        record.reference = [3, 4, 5];
        record.door = [6, 0];
        for (at, byte) in (PROFILE..).zip(record.to_bytes()) {
            chip.board.poke8(at, byte);
        }
        chip.set_word("BOARD", PROFILE);
        for name in ["INPUT", "RAW"] {
            chip.set_word(name, random.bits() as u16 & !(1 << 5) | u16::from(roles) << 5);
        }
        chip.set_word("OVERRIDE", 100 << 8 | 100);
        if !self.program {
            chip.set_word("VM_CODE", 0);
        }
        for (n, word) in (0..).zip(&self.words) {
            chip.board.poke16(place(chip, n), *word);
        }
    }
}

/// A long that is a rate or a way.
fn long() -> impl Strategy<Value = i32> {
    prop_oneof![20 => 1..30_000, 2 => -3_000..3_000, 1 => Just(0), 1 => value()]
}

/// A command with arguments that are often sound.
fn words() -> impl Strategy<Value = Vec<u16>> {
    let code = prop_oneof![
        20 => prop::sample::select(vec![100u16, 101, 102, 103, 104, 105, 106, 107, 108, 110]),
        8 => prop::sample::select(vec![command::HOME_PROFILE, command::JOG, command::DIRECT]),
        1 => prop::sample::select(vec![99u16, 109, 111, 1109, 1112, 1201, 358, 5]),
        1 => any::<u16>()
    ];
    let direct = vec![0u16, 87, 88, 128, 129, 130, 131, 132, 133, 134, 255, 343];
    let first = (1u16..4, 0u16..75, prop::sample::select(direct), any::<u16>(), 0u8..12);
    let flag = || prop_oneof![9 => 0u16..2, 1 => 2u16..4, 1 => any::<u16>()];
    let input = || prop_oneof![9 => 0u16..17, 1 => any::<u16>()];
    let zero = prop_oneof![9 => Just(0u16), 1 => any::<u16>()];
    let float = || (-30i16..4_000).prop_map(|mm| f32::from(mm) / 40.0);
    let heads = (zero, input(), flag(), flag());
    let rest = (heads, prop::collection::vec(long(), 10), [float(), float(), float(), float()]);
    (code, first, rest).prop_map(|(code, first, ((zero, input, level, side), longs, floats))| {
        let (axis, bits, direct, any, which) = first;
        let first = match (code, which) {
            (_, 0) => any,
            (command::JOG, _) => bits,
            (command::DIRECT, _) => direct,
            (command::FORCE_INPUT, _) => input,
            _ => axis,
        };
        let mut words = vec![code, first];
        let pair = |value: i32| [value as u16, (value >> 16) as u16];
        match code {
            command::HOME => words.extend([zero, input, level, side]),
            command::PROBE => words.extend([input, level]),
            command::FORCE_INPUT => words.push(if side == 0 { 0xFFFF } else { level }),
            command::JOG => words.extend(floats.iter().flat_map(|f| pair(f.to_bits() as i32))),
            _ => {}
        }
        words.extend(longs.iter().flat_map(|value| pair(*value)));
        words.truncate(WORDS.into());
        words
    })
}

/// Any of it, most often what lets a command begin.
pub fn found() -> impl Strategy<Value = Found> {
    let run = prop_oneof![9 => Just(1u8), 1 => 0u8..7];
    let command = Op::Probe as u8..=Op::HomeQuery as u8;
    let effect = prop_oneof![9 => Just(0u8), 1 => command, 1 => any::<u8>()];
    let moving = prop_oneof![9 => Just(0u8), 1 => 1u8..8];
    let roles = prop_oneof![8 => Just(0u8), 1 => Just(1u8)];
    let bytes = (run, effect, moving, roles).prop_map(|(a, b, c, d)| [a, b, c, d]);
    (any::<u64>(), words(), bytes, prop::bool::weighted(0.8))
        .prop_map(|(seed, words, bytes, program)| Found { seed, words, bytes, program })
}
