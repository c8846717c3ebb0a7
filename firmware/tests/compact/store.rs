//! The program store: uploads against [`firmware::store`], power cuts, the order of checks.

use std::sync::LazyLock;

use firmware::store::{Denied, NAME, Store, Upload as Whole};
use lang::image::at;
use lang::wire::{Exception, Refusal, Upload};
use proptest::prelude::*;

use crate::area::{AREA, Area, image, send, words};
use crate::chip::Chip;

/// Programs of many lengths, two with KEEP values.
static IMAGES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let text = |lines: usize| {
        (0..lines).map(|n| format!("PRINT \"line {n} of {lines}\"\n")).collect::<String>()
    };
    let mut images: Vec<_> = [1, 15, 20, 40, 55, 100, 120].map(|lines| image(&text(lines))).into();
    images.push(image("KEEP n\nn = n + 1"));
    images.push(image(&format!("KEEP a, b, c\na = b\n{}", text(60))));
    images
});

fn uses_keep(which: usize) -> bool {
    which >= 7
}

#[derive(Clone, Debug)]
enum Step {
    Begin { which: usize, replace: bool },
    Words { from: usize, to: usize, damage: Option<usize> },
    Commit,
    Erase,
    Reset,
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let words = (0usize..4, 0usize..4, prop::option::weighted(0.1, 0usize..1500));
    let step = prop_oneof![
        5 => (0..IMAGES.len(), any::<bool>()).prop_map(|(which, replace)| Step::Begin { which, replace }),
        8 => words.prop_map(|(from, to, damage)| match from {
            0 => Step::Words { from: to * 200, to: to * 200 + 300, damage },
            _ => Step::Words { from: 0, to: 4000, damage },
        }),
        6 => Just(Step::Commit),
        1 => Just(Step::Erase),
        2 => Just(Step::Reset),
    ];
    prop::collection::vec(step, 1..16)
}

fn number(result: Result<(), Denied>) -> u16 {
    match result {
        Ok(()) => Refusal::None as u16,
        Err(Denied::NotBegun) => Refusal::NotBegun as u16,
        Err(Denied::TooLong) => Refusal::TooLong as u16,
        Err(Denied::Flash) => Refusal::Flash as u16,
        Err(Denied::Image) => Refusal::Crc as u16,
    }
}

/// The chip's answer to a code: the refusal, which the exception must agree with.
fn control(chip: &mut Chip, code: Upload) -> u16 {
    chip.call("upload_control", &[(12, code as u16)]);
    let refusal = u16::from(chip.byte("REFUSAL"));
    let exception = if refusal == 0 { 0 } else { Exception::DeviceFailure as u16 };
    assert_eq!(chip.reg(12), exception);
    refusal
}

fn run(steps: &[Step]) -> Result<(), TestCaseError> {
    let mut chip = Chip::new();
    let (mut area, mut twin) = (Area::new(), Store::new());
    let mut sent = 0;
    let mut committed = false;
    for step in steps {
        let repeated = std::mem::take(&mut committed);
        match *step {
            Step::Begin { which, replace } => {
                let (length, keep) = (IMAGES[which].len() as u16, uses_keep(which));
                chip.set_word("UPLOAD", length | u16::from(keep) << 15);
                let code = if replace { Upload::Replace } else { Upload::Begin };
                let refusal = control(&mut chip, code);
                prop_assert_eq!(
                    refusal,
                    number(twin.begin(
                        &mut area,
                        Whole { number: 1, length, keeps: keep },
                        replace
                    ))
                );
                sent = which;
            }
            Step::Words { from, to, damage } => {
                committed = repeated;
                let words = words(&IMAGES[sent]);
                for (at, &word) in words.iter().enumerate().take(to).skip(from) {
                    let word = if damage == Some(at) { word ^ 0x0810 } else { word };
                    chip.call("upload_word", &[(12, at as u16), (13, word)]);
                    let exception = match twin.write(&mut area, 2 * at as u16, word) {
                        Ok(()) => 0,
                        Err(_) => Exception::DeviceFailure as u16,
                    };
                    prop_assert_eq!(chip.reg(12), exception, "word {}", at);
                }
            }
            Step::Commit => {
                let refusal = control(&mut chip, Upload::Commit);
                let own = number(twin.commit(&mut area, &[0; NAME]));
                if repeated {
                    // The F5529 answers a repeated commit as the first. This chip has no bytes left for that: the host
                    // compares the stored program.
                    prop_assert_eq!(
                        [refusal, own],
                        [Refusal::NotBegun as u16, Refusal::None as u16]
                    );
                } else {
                    prop_assert_eq!(refusal, own);
                }
                committed = own == Refusal::None as u16;
            }
            Step::Erase => {
                prop_assert_eq!(control(&mut chip, Upload::Erase), 0);
                twin.discard(&mut area, 1);
            }
            Step::Reset => {
                chip.restart();
                chip.call("store_mount", &[]);
                twin.mount(&mut area);
            }
        }
        prop_assert!(Area::of(&chip) == area, "the flash differs after {:?}", step);
        let slot = twin.image::<Area>().map_or(0, |offset| AREA + offset - 4);
        prop_assert_eq!(chip.word("STORED"), slot);
        chip.call("program_length", &[]);
        prop_assert_eq!(chip.reg(12), twin.length(&area));
        chip.call("free_bytes", &[]);
        prop_assert_eq!(chip.reg(12), twin.free(&area));
        let code = if slot == 0 { 0 } else { slot + 4 + firmware::verify::CODE };
        prop_assert_eq!(chip.word("VM_CODE"), code);
    }
    prop_assert_eq!(chip.board.warnings(), &[]);
    Ok(())
}

#[test]
fn uploads_leave_what_the_twin_leaves() {
    proptest!(ProptestConfig::with_cases(30), |(steps in steps())| run(&steps)?);
}

#[test]
fn an_upload_is_refused_while_something_runs_or_moves() {
    let mut chip = Chip::new();
    for (variable, value) in [("RUN", 2), ("RUN", 3), ("RUN", 6), ("MOVING", 1)] {
        chip.set_byte(variable, value);
        for (routine, first) in [("upload_control", 4), ("upload_word", 0), ("profile_word", 0)] {
            chip.call(routine, &[(12, first), (13, 0)]);
            assert_eq!(chip.reg(12), Exception::Busy as u16, "{routine}, {variable} {value}");
        }
        chip.set_byte(variable, 0);
    }
    for code in [0, 5, 0xFFFF] {
        chip.call("upload_control", &[(12, code)]);
        assert_eq!(chip.reg(12), Exception::IllegalValue as u16);
    }
    assert_eq!(chip.board.wear().operations, 0);
}

#[test]
fn the_check_names_what_it_refuses() {
    let seal = |change: fn(&mut [u8])| {
        let mut image = IMAGES[1].clone();
        change(&mut image);
        lang::image::seal(&mut image);
        image
    };
    let mut damaged = IMAGES[1].clone();
    damaged[200] ^= 1;
    for (image, refusal) in [
        (IMAGES[1].clone(), Refusal::None),
        (damaged, Refusal::Crc),
        (seal(|image| image[2] ^= 1), Refusal::Version),
        (seal(|image| image[1] |= 1 << 2), Refusal::Feature),
        (seal(|image| image[at::CELLS] = 200), Refusal::Memory),
        (seal(|image| image[at::ENTRY] ^= 1), Refusal::Code),
    ] {
        let mut chip = Chip::new();
        assert!(send(&mut chip, &image, false, Upload::Begin as u16));
        assert_eq!(control(&mut chip, Upload::Commit), refusal as u16);
        assert_eq!(chip.word("STORED") != 0, refusal == Refusal::None);
    }
}

#[test]
fn an_upload_cut_anywhere_leaves_the_old_program_or_the_new() {
    let (old, new) = (&IMAGES[0], &image("SetOut 2, ON"));
    let mut before = Chip::new();
    assert!(send(&mut before, old, false, Upload::Begin as u16));
    assert_eq!(control(&mut before, Upload::Commit), 0);
    let stored = |chip: &mut Chip| {
        chip.restart();
        chip.call("store_mount", &[]);
        let slot = chip.word("STORED");
        chip.call("program_length", &[]);
        let length = chip.reg(12);
        let bytes: Vec<u8> = (0..length).map(|at| chip.board.peek8(slot + 4 + at)).collect();
        bytes
    };
    let (mut cuts, mut found_new) = (0, false);
    loop {
        let mut chip = before.clone();
        chip.board.cut_at_flash_operation(cuts + 1, cuts);
        let sent = send(&mut chip, new, false, Upload::Begin as u16);
        if sent && chip.try_call("upload_control", &[(12, Upload::Commit as u16)]).is_some() {
            // The next operation is the mount's.
            chip.board.cut_at_flash_operation(u64::from(u32::MAX), 0);
            assert_eq!(&stored(&mut chip), new);
            break;
        }
        assert!(!chip.board.powered());
        cuts += 1;
        let found = stored(&mut chip);
        assert!(found == *old || found == *new, "cut {cuts}: {} bytes", found.len());
        found_new |= found == *new;
        // The board takes the next upload.
        assert!(send(&mut chip, old, false, Upload::Begin as u16), "after cut {cuts}");
        assert_eq!(control(&mut chip, Upload::Commit), 0, "after cut {cuts}");
        assert_eq!(&stored(&mut chip), old);
    }
    assert!(cuts > new.len() as u64 / 2 && found_new, "{cuts} cuts");
}
