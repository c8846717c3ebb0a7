//! `pasapas trace` as a user has it: a virtual board in real time, both parts.
#![cfg(unix)]

mod common;

use std::ffi::OsStr;
use std::fs;
use std::io::{Read as _, Write as _};
use std::net::TcpListener;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

use common::Board;
use lang::wire::{CRC_START, LATE_EVENTS, crc16};
use pasapas::link::{self, Link as _};

const SCRIPT: &str = "\
DIM i, way AS Length
FOR i = 1 TO 3
  way = 1mm * i
  MoveAxe X, way
  SetOut 1, i = 2
NEXT
PRINT \"at \"; i
";

/// Exit code, standard output, standard error.
fn pasapas(board: &Board, args: &[&str], said: &str) -> (i32, String, String) {
    let port = board.port();
    let port = [OsStr::new("--port"), port.as_os_str()];
    let mut child = Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .args(args)
        .args(port.iter().filter(|_| args[0] != "sim"))
        .current_dir(board.folder.path())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the tool starts");
    // Whoever does not ask closes its end at once.
    let _ = child.stdin.take().expect("a pipe").write_all(said.as_bytes());
    let output = child.wait_with_output().expect("it ends");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

fn board(part: &str) -> Board {
    let board = Board::start(&["--part", part]);
    fs::write(board.folder.path().join("a.bas"), SCRIPT).expect("a file");
    let (code, _, err) = pasapas(&board, &["upload", "a.bas"], "");
    assert_eq!(code, 0, "{err}");
    board
}

/// The trace without the simulator's time.
fn simulated(board: &Board) -> String {
    let sim = ["sim", "a.bas", "--engine", "vm", "--trace", "-"];
    let (code, out, err) = pasapas(board, &sim, "");
    assert_eq!(code, 0, "{err}");
    out.lines()
        .map(|line| match (line.find(",\"us\""), line.ends_with('}')) {
            (Some(at), true) => format!("{}}}\n", &line[..at]),
            _ => format!("{line}\n"),
        })
        .collect()
}

#[test]
fn the_trace_of_a_board_is_the_simulators() {
    for part in ["g2553", "f5529"] {
        let board = board(part);
        let (code, out, err) = pasapas(&board, &["trace", "a.bas"], "");
        assert_eq!((code, out), (0, simulated(&board)), "{part}: {err}");
    }
}

/// Stands between a client and a board, as RTU frames at the returned port, and lets its register of late events grow by 3 with
/// each read of it.
fn late_board(board: &Board) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener.local_addr().expect("an address").port();
    let path = board.port();
    thread::spawn(move || {
        let mut line = link::open(path.to_str().expect("UTF-8")).expect("the board");
        let mut late = 0u16;
        for mut client in listener.incoming().map_while(Result::ok) {
            let mut bytes = [0; 512];
            while let Ok(count @ 1..) = client.read(&mut bytes) {
                let request = &bytes[..count];
                let [high, low] = LATE_EVENTS.to_be_bytes();
                let mut reply = Vec::new();
                if request.get(1..6) == Some(&[3, high, low, 0, 1]) {
                    late += 3;
                    reply = vec![request[0], 3, 2, 0, late as u8];
                    let crc = reply.iter().fold(CRC_START, |crc, byte| crc16(crc, *byte));
                    reply.extend(crc.to_le_bytes());
                } else {
                    line.send(request).expect("sent");
                    let mut patience = Duration::from_millis(300);
                    while let Ok(count @ 1..) = line.receive(&mut bytes, patience) {
                        reply.extend(&bytes[..count]);
                        patience = Duration::from_millis(8);
                    }
                }
                if client.write_all(&reply).is_err() {
                    break;
                }
            }
        }
    });
    port
}

#[test]
fn late_steps_are_told_by_status_and_at_the_end_of_a_run() {
    let board = board("f5529");
    let port = format!("rtu:127.0.0.1:{}", late_board(&board));
    let at = |args: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_pasapas"))
            .args(args)
            .args(["--port", &port])
            .current_dir(board.folder.path())
            .stdin(Stdio::null())
            .output()
            .expect("the tool starts");
        let said = [output.stdout, output.stderr].concat();
        (output.status.code(), String::from_utf8_lossy(&said).into_owned())
    };
    let late = "3 step events came some us late; no step was lost, and no pulse shortened";
    let (code, said) = at(&["status"]);
    assert!(code == Some(0) && said.contains(&format!("steps     {late}")), "{said}");
    let (code, said) = at(&["status", "--format", "json"]);
    assert!(code == Some(0) && said.contains("\"late_events\":6"), "{said}");
    for args in [&["trace", "a.bas"][..], &["stream", "a.bas"], &["stream", "a.bas", "--stored"]] {
        let (code, said) = at(args);
        assert!(code == Some(0) && said.contains(&format!("a.bas: {late}")), "{args:?}: {said}");
    }
}

#[test]
fn a_halted_program_shows_its_variables_and_takes_new_values() {
    let board = board("g2553");
    let trace = ["trace", "a.bas", "--break", "5"];
    // A program halts before its next effect, so what it computes for that has been done: 9 comes
    // before the third pass's move, and there is no fourth.
    let said = "p\np nonesuch\nc\np way\nset i=9\nd 5\nc\n";
    let (code, out, err) = pasapas(&board, &trace, said);
    assert_eq!(code, 0, "{err}");
    for shown in
        ["i = 2\n", "way = 2000um\n", "no variable `nonesuch`", "way = 3000um\n", "i = 9\n"]
    {
        assert!(err.contains(shown), "{shown} is not in {err}");
    }
    assert_eq!(out.matches("\"move\"").count(), 3, "{out}");
    assert!(
        err.contains("line 5 is done: SetOut 1, i = 2\nline 4 is next: MoveAxe X, way"),
        "{err}"
    );
    assert!(out.contains("\"text\":\"at 10\""), "{out}");
}

#[test]
fn a_value_outside_of_min_and_max_is_refused_in_words_and_the_trace_goes_on() {
    let board = board("f5529");
    let text = "DIM qty AT 3000 MIN 1 MAX 500\nqty = 7\nWait 1ms\nWait 2ms\nPRINT qty\n";
    fs::write(board.folder.path().join("limits.bas"), text).expect("a file");
    let (code, _, err) = pasapas(&board, &["upload", "limits.bas"], "");
    assert_eq!(code, 0, "{err}");
    let said = "set qty=501\nset qty 500\nc\n";
    let (code, out, err) = pasapas(&board, &["trace", "limits.bas", "--break", "3"], said);
    assert!(err.contains("501 is outside of MIN and MAX of `qty`"), "{err}");
    assert!(code == 0 && out.contains("\"text\":\"500\""), "{code} {out} {err}");
}

#[test]
fn a_stepped_program_waits_and_can_be_ended() {
    let board = board("f5529");
    let trace = ["trace", "a.bas", "--step"];
    let (code, out, err) = pasapas(&board, &trace, "\n\ns\nq\n");
    assert_eq!(code, 3, "{err}");
    assert!(err.contains("line 4 is done: MoveAxe X, way"), "{err}");
    assert!(out.lines().last().is_some_and(|line| line.contains("stopped")), "{out}");
    // Nothing was started when the answer to the first question is no.
    let (code, out, _) = pasapas(&board, &trace, "q\n");
    assert_eq!((code, out.as_str()), (0, ""));
}

#[test]
fn another_program_is_named() {
    let board = board("g2553");
    fs::write(board.folder.path().join("b.bas"), "Wait 1ms\n").expect("a file");
    let (code, _, err) = pasapas(&board, &["trace", "b.bas"], "");
    assert!(code == 4 && err.contains("`pasapas upload b.bas`"), "{code} {err}");
}

#[test]
fn what_the_board_lacks_is_named_with_the_remedy_and_its_program_stays() {
    let board = board("g2553");
    let file = |name: &str, text: &str| {
        fs::write(board.folder.path().join(name), text).expect("a file");
    };
    file("start.bas", "START MoveAxe X, 2mm\nWaitMove\n");
    let (code, _, err) = pasapas(&board, &["upload", "start.bas"], "");
    assert_eq!(code, 4, "{err}");
    assert!(
        err.contains("axes on their own") && err.contains("another chip, the MSP430F5529"),
        "{err}"
    );
    file("arc.bas", "DIM i\nG1 X2 F600\nG2 X4 I[i + 1] J0\n");
    let (code, _, err) = pasapas(&board, &["upload", "arc.bas"], "");
    assert_eq!(code, 1, "{err}");
    assert!(err.contains("arc.bas:3:1: error[B008]") && err.contains("I is only known"), "{err}");
    let (code, out, err) = pasapas(&board, &["trace", "a.bas"], "");
    assert!(code == 0 && out.contains("at 4"), "{out} {err}");
}

#[test]
fn a_board_without_arcs_runs_their_chords() {
    let board = board("g2553");
    fs::write(board.folder.path().join("arc.bas"), "G1 X2 F600\nG2 X4 I1 J0\n").expect("a file");
    let (code, _, err) = pasapas(&board, &["upload", "arc.bas"], "");
    assert!(
        code == 0 && err.contains("arc.bas:2:1: note[B011]: this board draws no arcs"),
        "{err}"
    );
    let (code, out, err) = pasapas(&board, &["trace", "arc.bas"], "");
    assert_eq!(code, 0, "{err}");
    let lines: Vec<&str> = out.lines().filter(|line| line.contains("\"line\":2,")).collect();
    let last = lines.iter().rfind(|line| line.contains("\"ev\":\"move\"")).expect("chords");
    assert!(lines.len() > 4 && last.contains("{\"X\":400,\"Y\":0,"), "{out}");
}

#[test]
fn a_board_starts_with_the_profile_that_it_is_given() {
    let board = Board::start(&["--part", "f5529", "--speed", "max", "--profile", "laser"]);
    fs::write(board.folder.path().join("l.bas"), "PROFILE \"laser\"\nM3 S500\n").expect("a file");
    let (code, _, err) = pasapas(&board, &["upload", "l.bas"], "");
    assert_eq!(code, 0, "{err}");
}

/// The book's commissioning, typed as it is printed, on a machine that is not the mill.
#[test]
fn jog_and_home_go_by_the_axes_that_the_board_has() {
    for part in ["f5529", "g2553"] {
        let board = Board::start(&["--part", part, "--speed", "max"]);
        for command in [&["jog", "X", "1mm"][..], &["home", "X"]] {
            let (code, out, err) = pasapas(&board, command, "");
            assert_eq!((code, out.as_str()), (2, ""), "{part}: {err}");
            assert!(err.contains("no axes") && err.contains("profile set"), "{err}");
        }
        let (_, out, _) = pasapas(&board, &["profile", "get"], "");
        assert!(out.starts_with("# the board holds no program"), "{out}");
        assert!(!out.contains("[x]") && !out.contains("mill"), "{out}");

        let mill = lang::profile::BUILT_IN[0].1;
        let line = mill.lines().find(|line| line.starts_with("scale")).expect("a scale");
        let name = mill.lines().find(|line| line.starts_with("name")).expect("a name");
        let mine = |steps: &str| {
            let scale = format!("scale = {{ steps = {steps}, um = 5000 }}");
            mill.replacen(line, &scale, 1).replacen(name, "name = \"mine\"", 1)
        };
        for (steps, made) in [("3200", 640), ("1600", 320)] {
            fs::write(board.folder.path().join("my.toml"), mine(steps)).expect("a file");
            let (code, out, err) = pasapas(&board, &["profile", "set", "my.toml"], "");
            assert_eq!(code, 0, "{out}{err}");
            let place = |out: &str| -> i64 {
                out.split_whitespace().nth(1).and_then(|n| n.parse().ok()).expect("a place")
            };
            let jog = match part {
                "f5529" => vec!["jog", "X", "1mm"],
                // It does not tell its axes, and is asked for none of another machine.
                _ => {
                    let (code, out, err) = pasapas(&board, &["jog", "X", "1mm"], "");
                    assert_eq!((code, out.as_str()), (2, ""), "{err}");
                    vec!["jog", "X", "1mm", "--profile", "my.toml"]
                }
            };
            let (code, first, err) = pasapas(&board, &jog, "");
            assert_eq!(code, 0, "{err}");
            let (_, second, _) = pasapas(&board, &jog, "");
            assert_eq!(place(&second) - place(&first), made, "{part}: {first}{second}");
        }
        let (_, out, _) = pasapas(&board, &["profile", "get"], "");
        // Of X: the other axes are the mill's, with 400 steps.
        let x = out.split("[x.scale]").nth(1).map(|rest| rest.split("\n\n").next().unwrap_or(rest));
        assert_eq!(
            x.map(|x| x.contains("steps = 1600")),
            (part == "f5529").then_some(true),
            "{out}"
        );
        // A program for other axes: what moves by its, and that is said.
        fs::write(board.folder.path().join("p.bas"), "MoveAxe X, 1mm\n").expect("a file");
        assert_eq!(pasapas(&board, &["upload", "p.bas"], "").0, 0);
        let (code, _, err) = pasapas(&board, &["profile", "set", "my.toml"], "");
        assert!(code == 0 && err.contains("made for other axes"), "{err}");
        let (code, out, err) = pasapas(&board, &["start"], "");
        assert_eq!(code, 0, "{out}{err}");
    }
}

#[test]
fn jog_and_home_refuse_a_board_with_another_machine() {
    for part in ["g2553", "f5529"] {
        let board = board(part);
        let mill = lang::profile::BUILT_IN[0].1;
        // The same wiring and roles, another thread at X.
        let line = mill.lines().find(|line| line.starts_with("scale")).expect("a scale");
        let other = mill.replacen(line, "scale = { steps = 3200, um = 5000 }", 1);
        assert_ne!(other, mill);
        fs::write(board.folder.path().join("other.toml"), other).expect("a file");
        for (profile, why) in
            [("thesis", "the board's profile is not `"), ("other.toml", "other axes")]
        {
            for command in [&["jog", "X", "1mm"][..], &["home", "X"]] {
                let args = [command, &["--profile", profile]].concat();
                let (code, out, err) = pasapas(&board, &args, "");
                assert_eq!((code, out.as_str()), (4, ""), "{args:?} on {part}: {err}");
                assert!(err.contains(why) && err.contains("--any-profile"), "{err}");
            }
        }
        let (code, out, err) = pasapas(&board, &["jog", "X", "1mm"], "");
        assert_eq!((code, out.starts_with("X ")), (0, true), "{err}");
        let forced = ["jog", "X", "1mm", "--profile", "other.toml", "--any-profile"];
        assert_eq!(pasapas(&board, &forced, "").0, 0);
    }
}
