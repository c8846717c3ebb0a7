//! Serial ports as people meet them: two terminals on one, none named, busy, gone, no port at all.
#![cfg(unix)]

mod common;

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use common::{Board, sysfs};
use rustix::process::Signal;

fn tool(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pasapas"));
    command.args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn run(args: &[&str]) -> Output {
    tool(args).output().expect("the tool starts")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

fn port_of(board: &Board) -> String {
    board.port().display().to_string()
}

/// Uploads a program that never ends, starts it and watches it from another process without rest.
fn watched(board: &Board, more: &[&str]) -> Child {
    let port = port_of(board);
    let script = board.folder.path().join("loop.bas");
    fs::write(&script, "DO\nPRINT \"round\"\nWait 20ms\nLOOP\n").expect("a script");
    let script = script.display().to_string();
    for args in [vec!["upload", &script, "--port", &port], vec!["start", "--port", &port]] {
        let output = run(&args);
        assert!(output.status.success(), "{args:?}: {}", said(&output));
    }
    let args = [&["watch", "--port", &port], more].concat();
    tool(&args).spawn().expect("watch starts")
}

#[test]
fn stop_works_while_another_process_watches_without_a_pause() {
    let board = Board::start(&[]);
    let port = port_of(&board);
    let mut watch = watched(&board, &["--every", "0"]);
    std::thread::sleep(Duration::from_millis(500));
    for _ in 0..10 {
        let status = run(&["status", "--port", &port]);
        assert!(status.status.success(), "{}", said(&status));
    }
    let begun = Instant::now();
    let stop = run(&["stop", "--port", &port]);
    assert!(stop.status.success(), "{}", said(&stop));
    assert!(begun.elapsed() < Duration::from_secs(3), "{:?}", begun.elapsed());
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(watch.try_wait().expect("a child"), None, "watch still runs");
    watch.kill().expect("it ends");
    let shown = said(&watch.wait_with_output().expect("it ended"));
    assert!(shown.contains("> round") && shown.contains("ready"), "{shown}");
}

#[test]
fn who_keeps_the_line_is_named() {
    let board = Board::start(&[]);
    let port = port_of(&board);
    // A process that has the lock and goes to sleep with it, as one in a debugger does.
    let device = fs::canonicalize(&port).expect("the device").display().to_string();
    let keep = "import fcntl,sys,time\nf=open(sys.argv[1],'r+b',0)\nfcntl.lockf(f,fcntl.LOCK_EX)\n\
                print('kept',flush=True)\ntime.sleep(60)\n";
    let mut keeper = Command::new("python3")
        .args(["-c", keep, &device])
        .stdout(Stdio::piped())
        .spawn()
        .expect("python3 starts");
    let mut line = [0; 5];
    use std::io::Read as _;
    keeper.stdout.as_mut().expect("piped").read_exact(&mut line).expect("it has the lock");
    let output = run(&["status", "--port", &port]);
    let id = keeper.id();
    keeper.kill().expect("it ends");
    keeper.wait().expect("it ended");
    assert_eq!(output.status.code(), Some(4), "{}", said(&output));
    let text = said(&output);
    assert!(text.contains(&format!("(process {id})")) && text.contains("end it"), "{text}");
    let output = run(&["status", "--port", &port]);
    assert!(output.status.success(), "its lock went with it: {}", said(&output));
}

#[test]
fn a_port_that_vanishes_under_way_is_told_as_gone() {
    let mut board = Board::start(&[]);
    let watch = watched(&board, &[]);
    std::thread::sleep(Duration::from_millis(500));
    board.end(Signal::TERM);
    let output = watch.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(4), "{}", said(&output));
    let text = said(&output);
    assert!(text.contains("is gone: ") && text.contains("plug it in"), "{text}");
}

#[test]
fn what_does_not_open_is_told_with_its_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("file");
    fs::write(&file, "text").expect("a file");
    let missing = folder.path().join("missing").display().to_string();
    for (port, word) in [(file.display().to_string(), "no serial port"), (missing, "No such")] {
        let output = run(&["status", "--port", &port]);
        assert_eq!(output.status.code(), Some(4), "{}", said(&output));
        let text = said(&output);
        assert!(text.contains(word), "{text}");
        assert!(text.contains("there are ") || text.contains("plug the board in"), "{text}");
    }
}

#[test]
fn a_port_that_another_program_has_for_itself_is_told_with_its_name() {
    let board = Board::start(&[]);
    let device = fs::canonicalize(board.port()).expect("the device").display().to_string();
    let own = "import fcntl,sys,time\nf=open(sys.argv[1],'r+b',0)\nfcntl.flock(f,fcntl.LOCK_EX)\n\
               print('kept',flush=True)\ntime.sleep(60)\n";
    let mut owner = Command::new("python3")
        .args(["-c", own, &device])
        .stdout(Stdio::piped())
        .spawn()
        .expect("python3 starts");
    let mut line = [0; 5];
    use std::io::Read as _;
    owner.stdout.as_mut().expect("piped").read_exact(&mut line).expect("it has the port");
    let output = run(&["status", "--port", &device]);
    let id = owner.id();
    owner.kill().expect("it ends");
    owner.wait().expect("it ended");
    assert_eq!(output.status.code(), Some(4), "{}", said(&output));
    assert!(said(&output).contains(&format!("(process {id})")), "{}", said(&output));
}

#[cfg(target_os = "linux")]
#[test]
fn the_one_board_needs_no_name_and_of_several_one_is_chosen() {
    let board = Board::start(&[]);
    let device = fs::canonicalize(board.port()).expect("the device");
    let status = |root: &Path| {
        let mut command = tool(&["status"]);
        command.env("PASAPAS_SYSFS", root).output().expect("the tool starts")
    };
    // Sysfs writes `!` for a slash in a name.
    let name = device.strip_prefix("/dev").expect("a device").display().to_string();
    let own = ("0451", "f432", "00", name.replace('/', "!"));
    let other = ("0451", "f432", "00", "ttyACM7".to_owned());
    let one = status(sysfs(std::slice::from_ref(&own)).path());
    assert!(one.status.success(), "{}", said(&one));
    assert!(said(&one).contains(&device.display().to_string()), "{}", said(&one));
    let two = status(sysfs(&[own, other]).path());
    assert_eq!(two.status.code(), Some(2), "{}", said(&two));
    assert!(said(&two).contains("/dev/ttyACM7 (MSP-EXP430G2 LaunchPad LP1)"), "{}", said(&two));
    let none = status(sysfs(&[]).path());
    assert_eq!(none.status.code(), Some(2), "{}", said(&none));
    assert!(said(&none).contains("--port"), "{}", said(&none));
}
