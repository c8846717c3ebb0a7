//! Sparkplug B before another's decoder.

use std::process::{Command, Stdio};
use std::time::Duration;

use super::common::Board;
use super::{Ear, broker, free_port, gateway, mosquitto, upload};

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
    if len(sys.argv) > 4:
        metric.name, metric.datatype, metric.double_value = sys.argv[3], 10, float(sys.argv[4])
    elif len(sys.argv) > 3:
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
            assert {"State", "Runs", "Control", "Outputs/16", "Inputs/17", "Variables/made"} <= set(metrics)
            depth = metrics["Variables/depth"]
            assert depth.datatype == 10 and list(depth.properties.keys) == ["engUnit"]
            assert depth.properties.values[0].string_value == "mm", depth
        elif kind == "DDATA":
            assert set(metrics) <= names[parts[4]], metrics
            depth = metrics.get("Variables/depth", depth)
    seq = payload.seq
assert births == 2, kinds
assert kinds[:2] == ["NBIRTH", "DBIRTH"] and kinds[-1] == "NDEATH" and "DDATA" in kinds, kinds
assert depth.double_value == 2.5, depth
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
    upload(&board, "DIM depth AS LENGTH AT 3000\nKEEP made\nmade = made + 1\nMoveAxe X, 1mm\n");
    let port = free_port();
    let _broker = broker(&program, folder.path(), port, "");
    let ear = Ear::new(port, "spBv1.0/#", &["-F", "%t %x"]);
    let setting = format!(
        "broker = \"127.0.0.1:{port}\"\nwrite = [\"RUN_CONTROL\", \"registers 3000..3001\"]\n\
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
    // And sets a variable by its name.
    ask("spBv1.0/hall/DCMD/node/drill", &["Variables/depth", "2.5"]);
    std::thread::sleep(Duration::from_secs(1));
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
