//! `pasapas jog` and `home` at the ends of a machine: the message says what cuts them short, and the way out.
#![cfg(unix)]

mod common;

use common::{Board, pasapas, text};

/// A board whose switch of X stands 5 mm below the place at power-up.
fn board(part: &str) -> Board {
    let folder = tempfile::tempdir().expect("a folder");
    let world = folder.path().join("near.rhai");
    std::fs::write(&world, "switch_at(\"X\", -500);\n").expect("a world");
    let world = text(&world).to_owned();
    let board = Board::start_in(folder, &["--part", part, "--profile", "mill", "--world", &world]);
    let (code, said) = on(&board, &["profile", "set", "mill"]);
    assert_eq!(code, 0, "{said}");
    board
}

fn on(board: &Board, args: &[&str]) -> (i32, String) {
    let port = board.port();
    pasapas(&[args, &["--port", text(&port)]].concat())
}

#[test]
fn a_jog_that_meets_a_switch_fails_and_says_how_to_leave_it() {
    for part in ["f5529", "g2553"] {
        let board = board(part);
        let jog = |by: &str| on(&board, &["jog", "X", by, "--profile", "mill"]);
        let (code, said) = jog("-10mm");
        assert_eq!(code, 4, "{part}: {said}");
        for words in ["F06", "of X (input 9)", "of its -1000 steps", "`pasapas jog X 5mm`"] {
            assert!(said.contains(words), "{part}: {words}: {said}");
        }
        // Further in: no.
        let (code, said) = jog("-1mm");
        assert_eq!(code, 4, "{part}: {said}");
        // As it is told.
        let (code, said) = jog("5mm");
        assert_eq!(code, 0, "{part}: {said}");
        assert!(said.contains("is latched; `pasapas start` acknowledges"), "{part}: {said}");
        assert_eq!(on(&board, &["start"]).0, 0);
        let (code, said) = jog("1mm");
        assert_eq!(code, 0, "{part}: {said}");
        assert!(!said.contains("F06"), "a fault that is acknowledged is not latched: {said}");
    }
}

#[test]
fn a_jog_has_a_speed_with_its_unit() {
    let board = board("f5529");
    let jog = |speed: &str| on(&board, &["jog", "X", "1mm", "--profile", "mill", "--speed", speed]);
    for speed in ["10mm/s", "600mm/min", "800st/s", "800"] {
        let (code, said) = jog(speed);
        assert_eq!(code, 0, "{speed}: {said}");
    }
    let (code, said) = jog("10m");
    assert!(code == 2 && said.contains("10mm/s"), "{said}");
    let (code, said) = jog("9000mm/s");
    assert!(code == 0 && said.contains("goes at its top"), "{said}");
    let (_, help) = pasapas(&["jog", "--help"]);
    assert!(help.contains("10mm/s") && help.contains("steps/s"), "{help}");
}
