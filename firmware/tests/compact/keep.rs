//! KEEP values: the ring against [`firmware::keep`], power cuts.

use std::mem::offset_of;

use firmware::keep::{self, Kept};
use firmware::store::Store;
use lang::record::MachineRecord;
use lang::wire::{Exception, RunState, Upload};
use proptest::prelude::*;

use crate::area::{Area, image, send};
use crate::chip::Chip;

/// A chip with a program of `n` KEEP values and the twin of its flash.
fn stored(n: u16) -> (Chip, Area) {
    let names: Vec<String> = (0..n).map(|index| format!("k{index}")).collect();
    let mut chip = Chip::new();
    assert!(send(&mut chip, &image(&format!("KEEP {}\nk0 = 1", names.join(", "))), true, 1));
    chip.call("upload_control", &[(12, Upload::Commit as u16)]);
    assert_eq!(chip.reg(12), 0);
    let area = Area::of(&chip);
    (chip, area)
}

/// A run whose cells lie at the pool's start.
fn run(chip: &mut Chip) {
    let pool = chip.at("POOL");
    chip.set_byte("RUN", RunState::Running as u8);
    chip.set_word("VM_CELLS", pool);
}

fn set(chip: &mut Chip, index: u16, value: i32) -> Option<u16> {
    let (low, high) = (value as u16, (value >> 16) as u16);
    chip.try_call("keep_write", &[(12, index), (14, low), (15, high)])?;
    Some(chip.reg(12))
}

fn get(chip: &mut Chip, index: u16) -> i32 {
    chip.call("keep_read", &[(12, index)]);
    chip.result() as i32
}

/// What the chip's program keeps.
fn kept(chip: &Chip, count: u16) -> Kept {
    let place = MachineRecord::SIZE - offset_of!(MachineRecord, keeps);
    Kept { count, mark: chip.board.peek8(chip.word("VM_CODE") - place as u16) }
}

fn values(area: &Area, kept: Kept) -> Vec<i32> {
    (0..kept.count).map(|index| keep::read(area, kept, index)).collect()
}

/// The first cell of the KEEP values, which need not be the program's first.
fn first_cell(chip: &Chip) -> u16 {
    let header = chip.word("VM_CODE") - firmware::verify::CODE;
    4 * u16::from(chip.board.peek8(header + 17))
}

#[derive(Clone, Debug)]
enum Step {
    Write(u16, i32),
    Run(Vec<(u16, i32)>),
    Reset,
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let value = prop_oneof![Just(0), -3..3i32, any::<i32>()];
    let change = (0u16..9, value.clone());
    let step = prop_oneof![
        8 => (0u16..9, value).prop_map(|(index, value)| Step::Write(index, value)),
        3 => prop::collection::vec(change, 0..12).prop_map(Step::Run),
        1 => Just(Step::Reset),
    ];
    prop::collection::vec(step, 1..80)
}

fn compare(keeps: u16, owner: u16, steps: &[Step]) -> Result<(), TestCaseError> {
    let (mut chip, mut area) = stored(keeps);
    // Another program's values must not show.
    let kept = kept(&chip, keeps);
    keep::save(&mut area, kept.mark ^ 0x40, &vec![77; usize::from(owner)]);
    for (at, &byte) in area.0.iter().enumerate() {
        chip.board.poke8(crate::area::AREA + at as u16, byte);
    }
    for step in steps {
        match step {
            &Step::Write(index, value) => {
                let exception = set(&mut chip, index, value);
                if index < keeps {
                    let mut cells = values(&area, kept);
                    cells[usize::from(index)] = value;
                    keep::save(&mut area, kept.mark, &cells);
                    prop_assert_eq!(exception, Some(0));
                } else {
                    prop_assert_eq!(exception, Some(Exception::IllegalValue as u16));
                }
            }
            Step::Run(changes) => {
                run(&mut chip);
                chip.call("keep_load", &[]);
                let mut cells = values(&area, kept);
                keep::save(&mut area, kept.mark, &cells);
                for (index, &cell) in cells.iter().enumerate() {
                    prop_assert_eq!(get(&mut chip, index as u16), cell);
                    let offset = first_cell(&chip) + 4 * index as u16;
                    prop_assert_eq!(chip.long("POOL", offset) as i32, cell);
                }
                for &(index, value) in changes.iter().filter(|(index, _)| *index < keeps) {
                    prop_assert_eq!(set(&mut chip, index, value), Some(0));
                    cells[usize::from(index)] = value;
                }
                chip.call("keep_save", &[]);
                keep::save(&mut area, kept.mark, &cells);
                chip.set_byte("RUN", RunState::Ready as u8);
            }
            Step::Reset => {
                chip.restart();
                chip.call("store_mount", &[]);
                Store::new().mount(&mut area);
            }
        }
        prop_assert!(Area::of(&chip) == area, "the flash differs after {:?}", step);
        for index in 0..8 {
            prop_assert_eq!(get(&mut chip, index), keep::read(&area, kept, index));
        }
    }
    prop_assert_eq!(chip.board.warnings(), &[]);
    Ok(())
}

#[test]
fn the_ring_is_the_twins() {
    proptest!(ProptestConfig::with_cases(30), |(keeps in 1u16..9, owner in 1u16..9, steps in steps())| {
        compare(keeps, owner, &steps)?;
    });
}

#[test]
fn a_program_without_keep_values_takes_none() {
    let mut chip = Chip::new();
    chip.call("keep_load", &[]);
    chip.call("keep_save", &[]);
    assert_eq!(set(&mut chip, 0, 5), Some(Exception::IllegalValue as u16));
    assert_eq!(get(&mut chip, 0), 0);
    assert_eq!(chip.board.wear().operations, 0);
}

#[test]
fn a_value_is_not_written_while_an_axis_moves() {
    let (mut chip, ..) = stored(2);
    chip.set_byte("MOVING", 2);
    assert_eq!(set(&mut chip, 0, 5), Some(Exception::Busy as u16));
    run(&mut chip);
    assert_eq!(set(&mut chip, 0, 5), Some(0), "of a run it is a cell");
}

#[test]
fn a_value_cut_anywhere_is_the_old_one_or_the_new() {
    for filled in [3, 13, 14, 15, 27, 28, 29] {
        let (mut before, ..) = stored(8);
        for round in 1..=filled {
            assert_eq!(set(&mut before, 1, round), Some(0));
        }
        let mut cuts = 0;
        loop {
            let mut chip = before.clone();
            chip.board.cut_at_flash_operation(cuts + 1, cuts);
            if set(&mut chip, 0, 0x1234_5678).is_some() {
                break;
            }
            cuts += 1;
            chip.restart();
            chip.call("store_mount", &[]);
            let found = [get(&mut chip, 0), get(&mut chip, 1)];
            assert_eq!(found[1], filled, "cut {cuts} after {filled}");
            assert!(found[0] == 0 || found[0] == 0x1234_5678, "cut {cuts}: {found:x?}");
            assert_eq!(set(&mut chip, 7, 7), Some(0));
            assert_eq!(get(&mut chip, 7), 7, "after cut {cuts}");
        }
        assert!(cuts >= 4, "{cuts} cuts");
    }
}
