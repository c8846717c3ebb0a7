//! Sparkplug B before another's decoder.

use std::io::Write;
use std::process::{Command, Stdio};
use std::time::Duration;

use rustix::process::Signal;
use tempfile::TempDir;

use super::common::{Board, has, pasapas, text};
use super::{Ear, Process, broker, free_port, gateway, mosquitto, python, upload};

/// Another's decoder of Sparkplug's protocol buffer, and the rules that the messages keep: they come as
/// `TOPIC QOS RETAINED HEX` lines. `request FILE` writes a host's request for a birth instead.
const SPARKPLUG: &str = r#"
import sys
from tahutils.tahu.sparkplug_b_pb2 import Payload

if sys.argv[1] == "request":
    payload = Payload()
    payload.timestamp = 1
    metric = payload.metrics.add()
    metric.name, metric.datatype, metric.boolean_value = "Node Control/Rebirth", 11, True
    if len(sys.argv) > 4:
        metric.name, metric.datatype, metric.double_value = sys.argv[3], 10, float(sys.argv[4])
    elif len(sys.argv) > 3:
        metric.name, metric.datatype, metric.string_value = "Control", 12, sys.argv[3]
    open(sys.argv[2], "wb").write(payload.SerializeToString())
    sys.exit()

# What is seen: kinds, numbers of births, values by their names, values told as historical.
kinds, bds, births, values, historical = [], [], 0, {}, []
seq, names, dead, ended = None, {}, set(), True
for line in sys.stdin:
    topic, qos, retained, hexed = line.strip().split(" ")
    parts = topic.split("/")
    if parts[0] != "spBv1.0" or parts[2] in ("NCMD", "DCMD") or parts[1] == "STATE":
        continue
    assert parts[1] == "hall" and parts[3] == "node", topic
    payload = Payload()
    payload.ParseFromString(bytes.fromhex(hexed))
    kind = parts[2]
    kinds.append(kind)
    assert payload.HasField("timestamp")
    # Deaths of the node alone are QoS 1 (tck-id-payloads-ndeath-will-message-qos and its like).
    assert (qos, retained) == ("1" if kind == "NDEATH" else "0", "0"), (topic, qos, retained)
    metrics = {metric.name: metric for metric in payload.metrics}
    if kind == "NDEATH":
        # Its own connection's number, told without a birth too.
        number = metrics["bdSeq"].long_value
        assert not payload.HasField("seq") and (ended or number == bds[-1]), (payload, bds)
        ended = True
        continue
    if kind == "NBIRTH":
        assert payload.seq == 0, payload
        number = metrics["bdSeq"].long_value
        assert (number > bds[-1] if bds else True) if ended else number == bds[-1], (number, bds)
        bds.append(number)
        births += 1
        assert metrics["bdSeq"].datatype == 4
        assert metrics["Node Control/Rebirth"].boolean_value is False
        names, dead, ended = {}, set(), False
    else:
        assert not ended and payload.seq == (seq + 1) % 256, (topic, payload.seq, seq)
        if kind == "DBIRTH":
            dead.discard(parts[4])
            names[parts[4]] = set(metrics)
            assert all(metric.datatype for metric in payload.metrics)
            assert {"State", "Runs", "Control", "Outputs/16", "Inputs/17"} <= set(metrics)
            depth = metrics.get("Variables/depth")
            if depth is not None:
                assert depth.datatype == 10 and list(depth.properties.keys) == ["engUnit"]
                assert depth.properties.values[0].string_value == "mm", depth
        elif kind == "DDEATH":
            assert parts[4] in names and not payload.metrics
            dead.add(parts[4])
        elif kind == "DDATA":
            assert set(metrics) <= names[parts[4]] and parts[4] not in dead, metrics
        for name, metric in metrics.items():
            value = getattr(metric, metric.WhichOneof("value")) if metric.WhichOneof("value") else None
            if metric.is_historical:
                historical.append((name, value))
            else:
                values[name] = value
    seq = payload.seq
"#;

/// A node with a board, a host of the test's own, and all that is heard.
struct Stand {
    folder: TempDir,
    board: Board,
    port: u16,
    ear: Ear,
    heard: Vec<String>,
    _broker: Process,
}

impl Stand {
    fn new() -> Option<Stand> {
        let program = mosquitto()?;
        if !has("python3", &["-c", "import tahutils.tahu.sparkplug_b_pb2"]) {
            return None;
        }
        let folder = tempfile::tempdir().expect("a folder");
        let board = Board::start(&[]);
        let script = "DIM depth AS LENGTH AT 3000\nKEEP made\nmade = made + 1\nMoveAxe X, 1mm\n";
        upload(&board, script);
        let port = free_port();
        let broker = broker(&program, folder.path(), port, "");
        let ear = Ear::new(port, "spBv1.0/#", &["-F", "%t %q %r %x"]);
        Some(Stand { folder, board, port, ear, heard: Vec::new(), _broker: broker })
    }

    fn gateway(&self, more: &str) -> Process {
        let setting = format!(
            "broker = \"127.0.0.1:{}\"\nwrite = [\"RUN_CONTROL\", \"registers 3000..3001\"]\n\
             [sparkplug]\ngroup = \"hall\"\nnode = \"node\"\n{more}\n",
            self.port
        );
        gateway(&self.board, &self.folder, &setting)
    }

    /// Hears up to a message of that kind.
    fn until(&mut self, kind: &str) {
        loop {
            let (topic, rest) = self.ear.wait(kind, |_, _| true);
            self.heard.push(format!("{topic} {rest}"));
            if topic.contains(&format!("/{kind}/")) {
                return;
            }
        }
    }

    fn publish(&self, topic: &str, args: &[&str]) {
        let status = Command::new("mosquitto_pub")
            .args(["-h", "127.0.0.1", "-p", &self.port.to_string(), "-q", "1", "-t", topic])
            .args(args)
            .status();
        assert!(status.expect("it starts").success());
    }

    /// Asks the node for a birth, or its device for what the words say.
    fn ask(&self, topic: &str, words: &[&str]) {
        let file = self.folder.path().join("request");
        python(SPARKPLUG, &[&["request", text(&file)], words].concat());
        self.publish(topic, &["-f", text(&file)]);
    }

    /// Another's decoder reads all that was heard; `then` is what must be so besides.
    fn judge(&self, then: &str) {
        let program = format!("{SPARKPLUG}\n{then}\n");
        let mut judge = Command::new("python3")
            .args(["-c", &program, "judge"])
            .stdin(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("python");
        let lines = self.heard.join("\n");
        judge.stdin.take().expect("its input").write_all(lines.as_bytes()).expect("it reads");
        let output = judge.wait_with_output().expect("it ends");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn sparkplug_is_read_by_anothers_decoder_and_keeps_its_rules() {
    let Some(mut stand) = Stand::new() else { return };
    let mut gateway_process = stand.gateway("");
    stand.until("DBIRTH");
    stand.ask("spBv1.0/hall/NCMD/node", &[]);
    stand.until("NBIRTH");
    stand.until("DBIRTH");
    // A host starts the program: its run shows in the data. And sets a variable by its name.
    stand.ask("spBv1.0/hall/DCMD/node/drill", &["start"]);
    stand.until("DDATA");
    std::thread::sleep(Duration::from_secs(1));
    stand.ask("spBv1.0/hall/DCMD/node/drill", &["Variables/depth", "2.5"]);
    std::thread::sleep(Duration::from_secs(1));
    gateway_process.0.kill().expect("it lives");
    stand.until("NDEATH");
    stand.judge(
        "assert births == 2 and bds[0] == bds[1], bds\n\
         assert kinds[:2] == ['NBIRTH', 'DBIRTH'] and kinds[-1] == 'NDEATH', kinds\n\
         assert values['Variables/depth'] == 2.5 and values['Variables/made'] == 1, values\n\
         assert values['Runs'] == 1 and values['Position/X'] == 100, values",
    );
}

#[test]
fn a_board_that_dies_has_its_death_and_births_wait_for_the_primary_host() {
    let Some(mut stand) = Stand::new() else { return };
    let _gateway = stand.gateway("primary_host = \"scada\"");
    let state = |online: bool, time: u32| format!("{{\"online\":{online},\"timestamp\":{time}}}");
    let topic = "spBv1.0/STATE/scada";
    std::thread::sleep(Duration::from_secs(1));
    assert!(stand.ear.heard.try_recv().is_err(), "nobody hears it yet");
    stand.publish(topic, &["-r", "-m", &state(true, 10)]);
    stand.until("DBIRTH");
    // The host goes: the node says its death, and what happens meanwhile is kept.
    stand.publish(topic, &["-r", "-m", &state(false, 20)]);
    stand.until("NDEATH");
    let port = stand.board.port();
    let (code, said) = pasapas(&["start", "--port", text(&port)]);
    assert_eq!(code, 0, "{said}");
    std::thread::sleep(Duration::from_secs(2));
    stand.publish(topic, &["-r", "-m", &state(true, 30)]);
    stand.until("DBIRTH");
    stand.until("DDATA");
    // The board dies, and another one comes in its place.
    let folder = stand.board.folder.path().to_owned();
    stand.board.end(Signal::TERM);
    stand.until("DDEATH");
    let link = folder.join("board");
    let again = Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .args(["board", "--pty", text(&link)])
        .stdout(Stdio::null())
        .spawn();
    let _again = Process(again.expect("it starts"));
    // An empty one, which gets the program then.
    stand.until("DBIRTH");
    let script = folder.join("job.bas");
    let (code, said) = pasapas(&["upload", text(&script), "--port", text(&link)]);
    assert_eq!(code, 0, "{said}");
    stand.until("DBIRTH");
    stand.judge(
        "assert births == 2 and bds[1] > bds[0], bds\n\
         assert 'NDEATH' in kinds and 'DDEATH' in kinds and kinds[-1] == 'DBIRTH', kinds\n\
         assert 'Variables/made' in names['drill'] and values['Runs'] == 0, names\n\
         assert ('Runs', 1) in historical and ('Variables/made', 1) in historical, historical",
    );
}
