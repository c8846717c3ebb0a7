//! Damaged files: diagnostics or a script, never a crash, never without end.

use crate::{Format, Options, import};
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use proptest::prelude::*;
use std::time::Instant;

/// A sound file of each format.
const SOUND: [(&str, &str); 8] = [
    ("tour.isel", include_str!("../../../../examples/import/tour.isel")),
    ("listing.lst", include_str!("../../../../examples/import/dil14_listing.lst")),
    ("plate.pal", include_str!("../../../../examples/import/plate.pal")),
    ("corner.cde", include_str!("../../../../examples/import/corner.cde")),
    ("badge.gco", include_str!("../../../../examples/import/badge.gco")),
    ("board.ngc", include_str!("../../../../examples/import/board.ngc")),
    ("contour.nc", include_str!("../../../../examples/import/contour.nc")),
    ("drill.drl", include_str!("../../../../examples/import/drill.drl")),
];

/// What an editor, a disk or a line does to a file.
#[derive(Clone, Debug)]
enum Damage {
    Cut(usize),
    Byte(usize, u8),
    Insert(usize, &'static str),
    DropLine(usize),
    SwapLines(usize),
    Repeat(usize, usize),
}

fn damage() -> impl Strategy<Value = Damage> {
    const PIECES: [&str; 16] = [
        "99999999999999999999",
        "-",
        ",",
        ";",
        "@0",
        "3 9,-9\n",
        "3 0,2\n",
        "{",
        "(",
        "\u{e9}",
        "\0",
        "1e9",
        "X",
        "#define () ()()\n",
        "o100 if\n",
        "G91\n",
    ];
    prop_oneof![
        any::<usize>().prop_map(Damage::Cut),
        (any::<usize>(), any::<u8>()).prop_map(|(at, byte)| Damage::Byte(at, byte)),
        (any::<usize>(), proptest::sample::select(&PIECES[..]))
            .prop_map(|(at, piece)| Damage::Insert(at, piece)),
        any::<usize>().prop_map(Damage::DropLine),
        any::<usize>().prop_map(Damage::SwapLines),
        (any::<usize>(), 1..60usize).prop_map(|(at, times)| Damage::Repeat(at, times)),
    ]
}

fn apply(mut bytes: Vec<u8>, damage: &Damage) -> Vec<u8> {
    let len = bytes.len().max(1);
    let mut lines: Vec<Vec<u8>> =
        bytes.split_inclusive(|b| *b == b'\n').map(<[u8]>::to_vec).collect();
    let count = lines.len().max(1);
    match damage {
        Damage::Cut(at) => bytes.truncate(at % len),
        Damage::Byte(at, byte) => {
            if let Some(slot) = bytes.get_mut(at % len) {
                *slot = *byte;
            }
        }
        Damage::Insert(at, piece) => {
            let at = at % len;
            bytes.splice(at.min(bytes.len())..at.min(bytes.len()), piece.bytes());
        }
        Damage::DropLine(at) if !lines.is_empty() => {
            lines.remove(at % count);
            bytes = lines.concat();
        }
        Damage::SwapLines(at) if lines.len() > 1 => {
            lines.swap(at % (count - 1), at % (count - 1) + 1);
            bytes = lines.concat();
        }
        Damage::Repeat(at, times) if !lines.is_empty() => {
            let line = lines[at % count].repeat(*times);
            lines.insert(at % count, line);
            bytes = lines.concat();
        }
        _ => {}
    }
    bytes
}

/// A script, if there is one, compiles; otherwise something says why not.
fn check(name: &str, bytes: &[u8], options: &Options) -> Result<(), TestCaseError> {
    match import(name, bytes, options) {
        Ok(made) => {
            let source = Source::new("made.bas", made.script);
            let (program, diags) = compile(&source, ProfileChoice::built_in());
            prop_assert!(program.is_some(), "{}\n{}", source.text(), diags.render(&source));
        }
        Err(diags) => {
            prop_assert!(!diags.is_empty());
            prop_assert!(diags.iter().all(|diag| diag.line > 0 && diag.col > 0));
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn damaged_files_end_in_diagnostics_or_scripts(
        file in 0..SOUND.len(),
        list in proptest::collection::vec(damage(), 1..5),
    ) {
        let (name, text) = SOUND[file];
        let bytes = list.iter().fold(text.as_bytes().to_vec(), apply);
        check(name, &bytes, &Options::default())?;
    }

    #[test]
    fn noise_in_any_format_ends(
        bytes in proptest::collection::vec(any::<u8>(), 0..300),
        format in proptest::sample::select(&Format::ALL[..]),
    ) {
        check("noise", &bytes, &Options { from: Some(format), ..Options::default() })?;
    }
}

#[test]
fn strict_refuses_what_is_kept_otherwise() {
    let text = "G21 G90 F100\nG43 H1\nG1 X1\n";
    assert!(import("a.nc", text.as_bytes(), &Options::default()).is_ok());
    let strict = Options { strict: true, ..Options::default() };
    let diags = import("a.nc", text.as_bytes(), &strict).expect_err("refused");
    assert!(diags.iter().any(|diag| diag.line == 2 && diag.severity == crate::Severity::Error));
}

/// A bound that a slow machine keeps without optimisation; a desktop takes a tenth of a second.
#[test]
fn long_files_take_no_long_time() {
    let mut text = String::from("G21 G90\nG1 F600 X0 Y0\n");
    for i in 0..100_000 {
        text += &format!("G1 X{}.{:03} Y{}.25\n", i % 200, i % 1000, (i / 7) % 150);
    }
    let start = Instant::now();
    let made = import("long.nc", text.as_bytes(), &Options::default()).expect("a script");
    assert!(made.script.lines().count() > 100_000);
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
    let line = vec![b'x'; 70 << 20];
    let diags = import("huge.nc", &line, &Options::default()).expect_err("too large");
    assert_eq!(diags[0].code, crate::Code::TooLarge);
}
