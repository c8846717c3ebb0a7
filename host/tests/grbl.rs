//! `pasapas grbl` and `[[grbl]]` as users have them: clients of Grbl on the emulated F5529, over TCP and a
//! pseudo-terminal; who leaves; who comes second; what is no line.
#![cfg(unix)]

mod common;

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use common::{Board, Gateway, has, pasapas, text};
use tempfile::TempDir;

/// Longest wait for anything: the machine of a test may be busy.
const PATIENCE: Duration = Duration::from_secs(40);

/// Boards run in real time: one after the other.
static ALONE: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// `pasapas grbl` with a virtual board.
struct Server {
    child: Child,
    port: u16,
    folder: TempDir,
}

impl Server {
    fn start(more: &[&str]) -> Server {
        let folder = tempfile::tempdir().expect("a folder");
        let mut child = Command::new(env!("CARGO_BIN_EXE_pasapas"))
            .args(["grbl", "--tcp", "0", "--pty"])
            .arg(folder.path().join("grbl"))
            .args(more)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts");
        let mut line = String::new();
        BufReader::new(child.stdout.take().expect("piped")).read_line(&mut line).expect("text");
        let place = line.strip_prefix("Grbl 1.1h is served at tcp:").expect(&line);
        let port = place.split_whitespace().next().and_then(|port| port.parse().ok());
        Server { child, port: port.expect("a port"), folder }
    }

    fn pty(&self) -> String {
        text(&self.folder.path().join("grbl")).to_owned()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A client of our own.
struct Client {
    stream: TcpStream,
    heard: String,
}

impl Client {
    fn connect(port: u16) -> Client {
        let stream = TcpStream::connect(("127.0.0.1", port)).expect("a connection");
        stream.set_nodelay(true).expect("a socket");
        stream.set_read_timeout(Some(Duration::from_millis(10))).expect("a socket");
        Client { stream, heard: String::new() }
    }

    fn send(&mut self, bytes: &[u8]) {
        self.stream.write_all(bytes).expect("it takes bytes");
    }

    fn read(&mut self) {
        let mut bytes = [0; 4096];
        if let Ok(count) = self.stream.read(&mut bytes) {
            self.heard += &String::from_utf8_lossy(&bytes[..count]);
        }
    }

    fn until(&mut self, what: &str) {
        let begun = Instant::now();
        while !self.heard.contains(what) {
            assert!(begun.elapsed() < PATIENCE, "no {what:?} in {:?}", self.heard);
            self.read();
        }
    }

    /// A line, and all up to its answer.
    fn ask(&mut self, line: &str) -> String {
        self.heard.clear();
        self.send(format!("{line}\n").as_bytes());
        let begun = Instant::now();
        loop {
            self.read();
            let ends = |line: &str| line == "ok" || line.starts_with("error:");
            if self.heard.ends_with("\r\n") && self.heard.lines().any(ends) {
                return std::mem::take(&mut self.heard);
            }
            assert!(begun.elapsed() < PATIENCE, "{line}: {:?}", self.heard);
        }
    }

    /// Reports until one has the state; that report.
    fn state(&mut self, state: &str) -> String {
        let begun = Instant::now();
        loop {
            self.heard.clear();
            self.send(b"?");
            self.until(">");
            if self.heard.contains(&format!("<{state}|")) {
                return std::mem::take(&mut self.heard);
            }
            assert!(begun.elapsed() < PATIENCE, "never {state}: {:?}", self.heard);
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// A job of short lines on a spiral, as CAM writes it.
fn job(folder: &Path, lines: u32) -> String {
    let path = folder.join("job.nc");
    let mut file = File::create(&path).expect("a file");
    writeln!(file, "G21 G90 G17\nM3 S1000\nG0 Z0\nG1 F1200").expect("written");
    for i in 0..lines {
        let (angle, radius) = (f64::from(i) * 0.05, 5.0 + f64::from(i) * 0.01);
        let (x, y) = (20.0 + radius * angle.cos(), 20.0 + radius * angle.sin());
        writeln!(file, "X{x:.3} Y{y:.3}").expect("written");
    }
    writeln!(file, "M5\nG0 X0 Y0\nM30").expect("written");
    text(&path).to_owned()
}

/// Runs a client in Python; what it has seen, or none where it is not installed.
fn client(module: &str, args: &[&str]) -> Option<serde_json::Value> {
    if !has("python3", &["-c", &format!("import {module}")]) {
        return None;
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/grbl_clients.py");
    let home = tempfile::tempdir().expect("a folder");
    let output = Command::new("python3")
        .arg(script)
        .args(args)
        // bCNC keeps a file of its own.
        .env("HOME", home.path())
        .output()
        .expect("python3 starts");
    let said = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}\n{errors}");
    let last = said.lines().last().expect("an object");
    Some(serde_json::from_str(last).unwrap_or_else(|_| panic!("{said}")))
}

#[test]
fn bcnc_drives_a_job_over_tcp_with_a_hold_and_an_override() {
    let _alone = alone();
    let server = Server::start(&[]);
    let job = job(server.folder.path(), 300);
    let port = format!("socket://127.0.0.1:{}", server.port);
    let Some(seen) = client("bCNC", &["bcnc", &port, &job]) else { return };
    assert_eq!(seen["errors"], serde_json::json!([]), "{seen}");
    assert_eq!(seen["travel"], 300.0);
    assert_eq!(seen["jogged"], 30.0);
    assert_eq!(seen["end"], serde_json::json!([0.0, 0.0]));
    assert!(seen["lines"].as_u64() > Some(300), "{seen}");
}

#[test]
fn pygrbl_streamer_drives_a_job_over_a_pseudo_terminal_pauses_and_stops() {
    let _alone = alone();
    let server = Server::start(&[]);
    let job = job(server.folder.path(), 200);
    let Some(seen) = client("pygrbl_streamer", &["pygrbl", &server.pty(), &job]) else { return };
    assert_eq!(seen["first"], "IDLE", "{seen}");
    assert_eq!(seen["paused"], "PAUSED");
    assert_eq!(seen["ended"], true);
    let events = seen["events"].as_array().expect("events");
    assert!(events.iter().all(|event| event[0] == "gone"), "{seen}");
}

#[test]
fn probing_homing_arcs_inches_and_limits_on_the_board() {
    let _alone = alone();
    let server = Server::start(&[]);
    let mut client = Client::connect(server.port);
    client.until("Grbl 1.1h ['$' for help]\r\n");
    client.state("Idle");
    // Nothing is there that it could meet.
    let heard = client.ask("G38.3 Z-2 F600");
    assert!(heard.starts_with("[PRB:0.000,0.000,-2.000:0]"), "{heard}");
    let heard = client.ask("G38.2 Z-3 F600");
    assert!(heard.contains(":0]\r\nALARM:5\r\nok"), "{heard}");
    assert_eq!(client.ask("G0 X1"), "error:9\r\n");
    client.ask("$X");
    assert_eq!(client.ask("$H"), "ok\r\n");
    let report = client.state("Idle");
    assert!(report.contains("MPos:0.000,0.000,0.000"), "{report}");
    client.ask("G20 G0 X1 Y1");
    client.ask("G21 G2 X45.4 Y25.4 I10 J0 F3000");
    client.ask("G18 G3 X35.4 Z0 I-5 K0");
    assert_eq!(client.ask("M114"), "X:35.400 Y:25.400 Z:0.000\r\nok\r\n", "it turns inside");
    client.heard.clear();
    client.send(b"G0 X301\n");
    client.until("ALARM:2\r\n[MSG:Reset to continue]");
    client.heard.clear();
    client.send(b"\x18");
    client.until("to unlock]");
    client.ask("$X");
    client.ask("G0 X0 Y0");
    client.ask("G4 P0");
    assert!(client.state("Idle").contains("MPos:0.000,0.000,0.000"));
}

#[test]
fn a_job_whose_client_dies_is_stopped_with_its_outputs_off() {
    let _alone = alone();
    let board = Board::start(&[]);
    let folder = board.folder.path();
    let file = folder.join("hall.toml");
    let config = format!(
        "[[board]]\nname = \"saw\"\nport = \"{}\"\n[[grbl]]\nboard = \"saw\"\nlisten = \"127.0.0.1:0\"\n",
        board.port().display()
    );
    std::fs::write(&file, config).expect("a file");
    let mut gateway = Gateway::start(&[text(&file)]);
    let told = gateway.next_line();
    let place = told["grbl"].as_str().and_then(|place| place.rsplit(':').next()?.parse().ok());
    let mut client = Client::connect(place.unwrap_or_else(|| panic!("{told}")));
    client.until("Grbl 1.1h");
    client.state("Idle");
    for line in ["M3 S1000", "M8", "M42 P5 S1", "G1 X200 F600"] {
        assert_eq!(client.ask(line), "ok\r\n", "{line}");
    }
    let status = || {
        let port = format!("tcp:{}", gateway.port);
        let begun = Instant::now();
        loop {
            let (code, said) = pasapas(&["status", "--format", "json", "--port", &port]);
            if code == 0 {
                return serde_json::from_str::<serde_json::Value>(&said).expect("JSON");
            }
            // A busy machine may let the emulated board miss a reply.
            assert!(begun.elapsed() < PATIENCE, "{said}");
        }
    };
    let begun = Instant::now();
    while status()["outputs"] != serde_json::json!([1, 2, 5]) || status()["state"] != "running" {
        assert!(begun.elapsed() < PATIENCE, "{}", status());
    }
    drop(client);
    let gone = Instant::now();
    let rests = |last: &serde_json::Value| {
        let none = serde_json::json!([]);
        last["outputs"] == none && last["moving"] == none && last["state"] != "running"
    };
    // 2 s and the ramp from 10 mm/s: no look that begins later finds it moving or on. How long a look
    // takes on a busy machine does not count.
    let within = Duration::from_millis(2_040);
    loop {
        let looked = gone.elapsed();
        let last = status();
        if rests(&last) {
            break;
        }
        assert!(looked < within, "{looked:?}: {last}");
    }
}

#[test]
fn a_second_client_is_told_and_closed_and_the_first_goes_on() {
    let _alone = alone();
    let server = Server::start(&[]);
    let mut first = Client::connect(server.port);
    first.until("Grbl 1.1h");
    let mut second = Client::connect(server.port);
    second.until("[MSG:another client drives this machine]");
    assert!(!second.heard.contains("Grbl"));
    let mut pty = File::options().read(true).write(true).open(server.pty()).expect("it opens");
    pty.write_all(b"G0X5\n").expect("it takes bytes");
    assert_eq!(first.ask("G4P0"), "ok\r\n");
    assert!(first.state("Idle").contains("MPos:0.000,0.000,0.000"), "not moved");
    drop((first, pty));
    // A pseudo-terminal that closes is seen, too.
    for _ in 0..2 {
        let mut next = Client::connect(server.port);
        let begun = Instant::now();
        while !next.heard.contains("Grbl 1.1h") {
            next.read();
            if next.heard.contains("another client") {
                next = Client::connect(server.port);
            }
            assert!(begun.elapsed() < PATIENCE, "it stays taken");
        }
    }
}

#[test]
fn who_knocks_without_end_keeps_nobody_from_a_hold() {
    let _alone = alone();
    let server = Server::start(&[]);
    let mut client = Client::connect(server.port);
    client.until("Grbl 1.1h");
    let port = server.port;
    let over = std::sync::atomic::AtomicBool::new(false);
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                while !over.load(std::sync::atomic::Ordering::SeqCst) {
                    let mut knocks = TcpStream::connect(("127.0.0.1", port)).expect("a connection");
                    let _ = knocks.set_read_timeout(Some(Duration::from_millis(20)));
                    let _ = knocks.read(&mut [0; 64]);
                }
            });
        }
        client.send(b"G1X40F300\n");
        let heard = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            client.state("Run");
            client.send(b"!");
            client.state("Hold:0")
        }));
        over.store(true, std::sync::atomic::Ordering::SeqCst);
        heard.expect("it is heard");
    });
}

#[test]
fn hostile_bytes_move_nothing_and_cost_no_answer() {
    let _alone = alone();
    let server = Server::start(&[]);
    let mut client = Client::connect(server.port);
    client.until("Grbl 1.1h");
    let mut seed = 7u32;
    let mut bytes = Vec::new();
    for _ in 0..20_000 {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let byte = (seed >> 24) as u8;
        // Neither resets nor letters of motion: what may move is tried elsewhere.
        bytes.push(if byte == 0x18 || b"gG$".contains(&byte) { b' ' } else { byte });
    }
    client.send(&bytes);
    client.send(&b"?".repeat(2_000));
    client.send(&[b'Y'; 4_096]);
    client.send(b"\n");
    client.heard.clear();
    client.send(b"\x18");
    client.until("\r\nGrbl 1.1h");
    std::thread::sleep(Duration::from_millis(500));
    client.read();
    client.heard.clear();
    client.send(b"\x18");
    client.until("\r\nGrbl 1.1h");
    assert!(client.state("Idle").contains("MPos:0.000,0.000,0.000"));
    assert_eq!(client.ask("G0 X1"), "ok\r\n");
    assert_eq!(client.ask("G4 P0"), "ok\r\n");
    assert!(client.state("Idle").contains("MPos:1.000,0.000,0.000"));
}

#[test]
fn offsets_are_kept_in_a_file() {
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("offsets.json");
    let args = ["--offsets", text(&file)];
    let server = Server::start(&args);
    let mut client = Client::connect(server.port);
    client.until("Grbl 1.1h");
    client.ask("G10 L2 P3 X1.5 Y-2");
    drop(client);
    drop(server);
    let server = Server::start(&args);
    let mut client = Client::connect(server.port);
    client.until("Grbl 1.1h");
    assert!(client.ask("$#").contains("[G56:1.500,-2.000,0.000]"));
}

#[test]
fn the_manuals_section_is_a_good_one() {
    let page = include_str!("../grbl.md");
    let piece = page.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next());
    let file = format!("[[board]]\nname = \"drill\"\nport = \"x\"\n{}", piece.expect("a section"));
    let config = pasapas::gateway::Config::parse("grbl.md", &file);
    let config = config.unwrap_or_else(|note| panic!("{}", note.text));
    assert_eq!(config.grbl.len(), 1);
}
