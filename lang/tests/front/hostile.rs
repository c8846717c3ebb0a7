//! No input crashes, hangs or piles up diagnostics.

use crate::data::scripts;
use lang::front::diag::{Diags, MAX_DIAGS};
use lang::front::fmt::format;
use lang::front::lexer::lex;
use lang::front::parser::parse;
use lang::front::source::{MAX_SOURCE_BYTES, Source};
use lang::front::words::{Func, Kw};
use lang::front::{ProfileChoice, compile};
use proptest::prelude::*;
use std::time::{Duration, Instant};

/// Parses bytes; every diagnostic lies inside the text and renders.
fn survive(bytes: &[u8]) -> Diags {
    let (source, decoding) = Source::decode("hostile.bas", bytes);
    let mut diags = Diags::new();
    decoding.into_iter().for_each(|d| diags.push(d));
    let script = parse(source.text(), &mut diags);
    let _ = format(source.text());
    let (_, found) = compile(&source, ProfileChoice::built_in());
    for diag in found.into_sorted() {
        assert!(!diag.render(&source).is_empty());
        assert!(diag.span.end as usize <= source.text().len(), "{diag:?}");
    }
    for diag in diags.clone().into_sorted() {
        let span = diag.span;
        assert!(span.start <= span.end && span.end as usize <= source.text().len(), "{diag:?}");
        assert!(source.text().is_char_boundary(span.start as usize), "{diag:?}");
        assert!(source.text().is_char_boundary(span.end as usize), "{diag:?}");
        let (line, column) = source.place(span.start);
        assert!(line >= 1 && column >= 1);
    }
    assert!(diags.render(&source).lines().count() < 10 * MAX_DIAGS);
    // The tree is shallow enough to be walked and dropped.
    let _ = format!("{script:?}").len();
    diags
}

fn codes(diags: Diags) -> Vec<&'static str> {
    diags.into_sorted().iter().map(|d| d.code.id()).collect()
}

#[test]
fn nesting_ends_with_a_diagnostic() {
    const N: usize = 10_000;
    for (text, code) in [
        (format!("a = {}1{}", "(".repeat(N), ")".repeat(N)), "P006"),
        (format!("a = {}1", "(".repeat(N)), "P006"),
        (format!("a = {}1", "-".repeat(N)), "P006"),
        (format!("a = {}1", "NOT ".repeat(N)), "P006"),
        (format!("a = 1{}", " + 1".repeat(N)), "P006"),
        (format!("a = {}1{}", "b(".repeat(N), ")".repeat(N)), "P006"),
        (format!("a = {}1{}", "ABS(".repeat(N), ")".repeat(N)), "P006"),
        (format!("G1 X[{}1{}]", "(".repeat(N), ")".repeat(N)), "P006"),
        (format!("{}END", "IF a THEN ".repeat(N)), "P006"),
        (format!("{}a = 1", "IF a THEN\n".repeat(N)), "P006"),
        (format!("{}{}", "DO\n".repeat(N), "LOOP\n".repeat(N)), "P006"),
        (format!("{}a = 1", "FOR i = 1 TO 3\n".repeat(N)), "P004"),
        (format!("IF a THEN\n{}", "ELSEIF a THEN\n".repeat(N)), "P004"),
        (format!("a = {}", "[".repeat(N)), "P015"),
        (format!("G1 X{}", "[".repeat(N)), "P015"),
    ] {
        let found = codes(survive(text.as_bytes()));
        let start: String = text.chars().take(30).collect();
        assert!(found.contains(&code), "{start}: {found:?}");
    }
}

#[test]
fn files_that_are_no_text() {
    assert_eq!(codes(survive(b"")), [""; 0]);
    assert_eq!(codes(survive(b"a = 1\0b = 2")), ["L010"]);
    assert_eq!(codes(survive(&[0xFF, 0xFE, b'a', 0])), ["L010"]);
    assert_eq!(codes(survive(b"' caf\xE9\r\nWaitStart\r\n")), ["L011"]);
    assert_eq!(codes(survive(b"\xEF\xBB\xBFWaitStart")), [""; 0]);
    assert_eq!(codes(survive(b"WaitStart\r\n\x1A")), [""; 0]);
    let bytes = vec![b'a'; MAX_SOURCE_BYTES + 1];
    assert_eq!(codes(survive(&bytes)), ["L009"]);
}

#[test]
fn long_files_take_linear_time() {
    const BYTES: usize = 1 << 20;
    for piece in [
        "G1 X10.5 Y-3 F300\n",
        "a = 1\n",
        "a = (1 + 2) * b(3)\n",
        "@",
        "?",
        "(",
        "\"",
        "IF ",
        "IF a THEN ",
        "ELSE ",
        "SUB a\n",
        "a",
        "a b\n",
        "1",
        "_ ",
        ":",
        "'",
        "X",
        "\u{E4}",
        "TABLE t = 1, 2; 3\n",
        "NEXT\n",
        "SUB abc(\nabd 3\n",
    ] {
        let text = piece.repeat(BYTES / piece.len());
        let started = Instant::now();
        survive(text.as_bytes());
        let took = started.elapsed();
        assert!(took < Duration::from_secs(8), "{piece:?} took {took:?}");
    }
}

/// Words and signs in any order: closer to scripts than bytes are.
fn soup() -> impl Strategy<Value = String> {
    let mut words: Vec<String> = Kw::ALL.iter().map(|k| k.text().to_owned()).collect();
    words.extend(Func::ALL.iter().map(|f| f.text().to_owned()));
    for other in [
        "+", "-", "*", "/", "=", "<>", "<", "<=", ">>", "(", ")", "[", "]", ",", ";", ":", "\n",
        "a", "b", "foo", "X", "Y", "Z", "1", "2mm", "3s", "4st", "5mm/s", "G1", "X10", "Y[",
        "F300", "G81", "\"text\"", "'", "?", " _\n", "label:", "END IF", "END SUB", "Probe?", "%",
        "&H1F", "==", "x1", "{", ".", "1.5",
    ] {
        words.push(other.to_owned());
    }
    let word = prop::sample::select(words);
    prop::collection::vec((word, "[ \n]?"), 0..60)
        .prop_map(|list| list.into_iter().map(|(w, s)| w + &s).collect())
}

/// Good programs with tokens taken away, doubled or exchanged: close to what people type.
fn slips() -> impl Strategy<Value = String> {
    let mut programs = crate::manual::programs();
    for folder in ["parse/ok", "check/ok", "fmt"] {
        programs.extend(scripts(folder).iter().map(|f| std::fs::read_to_string(f).unwrap()));
    }
    let slips = prop::collection::vec((any::<prop::sample::Index>(), 0..4, any::<u8>()), 0..6);
    (prop::sample::select(programs), slips).prop_map(|(text, slips)| {
        let tokens = lex(&text, &mut Diags::new());
        let mut pieces: Vec<&str> = Vec::new();
        let mut end = 0;
        for token in &tokens {
            pieces.push(&text[end..token.span.start as usize]);
            pieces.push(token.span.of(&text));
            end = token.span.end as usize;
        }
        for (place, slip, other) in slips {
            let at = place.index(pieces.len());
            let from = (at + usize::from(other)) % pieces.len();
            match slip {
                0 => pieces[at] = "",
                1 => pieces[at] = pieces[from],
                2 => pieces.swap(at, from),
                _ => pieces.insert(at, pieces[from]),
            }
        }
        pieces.concat()
    })
}

proptest! {
    #[test]
    fn slips_of_the_fingers(text in slips()) {
        let started = Instant::now();
        survive(text.as_bytes());
        prop_assert!(started.elapsed() < Duration::from_secs(2));
    }

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        survive(&bytes);
    }

    #[test]
    fn any_text(text in "\\PC{0,200}") {
        survive(text.as_bytes());
    }

    #[test]
    fn any_words(text in soup()) {
        survive(text.as_bytes());
    }
}
