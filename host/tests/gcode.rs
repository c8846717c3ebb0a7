//! InterpCNC's command 1000 over the gateway: pymodbus sends G-code as text, the real firmware runs it.

mod common;

use std::process::Command;

use common::{Board, Gateway, has, text};

/// Runs a script of pymodbus against a board of a part behind a gateway that takes G-code for it.
fn run(part: &str, script: &str) {
    if !has("python3", &["-c", "import pymodbus"]) {
        return;
    }
    let board = Board::start(&["--part", part]);
    let file = board.folder.path().join("gcode.toml");
    let content = format!(
        "[[board]]\nname = \"mill\"\nport = {:?}\n[[gcode]]\nboard = \"mill\"\n\
         [[client]]\nfrom = \"127.0.0.1\"\nwrite = [\"all\"]\nfresh = true\n",
        text(&board.port())
    );
    std::fs::write(&file, content).expect("a file");
    let gateway = Gateway::start(&[text(&file)]);
    let script = format!("{COMMON}{script}");
    let output = Command::new("python3").args(["-c", &script, &gateway.port.to_string()]).output();
    let output = output.expect("python starts");
    let said = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&said));
}

/// As a client of InterpCNC does it: room first, then the line, two characters a register.
const COMMON: &str = r#"
import sys, time
from pymodbus.client import ModbusTcpClient

client = ModbusTcpClient("127.0.0.1", port=int(sys.argv[1]), timeout=5, retries=0)
assert client.connect()
end = time.time() + 20
while client.read_holding_registers(5000, count=1, device_id=1).isError():
    assert time.time() < end, "the board does not answer"

def send(line):
    text = line.encode() + b"\0" * (len(line) % 2)
    words = [1000, len(line)] + [text[i] | text[i + 1] << 8 for i in range(0, len(text), 2)]
    reply = client.write_registers(2000, words, device_id=1)
    return reply.exception_code if reply.isError() else 0

def free():
    return client.read_input_registers(3001, count=1, device_id=1).registers[0]

def feed(line):
    end = time.time() + 60
    while free() < 2 + len(line) // 2:
        assert time.time() < end, "no room"
    assert send(line) == 0, line

def position():
    words = client.read_holding_registers(5030, count=6, device_id=1).registers
    values = [words[i] | words[i + 1] << 16 for i in (0, 2, 4)]
    return [value - (1 << 32) if value >> 31 else value for value in values]

def register(n):
    return client.read_holding_registers(n, count=1, device_id=1).registers[0]

def rest(runs):
    end = time.time() + 120
    while register(5027) < runs or register(5020) == 2:
        assert time.time() < end, "it does not end"
        time.sleep(0.05)
"#;

#[test]
fn lines_are_one_run_however_they_come() {
    let script = r#"
assert free() == 4096
for line in ("G21 G90 G64", "M3 S1000", "G1 X1 F300"):
    feed(line)
# 400 short lines and an arc; the motion word holds, and so do distances. A line lasts 20 ms, so that the axes do not
# wait for this client.
feed("G91")
for n in range(400):
    feed("X0.1 Y%s" % (0.1 if n % 2 else 0.05))
feed("G90 G2 X41 Y40 I0 J5")
time.sleep(0.3)
assert register(5020) == 2 and client.read_coils(0, count=1, device_id=1).bits[0], "the spindle"
feed("M5")
rest(1)
assert position() == [4100, 4000, 0], position()
assert register(5027) == 1 and free() == 4096
assert register(5045) <= 2, register(5045)
# Another program; its end is its end.
for line in ("G0 X2", "Y2", "M30"):
    feed(line)
rest(2)
assert position() == [200, 200, 0], position()
for line in ("G81 X1 Y1 Z-1 R1 F100", "hello", "G1 X", "G1 A5 F100"):
    assert send(line) == 3, line
assert client.write_registers(2000, [1000, 40, 0x3047], device_id=1).exception_code == 3
"#;
    run("f5529", script);
}

#[test]
fn a_stop_forgets_what_waits_until_it_is_acknowledged() {
    let script = r#"
for n in range(100):
    feed("G1 X%d F600" % (50 + n % 2))
time.sleep(1)
assert not client.write_registers(2000, [101, 7], device_id=1).isError()
end = time.time() + 20
while register(5020) in (2, 6):
    assert time.time() < end
x = position()[0]
assert 0 < x < 5000, x
# A client that has not noticed goes on sending.
for n in range(5):
    assert send("G1 X80 F600") == 4
    time.sleep(0.1)
assert position()[0] == x and free() == 4096
assert not client.write_registers(2000, [1200, 88], device_id=1).isError()
feed("G1 X80 F3000")
rest(2)
assert position()[0] == 8000
# An emergency stop, and the soft end of a travel once the axis has its place.
feed("G1 X10 F600")
time.sleep(0.5)
assert not client.write_register(5050, 5, device_id=1).isError()
end = time.time() + 20
while send("G1 X80 F600") == 0:
    assert time.time() < end
x = position()[0]
time.sleep(0.5)
assert position()[0] == x and x > 1000, x
"#;
    run("f5529", script);
}

#[test]
fn a_board_that_cannot_be_fed_takes_none() {
    let script = r#"
send("G0 X5")
end = time.time() + 20
while send("G0 X5") != 4:
    assert time.time() < end
assert position() == [0, 0, 0]
"#;
    run("g2553", script);
}
