//! Images that are no compiler's: mutated, truncated, spliced, random. The verifier refuses them,
//! or they run without an error of stack or program counter, on the host's VM and on the board.

pub mod board;
pub mod judge;

use std::sync::atomic::{AtomicU64, Ordering};

use emulator::Rng;
use lang::image::{HEADER, Image, at as header, seal};
use lang::isa::{FINGERPRINT, Op, Operands};
use lang::record::MachineRecord;

use super::generate::generate_for;
use super::programs::{make_for, tape};
use super::{Row, Settings, Sink, Verdict};
use crate::board::{Build, DEFAULT};

/// Images that the cases are made from.
const CORPUS: u64 = 48;
/// Where the code begins.
const CODE: usize = HEADER + MachineRecord::SIZE;

/// Compiled programs for a board, the longest as long as it takes.
///
/// # Errors
/// No generated program compiles.
pub fn corpus(build: &Build, settings: &Settings) -> Result<Vec<Vec<u8>>, String> {
    let case = |n| generate_for(build.part, &tape(settings, "corpus", n));
    let made = (0..CORPUS).filter_map(|n| make_for(build, case(n)));
    let images: Vec<_> = made.map(|made| made.compiled.image).collect();
    if images.is_empty() { Err("no generated program compiles".to_owned()) } else { Ok(images) }
}

fn pick<'a, T>(rng: &mut Rng, list: &'a [T]) -> Option<&'a T> {
    list.get(rng.below(list.len() as u64) as usize)
}

fn at(rng: &mut Rng, length: usize) -> usize {
    rng.below(length as u64) as usize
}

/// Random bytes.
fn noise(rng: &mut Rng, length: usize) -> Vec<u8> {
    (0..length).map(|_| rng.bits() as u8).collect()
}

/// Code of any bytes in a sound shell.
fn any_code(rng: &mut Rng, shell: &[u8]) -> Vec<u8> {
    let mut image = shell.get(..CODE).unwrap_or(shell).to_vec();
    image.resize(CODE, 0);
    let length = 1 + at(rng, 60);
    image.extend(noise(rng, length));
    // No instruction falls off the end; a little data for those that read some.
    image.push(Op::End as u8);
    image.extend([1, 2, 10, 0, 20, 0, 3, b'a', b'b', b'c']);
    let whole = (image.len() as u16).to_le_bytes();
    image[header::LEN..][..2].copy_from_slice(&whole);
    image[header::CODE_LEN..][..2].copy_from_slice(&(length as u16 + 1).to_le_bytes());
    image[1] = 0;
    image[header::ENTRY..][..2].fill(0);
    // 255 stands for 256.
    image[header::CELLS] = [rng.below(20) as u8, 254, 255][at(rng, 3)];
    image[header::STACK] = rng.below(16) as u8;
    image[header::FRAME] = rng.below(16) as u8;
    image[header::CALLS] = rng.below(16) as u8;
    image[header::KEEPS] = 0;
    image[header::KEEP_BASE] = 0;
    image
}

/// Replaces instructions by others of the same length: what comes of it is accepted more often
/// than what chance makes.
fn other_instructions(rng: &mut Rng, image: &mut [u8]) {
    let Ok(read) = Image::new(image) else { return };
    let mut places = Vec::new();
    let mut pc = 0;
    while let Some((op, _)) = read.code.get(pc).and_then(|code| Op::decode(*code)) {
        places.push((CODE + pc, op.row().operands));
        pc += 1 + op.row().operands.len(false);
    }
    for _ in 0..1 + rng.below(3) {
        let Some(&(place, operands)) = pick(rng, &places) else { return };
        for _ in 0..20 {
            let code = rng.bits() as u8;
            let same = |other: Operands| other.len(false) == operands.len(false);
            if Op::decode(code).is_some_and(|(op, _)| same(op.row().operands))
                && let Some(byte) = image.get_mut(place)
            {
                *byte = code;
                break;
            }
        }
    }
}

/// A damaged image; mostly with its CRC made good again.
pub fn damaged(rng: &mut Rng, corpus: &[Vec<u8>]) -> Vec<u8> {
    let mut image = pick(rng, corpus).cloned().unwrap_or_default();
    match rng.below(16) {
        0 => {
            let end = at(rng, image.len());
            image.truncate(end);
            if rng.below(2) == 0 && image.len() >= HEADER {
                let whole = (image.len() as u16).to_le_bytes();
                image[header::LEN..][..2].copy_from_slice(&whole);
            }
        }
        1 => {
            let length = at(rng, 400);
            image = noise(rng, length);
            if image.len() >= HEADER && rng.below(2) == 0 {
                let fingerprint = FINGERPRINT.to_le_bytes();
                image[2..4].copy_from_slice(&fingerprint);
                image[0] = corpus.first().map_or(0, |first| first[0]);
            }
        }
        2 | 3 => image = any_code(rng, &image),
        4..=7 => other_instructions(rng, &mut image),
        8 => {
            // A piece of another program, or of the same at another place.
            let from = pick(rng, corpus).cloned().unwrap_or_default();
            let length = 1 + at(rng, 24);
            let (source, target) = (at(rng, from.len()), CODE + at(rng, image.len() - CODE));
            for (to, byte) in image.iter_mut().skip(target).take(length).zip(&from[source..]) {
                *to = *byte;
            }
        }
        9 => {
            let place = 9 + at(rng, HEADER - 9);
            image[place] = rng.bits() as u8;
        }
        10 => {
            let place = at(rng, image.len());
            image[place] ^= 1 << rng.below(8);
        }
        _ => {
            for _ in 0..1 + rng.below(4) {
                let place = at(rng, image.len());
                image[place] = rng.bits() as u8;
            }
        }
    }
    if rng.below(16) != 0 {
        seal(&mut image);
    }
    image
}

/// Images through the verifier and the VM on the host, then through the emulated board.
///
/// # Errors
/// There is nothing to make images from, or the table cannot be written.
pub fn run(settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    let corpus = corpus(DEFAULT, settings)?;
    let fault = "damaged, verifier and vm";
    let mut row = Row::new("images", fault, settings);
    let accepted = AtomicU64::new(0);
    row.run(settings, settings.count(30_000, 1_000_000, 10_000_000), |n| {
        let mut rng = settings.rng(fault, n);
        let image = damaged(&mut rng, &corpus);
        match judge::try_out(&image, &mut rng) {
            Ok(true) => {
                accepted.fetch_add(1, Ordering::Relaxed);
                Verdict::Survived
            }
            Ok(false) => Verdict::Survived,
            Err(text) => Verdict::Lost(format!("{text}: {image:02X?}")),
        }
    });
    row.note = format!("{} accepted and run", accepted.into_inner());
    sink(row)?;
    settings.builds.iter().try_for_each(|build| board::run(build, settings, sink))
}
