//! The library of a board on the command line: programs by name, as many as fit, none lost.

#![cfg(unix)]

mod common;

use common::{Board, pasapas, text};

fn script(board: &Board, name: &str, text: &str) -> String {
    let path = board.folder.path().join(name);
    std::fs::write(&path, text).expect("a file");
    path.to_string_lossy().into_owned()
}

/// Runs a command on the board; what it said, and whether it went well.
fn on(board: &Board, args: &[&str]) -> (bool, String) {
    let port = board.port();
    let (code, said) = pasapas(&[args, &["--port", text(&port)]].concat());
    (code == 0, said)
}

#[test]
fn programs_have_names_and_start_takes_one() {
    let board = Board::start(&["--part", "f5529"]);
    let drill = script(&board, "drill.bas", "SetOut 3, ON\nWait 99s\n");
    let mill = script(&board, "mill.bas", "SetOut 4, ON\nWait 99s\n");
    let (good, said) = on(&board, &["list"]);
    assert!(good && said.contains("no program"), "{said}");
    assert!(on(&board, &["upload", &drill]).0);
    let (_, said) = on(&board, &["upload", &mill]);
    assert!(said.contains("as 2 mill"), "{said}");
    let (good, said) = on(&board, &["upload", &drill, "--as", "second hand"]);
    assert!(good, "{said}");
    let (_, said) = on(&board, &["list"]);
    let lines: Vec<&str> = said.lines().collect();
    assert!(lines[0].starts_with(" 1  drill") && lines[1].starts_with(" 2  mill"), "{said}");
    assert!(
        lines[2].starts_with(" 3  second hand") && lines[2].ends_with("Start runs it"),
        "{said}"
    );
    for (called, output) in [("MILL", "4"), ("1", "3")] {
        assert!(on(&board, &["start", called]).0);
        let (_, said) = on(&board, &["status"]);
        let outputs = said.lines().find(|line| line.starts_with("outputs")).expect("a line");
        assert!(outputs.contains(output), "{said}");
        let (good, said) = on(&board, &["start", "second hand"]);
        assert!(!good && said.contains("pasapas stop"), "{said}");
        assert!(on(&board, &["stop"]).0);
    }
    let (good, said) = on(&board, &["start", "engrave"]);
    assert!(!good && said.contains("it holds 1 drill, 2 mill, 3 second hand"), "{said}");
    // The next version takes the place of its name.
    let (_, said) = on(&board, &["upload", &drill]);
    assert!(said.contains("as 1 drill"), "{said}");
    let (good, said) = on(&board, &["erase"]);
    assert!(!good && said.contains("which one"), "{said}");
    assert!(on(&board, &["erase", "mill"]).0);
    let (_, said) = on(&board, &["list", "--format", "json"]);
    let numbers: Vec<serde_json::Value> =
        said.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(
        numbers.iter().map(|line| line["number"].as_u64()).collect::<Vec<_>>(),
        [Some(1), Some(3)]
    );
    assert!(on(&board, &["erase", "--all"]).0);
    let (good, said) = on(&board, &["start"]);
    assert!(!good && said.contains("pasapas list"), "{said}");
}

#[test]
fn a_program_of_30_kb_runs_and_another_one_as_large_says_what_makes_room() {
    let board = Board::start(&["--part", "f5529"]);
    let lines: String =
        (0..3200).map(|n| format!("IF i = {} THEN k = k + {}\n", n % 200 + 3, n % 100)).collect();
    let large = format!(
        "DIM i, k\nFOR i = 1 TO 2\n  GOSUB work\nNEXT\nPRINT k\nEND\nwork:\n{lines}RETURN\n"
    );
    let file = script(&board, "large.bas", &large);
    let (good, said) = on(&board, &["upload", &file]);
    assert!(good, "{said}");
    assert!(on(&board, &["start"]).0);
    let (good, said) = on(&board, &["upload", &file, "--as", "copy"]);
    assert!(!good && said.contains("free beside what is stored"), "{said}");
    let (good, said) = on(&board, &["upload", &file]);
    assert!(!good && said.contains("--replace"), "{said}");
    let (good, said) = on(&board, &["upload", &file, "--replace"]);
    assert!(good, "{said}");
}

#[test]
fn a_board_with_one_program_says_that_it_has_no_library() {
    let board = Board::start(&["--part", "g2553"]);
    let file = script(&board, "drill.bas", "SetOut 3, ON\n");
    let (good, said) = on(&board, &["upload", &file, "--as", "drill"]);
    assert!(!good && said.contains("leave --as away"), "{said}");
    assert!(on(&board, &["upload", &file]).0);
    let (good, said) = on(&board, &["list"]);
    assert!(good && said.contains("one program of"), "{said}");
    let (good, said) = on(&board, &["start", "drill"]);
    assert!(!good && said.contains("without a name"), "{said}");
    let (good, said) = on(&board, &["erase", "drill"]);
    assert!(!good && said.contains("--all"), "{said}");
    assert!(on(&board, &["erase"]).0);
}
