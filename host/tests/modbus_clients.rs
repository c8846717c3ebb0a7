//! Modbus masters that are not ours, on the virtual board: mbpoll, pymodbus and tokio-modbus.
//!
//! mbpoll and pymodbus are packages of the system; where one is missing its test says so and
//! passes, and CI installs both.

mod common;

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use common::{Board, has};

/// Every master talks to both chips.
const PARTS: [&str; 2] = ["g2553", "f5529"];

/// Runs mbpoll once and gives what it printed.
fn mbpoll(port: &Path, args: &[&str]) -> String {
    let output = Command::new("mbpoll")
        .args(["-m", "rtu", "-a", "1", "-b", "115200", "-P", "none", "-0", "-1", "-q", "-o", "5"])
        .args(&args[..args.iter().position(|arg| *arg == "--").unwrap_or(args.len())])
        .arg(port)
        .args(args.iter().skip_while(|arg| **arg != "--").skip(1))
        .output()
        .expect("mbpoll starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "mbpoll {args:?}: {text}");
    text
}

#[test]
fn mbpoll_reads_inputs_and_positions_and_sets_an_output() {
    if !has("mbpoll", &["-V"]) {
        return;
    }
    PARTS.iter().for_each(|part| mbpoll_on(&Board::start(&["--part", part])));
}

fn mbpoll_on(board: &Board) {
    let port = board.port();
    // Holding registers: the version of the register map, then machine positions.
    let version = mbpoll(&port, &["-t", "4", "-r", "5000", "-c", "1"]);
    assert!(version.contains("[5000]: \t1"), "{version}");
    let positions = mbpoll(&port, &["-t", "4:int", "-r", "2400", "-c", "3"]);
    assert!(positions.contains("[2400]: \t0"), "{positions}");
    let inputs = mbpoll(&port, &["-t", "1", "-r", "0", "-c", "16"]);
    assert!(inputs.contains("[0]: \t0"), "{inputs}");
    mbpoll(&port, &["-t", "0", "-r", "2", "--", "1"]);
    let coils = mbpoll(&port, &["-t", "0", "-r", "0", "-c", "4"]);
    assert!(coils.contains("[2]: \t1") && coils.contains("[1]: \t0"), "{coils}");
}

/// What ordinary clients of Modbus TCP do, five at a time, each on a register of its own, while a
/// sixth asks for a board that does not exist.
const MODBUS_TCP: &str = r#"
import sys, threading
from pymodbus.client import ModbusTcpClient

port, rounds, failures = int(sys.argv[1]), 40, []

def client():
    client = ModbusTcpClient("127.0.0.1", port=port, timeout=3, retries=0)
    assert client.connect()
    return client

def keep(n):
    mine = client()
    for i in range(rounds):
        value = 1000 * n + i
        written = mine.write_registers(4000 + 2 * n, [value, 0])
        read = mine.read_holding_registers(4000 + 2 * n, count=2)
        if written.isError() or read.isError() or read.registers != [value, 0]:
            failures.append((n, i, str(written), str(read)))
    mine.close()

def nobody():
    mine = client()
    for i in range(3):
        reply = mine.read_holding_registers(5000, count=1, device_id=9)
        if not reply.isError() or reply.exception_code != 11:
            failures.append(("nobody", i, str(reply)))
    mine.close()

threads = [threading.Thread(target=keep, args=(n,)) for n in range(5)]
threads.append(threading.Thread(target=nobody))
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
# The board itself, whatever its address; then a block that does not exist.
mine = client()
for unit in (0, 255):
    assert mine.read_holding_registers(5000, count=1, device_id=unit).registers == [1]
assert mine.read_holding_registers(9999, count=1).exception_code == 2
assert not failures, failures
print("Modbus TCP passed")
"#;

#[test]
fn several_clients_of_modbus_tcp_get_all_their_answers() {
    if !has("python3", &["-c", "import pymodbus"]) {
        return;
    }
    let keeps = "KEEP a, b, c, d, e\na = 1: b = 1: c = 1: d = 1: e = 1\n";
    for part in PARTS {
        let port = free_port();
        let board = Board::start(&["--part", part, "--tcp", &port.to_string()]);
        reachable(port);
        let script = board.folder.path().join("keeps.bas");
        std::fs::write(&script, keeps).expect("a script");
        let script = script.to_str().expect("UTF-8");
        let port_name = format!("tcp:{port}");
        pasapas(&["upload", script, "--port", &port_name]);
        let python = Command::new("python3")
            .args(["-c", MODBUS_TCP, &port.to_string()])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("python starts");
        // Meanwhile the pseudo-terminal and our own client are served too.
        let line = board.port();
        for _ in 0..5 {
            pasapas(&["status", "--port", &port_name]);
            pasapas(&["status", "--port", line.to_str().expect("UTF-8")]);
        }
        let output = python.wait_with_output().expect("python ends");
        let said = [output.stdout, output.stderr].concat();
        assert!(output.status.success(), "{part}: {}", String::from_utf8_lossy(&said));
    }
}

/// What an operator does to AT variables: types, presses Start, reads, changes nothing, starts again.
const OPERATOR: &str = r#"
import sys, time
from pymodbus.client import ModbusSerialClient

board = ModbusSerialClient(sys.argv[1], baudrate=115200, parity="N", timeout=1)
assert board.connect()

def read(register):
    reply = board.read_holding_registers(register, count=2)
    assert not reply.isError(), reply
    return reply.registers[0] | reply.registers[1] << 16

def write(register, value):
    return board.write_registers(register, [value & 0xFFFF, value >> 16])

def run():
    before = board.read_holding_registers(5027, count=1).registers
    assert not board.write_register(5050, 1).isError()
    end = time.time() + 30
    while board.read_holding_registers(5020, count=1).registers != [1] \
            or board.read_holding_registers(5027, count=1).registers == before:
        assert time.time() < end, "the run goes on"
        time.sleep(0.02)

if sys.argv[2] == "zero":
    assert [read(3000), read(3004)] == [0, 0], [read(3000), read(3004)]
    sys.exit()
# After the upload: 0, and the operator's at once; the gap at 3002 is nobody's, 3006 is the program's.
assert [read(3000), read(3004)] == [0, 0]
assert not write(3000, 70000).isError()
assert read(3000) == 70000
assert write(3006, 1).exception_code == 4 and read(3006) == 0
assert write(3999, 1).isError()
run()
# Start kept the quantity, the run its result; what belongs to the program alone began with 0.
assert [read(3000), read(3004)] == [70000, 70001], [read(3000), read(3004)]
assert read(3006) == 0
run()
assert [read(3000), read(3004)] == [70000, 140002], [read(3000), read(3004)]
assert not write(3004, 0).isError()
assert not board.write_register(3000, 5).isError()
run()
assert [read(3000), read(3004)] == [5, 6], [read(3000), read(3004)]
board.close()
"#;

#[test]
fn at_variables_are_the_operators_whether_a_program_runs_or_not() {
    if !has("python3", &["-c", "import pymodbus, serial"]) {
        return;
    }
    let operator = |port: &str, what: &str| {
        let output = Command::new("python3").args(["-c", OPERATOR, port, what]).output();
        let output = output.expect("python ends");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{what}: {said}");
    };
    for part in ["g2553", "f5529"] {
        let board = Board::start(&["--part", part]);
        let port = board.port();
        let port = port.to_str().expect("UTF-8");
        let upload = |name: &str, text: &str| {
            let script = board.folder.path().join(name);
            std::fs::write(&script, text).expect("a script");
            pasapas(&["upload", script.to_str().expect("UTF-8"), "--port", port]);
        };
        let counts = "DIM qty AT 3000, total AT 3004\nDIM own\nKEEP runs\nown = own + 1\n\
                      runs = runs + 1\ntotal = total + qty + own\n";
        upload("counts.bas", counts);
        operator(port, "operate");
        upload("other.bas", &counts.replace("+ own", "+ own * 2"));
        operator(port, "zero");
    }
}

/// The block of a language in the firmware's manual that begins behind the heading of the session.
fn session(language: &str) -> String {
    let manual = include_str!("../../firmware/README.md");
    let (_, text) = manual.split_once("### A session").expect("a session");
    let (_, text) = text.split_once(&format!("```{language}\n")).expect("its block");
    text.split("```").next().unwrap_or_default().to_owned()
}

#[test]
fn the_manuals_session_is_what_happens() {
    if !has("python3", &["-c", "import pymodbus, serial"]) || !has("mbpoll", &["-V"]) {
        return;
    }
    for part in PARTS {
        let board = Board::start(&["--part", part]);
        let port = board.port();
        let port = port.to_str().expect("UTF-8");
        let script = board.folder.path().join("batch.bas");
        std::fs::write(&script, session("basic")).expect("a script");
        pasapas(&["upload", script.to_str().expect("UTF-8"), "--port", port]);
        let python = session("python").replace("/dev/ttyACM0", port);
        let output = Command::new("python3").args(["-c", &python]).output().expect("python");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{part}: {said}");
        let lines = session("sh").replace("/dev/ttyACM0", port);
        let lines: Vec<&str> = lines.lines().collect();
        for (i, line) in lines.iter().enumerate() {
            // mbpoll polls until it is ended unless it is told to do so once, or writes.
            let line = line.replacen("mbpoll", "mbpoll -q -1", 1);
            let output = Command::new("sh").args(["-c", &line]).output().expect("a shell");
            let said = String::from_utf8_lossy(&output.stdout).into_owned();
            assert!(output.status.success(), "{part}: {line}: {said}");
            if line.contains("-r 5020") {
                assert!(said.contains("[5020]: \t2"), "it does not run: {said}");
                std::thread::sleep(Duration::from_secs(2));
            }
            if i + 1 == lines.len() {
                assert!(said.contains("[5026]: \t1"), "{part}: {said}");
            }
        }
    }
}

#[test]
fn every_command_of_the_manual_is_taken_and_axes_that_are_none_are_not() {
    use lang::wire::{COMMAND, Exception, RUN_STATE, RunState, STATUS_BITS, command};
    use pasapas::client::Client;
    use pasapas::link;

    for part in PARTS {
        let board = Board::start(&["--part", part, "--speed", "4"]);
        let port = board.port();
        let port = port.to_str().expect("UTF-8");
        let script = board.folder.path().join("none.bas");
        std::fs::write(&script, "Wait 1s\n").expect("a script");
        pasapas(&["upload", script.to_str().expect("UTF-8"), "--port", port]);
        let mut client = Client::new(link::open(port).expect("the port"), 1);
        client.find().expect("the board");
        for command in command::ALL {
            let number = command.number;
            let example = command.example();
            client
                .write_all(COMMAND, &example)
                .unwrap_or_else(|error| panic!("{part}: {number}: {error}"));
            let rest = |client: &mut Client<_>| {
                let bits = client.inputs(STATUS_BITS, 120).expect("status");
                // Moving, homing, probing.
                !(bits[..3].contains(&true)
                    || bits[16..19].contains(&true)
                    || bits[104..107].contains(&true))
            };
            let begun = std::time::Instant::now();
            while !rest(&mut client) {
                assert!(begun.elapsed() < Duration::from_secs(20), "{part}: {number} goes on");
                if number == command::MOVE_SPEED {
                    client.write_all(COMMAND, &[command::STOP_AXIS, 1]).expect("a stop");
                }
            }
            let state = client.holding(RUN_STATE, 1).expect("the state")[0];
            assert_eq!(RunState::from_number(state), Some(RunState::Ready), "{part}: {number}");
            if command.arguments[0].name().starts_with("axis") {
                for axis in [0, 4] {
                    let mut wrong = example.clone();
                    wrong[1] = axis;
                    let error = client.write_all(COMMAND, &wrong).expect_err("no such axis");
                    assert!(
                        error.is_exception(Exception::IllegalValue),
                        "{part}: {number} {axis}: {error}"
                    );
                }
            }
        }
    }
}

/// Runs our own command, which must succeed.
fn pasapas(args: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_pasapas")).args(args).output();
    let output = output.expect("pasapas starts");
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn mbpoll_speaks_modbus_tcp() {
    if !has("mbpoll", &["-V"]) {
        return;
    }
    for part in PARTS {
        let port = free_port();
        let _board = Board::start(&["--part", part, "--tcp", &port.to_string()]);
        reachable(port);
        let poll = |args: &[&str], value: &[&str]| {
            let output = Command::new("mbpoll")
                .args(["-m", "tcp", "-p", &port.to_string(), "-0", "-1", "-q", "-o", "5"])
                .args(args)
                .arg("127.0.0.1")
                .args(value)
                .output()
                .expect("mbpoll starts");
            let text = String::from_utf8_lossy(&output.stdout).into_owned();
            assert!(output.status.success(), "{part}: mbpoll {args:?}: {text}");
            text
        };
        let version = poll(&["-t", "4", "-r", "5000", "-c", "1"], &[]);
        assert!(version.contains("[5000]: \t1"), "{version}");
        poll(&["-t", "0", "-r", "2"], &["1"]);
        let coils = poll(&["-t", "0", "-r", "0", "-c", "4"], &[]);
        assert!(coils.contains("[2]: \t1") && coils.contains("[1]: \t0"), "{coils}");
    }
}

/// What pymodbus does to the board: command 103 moves, the status bits follow, 106 homes, 107
/// probes, outputs are set, and what does not exist is an exception.
const PYMODBUS: &str = r#"
import sys, time
from pymodbus.client import ModbusSerialClient

client = ModbusSerialClient(sys.argv[1], baudrate=115200, parity="N", timeout=1)
assert client.connect()

def low_high(value):
    value &= 0xFFFFFFFF
    return [value & 0xFFFF, value >> 16]

def long(words):
    value = words[0] | words[1] << 16
    return value - (1 << 32) if value >> 31 else value

def good(reply):
    assert not reply.isError(), reply
    return reply

def position(axis):
    return long(good(client.read_holding_registers(2400 + 2 * axis, count=2)).registers)

def bit(address):
    return good(client.read_discrete_inputs(address, count=1)).bits[0]

def rest(address):
    end = time.time() + 30
    while bit(address):
        assert time.time() < end, f"status bit {address} stays on"
        time.sleep(0.02)

# Command 103: X to 1200 steps.
good(client.write_registers(2000, [103, 1] + low_high(25000) + low_high(4000) + low_high(25000) + low_high(1200)))
moving = any(bit(256) for _ in range(3))
rest(256)
assert moving, "the bit `moving` never came on"
assert position(0) == 1200, position(0)

# Outputs: coil and register.
good(client.write_coil(1, True))
assert good(client.read_coils(0, count=8)).bits[:3] == [False, True, False]
good(client.write_coil(1, False))

# Command 106: X against its switch (input 9, bit 8), 20 mm away to the negative side.
good(client.write_registers(2000, [106, 1, 0, 8, 1, 0] + low_high(2000) + low_high(400)
    + low_high(25000) + low_high(25000) + low_high(30000) + [50] + low_high(0) + low_high(0)))
time.sleep(0.1)
rest(272)
assert not bit(280), "homing error"
assert position(0) == 0, position(0)

# Command 107: Z down by at most 3000 until the probe input (17, bit 16) is on, which it is from
# -1840 on; it is caught at that step, Z comes to rest behind it.
good(client.write_registers(2000, [107, 3, 16, 1] + low_high(25000) + low_high(1000) + low_high(25000) + low_high(-3000)))
rest(362)
rest(258)
assert not bit(370), "probe error"
caught = long(good(client.read_input_registers(1354, count=2)).registers)
assert caught == -1840, caught
assert -1900 < position(2) <= -1840, position(2)
# Again from there: the input is on already.
good(client.write_registers(2000, [107, 3, 16, 1] + low_high(25000) + low_high(1000) + low_high(25000) + low_high(-3000)))
rest(362)
assert bit(370), "no probe error"

# A register block that does not exist is an exception, not silence.
assert client.read_holding_registers(9999, count=1).isError()
client.close()
print("pymodbus passed")
"#;

#[test]
fn pymodbus_moves_homes_and_follows_the_status_bits() {
    if !has("python3", &["-c", "import pymodbus, serial"]) {
        return;
    }
    let world = tempfile::NamedTempFile::with_suffix(".rhai").expect("a file");
    std::fs::write(world.path(), "probe_at(\"Z\", -1840);\n").expect("a world");
    let world = world.path().to_str().expect("UTF-8");
    for part in PARTS {
        let board = Board::start(&["--part", part, "--world", world]);
        let output = Command::new("python3")
            .args(["-c", PYMODBUS])
            .arg(board.port())
            .output()
            .expect("python starts");
        let said = [output.stdout, output.stderr].concat();
        assert!(output.status.success(), "{part}: {}", String::from_utf8_lossy(&said));
    }
}

#[test]
fn tokio_modbus_reads_writes_and_gets_exceptions() {
    PARTS.iter().for_each(|part| tokio_modbus_on(part));
}

/// RTU frames over TCP.
fn tokio_modbus_on(part: &str) {
    use tokio_modbus::client::{Reader, Writer};
    use tokio_modbus::{ExceptionCode, Slave};

    let port = free_port();
    let _board = Board::start(&["--part", part, "--rtu", "--tcp", &port.to_string()]);
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    runtime.expect("a runtime").block_on(async {
        reachable(port);
        let stream = tokio::net::TcpStream::connect(("127.0.0.1", port)).await;
        let stream = stream.expect("a connection");
        let mut client = tokio_modbus::client::rtu::attach_slave(stream, Slave(1));
        let limit = Duration::from_secs(20);
        let work = async {
            let version = client.read_holding_registers(5000, 1).await;
            assert_eq!(version.expect("sent").expect("no exception"), [1]);
            client.write_single_coil(4, true).await.expect("sent").expect("no exception");
            let coils = client.read_coils(0, 8).await.expect("sent").expect("no exception");
            assert!(coils[4] && !coils[3]);
            let missing = client.read_holding_registers(9999, 1).await.expect("sent");
            assert_eq!(missing, Err(ExceptionCode::IllegalDataAddress));
        };
        tokio::time::timeout(limit, work).await.expect("in time");
    });
}

/// Waits until somebody listens: the pseudo-terminal is there a moment before the TCP port.
fn reachable(port: u16) {
    for _ in 0..100 {
        if std::net::TcpStream::connect(("127.0.0.1", port)).is_ok() {
            return;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    panic!("nobody listens on port {port}");
}

/// A port that was free a moment ago.
fn free_port() -> u16 {
    let listener = std::net::TcpListener::bind(("127.0.0.1", 0)).expect("a port");
    listener.local_addr().expect("its number").port()
}
