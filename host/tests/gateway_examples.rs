//! What stands in `examples/gateway`, run as a user would.

#![cfg(unix)]

mod common;

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use common::{Board, Gateway, end_of, has, pasapas, signal, text};
use rustix::process::Signal;

/// Longer than anything here takes, on a loaded machine too.
const PATIENCE: Duration = Duration::from_secs(60);
/// Ports that `up.sh` takes: broker, gateway, boards.
const PORTS: [u16; 4] = [1883, 1502, 1601, 1602];

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/gateway").join(name)
}

fn is_taken(port: u16) -> bool {
    TcpStream::connect(("127.0.0.1", port)).is_ok()
}

#[test]
fn up_brings_everything_up_and_leaves_nothing_behind() {
    let there = "PATH=$PATH:/usr/sbin; command -v mosquitto && command -v mosquitto_sub";
    if !has("sh", &["-c", there]) || PORTS.into_iter().any(is_taken) {
        eprintln!("no mosquitto, or one of {PORTS:?} is taken: it is left out");
        return;
    }
    let mut script = Command::new("sh")
        .arg(example("up.sh"))
        .env("PASAPAS", env!("CARGO_BIN_EXE_pasapas"))
        .stdout(Stdio::piped())
        .spawn()
        .expect("a shell");
    let lines = BufReader::new(script.stdout.take().expect("its output")).lines();
    let (to, told) = mpsc::channel();
    std::thread::spawn(move || lines.map_while(Result::ok).try_for_each(|line| to.send(line)));
    let mut said = Vec::new();
    while let Ok(line) = told.recv_timeout(PATIENCE) {
        let ready = line.starts_with("pasapas/hall/drill/state") && line.contains("\"parts\":0");
        said.push(line);
        if ready {
            break;
        }
    }
    let all_up = PORTS.into_iter().all(is_taken);
    // The shell alone is told to end, as by `kill`; it may have ended by itself.
    if script.try_wait().expect("a child").is_none() {
        signal(&script, Signal::TERM);
    }
    assert!(said.last().is_some_and(|line| line.contains("\"health\":\"up\"")), "{said:#?}");
    assert!(all_up, "{said:#?}");
    assert!(end_of(&mut script, PATIENCE).is_some(), "it does not end");
    let begun = Instant::now();
    while PORTS.into_iter().any(is_taken) {
        assert!(begun.elapsed() < PATIENCE, "something is left behind");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Checks a configuration by the rules of Telegraf's `inputs.modbus` (names, byte orders, data types, scales),
/// and reads it as that does: neighbours in one request.
const TELEGRAF: &str = r#"
import struct, sys, tomllib
from pymodbus.client import ModbusTcpClient

config = tomllib.load(sys.stdin.buffer)
client = ModbusTcpClient("127.0.0.1", port=int(sys.argv[1]))
assert client.connect()
reads = {
    "coils": client.read_coils, "discrete_inputs": client.read_discrete_inputs,
    "holding_registers": client.read_holding_registers, "input_registers": client.read_input_registers,
}
values = {}
for board in config["inputs"]["modbus"]:
    for table, read in reads.items():
        fields = board[table]
        names = [field["name"] for field in fields]
        assert all(names) and len(set(names)) == len(names), names
        held, groups = {}, []
        for field in sorted(fields, key=lambda field: field["address"]):
            first, count = field["address"][0], len(field["address"])
            assert field["address"] == list(range(first, first + count)) and count in (1, 2)
            if groups and first <= sum(groups[-1]) and first + count - groups[-1][0] <= 125:
                groups[-1][1] = max(groups[-1][1], first + count - groups[-1][0])
            else:
                groups.append([first, count])
        for first, count in groups:
            reply = read(first, count=count, device_id=board["slave_id"])
            assert not reply.isError(), (table, first, count, reply)
            held |= dict(enumerate(reply.bits if "register" not in table else reply.registers, first))
        for field in fields:
            words = [held[at] for at in field["address"]]
            if "register" not in table:
                values[table, field["name"]] = words[0]
                continue
            assert field["scale"] != 0 and len(field["byte_order"]) == 2 * len(words), field
            if field["byte_order"] == "AB":
                assert field["data_type"] == "UINT16", field
                value = words[0]
            else:
                assert field["byte_order"] == "CDAB" and field["data_type"] in ("INT32", "FIXED"), field
                value = struct.unpack(">i", struct.pack(">HH", words[1], words[0]))[0]
            value *= field["scale"]
            values[table, field["name"]] = int(value) if field["data_type"] == "INT32" else value
assert values["holding_registers", "depth"] == 1.5, values
assert values["holding_registers", "made"] == 1
assert values["coils", "OUTPUT_2"] == 1 and values["coils", "OUTPUT_1"] == 0
position = [value for (_, name), value in values.items() if name == "MACHINE_POSITIONS_X"]
assert position == [1.0], values
print("telegraf passed", len(values))
"#;

#[test]
fn what_telegraf_is_given_can_be_read_as_telegraf_reads() {
    if !has("python3", &["-c", "import pymodbus, tomllib"]) {
        return;
    }
    for part in ["g2553", "f5529"] {
        let board = Board::start(&["--part", part]);
        let port = board.port();
        let gateway = Gateway::start(&["--port", text(&port), "--write", "all"]);
        let over = format!("tcp:{}", gateway.port);
        let script = board.folder.path().join("made.bas");
        let program = "DIM depth AS LENGTH AT 3000\nKEEP made\nmade = made + 1\ndepth = 1.5mm\n\
                       MoveAxe X, 1mm\n";
        std::fs::write(&script, program).expect("a script");
        for command in ["upload", "trace"] {
            let (code, said) = pasapas(&[command, text(&script), "--port", &over]);
            assert_eq!(code, 0, "{said}");
        }
        let (code, said) = pasapas(&["io", "2=on", "--port", &over]);
        assert_eq!(code, 0, "{said}");
        let (code, table) = pasapas(&["gateway", "--describe", "--port", &over]);
        assert_eq!(code, 0, "{table}");
        let through = |program: &mut Command, input: &str| {
            let mut child = program
                .stdin(Stdio::piped())
                .stdout(Stdio::piped())
                .stderr(Stdio::piped())
                .spawn()
                .expect("python");
            let mut to = child.stdin.take().expect("its input");
            to.write_all(input.as_bytes()).expect("it reads");
            drop(to);
            let output = child.wait_with_output().expect("it ends");
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.success(), "{part}: {said}");
            String::from_utf8_lossy(&output.stdout).into_owned()
        };
        let config = through(Command::new("python3").arg(example("telegraf.py")), &table);
        let reader = ["-c", TELEGRAF, &gateway.port.to_string()];
        let said = through(Command::new("python3").args(reader), &config);
        assert!(said.contains("telegraf passed"), "{said}");
    }
}
