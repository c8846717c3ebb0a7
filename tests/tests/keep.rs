//! Whose KEEP values are in flash: a program that declares the same names and kinds in the same order
//! finds them, any other one begins with 0 (lang/README.md, Declarations). On every part.

use emulator::Config;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::wire::{Control, KEEPS, RunState};
use pasapas::board::BUILDS;
use pasapas::torture::stand::Stand;

/// Longest wait for a short run, us.
const RUN_US: u64 = 400_000;

/// The first KEEP value once a script was uploaded and has run.
fn behind(stand: &mut Stand, script: &str) -> Option<i32> {
    let source = Source::new("test.bas", script.to_owned());
    let (program, _) = compile(&source, ProfileChoice::built_in());
    let image = lang::back::compile(&program.expect("the script is sound")).expect("it fits").image;
    if stand.upload(&image, true).is_err() {
        // Beside KEEP values the smallest program area holds one program.
        stand.erase();
        stand.upload(&image, true).unwrap_or_else(|answer| panic!("{script}: {answer:?}"));
    }
    assert!(stand.power_cycle());
    stand.control(Control::Start);
    stand.board.run_us(RUN_US);
    assert_eq!(stand.state(), Some(RunState::Ready as u16));
    stand.read_long(KEEPS)
}

#[test]
fn values_belong_to_the_declarations() {
    for build in BUILDS {
        let name = build.part.name;
        let mut stand = Stand::new(build, &Config::default()).expect("the shipped image");
        let mut runs = |script, expected| {
            assert_eq!(behind(&mut stand, script), Some(expected), "{script} on {name}");
        };
        runs("KEEP parts\nparts = parts + 7", 7);
        runs("KEEP parts\nparts = parts + 7", 14);
        // Other code, and letters of other case.
        runs("DIM i\nkeep PARTS\ni = 3\nparts = parts + i", 17);
        runs("KEEP holes\nholes = holes + 1", 1);
        runs("KEEP parts\nparts = parts + 7", 7);
        // Of another kind; two in either order.
        runs("KEEP parts AS TIME\nparts = parts + 1ms", 1);
        runs("KEEP parts, holes\nparts = parts + 5", 5);
        runs("KEEP holes, parts\nholes = holes + 2", 2);
        runs("KEEP holes, parts\nholes = holes + 2", 4);
    }
}
