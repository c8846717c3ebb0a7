//! A client at a serial port.

use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use rustix::process::Signal;

use super::common::{has, signal, text};
use super::{PATIENCE, Stand};

/// A cable between two serial ports, until it is dropped.
struct Cable(Child);

impl Cable {
    fn new(one: &Path, other: &Path) -> Cable {
        let end = |path: &Path| format!("pty,raw,echo=0,link={}", text(path));
        let child = Command::new("socat").args([end(one), end(other)]).spawn();
        let begun = Instant::now();
        while !(one.exists() && other.exists()) {
            assert!(begun.elapsed() < PATIENCE, "no cable");
            std::thread::sleep(Duration::from_millis(20));
        }
        Cable(child.expect("socat starts"))
    }
}

impl Drop for Cable {
    fn drop(&mut self) {
        signal(&self.0, Signal::TERM);
        let _ = self.0.wait();
    }
}

/// At a serial port, with pyserial at the other end of the cable; the cable is pulled and put back.
#[test]
fn a_client_at_a_serial_port_is_answered_before_and_behind_a_pulled_cable() {
    if !has("socat", &["-V"]) || !has("python3", &["-c", "import serial"]) {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let (card, client) = (folder.path().join("card"), folder.path().join("client"));
    let cable = Cable::new(&card, &client);
    let more = format!("port = {:?}\nrate = 19200", text(&card));
    let stand = Stand::start("g2553", &more);
    let run = |x: u32| {
        let (x, client) = (x.to_string(), text(&client));
        let output = Command::new("python3").args(["-c", SERIAL, client, &x]).output();
        let output = output.expect("python starts");
        let said = [output.stdout, output.stderr].concat();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&said));
    };
    run(300);
    assert_eq!(stand.at("X"), 300);
    drop(cable);
    std::thread::sleep(Duration::from_millis(500));
    let _cable = Cable::new(&card, &client);
    std::thread::sleep(Duration::from_secs(2));
    run(500);
    assert_eq!(stand.at("X"), 500);
}

/// Sends lines, waits for each one's character; a stop in the middle of a move.
const SERIAL: &str = r#"
import sys, time
import serial

port = serial.Serial(sys.argv[1], 19200, timeout=60)
def say(line, answer):
    port.write(line.encode() + b"\r")
    got = port.read(len(answer))
    assert got == answer, (line, got)
say("@07", b"0")
say("@0R7", b"0")
port.write(b"@0A 20000,900,0,21,0,21,0,21\r")
time.sleep(0.5)
port.write(b"\xff")
assert port.read(1) == b"0"
say("@0M %s,900,0,21,0,21,0,21" % sys.argv[2], b"0")
say("@0P", b"0" + b"%06X" % int(sys.argv[2]) + b"0" * 12)
"#;
