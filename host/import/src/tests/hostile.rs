//! Damaged files: diagnostics or a script, never a crash, never without end.

use super::{refused, shown};
use crate::{Format, Options, import};
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use proptest::prelude::*;
use std::time::Instant;

/// A sound file of each format.
const SOUND: [(&str, &str); 11] = [
    ("tour.isel", include_str!("../../../../examples/import/tour.isel")),
    ("listing.lst", include_str!("../../../../examples/import/dil14_listing.lst")),
    ("plate.pal", include_str!("../../../../examples/import/plate.pal")),
    ("corner.cde", include_str!("../../../../examples/import/corner.cde")),
    ("badge.gco", include_str!("../../../../examples/import/badge.gco")),
    ("board.ngc", include_str!("../../../../examples/import/board.ngc")),
    ("contour.nc", include_str!("../../../../examples/import/contour.nc")),
    ("panel.nc", include_str!("../../../../examples/import/panel.nc")),
    ("drill.drl", include_str!("../../../../examples/import/drill.drl")),
    ("routes.drl", include_str!("../../../../examples/import/routes.drl")),
    ("slots.drl", include_str!("../../../../examples/import/slots.drl")),
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
        // No place comes twice.
        text += &format!("G1 X{}.{:03} Y{}.25\n", i / 1000, i % 1000, (i / 7) % 150);
    }
    let start = Instant::now();
    let made = import("long.nc", text.as_bytes(), &Options::default()).expect("a script");
    assert!(made.script.lines().count() > 100_000);
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
    // The same path at 200 depths becomes one SUB, lines that swing between two places a loop.
    let mut text = String::from("G21 G90 F600\n");
    for depth in 1..=200 {
        text += &format!("G1 Z-{}.{:02}\n", depth / 100, depth % 100);
        (0..500).for_each(|i| text += &format!("X{}.5 Y{}\n", i * 37 % 190, i * 53 % 140));
    }
    let start = Instant::now();
    let made = import("depths.nc", text.as_bytes(), &Options::default()).expect("a script");
    assert!(made.script.lines().count() < 1000, "{}", made.script.lines().count());
    let text = format!("G21 G90 F600\n{}", "G1 X0 Y0\nG1 X9 Y0\n".repeat(50_000));
    let made = import("swing.nc", text.as_bytes(), &Options::default()).expect("a script");
    assert!(made.script.contains("REPEAT 50000"), "{}", made.script);
    assert!(start.elapsed().as_secs() < 40, "{:?}", start.elapsed());
    let line = vec![b'x'; 70 << 20];
    let diags = import("huge.nc", &line, &Options::default()).expect_err("too large");
    assert_eq!(diags[0].code, crate::Code::TooLarge);
}

/// Every place where a file can be cut, every number out of range, every value left out or doubled.
#[test]
fn each_number_and_each_cut_of_each_format_is_told_with_its_line() {
    let mut cases = 0;
    for (name, text) in SOUND {
        let mut tried = |bytes: &[u8]| {
            cases += 1;
            check(name, bytes, &Options::default()).expect("a script that compiles, or lines");
        };
        for at in (0..text.len()).step_by(3) {
            tried(&text.as_bytes()[..at]);
        }
        let digits = text.match_indices(|c: char| c.is_ascii_digit());
        for (at, _) in digits.step_by(2) {
            let (before, after) = text.split_at(at);
            for number in ["9999999999", "-", "", "1e9", "0x7", "\u{0663}", ".", "--1"] {
                tried([before, number, &after[1..]].concat().as_bytes());
            }
        }
        for (at, _) in text.match_indices([',', ';', ' ']).step_by(2) {
            let (before, after) = text.split_at(at);
            tried([before, &after[1..]].concat().as_bytes());
            tried([before, &after[..1], after].concat().as_bytes());
        }
    }
    assert!(cases > 4000, "{cases}");
}

/// The same text as other systems store it: what is read means the same or is refused with a line.
#[test]
fn encodings_are_read_or_named() {
    for (name, text) in SOUND {
        let plain = import(name, text.as_bytes(), &Options::default()).map(|made| made.script);
        for ends in ["\r\n", "\r", "\n\r"] {
            let other = text.replace('\n', ends);
            let made = import(name, other.as_bytes(), &Options::default()).map(|made| made.script);
            let lines = |script: &Result<String, _>| {
                script.as_ref().map(|script: &String| script.lines().count()).unwrap_or(0)
            };
            // LF CR counts as two line ends for some, so remarks' places may differ.
            assert!(lines(&made) >= lines(&plain), "{name} {ends:?}");
        }
        let marked = [&b"\xEF\xBB\xBF"[..], text.as_bytes()].concat();
        let made = import(name, &marked, &Options::default()).map(|made| made.script);
        assert_eq!(made.is_ok(), plain.is_ok(), "{name} with a byte order mark");
        let wide: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        for bytes in [wide.clone(), [&b"\xFF\xFE"[..], &wide].concat()] {
            check(name, &bytes, &Options::default()).expect("refused with a line");
        }
        let latin = [text.as_bytes(), b"\xE9\xA0\xFF\n"].concat();
        check(name, &latin, &Options::default()).expect("refused with a line, or a script");
        let packed: Vec<u8> =
            (0..4000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
        let diags = import(name, &packed, &Options::default()).expect_err("binary");
        assert!(diags.iter().any(|diag| diag.line > 0), "{name}");
    }
}

/// A French source as DOS, as Windows and as a modern editor stores it.
#[test]
fn a_dos_file_reads_as_its_author_wrote_it() {
    let text = "#axis xyz;\n#elev4,4,4;\n#define R 0(21);\n#define perçage 1(350),-1(2000);\n\
        move 66(2000),R,perçage;\nréférence xy;\nstop.\n";
    let latin: Vec<u8> = text.chars().map(|c| u8::try_from(c).expect("Latin-1")).collect();
    let dos: Vec<u8> = latin
        .iter()
        .map(|b| match b {
            0xE9 => 0x82,
            0xE7 => 0x87,
            b => *b,
        })
        .collect();
    let script = |bytes: &[u8]| {
        let made = import("a.pal", bytes, &Options::default());
        made.map(|made| made.script).unwrap_or_else(|diags| panic!("{diags:?}"))
    };
    let plain = script(text.as_bytes());
    assert!(plain.contains("Home Y, X"), "{plain}");
    assert_eq!(script(&latin), plain);
    assert_eq!(script(&dos), plain);
}

/// What the card would have answered stands in the diagnostic.
#[test]
fn the_cards_error_characters_are_named() {
    for (line, answer) in [
        ("0 1,2,3", '7'),
        ("0 5,900000,0,900,0,900,0,900", 'D'),
        ("3 5,-9", 'B'),
        ("3 5,0", 'C'),
        ("4 7", 'A'),
        ("q", '5'),
        ("3 0,-99", 'B'),
        ("0 60E3,1,2,3,4,5,6,7", '5'),
    ] {
        let text = format!("@07\n@0i\n{line}\n9\n");
        let diags = import("a.isel", text.as_bytes(), &Options::default()).expect_err(line);
        let named = format!("the card answers {answer} ");
        assert!(
            diags.iter().any(|diag| diag.line == 3 && diag.text.contains(&named)),
            "{diags:#?}"
        );
    }
    let diags = import("a.isel", b"@0i\n0 1,900\n9\n", &Options::default()).expect_err("no axes");
    assert!(diags.iter().any(|diag| diag.text.contains("the card answers 4 ")), "{diags:#?}");
}

/// The sign of a count is changed where a motor turns the other way.
#[test]
fn the_least_number_of_64_bits_is_none() {
    for text in [
        "@07\n@0i\n0 -9223372036854775808,2000,100,2000,0,21,0,21\n9\n",
        "@07\n@0A -9223372036854775808,900\n",
    ] {
        let told = refused("a.isel", text);
        assert!(told.contains("error["), "{told}");
    }
    for n in [i64::MIN, i64::MIN + 1, i64::MAX] {
        let read = crate::line::whole(&n.to_string()).map(|(_, number)| number).ok();
        assert_eq!(read, (n != i64::MIN).then_some(n));
    }
}

#[test]
fn utf_16_is_named_with_and_without_its_mark() {
    for mark in ["\u{FEFF}", ""] {
        for order in [u16::to_le_bytes as fn(u16) -> [u8; 2], u16::to_be_bytes] {
            for text in ["G0 X1\n", "(Fräsen, ein längerer Kommentar)\nG1 X1 F100\n"] {
                let bytes: Vec<u8> =
                    format!("{mark}{text}").encode_utf16().flat_map(order).collect();
                let diags = import("a.nc", &bytes, &Options::default()).expect_err("refused");
                let said = shown("a.nc", &diags);
                assert!(said.contains("the file is UTF-16 text"), "{mark:?} {text}: {said}");
                let (_, said) = Source::decode("a.bas", &bytes);
                assert_eq!(said[0].message, "the file is UTF-16 text", "{mark:?} {text}");
            }
        }
    }
    // Zeros among letters are none.
    let (_, said) = Source::decode("a.bas", b"G0 X1\0\0\nG1 X2\n");
    assert_eq!(said[0].message, "the file is not text: byte 5 is 0");
}
