//! Long and hostile scripts check in time.

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use std::fmt::Write;
use std::time::{Duration, Instant};

/// Far above what a debug build needs (tenths of a second); a quadratic walk takes minutes.
const BOUND: Duration = Duration::from_secs(20);

fn compiles_in_time(text: String) -> bool {
    let start = Instant::now();
    let (program, _) = compile(&Source::new("long.bas", text), ProfileChoice::built_in());
    let time = start.elapsed();
    assert!(time < BOUND, "took {time:?}");
    program.is_some()
}

#[test]
fn ten_thousand_lines() {
    let mut text = String::from("DIM a, b\nF300\n");
    for i in 0..2500 {
        let _ =
            write!(text, "a = a + {i}\nIF a > {i} THEN b = a\nG1 X{} Y[a]\nWait {i}ms\n", i % 200);
    }
    assert!(compiles_in_time(text));
}

#[test]
fn chains_of_open_names_in_reverse_order() {
    let mut text = String::new();
    for i in 0..3000 {
        let _ = writeln!(text, "DIM v{i}_");
    }
    for i in 0..2999 {
        let _ = writeln!(text, "v{i}_ = v{}_", i + 1);
    }
    text.push_str("v2999_ = 5mm\n");
    assert!(compiles_in_time(text));
}

#[test]
fn gosubs_that_run_into_one_another() {
    let mut text = String::new();
    for i in 0..2000 {
        let _ = writeln!(text, "GOSUB l{i}_");
    }
    text.push_str("END\n");
    for i in 0..2000 {
        let _ = writeln!(text, "l{i}_:\nG0 X{}", i % 200);
    }
    text.push_str("RETURN\n");
    compiles_in_time(text);
}

#[test]
fn calls_in_a_ladder() {
    let mut text = String::from("s0_\n");
    for i in 0..1500 {
        let _ = writeln!(text, "SUB s{i}_\ns{0}_\ns{0}_\nG1 X1 F100\nEND SUB", i + 1);
    }
    text.push_str("SUB s1500_\nG91\nEND SUB\n");
    assert!(compiles_in_time(text));
}

#[test]
fn thousands_of_errors() {
    let mut text = String::new();
    for i in 0..5000 {
        let _ = writeln!(text, "DIM name{i}\nnome{i} = nume{i} + 1mm");
    }
    assert!(!compiles_in_time(text));
}

/// Words from which scripts are strung together that parse often enough to be checked.
const WORDS: [&str; 60] = [
    "a",
    "b(2)",
    "s",
    "h(1)",
    "5",
    "3mm",
    "2s",
    "10st",
    "5mm/s",
    "ON",
    "IN(3)",
    "POS(X)",
    " + ",
    " * ",
    " = ",
    " < ",
    " AND ",
    "NOT ",
    "(",
    ")",
    ", ",
    ":",
    "\n",
    "\n",
    "\nDIM a, b(3)\n",
    "\nSUB s\n",
    "\nEND SUB\n",
    "\nFUNCTION h(p)\n",
    "\nEND FUNCTION\n",
    "\nRETURN ",
    "\nIF IN(1) THEN\n",
    "\nEND IF\n",
    "\nELSE\n",
    "\nFOR a = 1 TO 3\n",
    "\nNEXT\n",
    "\nDO\n",
    "\nLOOP\n",
    "\nEXIT DO\n",
    "\nl:\n",
    "\nGOTO l\n",
    "\nGOSUB l\n",
    "\nON IN 3 RISE GOSUB l\n",
    "\nON ERROR GOTO l\n",
    "\nRESUME NEXT\n",
    "\nG1 X5 F100",
    " Y[a]",
    "\nG91",
    "\nG20",
    "\nG81 X1 Z-3 R1",
    "\nG99 X3",
    "\nG2 X5 I2",
    "\nG80",
    "\nMoveAxe X, ",
    "\nHome",
    "\nWait ",
    "\na = ",
    "\nSELECT CASE a\nCASE 1\n",
    "\nEND SELECT\n",
    "\nREPEAT 3\n",
    "\nEND REPEAT\n",
];

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(2000))]

    /// No script makes the checker panic, and an error and a program never come together.
    #[test]
    fn any_script_is_checked(picks in proptest::collection::vec(0..WORDS.len(), 0..60)) {
        let text: String = picks.into_iter().map(|i| WORDS[i]).collect();
        let source = Source::new("any.bas", text);
        let (program, diags) = compile(&source, ProfileChoice::built_in());
        proptest::prop_assert_eq!(program.is_none(), diags.has_errors());
        diags.render(&source);
    }
}
