//! A virtual board that a test keeps up, as a user would, and processes that a test ends.
#![allow(dead_code, reason = "each test takes what it needs")]

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

/// `pasapas board` on a pseudo-terminal, running until it is dropped.
pub struct Board {
    child: Child,
    /// For the test's files; the pseudo-terminal is there too.
    pub folder: TempDir,
}

impl Board {
    /// Waits until the board's pseudo-terminal is there.
    pub fn start(more: &[&str]) -> Board {
        Board::start_in(tempfile::tempdir().expect("a folder"), more)
    }

    /// The same with the pseudo-terminal in a folder.
    pub fn start_in(folder: TempDir, more: &[&str]) -> Board {
        let child = board_at(&folder.path().join("board"), more);
        Board { child, folder }
    }

    /// Another board in the place of one that ended.
    pub fn begin_again(&mut self, more: &[&str]) {
        // One that was killed leaves its name behind.
        let _ = std::fs::remove_file(self.port());
        self.child = board_at(&self.port(), more);
    }

    /// Sends it a signal.
    #[cfg(unix)]
    pub fn signal(&self, by: rustix::process::Signal) {
        signal(&self.child, by);
    }

    /// Ends the board by a signal.
    #[cfg(unix)]
    pub fn end(&mut self, by: rustix::process::Signal) -> ExitStatus {
        signal(&self.child, by);
        let status = end_of(&mut self.child, Duration::from_secs(20)).expect("the board ends");
        if by == rustix::process::Signal::KILL {
            // Its pseudo-terminal's number is free again: the name that it leaves behind could lead to
            // the board of a test beside this one.
            let _ = std::fs::remove_file(self.port());
        }
        status
    }

    /// Name of the pseudo-terminal.
    pub fn port(&self) -> PathBuf {
        self.folder.path().join("board")
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Starts `pasapas board` and waits until its pseudo-terminal is there.
fn board_at(link: &Path, more: &[&str]) -> Child {
    let child = Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .args(["board", "--pty"])
        .arg(link)
        .args(more)
        .stdout(Stdio::null())
        .spawn()
        .expect("the board starts");
    let begun = Instant::now();
    while !link.exists() {
        assert!(begun.elapsed() < Duration::from_secs(20), "no pseudo-terminal appeared");
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

/// A gateway that runs until it is dropped.
pub struct Gateway {
    child: Child,
    /// Where it listens.
    pub port: u16,
    /// Kept open: a tool whose output nobody reads ends.
    said: BufReader<ChildStdout>,
}

impl Gateway {
    /// Starts it at a free port.
    pub fn start(args: &[&str]) -> Gateway {
        Gateway::start_by(&mut Command::new(env!("CARGO_BIN_EXE_pasapas")), args)
    }

    /// The same by a command that takes the tool's arguments.
    pub fn start_by(command: &mut Command, args: &[&str]) -> Gateway {
        let mut child = command
            .args(["gateway", "--format", "json", "--listen", "127.0.0.1:0"])
            .args(args)
            .stdout(Stdio::piped())
            .spawn()
            .expect("it starts");
        let mut line = String::new();
        let mut said = BufReader::new(child.stdout.take().expect("its output"));
        said.read_line(&mut line).expect("text");
        let told: serde_json::Value = serde_json::from_str(&line).expect("JSON");
        let place = told["port"].as_str().expect("a port").rsplit(':').next().expect("a number");
        Gateway { child, port: place.parse().expect("a number"), said }
    }

    /// KB of memory that it holds.
    pub fn memory(&self) -> u64 {
        memory(self.child.id())
    }

    /// The next line of what it says.
    pub fn next_line(&mut self) -> serde_json::Value {
        let mut line = String::new();
        self.said.read_line(&mut line).expect("text");
        serde_json::from_str(&line).expect("JSON")
    }
}

impl Drop for Gateway {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// KB of memory that a process holds, where the system tells it.
pub fn memory(id: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}

/// A path as an argument.
pub fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// Runs our own command: its exit code, and all that it says.
pub fn pasapas(args: &[&str]) -> (i32, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_pasapas")).args(args).output();
    let output = output.expect("pasapas starts");
    let said = [output.stdout, output.stderr].concat();
    (output.status.code().unwrap_or(-1), String::from_utf8_lossy(&said).into_owned())
}

/// Sends a signal to a process.
#[cfg(unix)]
pub fn signal(child: &Child, signal: rustix::process::Signal) {
    let id = i32::try_from(child.id()).ok().and_then(rustix::process::Pid::from_raw);
    rustix::process::kill_process(id.expect("a process"), signal).expect("it lives");
}

/// How a process ends within a time.
pub fn end_of(child: &mut Child, within: Duration) -> Option<ExitStatus> {
    let begun = Instant::now();
    while begun.elapsed() < within {
        if let Some(status) = child.try_wait().expect("a child") {
            return Some(status);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    None
}

/// What Linux shows of USB devices: vendor, product, and an interface with its serial port.
pub fn sysfs(devices: &[(&str, &str, &str, String)]) -> TempDir {
    let root = tempfile::tempdir().expect("a folder");
    for (n, (vendor, product, interface, port)) in devices.iter().enumerate() {
        let files = [
            (format!("1-{n}/idVendor"), (*vendor).to_owned()),
            (format!("1-{n}/idProduct"), (*product).to_owned()),
            (format!("1-{n}/serial"), format!("LP{n}")),
            (format!("1-{n}:1.0/bInterfaceNumber"), (*interface).to_owned()),
            (format!("1-{n}:1.0/tty/{port}/dev"), "166:0".to_owned()),
        ];
        for (file, text) in files {
            let path = root.path().join("bus/usb/devices").join(file);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            std::fs::write(path, text).expect("a file");
        }
    }
    root
}

/// Whether a program of the system can be started; says so when it cannot.
pub fn has(program: &str, args: &[&str]) -> bool {
    let found = Command::new(program)
        .args(args)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success());
    if !found {
        eprintln!("{program} {args:?} does not run here: its test is left out");
    }
    found
}
