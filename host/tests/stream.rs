//! `pasapas stream` as a user has it: a virtual board in real time, keys through a terminal.
#![cfg(unix)]

mod common;

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use serialport::{SerialPort, TTYPort};

/// A board, and jobs streamed to it.
struct Board(common::Board);

impl Board {
    fn start() -> Board {
        Board(common::Board::start(&[]))
    }

    /// Streams a job with a terminal as standard input.
    fn stream(&self, job: &str, more: &[&str]) -> Stream {
        self.stream_as("job.bas", job, more)
    }

    /// The same under a name that tells what it is.
    fn stream_as(&self, name: &str, job: &str, more: &[&str]) -> Stream {
        let file = self.0.folder.path().join(name);
        std::fs::write(&file, job).expect("a file");
        let (keys, terminal) = TTYPort::pair().expect("a pseudo-terminal");
        let device = terminal.name().expect("a name");
        let input = File::open(Path::new(&device)).expect("its far end");
        let mut child = Command::new(env!("CARGO_BIN_EXE_pasapas"))
            .arg("stream")
            .arg(&file)
            .arg("--port")
            .arg(self.0.port())
            .args(more)
            .stdin(Stdio::from(input))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        let lines = lines(child.stderr.take().expect("piped"));
        Stream { child, keys, _terminal: terminal, lines, told: String::new() }
    }

    fn status(&self) -> String {
        let output = Command::new(env!("CARGO_BIN_EXE_pasapas"))
            .args(["status", "--format", "json", "--port"])
            .arg(self.0.port())
            .output()
            .expect("it starts");
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// Asks until its status has `text` in it, and gives that status.
    fn comes_to(&self, text: &str) -> String {
        let end = Instant::now() + Duration::from_secs(20);
        loop {
            let status = self.status();
            if status.contains(text) {
                return status;
            }
            assert!(Instant::now() < end, "`{text}` does not come: {status}");
            std::thread::sleep(Duration::from_millis(100));
        }
    }
}

/// What a child writes to standard error, line by line.
fn lines(from: ChildStderr) -> Receiver<String> {
    let (send, receive) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(from).lines().map_while(Result::ok) {
            if send.send(line).is_err() {
                return;
            }
        }
    });
    receive
}

struct Stream {
    child: Child,
    keys: TTYPort,
    _terminal: TTYPort,
    lines: Receiver<String>,
    told: String,
}

impl Stream {
    fn press(&mut self, key: &str) {
        self.keys.write_all(format!("{key}\n").as_bytes()).expect("typed");
    }

    /// Waits for a line with `text`.
    fn hears(&mut self, text: &str) {
        let end = Instant::now() + Duration::from_secs(20);
        while let Ok(line) = self.lines.recv_timeout(end.saturating_duration_since(Instant::now()))
        {
            self.told += &format!("{line}\n");
            if line.contains(text) {
                return;
            }
        }
        panic!("`{text}` was not told:\n{}", self.told);
    }

    /// Exit code and standard output.
    fn end(mut self) -> (i32, String) {
        let mut out = String::new();
        self.child.stdout.take().expect("piped").read_to_string(&mut out).expect("text");
        let status = self.child.wait().expect("an end");
        (status.code().unwrap_or(-1), out)
    }
}

const LONG: &str = "SetOut 2, ON\nF300\nG1 X10\nG1 X20\nG1 X30\nG1 X40\n";

#[test]
fn p_pauses_r_goes_on_and_q_stops() {
    let board = Board::start();
    let mut stream = board.stream(LONG, &["--any-profile"]);
    std::thread::sleep(Duration::from_millis(700));
    stream.press("x");
    stream.hears("p pauses, r goes on, q stops");
    stream.press("p");
    stream.hears("paused");
    stream.press("r");
    std::thread::sleep(Duration::from_millis(300));
    stream.press("q");
    stream.hears("stopped here");
    stream.hears("--from-line");
    assert_eq!(stream.end().0, 3);
    let status = board.status();
    assert!(status.contains(r#""last_end":"stopped""#) && status.contains(r#""outputs":[]"#));
}

/// Where no terminal turns Ctrl-C into a key it is a signal: that stops the job on a ramp, too.
#[test]
fn ctrl_c_from_outside_stops_the_job() {
    for more in [&["--any-profile"][..], &["--any-profile", "--stored"]] {
        let board = Board::start();
        let mut stream = board.stream(LONG, more);
        std::thread::sleep(Duration::from_millis(900));
        common::signal(&stream.child, rustix::process::Signal::INT);
        stream.hears("stopping");
        stream.hears("stopped here");
        assert_eq!(stream.end().0, 3);
        let status = board.status();
        assert!(status.contains(r#""last_end":"stopped""#), "{status}");
        assert!(status.contains(r#""outputs":[]"#), "{status}");
    }
}

#[test]
fn a_killed_host_leaves_a_board_that_halts_with_its_outputs_off() {
    let board = Board::start();
    let mut stream = board.stream(LONG, &["--any-profile"]);
    board.comes_to(r#""state":"running""#);
    stream.child.kill().expect("killed");
    let _ = stream.child.wait();
    // After two seconds of the board's own time, which a busy computer makes long.
    let status = board.comes_to(r#""state":"fault""#);
    assert!(status.contains(r#""fault":"F18""#) && status.contains(r#""outputs":[]"#), "{status}");
}

#[test]
fn a_restart_asks_where_the_tool_stands() {
    let board = Board::start();
    let job = "F6000\nG91\nG1 X1\nG1 X1\nG1 X1\n";
    let mut stream = board.stream(job, &["--any-profile", "--from-line", "4"]);
    stream.hears("line 4 begins at X 100, Y 0, Z 0; the board stands at X 0, Y 0, Z 0");
    stream.hears("it goes there first, with its outputs off: X to 1 mm (machine positions)");
    stream.hears("Is this way free");
    stream.press("no");
    assert_eq!(stream.end().0, 2);
    let mut stream = board.stream(job, &["--any-profile", "--from-line", "4"]);
    stream.hears("Is this way free");
    stream.press("yes");
    let (code, out) = stream.end();
    assert_eq!(code, 0);
    assert!(out.contains("done, 4 statements"), "{out}");
    // Where the whole job ends.
    assert!(board.status().contains(r#""X":300"#));
}

#[test]
fn lines_are_those_of_the_file_also_of_another_systems() {
    let board = Board::start();
    let job = "G21 G90\nG91\n\nG1 F6000 X1\nG1 X1\nG4 P30\nG1 X1\nM30\n";
    let mut stream = board.stream_as("job.nc", job, &["--any-profile"]);
    std::thread::sleep(Duration::from_millis(1500));
    stream.press("q");
    stream.hears("job.nc:6:1: stopped here");
    assert_eq!(stream.end().0, 3);
    let mut stream =
        board.stream_as("job.nc", job, &["--any-profile", "--from-line", "7", "--yes"]);
    stream.hears("line 7 begins at X 200");
    assert_eq!(stream.end().0, 0);
    assert!(board.status().contains(r#""X":300"#));
}

/// What stops it is told by the lines of the job, not by the pieces that they became.
#[test]
fn a_job_is_laid_onto_the_heights_of_a_file_on_its_way() {
    let board = Board::start();
    let heights = board.0.folder.path().join("heights.txt");
    let text = "height 0 0 0\nheight 10 0 1\nheight 0 10 0\nheight 10 10 1\n";
    std::fs::write(&heights, text).expect("a file");
    let level = ["--any-profile", "--level", heights.to_str().expect("a name")];
    let job = "G21 G90\nG0 X1 Y1 Z-1\nG1 X3 F6000\nM30\n";
    assert_eq!(board.stream_as("job.nc", job, &level).end().0, 0);
    let status = board.status();
    assert!(status.contains(r#""X":300"#) && status.contains(r#""Z":-70"#), "{status}");
    let mut stream = board.stream_as("job.nc", &job.replace("X3", "X30"), &level);
    stream.hears("job.nc:3:1: error[X038]");
    assert_eq!(stream.end().0, 1);
}

/// Its KEEP values and handlers want a stored program, and there is room for one.
#[test]
fn what_cannot_be_cut_is_stored_whole_where_it_fits() {
    let board = Board::start();
    let lines: String = (0..400)
        .map(|i| format!("IF parts > {} THEN parts = parts + {}\n", 1_000 + i, 1 + i % 3))
        .collect();
    for head in ["KEEP parts\nparts = 7\n", "DIM parts\nON EVERY 1s GOSUB tick\nparts = 7\n"] {
        let tail = "PRINT \"end\"\nEND\ntick:\nRETURN\n";
        let tail = if head.contains("ON EVERY") { tail } else { "PRINT \"end\"\n" };
        let mut stream = board.stream(&format!("{head}{lines}{tail}"), &["--any-profile"]);
        stream.hears("it fits and is stored");
        let (code, out) = stream.end();
        assert_eq!(code, 0, "{out}");
        assert!(out.contains("1 pieces"), "{out}");
    }
}

#[test]
fn a_job_is_stored_in_pieces_where_that_is_asked_for() {
    let board = Board::start();
    let job: String = (0..500).map(|i| format!("G1 X0.{:02} Y0.{:02}\n", i % 70, i % 50)).collect();
    let stream = board.stream(&format!("F30000\n{job}"), &["--any-profile", "--stored"]);
    let (code, out) = stream.end();
    assert_eq!(code, 0, "{out}");
    assert!(out.contains("done, 501 lines") && out.contains("pieces"), "{out}");
    assert!(board.status().contains(r#""X":9,"Y":49"#), "{}", board.status());
}

/// On a board that cannot be fed Start would acknowledge the fault and begin nothing: the job waited for
/// ever, and so did the first Ctrl-C.
#[test]
fn a_latched_fault_is_told_before_a_job() {
    for part in ["g2553", "f5529"] {
        told_before_a_job(part);
    }
}

fn told_before_a_job(part: &str) {
    let board = Board(common::Board::start(&["--part", part]));
    let faulty = "PRINT 1\nWaitIn 5, ON, 50ms\nPRINT 2\n";
    let mut stream = board.stream(faulty, &["--any-profile"]);
    stream.hears("--from-line");
    assert_eq!(stream.end().0, 3);
    assert!(board.status().contains("\"state\":\"fault\""), "{}", board.status());
    let mut stream = board.stream("MoveRel X, 1mm\n", &["--any-profile"]);
    stream.hears("F13 is latched (");
    assert!(stream.told.contains("`pasapas start` acknowledges"), "{}", stream.told);
    assert_eq!(stream.end().0, 4);
    // It was told, not acknowledged.
    assert!(board.status().contains("\"state\":\"fault\""), "{}", board.status());
}
