//! `pasapas gateway` in front of virtual boards, with Modbus masters that are not ours.
//!
//! mbpoll and pymodbus are packages of the system; where one is missing its test says so and
//! passes, and CI installs both.

#![cfg(unix)]

mod common;

use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::{Board, Gateway, has, pasapas, text};

/// Ten clients on two boards, each with a coil or register of its own; a board that does not exist, a unit
/// that does not exist, rights.
const CLIENTS: &str = r#"
import sys, threading, time
from pymodbus.client import ModbusTcpClient

port, failures = int(sys.argv[1]), []

def client():
    client = ModbusTcpClient("127.0.0.1", port=port, timeout=5, retries=0)
    assert client.connect()
    return client

def keep(n):
    mine, unit = client(), 1 + n % 2
    for i in range(30):
        value = 1000 * n + i
        written = mine.write_registers(4000 + 2 * (n // 2), [value, 0], device_id=unit)
        read = mine.read_holding_registers(4000 + 2 * (n // 2), count=2, device_id=unit)
        if written.isError() or read.isError() or read.registers != [value, 0]:
            failures.append((n, i, str(written), str(read)))
    mine.close()

def dead(n):
    mine = client()
    for i in range(50):
        reply = mine.read_holding_registers(5000, count=1, device_id=9)
        if not reply.isError() or reply.exception_code != 11:
            failures.append(("dead", i, str(reply)))
    mine.close()

threads = [threading.Thread(target=keep, args=(n,)) for n in range(10)]
threads.append(threading.Thread(target=dead, args=(0,)))
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
assert not failures, failures[:5]
mine = client()
assert mine.read_holding_registers(5000, count=1, device_id=77).exception_code == 10
assert mine.write_register(5051, 1, device_id=1).exception_code == 2
assert mine.write_coil(0, True, device_id=1).exception_code == 2
assert mine.read_holding_registers(9999, count=1, device_id=1).exception_code == 2
counts = mine.read_input_registers(100, count=40, device_id=247).registers
assert counts[0] == 1 and counts[2] == 1, counts
# An input that the program waits for would not come: it is stopped over the gateway.
assert not mine.write_register(5050, 1, device_id=2).isError()
end = time.time() + 20
while mine.read_holding_registers(5020, count=1, device_id=102).registers != [2]:
    assert time.time() < end, "it does not run"
assert not mine.write_register(5050, 2, device_id=2).isError()
while mine.read_holding_registers(5020, count=1, device_id=102).registers != [1]:
    assert time.time() < end, "it does not stop"
print("gateway passed")
"#;

#[test]
fn many_clients_of_modbus_tcp_share_two_boards() {
    if !has("python3", &["-c", "import pymodbus"]) {
        return;
    }
    let (one, other) = (Board::start(&[]), Board::start(&["--part", "f5529"]));
    let script = one.folder.path().join("keeps.bas");
    let keeps = "KEEP a, b, c, d, e\na = 1: b = 1: c = 1: d = 1: e = 1\nWait 1000s\n";
    std::fs::write(&script, keeps).expect("a script");
    let (first, second) = (one.port(), other.port());
    for port in [&first, &second] {
        let (code, said) = pasapas(&["upload", text(&script), "--port", text(port)]);
        assert_eq!(code, 0, "{said}");
    }
    let file = one.folder.path().join("gateway.toml");
    let config = format!(
        r#"
[[board]]
name = "drill"
port = {first:?}
[[board]]
name = "saw"
port = {second:?}
unit = 2
fresh_unit = 102
[[board]]
name = "missing"
port = {second:?}
address = 9
[[client]]
from = "127.0.0.1"
write = ["registers 4000..4015", "RUN_CONTROL"]
"#,
        first = text(&first),
        second = text(&second)
    );
    std::fs::write(&file, config).expect("a file");
    let gateway = Gateway::start(&[text(&file)]);
    let output = Command::new("python3")
        .args(["-c", CLIENTS, &gateway.port.to_string()])
        .output()
        .expect("python starts");
    let said = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&said));
}

#[test]
fn one_board_needs_no_file_and_our_own_commands_go_through() {
    let board = Board::start(&[]);
    let port = board.port();
    let gateway = Gateway::start(&["--port", text(&port), "--write", "all"]);
    let over = format!("tcp:{}", gateway.port);
    let script = board.folder.path().join("move.bas");
    std::fs::write(&script, "PRINT \"hello\"\nMoveAxe X, 2mm\n").expect("a script");
    for args in [&["upload", text(&script)][..], &["start"], &["status"]] {
        let (code, said) = pasapas(&[args, &["--port", &over]].concat());
        assert_eq!(code, 0, "{args:?}: {said}");
    }
    // Its run ends before the next one begins.
    let begun = Instant::now();
    while !pasapas(&["status", "--port", &over]).1.contains("ready") {
        assert!(begun.elapsed() < Duration::from_secs(20), "its run does not end");
    }
    let (code, said) = pasapas(&["trace", text(&script), "--port", &over]);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("hello") && said.contains("\"X\":200"), "{said}");
    if !has("mbpoll", &["-V"]) {
        return;
    }
    let poll = |args: &[&str], value: &[&str]| {
        let output = Command::new("mbpoll")
            .args(["-m", "tcp", "-p", &gateway.port.to_string(), "-0", "-1", "-q", "-o", "5"])
            .args(args)
            .arg("127.0.0.1")
            .args(value)
            .output()
            .expect("mbpoll starts");
        (output.status.success(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let (good, said) = poll(&["-t", "4", "-r", "5000", "-c", "1"], &[]);
    assert!(good && said.contains("[5000]: \t1"), "{said}");
    // The gateway's own counters: one board.
    let (good, said) = poll(&["-a", "247", "-t", "3:int", "-r", "0", "-c", "1"], &[]);
    assert!(good && said.contains("[0]: \t1"), "{said}");
    assert!(poll(&["-t", "0", "-r", "2"], &["1"]).0);
    let (good, said) = poll(&["-t", "0", "-r", "0", "-c", "4"], &[]);
    assert!(good && said.contains("[2]: \t1") && said.contains("[1]: \t0"), "{said}");
}

/// Silence, half a header, half a request, all that it takes and nothing read, from a thousand at once.
#[test]
fn a_thousand_connections_are_held_or_turned_away_and_cost_the_others_nothing() {
    use rustix::process::{Resource, getrlimit, setrlimit};

    let mut limit = getrlimit(Resource::Nofile);
    limit.current = limit.maximum;
    setrlimit(Resource::Nofile, limit).expect("as many files as may be");
    let board = Board::start(&[]);
    let port = board.port();
    for most in [1_200, 128] {
        let file = board.folder.path().join("many.toml");
        let config = format!(
            "[modbus]\nclients = {most}\n[[board]]\nname = \"b\"\nport = {port:?}\n\
             [[client]]\nfrom = \"any\"\nfresh = true\n"
        );
        std::fs::write(&file, config).expect("a file");
        // It asks the system for the files that it needs.
        let mut shell = Command::new("sh");
        shell.args(["-c", "ulimit -S -n 100; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_pasapas")]);
        let gateway = Gateway::start_by(&mut shell, &[text(&file)]);
        let address = ("127.0.0.1", gateway.port);
        let mut honest = TcpStream::connect(address).expect("it listens");
        honest.set_read_timeout(Some(Duration::from_secs(20))).expect("a socket");
        let mut ask = |n: u16| {
            let [high, low] = n.to_be_bytes();
            let begun = Instant::now();
            let request = [high, low, 0, 0, 0, 6, 1, 3, 0x13, 0x88, 0, 1];
            honest.write_all(&request).expect("open");
            let mut reply = [0; 11];
            honest.read_exact(&mut reply).expect("an answer");
            assert_eq!(reply[..9], [high, low, 0, 0, 0, 5, 1, 3, 2], "{reply:?}");
            begun.elapsed()
        };
        let quiet: Vec<Duration> = (0..50).map(&mut ask).collect();
        let before = gateway.memory();
        let whole = [0, 1, 0, 0, 0, 6, 9, 3, 0, 0, 0, 1];
        let mut guests = Vec::new();
        let mut times = Vec::new();
        for n in 0..1_000_u16 {
            let mut guest = TcpStream::connect(address).expect("it listens");
            let said = match n % 4 {
                0 => Vec::new(),
                1 => vec![0, 1, 0, 0, 0],
                2 => [&[0, 1, 0, 0, 0, 250, 1, 16][..], &[7; 200]].concat(),
                _ => whole.repeat(2_000),
            };
            // One that is turned away or displaced cannot say all of it.
            guest.set_nonblocking(true).expect("a socket");
            let _ = guest.write(&said);
            guests.push(guest);
            if n % 10 == 0 {
                times.push(ask(n));
            }
        }
        times.extend((0..50).map(ask));
        let grown = gateway.memory().saturating_sub(before);
        times.sort_unstable();
        let (middle, slowest) = (times[times.len() / 2], times[times.len() - 1]);
        let before = quiet.iter().max().expect("some");
        println!("{most}: {grown} KB more; {middle:?}, at most {slowest:?} ({before:?} before)");
        assert!(grown < 8 << 10, "{grown} KB more for a thousand connections");
        assert!(
            middle < Duration::from_millis(100) && slowest < Duration::from_secs(2),
            "{slowest:?}"
        );
    }
}

#[test]
fn without_rights_a_gateway_reads_and_does_not_write() {
    let board = Board::start(&[]);
    let port = board.port();
    let gateway = Gateway::start(&["--port", text(&port)]);
    let over = format!("tcp:{}", gateway.port);
    let (code, said) = pasapas(&["status", "--port", &over]);
    assert_eq!(code, 0, "{said}");
    let (code, said) = pasapas(&["io", "1=on", "--port", &over]);
    assert_ne!(code, 0, "{said}");
}

#[test]
fn what_is_wrong_in_a_file_is_told_with_its_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("g.toml");
    std::fs::write(&file, "[[board]]\nname = \"a b\"\nport = \"x\"\n").expect("a file");
    let (code, said) = pasapas(&["gateway", text(&file)]);
    assert_eq!(code, 1, "{said}");
    assert!(said.contains("g.toml:2:8: error[I006]"), "{said}");
    let (code, said) = pasapas(&["gateway"]);
    assert_eq!(code, 2, "{said}");
    let (code, said) = pasapas(&["gateway", "--port", "x", "--write", "everything"]);
    assert_eq!(code, 2, "{said}");
}

#[test]
fn the_manuals_table_is_that_of_the_counters() {
    use pasapas::gateway::counters::{BOARD_STEP, COUNTERS, FIRST_BOARD, TOTALS};

    let mut table = String::from("\n| register | count | of |\n|---|---|---|\n");
    for (i, (name, meaning)) in TOTALS.iter().enumerate() {
        table += &format!("| {} | {name} | {} |\n", 2 * i, meaning.trim());
    }
    for (i, (name, meaning)) in COUNTERS.iter().enumerate() {
        let first = usize::from(FIRST_BOARD) + 2 * i;
        table += &format!("| {first} + {BOARD_STEP} n | {name} | board n: {} |\n", meaning.trim());
    }
    table += "\n";
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/gateway.md");
    let page = std::fs::read_to_string(path).expect("the page");
    let begin = "<!-- counters: made by the test `gateway` -->\n";
    let end = "<!-- end of counters -->\n";
    let (before, rest) = page.split_once(begin).expect("its begin");
    let (shown, after) = rest.split_once(end).expect("its end");
    if std::env::var_os("UPDATE_README").is_some() {
        std::fs::write(path, [before, begin, &table, end, after].concat()).expect("written");
        return;
    }
    assert_eq!(shown, table, "run UPDATE_README=1 cargo test -p pasapas --test gateway manuals");
}

/// The manual's pieces of a file make one that the gateway takes.
#[test]
fn the_manuals_file_is_a_good_one() {
    let page = include_str!("../gateway.md");
    let pieces = page.split("```toml\n").skip(1);
    let pieces = pieces.map(|piece| piece.split_once("```").expect("its end").0);
    // `[opcua]` is known to builds that have it.
    let has = cfg!(feature = "opcua");
    let file: String = pieces.filter(|piece| has || !piece.contains("[opcua]")).collect();
    let config = pasapas::gateway::Config::parse("gateway.md", &file);
    let config = config.unwrap_or_else(|note| panic!("{}", note.text));
    assert_eq!((config.boards.len(), config.cards.len()), (2, 1));
    assert!(config.mqtt.is_some() && config.sparkplug.is_some() && config.names.is_some());
    assert_eq!(config.opcua.is_some(), has);
}

#[test]
fn the_example_describes_its_boards_for_other_tools() {
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/gateway/hall.toml");
    let (code, table) = pasapas(&["gateway", example, "--describe"]);
    assert_eq!(code, 0, "{table}");
    let columns = table.lines().next().unwrap_or_default().split(',').count();
    assert!(table.lines().filter(|line| line.starts_with("drill,1,")).count() > 80);
    assert!(table.lines().filter(|line| line.starts_with("feeder,2,")).count() > 80);
    assert!(table.contains("drill,1,holding register,4000,int32,"), "a KEEP of the script");
    let (code, json) = pasapas(&["gateway", example, "--describe", "--format", "json"]);
    assert_eq!((code, json.lines().count()), (0, table.lines().count() - 1));
    if !has("python3", &["--version"]) {
        return;
    }
    // An independent reader of CSV.
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/gateway/telegraf.py");
    let mut python = Command::new("python3");
    let python = python.arg(script).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut python = python.spawn().expect("it starts");
    std::io::Write::write_all(&mut python.stdin.take().expect("its input"), table.as_bytes())
        .expect("it reads");
    let said = python.wait_with_output().expect("it ends").stdout;
    let config: toml::Table = toml::from_str(&String::from_utf8_lossy(&said)).expect("TOML");
    let boards = config["inputs"]["modbus"].as_array().expect("boards");
    assert_eq!((boards.len(), columns), (2, 10));
    assert_eq!(boards[1]["slave_id"].as_integer(), Some(2));
}
