//! `pasapas gateway` with a real broker, mosquitto, its own clients and those of others.
//!
//! They are packages of the system; where one is missing its test says so and passes, and CI installs
//! them.

#![cfg(unix)]

#[path = "../common/mod.rs"]
mod common;
mod harm;
mod kills;
mod paho;
mod plain;
mod relay;
mod sparkplug;
mod tls;

use std::io::{BufRead, BufReader};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::time::{Duration, Instant};

use common::Board;
use serde_json::Value;
use tempfile::TempDir;

/// Everything of these tests ends long before this, on a loaded machine too.
const PATIENCE: Duration = Duration::from_secs(30);

/// Where Debian has the broker: not on everybody's path.
fn mosquitto() -> Option<PathBuf> {
    let places = ["/usr/sbin/mosquitto", "/usr/bin/mosquitto", "/usr/local/sbin/mosquitto"];
    let found = places.into_iter().map(PathBuf::from).find(|path| path.exists());
    let clients =
        Command::new("mosquitto_sub").arg("--help").stdout(Stdio::null()).status().is_ok();
    if found.is_none() || !clients {
        eprintln!("mosquitto is not here: its test is left out");
        return None;
    }
    found
}

/// A process that ends with the test.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").and_then(|one| one.local_addr()).expect("a port").port()
}

/// A broker with a file of settings.
fn broker(program: &Path, folder: &Path, port: u16, more: &str) -> Process {
    let file = folder.join(format!("mosquitto-{port}.conf"));
    // Run as root it would become a user who cannot read the test's folder.
    let text = format!("listener {port} 127.0.0.1\nallow_anonymous true\nuser root\n{more}");
    std::fs::write(&file, text).expect("a file");
    let mut command = Command::new(program);
    let command = command.arg("-c").arg(&file).stdout(Stdio::null()).stderr(Stdio::null());
    let process = Process(command.spawn().expect("it starts"));
    let begun = Instant::now();
    while TcpStream::connect(("127.0.0.1", port)).is_err() {
        assert!(begun.elapsed() < PATIENCE, "the broker does not listen");
        std::thread::sleep(Duration::from_millis(20));
    }
    process
}

/// What a subscriber hears: topic and text.
struct Ear {
    heard: Receiver<(String, String)>,
    _process: Process,
}

impl Ear {
    fn new(port: u16, topic: &str, more: &[&str]) -> Ear {
        let mut child = Command::new("mosquitto_sub")
            .args(["-h", "localhost", "-p", &port.to_string(), "-q", "1", "-v", "-t", topic])
            .args(more)
            .stdout(Stdio::piped())
            .spawn()
            .expect("it starts");
        let lines = BufReader::new(child.stdout.take().expect("its output")).lines();
        let (to, heard) = mpsc::channel();
        std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                let (topic, text) = line.split_once(' ').unwrap_or((&line, ""));
                if to.send((topic.to_owned(), text.to_owned())).is_err() {
                    return;
                }
            }
        });
        Ear { heard, _process: Process(child) }
    }

    /// The next message that fits.
    fn wait(&self, what: &str, fits: impl Fn(&str, &str) -> bool) -> (String, String) {
        let until = Instant::now() + PATIENCE;
        let mut all = Vec::new();
        loop {
            let left = until.saturating_duration_since(Instant::now());
            match self.heard.recv_timeout(left) {
                Ok((topic, text)) if fits(&topic, &text) => return (topic, text),
                Ok((topic, mut text)) => {
                    text.truncate(text.floor_char_boundary(300));
                    all.push((topic, text));
                }
                Err(_) => panic!("no {what}; it heard {all:#?}"),
            }
        }
    }

    fn event(&self, name: &str) -> Value {
        let is = |topic: &str, text: &str| {
            topic.ends_with("/event") && text.contains(&format!("\"event\":\"{name}\""))
        };
        let (_, text) = self.wait(name, is);
        serde_json::from_str(&text).expect("JSON")
    }
}

fn publish(port: u16, topic: &str, text: &str) {
    let status = Command::new("mosquitto_pub")
        .args(["-h", "127.0.0.1", "-p", &port.to_string(), "-q", "1", "-t", topic, "-m", text])
        .status();
    assert!(status.expect("it starts").success());
}

fn upload(board: &Board, text: &str) {
    let script = board.folder.path().join("job.bas");
    std::fs::write(&script, text).expect("a script");
    let output = Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .arg("upload")
        .args([&script, Path::new("--port"), &board.port()])
        .output()
        .expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// The file of a gateway with that board and that `[mqtt]`.
fn gateway_file(board: &Board, folder: &TempDir, mqtt: &str) -> PathBuf {
    let file = folder.path().join("gateway.toml");
    let (port, outbox) = (board.port(), folder.path().join("outbox"));
    // What was uploaded, for the names of its variables.
    let script = board.folder.path().join("job.bas");
    let script = if script.exists() { format!("script = {script:?}\n") } else { String::new() };
    let text = format!(
        "[modbus]\nlisten = \"127.0.0.1:0\"\n[mqtt]\nlook_ms = 50\noutbox = {outbox:?}\n{mqtt}\n\
         [[board]]\nname = \"drill\"\nport = {port:?}\n{script}"
    );
    std::fs::write(&file, text).expect("a file");
    file
}

fn gateway(board: &Board, folder: &TempDir, mqtt: &str) -> Process {
    let child = Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .args([Path::new("gateway"), &gateway_file(board, folder, mqtt)])
        .stdout(Stdio::null())
        .spawn();
    Process(child.expect("it starts"))
}

/// Runs Python with a program; it must succeed.
fn python(program: &str, args: &[&str]) {
    let output = Command::new("python3").args(["-c", program]).args(args).output();
    let output = output.expect("python starts");
    let said = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&said));
}
