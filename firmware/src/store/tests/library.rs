//! Several programs beside one another, and cuts of power at any operation.

use std::collections::BTreeMap;

use lang::part::F5529;
use proptest::prelude::*;

use super::super::{Flash, NAME, Store, Upload};
use super::{Chip, image};

/// The F5529's area.
#[derive(Clone)]
struct Shelf(Chip);

impl Flash for Shelf {
    const SEGMENTS: u8 = F5529.segments;
    const PROGRAMS: u8 = F5529.programs;

    fn read(&self, offset: u16) -> u16 {
        self.0.read(offset)
    }
    fn write(&mut self, offset: u16, word: u16) {
        self.0.write(offset, word);
    }
    fn erase(&mut self, offset: u16) {
        self.0.erase(offset);
    }
    fn image(&self, offset: u16) -> Option<u16> {
        self.0.image(offset)
    }
    fn length(&self, offset: u16) -> u16 {
        self.0.length(offset)
    }
}

/// What a program is: its image's words and its name.
type Program = (Vec<u16>, [u16; NAME]);

#[derive(Clone, Copy, Debug)]
enum Step {
    Bring { number: u8, words: u16, seed: u16, keeps: bool, replace: bool },
    Discard { number: u8 },
    Reset,
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    // Few numbers, so that versions follow one another; the outermost too.
    let number = || prop_oneof![1u8..5, Just(64u8), 0u8..66];
    let words = prop_oneof![4 => 3u16..2500, 1 => 2500u16..16_384];
    let bring = (number(), words, 1u16..100, any::<bool>(), any::<bool>());
    let step = prop_oneof![
        6 => bring.prop_map(|(number, words, seed, keeps, replace)| {
            Step::Bring { number, words, seed, keeps, replace }
        }),
        1 => number().prop_map(|number| Step::Discard { number }),
        1 => Just(Step::Reset),
    ];
    prop::collection::vec(step, 1..12)
}

fn name(seed: u16) -> [u16; NAME] {
    std::array::from_fn(|n| seed.wrapping_mul(n as u16 + 1))
}

/// Takes a step; what is there behind it. A refused upload changes nothing, unless it was to replace.
fn take(store: &mut Store, flash: &mut Shelf, there: &mut BTreeMap<u8, Program>, step: Step) {
    match step {
        Step::Bring { number, words, seed, keeps, replace } => {
            let image = image(words, seed);
            let upload = Upload { number, length: 2 * image.len() as u16, keeps };
            let begun = store.begin(flash, upload, replace).is_ok();
            if replace && (1..=64).contains(&number) {
                there.remove(&number);
            }
            let brings = |store: &mut Store, flash: &mut Shelf| {
                let mut words = (0..).step_by(2).zip(&image);
                words.all(|(at, &word)| store.write(flash, at, word).is_ok())
                    && store.commit(flash, &name(seed)).is_ok()
            };
            if begun && brings(store, flash) {
                there.insert(number, (image, name(seed)));
            }
        }
        Step::Discard { number } => {
            store.discard(flash, number);
            there.remove(&number);
        }
        Step::Reset => store.mount(flash),
    }
}

fn found(store: &Store, flash: &Shelf) -> BTreeMap<u8, Program> {
    let program = |number: u8| {
        let first = usize::from(store.image_of::<Shelf>(number)?) / 2;
        let length = usize::from(flash.0.words[first]);
        let name = std::array::from_fn(|n| store.name(flash, number, n as u16));
        Some((number, (flash.0.words[first..first + length].to_vec(), name)))
    };
    (0..=255).filter_map(program).collect()
}

fn run(steps: &[Step], cut: Option<(usize, u32, u16)>) -> Result<(), TestCaseError> {
    let (mut store, mut flash) = (Store::new(), Shelf(Chip::of(F5529.segments)));
    let mut there = BTreeMap::new();
    for (n, &step) in steps.iter().enumerate() {
        let before = there.clone();
        let (mut whole, mut wholly) = (store, flash.clone());
        take(&mut whole, &mut wholly, &mut there, step);
        let used: u16 = there.values().map(|(image, _)| 2 * image.len() as u16).sum();
        prop_assert!(whole.free(&wholly) <= Store::area::<Shelf>() - used);
        prop_assert_eq!(&found(&whole, &wholly), &there, "behind {:?}", step);
        let Some((at, operation, noise)) = cut.filter(|cut| cut.0 == n) else {
            (store, flash) = (whole, wholly);
            continue;
        };
        // Power fails in the middle of it: all others are as they were, this one is its old or its new
        // version, or none where that was asked for.
        let operations = wholly.0.operations - flash.0.operations;
        flash.0.cut_at = flash.0.operations + 1 + operation % operations.max(1);
        flash.0.noise = noise;
        take(&mut store, &mut flash, &mut before.clone(), step);
        flash.0.cut_at = u32::MAX;
        store.mount(&mut flash);
        let (Step::Bring { number, .. } | Step::Discard { number }) = step else {
            prop_assert_eq!(&found(&store, &flash), &before, "a reset cut at {}", at);
            return Ok(());
        };
        let (mut left, mut old, mut new) = (found(&store, &flash), before, there.clone());
        let gives_up = !matches!(step, Step::Bring { replace: false, .. });
        let [left_one, old_one, new_one] =
            [&mut left, &mut old, &mut new].map(|one| one.remove(&number));
        prop_assert_eq!(&left, &old, "others, cut in {:?}", step);
        let fits = left_one == old_one || left_one == new_one || gives_up && left_one.is_none();
        prop_assert!(fits, "cut in {step:?}: {:?}", left_one.map(|one| one.0.len()));
        // And the next upload is taken.
        let small = Step::Bring { number: 9, words: 20, seed: 3, keeps: false, replace: true };
        left.extend(left_one.map(|one| (number, one)));
        take(&mut store, &mut flash, &mut left, small);
        store.mount(&mut flash);
        prop_assert_eq!(&found(&store, &flash), &left, "the next one, behind a cut in {:?}", step);
        return Ok(());
    }
    store.mount(&mut flash);
    prop_assert_eq!(found(&store, &flash), there);
    Ok(())
}

proptest! {
    #[test]
    fn programs_are_what_was_brought(steps in steps()) {
        run(&steps, None)?;
    }

    #[test]
    fn a_cut_anywhere_harms_no_other_program(
        steps in steps(), at in 0usize..12, operation: u32, noise: u16
    ) {
        run(&steps, Some((at % steps.len(), operation, noise)))?;
    }
}

#[test]
fn sixty_four_programs_fit_and_the_one_that_replaces_another_finds_its_place() {
    let (mut store, mut flash) = (Store::new(), Shelf(Chip::of(F5529.segments)));
    let mut there = BTreeMap::new();
    let bring =
        |number, words| Step::Bring { number, words, seed: 7, keeps: false, replace: false };
    (1..=64).for_each(|number| take(&mut store, &mut flash, &mut there, bring(number, 200)));
    assert_eq!(there.len(), 64);
    take(&mut store, &mut flash, &mut there, bring(17, 240));
    assert_eq!(there[&17].0.len(), 240);
    // 14 segments are left, one of them where 17 was.
    assert_eq!(store.free(&flash), 13 * 512 - Shelf::HEAD);
    store.mount(&mut flash);
    assert_eq!(found(&store, &flash), there);
}
