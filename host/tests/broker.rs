//! `pasapas gateway` with a real broker, mosquitto, and its own clients.
//!
//! They are packages of the system; where one is missing its test says so and passes, and CI installs
//! them.

#![cfg(unix)]

mod common;

use std::io::{BufRead, BufReader};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::time::{Duration, Instant};

use common::{Board, end_of, signal};
use rustix::process::Signal;
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
                Ok(other) => all.push(other),
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

fn gateway(board: &Board, folder: &TempDir, mqtt: &str) -> Process {
    let file = folder.path().join("gateway.toml");
    let (port, outbox) = (board.port(), folder.path().join("outbox"));
    let text = format!(
        "[modbus]\nlisten = \"127.0.0.1:0\"\n[mqtt]\nlook_ms = 50\noutbox = {outbox:?}\n{mqtt}\n\
         [[board]]\nname = \"drill\"\nport = {port:?}\n"
    );
    std::fs::write(&file, text).expect("a file");
    let child = Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .args([Path::new("gateway"), &file])
        .stdout(Stdio::null())
        .spawn();
    Process(child.expect("it starts"))
}

#[test]
fn state_events_orders_will_and_what_happened_while_the_broker_was_away() {
    let Some(program) = mosquitto() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let board = Board::start(&[]);
    upload(&board, "PRINT \"hello\"\nMoveAxe X, 1mm\n");
    let port = free_port();
    let mut first = broker(&program, folder.path(), port, "");
    let ear = Ear::new(port, "pasapas/#", &[]);
    let setting =
        format!("broker = \"127.0.0.1:{port}\"\nwrite = [\"RUN_CONTROL\", \"coils 0..3\"]");
    let mut gateway_process = gateway(&board, &folder, &setting);
    ear.wait("online", |topic, text| topic == "pasapas/gateway/status" && text == "online");
    let ready = |topic: &str, text: &str| {
        topic == "pasapas/gateway/drill/state" && text.contains("\"state\":\"ready\"")
    };
    ear.wait("ready", ready);
    // An order with a reply, and the events of the run.
    publish(port, "pasapas/gateway/drill/command", r#"{"do":"start","id":77,"reply":"my/reply"}"#);
    let replies = Ear::new(port, "my/reply", &[]);
    let begun = ear.event("start");
    assert_eq!(ear.event("print")["text"], "hello");
    let end = ear.event("end");
    assert_eq!((&end["status"], &begun["run"]), (&"done".into(), &end["run"]));
    assert!(end["id"].as_u64() > begun["id"].as_u64());
    // What is not allowed is not done, and told.
    publish(port, "pasapas/gateway/drill/command", r#"{"do":"set","output":5,"value":1,"id":5}"#);
    let refused =
        |topic: &str, text: &str| topic.ends_with("/drill/reply") && text.contains("\"id\":5");
    let (_, text) = ear.wait("refusal", refused);
    assert!(text.contains("\"ok\":false") && text.contains("does not allow"), "{text}");
    publish(
        port,
        "pasapas/gateway/drill/command",
        r#"{"do":"set","output":2,"value":1,"reply":"my/reply"}"#,
    );
    replies.wait("reply", |_, text| text.contains("\"ok\":true"));
    ear.wait("output 2", |topic, text| {
        topic.ends_with("/state") && text.contains("\"outputs\":[2]")
    });
    // The broker goes; the board runs meanwhile; a new broker that knows nothing hears of it.
    signal(&first.0, Signal::TERM);
    assert!(end_of(&mut first.0, PATIENCE).is_some());
    let start = Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .args([Path::new("start"), Path::new("--port"), &board.port()])
        .status();
    assert!(start.expect("it starts").success());
    std::thread::sleep(Duration::from_secs(1));
    let _second = broker(&program, folder.path(), port, "");
    // It comes back by itself within its rests, the subscriber too.
    let ear = Ear::new(port, "pasapas/#", &[]);
    let again = ear.event("end");
    assert!(again["id"].as_u64() > end["id"].as_u64(), "{again} behind {end}");
    assert_eq!(again["status"], "done");
    // The gateway is killed: its will is heard.
    gateway_process.0.kill().expect("it lives");
    ear.wait("will", |topic, text| topic == "pasapas/gateway/status" && text == "offline");
}

/// Runs a program of the system that must succeed.
fn run(folder: &Path, program: &str, args: &str) {
    let output = Command::new(program).args(args.split(' ')).current_dir(folder).output();
    let output = output.expect("it starts");
    assert!(
        output.status.success(),
        "{program} {args}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn tls_and_passwords_are_kept_to() {
    let Some(program) = mosquitto() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path();
    for name in ["ca", "other"] {
        run(
            place,
            "openssl",
            &format!(
                "req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj /CN={name} \
                 -keyout {name}.key -out {name}.pem"
            ),
        );
    }
    std::fs::write(place.join("ext"), "subjectAltName=DNS:localhost,IP:127.0.0.1\n")
        .expect("a file");
    let request = "req -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN=localhost -keyout \
                   server.key -out server.csr";
    run(place, "openssl", request);
    let sign = "x509 -req -in server.csr -CA ca.pem -CAkey ca.key -CAcreateserial -days 2 -extfile ext \
                -out server.pem";
    run(place, "openssl", sign);
    run(place, "mosquitto_passwd", "-c -b users hall secret");
    std::fs::write(place.join("password"), "secret\n").expect("a file");
    std::fs::write(place.join("wrong"), "sekret\n").expect("a file");
    let (plain, port) = (free_port(), free_port());
    let path = |name: &str| place.join(name).display().to_string();
    let more = format!(
        "listener {port} 127.0.0.1\ncafile {}\ncertfile {}\nkeyfile {}\nallow_anonymous false\n\
         password_file {}\nper_listener_settings false\n",
        path("ca.pem"),
        path("server.pem"),
        path("server.key"),
        path("users")
    );
    let _broker = broker(&program, place, plain, &more);
    let board = Board::start(&[]);
    let user = ["--cafile", &path("ca.pem"), "-u", "hall", "-P", "secret"];
    let ear = Ear::new(port, "pasapas/#", &user);
    let setting = |name: &str, ca: &str, password: &str| {
        format!(
            "broker = \"localhost:{port}\"\nname = \"{name}\"\nuser = \"hall\"\nca_file = {:?}\n\
             password_file = {:?}",
            place.join(ca),
            place.join(password)
        )
    };
    // Two that must not come in, then one that must.
    let wrong = [setting("foreign", "other.pem", "password"), setting("thief", "ca.pem", "wrong")];
    for setting in wrong {
        let _gateway = gateway(&board, &folder, &setting);
        std::thread::sleep(Duration::from_secs(1));
    }
    let _gateway = gateway(&board, &folder, &setting("good", "ca.pem", "password"));
    let (topic, _) =
        ear.wait("online", |topic, text| topic.ends_with("/status") && text == "online");
    assert_eq!(topic, "pasapas/good/status");
}

/// Another's decoder of Sparkplug's protocol buffer, and the rules that the messages keep: they come as
/// `TOPIC HEX` lines. `request FILE` writes a host's request for a birth instead.
const SPARKPLUG: &str = r#"
import sys
from tahutils.tahu.sparkplug_b_pb2 import Payload

if sys.argv[1] == "request":
    payload = Payload()
    payload.timestamp = 1
    metric = payload.metrics.add()
    metric.name, metric.datatype, metric.boolean_value = "Node Control/Rebirth", 11, True
    if len(sys.argv) > 3:
        metric.name, metric.datatype, metric.string_value = "Control", 12, sys.argv[3]
    open(sys.argv[2], "wb").write(payload.SerializeToString())
    sys.exit()

kinds, seq, bd, births, names = [], None, None, 0, {}
for line in sys.stdin:
    topic, _, hexed = line.strip().partition(" ")
    parts = topic.split("/")
    if parts[0] != "spBv1.0" or parts[2] in ("NCMD", "DCMD"):
        continue
    assert parts[1] == "hall" and parts[3] == "node", topic
    payload = Payload()
    payload.ParseFromString(bytes.fromhex(hexed))
    kind = parts[2]
    kinds.append(kind)
    assert payload.HasField("timestamp")
    metrics = {metric.name: metric for metric in payload.metrics}
    if kind == "NDEATH":
        assert not payload.HasField("seq") and metrics["bdSeq"].long_value == bd, (payload, bd)
        continue
    if kind == "NBIRTH":
        assert payload.seq == 0, payload
        assert births == 0 or metrics["bdSeq"].long_value == bd, "a rebirth keeps bdSeq"
        bd, births = metrics["bdSeq"].long_value, births + 1
        assert metrics["bdSeq"].datatype == 4
        assert metrics["Node Control/Rebirth"].boolean_value is False
        names = {}
    else:
        assert payload.seq == (seq + 1) % 256, (topic, payload.seq, seq)
        if kind == "DBIRTH":
            names[parts[4]] = set(metrics)
            assert all(metric.datatype for metric in payload.metrics)
            assert {"State", "Runs", "Control", "Outputs/16", "Inputs/17"} <= set(metrics)
        elif kind == "DDATA":
            assert set(metrics) <= names[parts[4]], metrics
    seq = payload.seq
assert births == 2, kinds
assert kinds[:2] == ["NBIRTH", "DBIRTH"] and kinds[-1] == "NDEATH" and "DDATA" in kinds, kinds
print("sparkplug passed", len(kinds))
"#;

#[test]
fn sparkplug_is_read_by_anothers_decoder_and_keeps_its_rules() {
    let Some(program) = mosquitto() else { return };
    let python = |args: &[&str]| {
        let mut command = Command::new("python3");
        command.args(["-c", SPARKPLUG]).args(args);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().expect("it starts")
    };
    let there = Command::new("python3")
        .args(["-c", "import tahutils.tahu.sparkplug_b_pb2"])
        .stderr(Stdio::null())
        .status();
    if !there.is_ok_and(|status| status.success()) {
        eprintln!("tahutils is not here: its test is left out");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let board = Board::start(&[]);
    upload(&board, "MoveAxe X, 1mm\n");
    let port = free_port();
    let _broker = broker(&program, folder.path(), port, "");
    let ear = Ear::new(port, "spBv1.0/#", &["-F", "%t %x"]);
    let setting = format!(
        "broker = \"127.0.0.1:{port}\"\nwrite = [\"RUN_CONTROL\"]\n\
         [sparkplug]\ngroup = \"hall\"\nnode = \"node\"\n"
    );
    let mut gateway_process = gateway(&board, &folder, &setting);
    let mut heard = Vec::new();
    let mut until = |kind: &str| {
        let is = |topic: &str, _: &str| topic.contains(&format!("/{kind}/"));
        loop {
            let message = ear.wait(kind, |_, _| true);
            heard.push(format!("{} {}", message.0, message.1));
            if is(&message.0, &message.1) {
                return;
            }
        }
    };
    let ask = |topic: &str, words: &[&str]| {
        let file = folder.path().join("request");
        let file = file.to_str().expect("UTF-8");
        let output = python(&[&["request", file], words].concat()).wait_with_output();
        assert!(output.is_ok_and(|output| output.status.success()));
        let status = Command::new("mosquitto_pub")
            .args(["-h", "127.0.0.1", "-p", &port.to_string(), "-q", "1", "-t", topic, "-f", file])
            .status();
        assert!(status.expect("it starts").success());
    };
    until("DBIRTH");
    ask("spBv1.0/hall/NCMD/node", &[]);
    until("NBIRTH");
    until("DBIRTH");
    // A host starts the program: its run shows in the data.
    ask("spBv1.0/hall/DCMD/node/drill", &["start"]);
    until("DDATA");
    gateway_process.0.kill().expect("it lives");
    until("NDEATH");
    let mut judge = python(&["judge"]);
    let lines = heard.join("\n");
    std::io::Write::write_all(&mut judge.stdin.take().expect("its input"), lines.as_bytes())
        .expect("it reads");
    let output = judge.wait_with_output().expect("it ends");
    let said = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&said));
}
