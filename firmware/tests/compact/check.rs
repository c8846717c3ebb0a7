//! The check of an image, in the assembly's build, against its model.

use std::cell::RefCell;
use std::path::Path;

use firmware::WHOLE;
use firmware::verify::model::{Limits, verify};
use firmware::verify::{Bytes, feature_of};
use lang::image::seal;
use lang::isa::{Op, flags};
use lang::wire::Refusal;
use proptest::prelude::*;

use crate::area::{AREA, image};
use crate::chip::Chip;

/// Where the code begins in an image.
const CODE: usize = firmware::verify::CODE as usize;

struct Flat<'a>(&'a [u8]);

impl Bytes for Flat<'_> {
    fn byte(&self, offset: u16) -> u8 {
        self.0.get(usize::from(offset)).copied().unwrap_or(0xFF)
    }
}

fn model(image: &[u8]) -> u16 {
    verify(&Flat(image), &Limits::of(&WHOLE)).err().map_or(0, |refusal| refusal as u16)
}

fn check(chip: &mut Chip, image: &[u8]) -> u16 {
    for offset in 0..WHOLE.room_for(false) as u16 {
        let byte = image.get(usize::from(offset)).copied().unwrap_or(0xFF);
        chip.board.poke8(AREA + 4 + offset, byte);
    }
    let scratch = chip.at("POOL");
    chip.call("pasapas_verify", &[(12, AREA + 4), (13, WHOLE.features), (14, scratch)]);
    chip.reg(12)
}

/// The examples that fit the part, and what they do not use.
fn programs() -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let texts = std::fs::read_dir(folder).expect("examples are there").filter_map(|entry| {
        let path = entry.expect("readable").path();
        let basic = path.extension().is_some_and(|extension| extension == "bas");
        basic.then(|| std::fs::read_to_string(path).expect("readable"))
    });
    let mut images: Vec<_> = texts.map(|text| image(&text)).collect();
    images.push(image(
        "KEEP k\nON ERROR GOTO h\nk = k + 1\nG0 X1 Y2\nEND\nh: PRINT ERR\nRESUME NEXT",
    ));
    images.push(image(
        "DIM n\nON IN 3 RISE GOSUB h\nON EVERY 1s GOSUB h\nWait 9s\nEND\nh: n = n + 1\nRETURN",
    ));
    images.push(image("DIM a(3), i\nFOR i = 0 TO 2: a(i) = i * 70000: NEXT\nPRINT a(1)"));
    images
        .push(image("TABLE t = 10mm, 22.5mm, 35mm\nDIM i\nFOR i = 0 TO 2: MoveAxe X, t(i): NEXT"));
    images.retain(|image| image.len() <= WHOLE.room_for(false) && model(image) == 0);
    println!("{} programs", images.len());
    assert!(images.len() >= 8, "only {} programs fit", images.len());
    images
}

#[test]
fn what_the_model_takes_is_taken_and_what_it_refuses_refused() {
    let images = programs();
    let chip = RefCell::new(Chip::new());
    for image in &images {
        assert_eq!((model(image), check(&mut chip.borrow_mut(), image)), (0, 0));
    }
    let slip = (any::<prop::sample::Index>(), any::<u8>());
    let change = (0..images.len(), prop::collection::vec(slip, 1..4));
    proptest!(ProptestConfig::with_cases(400), |((which, changes) in change)| {
        let mut image = images[which].clone();
        for (index, byte) in changes {
            let at = index.index(image.len());
            // Length and CRC are another routine's.
            if !(4..9).contains(&at) {
                image[at] = byte;
            }
        }
        prop_assert_eq!(check(&mut chip.borrow_mut(), &image), model(&image));
    });
}

#[test]
fn instructions_of_a_feature_that_the_part_lacks_are_none() {
    let mut chip = Chip::new();
    let lacking = [Op::Arc, Op::ArcMixed, Op::ArcBy, Op::MoveSpeed];
    for op in lacking {
        assert_ne!(feature_of(op as u8), 0);
        let mut image = image("PRINT 1\nPRINT 2");
        image[CODE] = op as u8;
        seal(&mut image);
        assert_eq!(check(&mut chip, &image), Refusal::Code as u16, "{op:?}");
        assert_eq!(model(&image), Refusal::Code as u16, "{op:?}");
    }
}

#[test]
fn a_probes_input_is_never_in_the_code() {
    let mut image = image("Probe Z, -5mm, 2mm/s");
    let at =
        CODE + image[CODE..].iter().position(|&code| code == Op::ProbeMm as u8).expect("short");
    assert_eq!(model(&image), 0);
    // A sensor bit in place of the speed's: as many values, another meaning.
    image[at + 3] &= !flags::SPEED;
    image[at + 4] |= flags::SENSOR & 2;
    seal(&mut image);
    assert_eq!(check(&mut Chip::new(), &image), Refusal::Code as u16);
    assert_eq!(model(&image), Refusal::Code as u16);
}
