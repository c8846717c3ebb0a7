//! What commands write: never over an input, whole or not at all, and only while there is a reader.

mod common;

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

const SCRIPT: &str = "SetOut 1, ON\nMoveAxe X, 2mm\nSetOut 1, OFF\n";

/// The tool in a folder.
fn tool(folder: &TempDir, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pasapas"));
    command.args(args).current_dir(folder.path()).stdin(Stdio::null());
    command
}

fn run(folder: &TempDir, args: &[&str]) -> (Option<i32>, String) {
    let Output { status, stderr, .. } = tool(folder, args).output().expect("the tool starts");
    (status.code(), String::from_utf8_lossy(&stderr).into_owned())
}

fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    folder
}

#[cfg(unix)]
#[test]
fn no_command_writes_over_what_it_reads() {
    let mill = include_str!("../../examples/profiles/mill.toml").replace("\"mill\"", "\"own\"");
    let files = [
        ("a.bas", SCRIPT),
        ("own.bas", "PROFILE \"own\"\nMoveAxe X, 2mm\n"),
        ("a.nc", "G21\nG0 X1\nM30\n"),
        ("w.rhai", "at(5, || set_in(1, true));\n"),
        ("own.toml", &mill),
    ];
    let folder = folder(&files);
    let at = |name: &str| folder.path().join(name);
    std::os::unix::fs::symlink(at("a.bas"), at("link.svg")).expect("a link");
    fs::hard_link(at("own.toml"), at("second.toml")).expect("a second name");
    for args in [
        &["sim", "a.bas", "--trace", "a.bas"][..],
        &["sim", "a.bas", "--trace", "./a.bas"],
        &["sim", "a.bas", "--plot", "link.svg"],
        &["sim", "a.bas", "--engine", "board", "--vcd", "a.bas"],
        &["sim", "a.bas", "--world", "w.rhai", "--trace", "w.rhai"],
        &["sim", "a.bas", "--profile", "own.toml", "--trace", "second.toml"],
        &["sim", "own.bas", "--trace", "own.toml"],
        &[
            "sim", "a.bas", "--trace", "new", "--plot", "sub.svg", "--engine", "board", "--vcd",
            "new",
        ],
        &["build", "a.bas", "-o", "a.bas"],
        &["build", "own.bas", "-o", "own.toml"],
        &["import", "a.nc", "-o", "a.nc"],
        &["import", "a.nc", "--profile", "own.toml", "-o", "own.toml"],
        &["board", "--world", "w.rhai", "--flash", "w.rhai"],
    ] {
        let (code, said) = run(&folder, args);
        assert_eq!(code, Some(2), "{args:?}: {said}");
        assert!(
            said.contains("give it another name") || said.contains("a name of its own"),
            "{said}"
        );
        for (name, text) in files {
            assert_eq!(
                fs::read_to_string(at(name)).expect("there"),
                text,
                "{args:?} changed {name}"
            );
        }
    }
}

/// A limit on the size of files stands for a disk that is full.
#[cfg(unix)]
#[test]
fn a_full_disk_takes_no_script() {
    let folder = folder(&[("big.bas", "")]);
    let path = folder.path().join("big.bas");
    let text = "dim i\nfor i=1 to 3\nsetout i,on\nnext\n".repeat(2000).replace("dim i", "");
    let text = format!("dim i\n{text}");
    fs::write(&path, &text).expect("written");
    // Blocks of 512 or 1024 bytes: in any case less than the file.
    let tool = env!("CARGO_BIN_EXE_pasapas");
    let shell = format!("trap '' XFSZ; ulimit -f 4; exec {tool} fmt big.bas");
    let done = Command::new("sh").args(["-c", &shell]).current_dir(folder.path()).output();
    let done = done.expect("a shell");
    assert_eq!(done.status.code(), Some(4), "{}", String::from_utf8_lossy(&done.stderr));
    assert_eq!(fs::read_to_string(&path).expect("there"), text);
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "something is left");
    assert_eq!(run(&folder, &["fmt", "big.bas"]).0, Some(0));
    assert_ne!(fs::read_to_string(&path).expect("there"), text);
}

#[cfg(unix)]
#[test]
fn a_reader_that_goes_away_ends_an_endless_run() {
    let folder = folder(&[("inf.bas", "DO\n  PRINT 1\n  SetOut 1, ON\nLOOP\n")]);
    for args in [
        &["sim", "inf.bas"][..],
        &["sim", "inf.bas", "--engine", "vm"],
        &["sim", "inf.bas", "--trace", "-"],
        &["sim", "inf.bas", "--engine", "board", "--trace", "-"],
        &["sim", "inf.bas", "--engine", "board"],
    ] {
        let begun = Instant::now();
        let mut child = tool(&folder, args)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the tool starts");
        drop(child.stdout.take());
        let ended = common::end_of(&mut child, Duration::from_secs(30));
        let _ = child.kill();
        let said = child.wait_with_output().expect("its words").stderr;
        assert_eq!(ended.and_then(|status| status.code()), Some(141), "{args:?}");
        assert_eq!(String::from_utf8_lossy(&said), "", "{args:?}");
        assert!(begun.elapsed() < Duration::from_secs(30), "{args:?}");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_run_and_what_it_has_is_written() {
    let folder = folder(&[("inf.bas", "DO\n  PRINT 1\n  Wait 1ms\nLOOP\n")]);
    let mut child = tool(&folder, &["sim", "inf.bas", "--trace", "t"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the tool starts");
    let mut out = child.stdout.take().expect("its output");
    let mut first = [0; 2];
    std::io::Read::read_exact(&mut out, &mut first).expect("it prints");
    let reader = std::thread::spawn(move || std::io::copy(&mut out, &mut std::io::sink()));
    common::signal(&child, rustix::process::Signal::INT);
    let ended = common::end_of(&mut child, Duration::from_secs(30));
    let _ = child.kill();
    let _ = reader.join();
    assert_eq!(ended.and_then(|status| status.code()), Some(3));
    let trace = fs::read_to_string(folder.path().join("t")).expect("the trace");
    let last = trace.lines().last().unwrap_or_default();
    assert!(last.contains("\"end\"") && last.contains("\"stopped\""), "{last}");
}

/// The process may be ended as soon as `upload` has said that the program is on the board.
#[cfg(unix)]
#[test]
fn an_upload_that_said_done_is_in_the_flash_file() {
    let board = |folder: &Path| {
        let flash = folder.join("flash").display().to_string();
        common::Board::start_in(tempfile::tempdir().expect("a folder"), &["--flash", &flash])
    };
    let folder = folder(&[("a.bas", SCRIPT)]);
    for signal in [rustix::process::Signal::TERM, rustix::process::Signal::KILL] {
        let mut kept = board(folder.path());
        let port = kept.port().display().to_string();
        let (code, said) = run(&folder, &["upload", "a.bas", "--port", &port]);
        assert_eq!(code, Some(0), "{said}");
        let ended = kept.end(signal);
        if signal == rustix::process::Signal::TERM {
            assert_eq!(ended.code(), Some(0));
            assert!(!kept.port().is_symlink(), "the link is left behind");
        }
        let again = board(folder.path());
        let port = again.port().display().to_string();
        let status = tool(&folder, &["status", "--port", &port, "--format", "json"]).output();
        let status: serde_json::Value =
            serde_json::from_slice(&status.expect("the tool starts").stdout).expect("JSON");
        assert!(status["board"]["program_bytes"].as_u64() > Some(0), "{signal:?}: {status}");
        fs::remove_file(folder.path().join("flash")).expect("the flash's file");
    }
}

#[test]
fn a_world_takes_no_time_of_the_desktop() {
    let folder = folder(&[("a.bas", SCRIPT), ("w.rhai", "at(5, || sleep(100000));\n")]);
    let begun = Instant::now();
    let (code, said) = run(&folder, &["sim", "a.bas", "--world", "w.rhai"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.starts_with("w.rhai:1:") && said.contains("cannot sleep"), "{said}");
    assert!(begun.elapsed() < Duration::from_secs(20));
    // What a world says is no part of the trace.
    fs::write(folder.path().join("w.rhai"), "print(1); debug(2);\n").expect("written");
    let done = tool(&folder, &["sim", "a.bas", "--world", "w.rhai", "--trace", "-"]).output();
    let done = done.expect("the tool starts");
    let trace = String::from_utf8_lossy(&done.stdout).into_owned();
    assert!(trace.lines().all(|line| line.starts_with('{')), "{trace}");
}

#[test]
fn a_page_of_a_file_that_is_called_like_a_mark_is_whole() {
    for name in ["{{data}}.bas", "{{viewer}}.bas", "{{css}}.bas", "{{title}}.bas"] {
        let folder = folder(&[(name, SCRIPT)]);
        let (code, said) = run(&folder, &["sim", name, "--plot", "p.html"]);
        assert_eq!(code, Some(0), "{said}");
        let page = fs::read_to_string(folder.path().join("p.html")).expect("the page");
        assert!(page.contains(&format!("<title>{name}</title>")), "{name}");
        let data = page.lines().find_map(|line| line.strip_prefix("const RUN = "));
        let data = data.and_then(|data| data.strip_suffix(';')).expect("the data");
        let data: serde_json::Value = serde_json::from_str(data).expect("JSON");
        assert_eq!(data["title"], name);
        assert_eq!(page.matches("<script>").count(), 1, "{name}");
    }
}
