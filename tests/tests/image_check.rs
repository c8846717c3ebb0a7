//! The chip's check of an image, in assembly, against its model and against `lang`'s.

use std::cell::{Cell, RefCell};
use std::path::Path;

use emulator::{Board, Stop};
use firmware::verify::Bytes;
use firmware::verify::model::{Limits, verify};
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::image::{Flaw, Image, at, seal};
use lang::part::{F5529, G2553, SEGMENT};
use lang::record::feature;
use lang::wire::Refusal;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

/// Where the test puts the image: the chip's program area.
const PLACE: u16 = BACK - (SEGMENT * G2553.segments as usize) as u16;
/// Where the routine returns to: nothing runs there.
const BACK: u16 = 0xFE00;
/// Scratch memory, away from the machine stack.
const SCRATCH: u16 = 0x2400;
const STACK: u16 = 0x4300;
/// From reset to the main loop.
const BOOT_US: u64 = 200_000;
const FEATURES: u16 = !feature::WIDE;
/// Accepted.
const GOOD: u16 = 0;

struct Flat<'a>(&'a [u8]);

impl Bytes for Flat<'_> {
    fn byte(&self, offset: u16) -> u8 {
        self.0.get(usize::from(offset)).copied().unwrap_or(0xFF)
    }
}

fn model(image: &[u8]) -> u16 {
    let limits = Limits { features: FEATURES, ..Limits::of(&F5529) };
    verify(&Flat(image), &limits).err().map_or(GOOD, |refusal| refusal as u16)
}

/// What `lang`'s verifier says.
fn hosts(bytes: &[u8]) -> Result<(), Flaw> {
    let image = Image::new(bytes)?;
    lang::verify::verify(&image, &lang::verify::Limits::device(image.header.features), &mut [0; 48])
}

struct Chip(Board);

impl Chip {
    fn new() -> Chip {
        let firmware = pasapas::board::DEFAULT.image().expect("the shipped image is an ELF file");
        let mut board = Board::new(pasapas::board::DEFAULT.chip.clone(), &firmware);
        // Clocks are the firmware's own; then the watchdog is off until the routine sets it (SLAU208, 16.3.1).
        board.run_us(BOOT_US);
        board.set_breakpoint(BACK);
        board.bus_write16(0x015C, 0x5A80);
        Chip(board)
    }

    fn verify(&mut self, image: &[u8]) -> u16 {
        let board = &mut self.0;
        for offset in 0..3072u16 {
            let byte = image.get(usize::from(offset)).copied().unwrap_or(0xFF);
            board.poke8(PLACE + offset, byte);
        }
        board.poke16(STACK, BACK);
        let routine = board.symbol("pasapas_verify").expect("the image has the routine");
        for (register, value) in
            [(0, routine), (1, STACK), (2, 0), (12, PLACE), (13, FEATURES), (14, SCRATCH)]
        {
            board.set_reg(register, value);
        }
        let limit = board.cycles() + 3 * board.ticks_per_second();
        assert_eq!(board.run_until(limit), Stop::Breakpoint(BACK.into()), "it hangs");
        assert_eq!(board.reg(1), STACK + 2, "the machine stack is not what it was");
        board.reg(12)
    }
}

fn examples() -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let mut images = Vec::new();
    for entry in std::fs::read_dir(folder).expect("examples are there") {
        let path = entry.expect("readable").path();
        if path.extension().is_none_or(|extension| extension != "bas") {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("readable");
        let source = Source::new(&path.to_string_lossy(), text);
        let (program, _) = compile(&source, ProfileChoice::built_in());
        let program = program.unwrap_or_else(|| panic!("{} does not compile", path.display()));
        let image = lang::back::compile(&program).expect("fits").image;
        if image.len() <= 3072 {
            images.push(image);
        }
    }
    assert!(images.len() >= 16, "only {} examples fit", images.len());
    images.extend([LIMITS, LIMITS_AND_HANDLERS, RUNS].map(|text| {
        let source = Source::new("limits.bas", text.to_owned());
        let (program, _) = compile(&source, ProfileChoice::built_in());
        lang::back::compile(&program.expect("a program")).expect("fits").image
    }));
    images
}

/// RUN, which no example has.
const RUNS: &str = "PRINT \"one\"\nIF IN(1) THEN RUN \"another one\"\nRUN \"two\"\n";
/// Limits of AT variables, which no example has beside handlers.
const LIMITS: &str = "DIM n AT 3000 MIN 1 MAX 500, a(3) AT 3004 MIN -5\nPRINT n + a(1)\n";
const LIMITS_AND_HANDLERS: &str = "DIM n AT 3000 MAX 9\nON ERROR GOTO h\nON IN 3 RISE GOSUB e\n\
    n = n + 1\nEND\ne: n = 0\nRETURN\nh: PRINT ERR\nRESUME NEXT\n";

#[test]
fn the_chip_accepts_every_example() {
    let mut chip = Chip::new();
    for image in examples() {
        assert_eq!((model(&image), chip.verify(&image)), (GOOD, GOOD));
    }
}

#[test]
fn limits_that_are_no_column_of_whole_entries_are_refused() {
    let mut chip = Chip::new();
    let source = Source::new("limits.bas", LIMITS.to_owned());
    let (program, _) = compile(&source, ProfileChoice::built_in());
    let good = lang::back::compile(&program.expect("a program")).expect("fits").image;
    let image = Image::new(&good).expect("an image");
    let data = good.len() - image.data.len();
    let column = data + usize::from(u16::from_le_bytes([good[data], good[data + 1]]));
    let rows = good[column + 1];
    assert_eq!(rows, 8, "two variables of four values");
    for (at, byte) in [(column + 1, 6), (column + 1, 12), (column, 5), (column, 0), (data + 1, 9)] {
        let mut image = good.clone();
        image[at] = byte;
        seal(&mut image);
        let verdicts = (model(&image), chip.verify(&image));
        assert_eq!(verdicts, (Refusal::Code as u16, Refusal::Code as u16), "{at} {byte}");
        assert_eq!(hosts(&image), Err(Flaw::Layout), "{at} {byte}");
    }
}

#[test]
fn resume_next_goes_on_inside_the_code_and_the_statement_table_ends_inside_the_image() {
    let mut chip = Chip::new();
    let source = Source::new("handlers.bas", "ON ERROR GOTO h\nh: PRINT ERR\n".to_owned());
    let (program, _) = compile(&source, ProfileChoice::built_in());
    let good = lang::back::compile(&program.expect("a program")).expect("fits").image;
    let image = Image::new(&good).expect("an image");
    let (code, data) = (image.code.len() as u8, good.len() - image.data.len());
    let table = data + usize::from(u16::from_le_bytes([good[data], good[data + 1]]));
    // One entry for all but the last instruction; for all; without the byte of its line.
    let tables: [(&[u8], _); 3] = [
        (&[code - 1], Ok(())),
        (&[code], Err(Flaw::Target)),
        (&[(code - 1) | 0x80], Err(Flaw::Layout)),
    ];
    for (entries, wanted) in tables {
        let mut image = [&good[..table], entries].concat();
        let length = image.len() as u16;
        image[at::LEN..][..2].copy_from_slice(&length.to_le_bytes());
        seal(&mut image);
        let refusal = wanted.err().map_or(GOOD, |_| Refusal::Code as u16);
        assert_eq!((model(&image), chip.verify(&image)), (refusal, refusal), "{entries:?}");
        assert_eq!(hosts(&image), wanted, "{entries:?}");
    }
}

#[test]
fn the_chip_refuses_what_its_model_refuses() {
    let images = examples();
    let chip = RefCell::new(Chip::new());
    let (good, bad) = (Cell::new(0), Cell::new(0));
    let slip = (any::<prop::sample::Index>(), any::<u8>());
    let change = (0..images.len(), prop::collection::vec(slip, 1..4));
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut runner = TestRunner::new_with_rng(Config::with_cases(20_000), rng);
    runner
        .run(&change, |(which, changes)| {
            let mut image = images[which].clone();
            for (index, byte) in changes {
                let at = index.index(image.len());
                // Length and CRC are another routine's.
                if !(4..9).contains(&at) {
                    image[at] = byte;
                }
            }
            seal(&mut image);
            let wanted = model(&image);
            prop_assert_eq!(chip.borrow_mut().verify(&image), wanted);
            if wanted == GOOD {
                good.set(good.get() + 1);
                // Flag bits without a meaning are an operand that the host's verifier refuses.
                let found = hosts(&image);
                prop_assert!(matches!(found, Ok(()) | Err(Flaw::Operand)), "{found:?}");
            } else {
                bad.set(bad.get() + 1);
                prop_assert!(hosts(&image).is_err(), "refused with {wanted}");
            }
            Ok(())
        })
        .unwrap_or_else(|error| panic!("{error}"));
    let (good, bad) = (good.get(), bad.get());
    assert!(good > 100 && bad > 100, "{good} accepted, {bad} refused: the mix tests nothing");
}
