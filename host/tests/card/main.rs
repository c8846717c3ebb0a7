//! The gateway as an interface card: the binder's sequences, those of programs of others, and clients
//! that stop, leave or send rubbish, before boards of the real firmware.

#![cfg(unix)]

#[path = "../common/mod.rs"]
mod common;
mod others;
mod serial;

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use common::{Board, Gateway, pasapas, text};

/// Longer than any move of these tests takes, on a loaded machine too.
const PATIENCE: Duration = Duration::from_secs(60);

/// A board of the charlyrobot machine behind a gateway whose card answers by TCP.
struct Stand {
    board: Board,
    gateway: Gateway,
    card: u16,
}

impl Stand {
    /// A host's emergency stop: 5 into the register of the run's control, by Modbus TCP through the gateway.
    fn emergency_stop(&self) {
        let [high, low] = lang::wire::RUN_CONTROL.to_be_bytes();
        let stop = lang::wire::Control::EmergencyStop as u8;
        let mut host = TcpStream::connect(("127.0.0.1", self.gateway.port)).expect("the gateway");
        let request = [0, 1, 0, 0, 0, 6, 1, 6, high, low, 0, stop];
        host.set_read_timeout(Some(PATIENCE)).expect("a socket");
        host.write_all(&request).expect("it listens");
        // An exception is shorter than what it answers, so the length is read first.
        let mut reply = vec![0; 6];
        host.read_exact(&mut reply).expect("an answer");
        reply.resize(6 + usize::from(reply[5]), 0);
        host.read_exact(&mut reply[6..]).expect("the rest of it");
        assert_eq!(reply, request, "the board has taken it");
    }

    fn start(part: &str, more: &str) -> Stand {
        let board = Board::start(&["--part", part, "--profile", "charly"]);
        let port = board.port();
        let (code, said) = pasapas(&["profile", "set", "charly", "--port", text(&port)]);
        assert_eq!(code, 0, "{said}");
        let file = board.folder.path().join("card.toml");
        let content = format!(
            "[[board]]\nname = \"mill\"\nport = {:?}\n[[card]]\nboard = \"mill\"\n{more}\n\
             [[client]]\nfrom = \"127.0.0.1\"\nfresh = true\nwrite = [\"RUN_CONTROL\"]\n",
            text(&port)
        );
        let content = if more.contains("pty") || more.contains("port") {
            content
        } else {
            content.replace("[[client]]", "listen = \"127.0.0.1:0\"\n[[client]]")
        };
        std::fs::write(&file, content).expect("a file");
        let mut gateway = Gateway::start(&[text(&file)]);
        let place = gateway.next_line();
        let place = place["card"].as_str().expect("a card").rsplit(':').next().expect("a port");
        let card = place.parse().unwrap_or(0);
        Stand { board, gateway, card }
    }

    fn client(&self) -> Client {
        let stream = TcpStream::connect(("127.0.0.1", self.card)).expect("it listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a socket");
        Client(stream)
    }

    /// Machine positions and whether something moves or runs, as the board says it.
    fn status(&self) -> serde_json::Value {
        let over = format!("tcp:{}", self.gateway.port);
        let (code, said) = pasapas(&["status", "--format", "json", "--port", &over]);
        assert_eq!(code, 0, "{said}");
        serde_json::from_str(&said).expect("JSON")
    }

    fn at(&self, axis: &str) -> i64 {
        self.status()["pos"][axis].as_i64().expect("a position")
    }

    /// Waits until the board rests, and gives its X.
    fn rest(&self) -> i64 {
        let begun = Instant::now();
        loop {
            let status = self.status();
            if status["moving"].as_array().is_some_and(Vec::is_empty) {
                let x = status["pos"]["X"].as_i64().expect("a position");
                std::thread::sleep(Duration::from_millis(200));
                if self.at("X") == x {
                    return x;
                }
            }
            assert!(begun.elapsed() < PATIENCE, "it moves for ever");
        }
    }
}

struct Client(TcpStream);

impl Client {
    fn send(&mut self, bytes: &[u8]) {
        self.0.write_all(bytes).expect("open");
    }

    fn bytes(&mut self, count: usize) -> String {
        let mut bytes = vec![0; count];
        self.0.read_exact(&mut bytes).expect("an answer");
        String::from_utf8(bytes).expect("text")
    }

    /// Says a line and waits for its one character, as the binder's programs do.
    fn say(&mut self, line: &str) -> String {
        self.send(format!("{line}\r").as_bytes());
        self.bytes(1)
    }

    fn position(&mut self) -> [i64; 3] {
        assert_eq!(self.say("@0P"), "0");
        let digits = self.bytes(18);
        [0, 1, 2].map(|n| {
            let value = i64::from_str_radix(&digits[6 * n..6 * n + 6], 16).expect("hexadecimal");
            if value >= 1 << 23 { value - (1 << 24) } else { value }
        })
    }
}

/// The GW-BASIC programs of the binder, chapter 3, with their answers.
fn binder(part: &str) {
    let stand = Stand::start(part, "");
    let mut client = stand.client();
    assert_eq!(client.say("@0R7"), "4", "no axes yet");
    for (line, answer) in
        [("@07", "0"), ("@0d2000,2000,2000", "0"), ("@0R7", "0"), ("@0A 50,900", "7")]
    {
        assert_eq!(client.say(line), answer, "{line}");
    }
    assert_eq!(client.position(), [0, 0, 0]);
    assert_eq!(client.say("@0A 500,9000,0,9000,0,9000,0,9000"), "0");
    assert_eq!(client.position(), [500, 0, 0]);
    // Both of X and Y in a line, then Z down and up.
    assert_eq!(client.say("@0A 300,1200,400,5000,200,900,-100,900"), "0");
    assert_eq!(client.position(), [800, 400, 100]);
    assert_eq!(client.say("@0M 50,900,20,900,33,900,0,21"), "0");
    assert_eq!(client.position(), [50, 20, 33]);
    for _ in 0..5 {
        assert_eq!(client.say("@0A 7,900,-3,900,0,21,0,21"), "0");
    }
    assert_eq!(client.position(), [85, 5, 33]);
    // Beyond the travel of a homed axis.
    assert_eq!(client.say("@0A -900,900,0,21,0,21,0,21"), "2");
    assert_eq!(client.position(), [85, 5, 33]);
    // "Point zéro": absolute moves count from there, positions do not.
    assert_eq!(client.say("@0n3"), "0");
    assert_eq!(client.say("@0m100,900,50,900,33,900,0,21"), "0");
    assert_eq!(client.position(), [185, 55, 33]);
    assert_eq!(client.say("@0B65529,5"), "0");
    assert_eq!((client.say("@0b65529"), client.bytes(2)), ("0".to_owned(), "05".to_owned()));
    assert_eq!(stand.status()["outputs"], serde_json::json!([1, 3]));

    // Memory mode: a frame of the DIL socket, three times; an error ends it and nothing runs.
    for line in ["@0i", "0 100,900,0,21,0,21,0,21", "0 0,21,60,900,10,900,-10,900", "3 3,-2"] {
        assert_eq!(client.say(line), "0", "{line}");
    }
    assert_eq!(client.say("4 9"), "A");
    assert_eq!((client.say("9"), client.say("@0S")), ("5".to_owned(), "5".to_owned()));
    assert_eq!(client.position(), [185, 55, 33]);
    for line in
        ["@0i", "0 100,900,0,21,0,21,0,21", "0 0,21,60,900,10,900,-10,900", "3 3,-2", "1 70", "9"]
    {
        assert_eq!(client.say(line), "0", "{line}");
    }
    // The synchronisation character comes before the end's answer.
    client.send(b"@0S\r");
    assert_eq!(client.bytes(2), "F0", "character 70 and the end");
    assert_eq!(client.position(), [485, 235, 33]);
    // It is on the board: its Start button runs it, and so does the link.
    let over = format!("tcp:{}", stand.gateway.port);
    assert_eq!(pasapas(&["status", "--port", &over]).0, 0);
    assert_eq!(client.say("@0C1"), "0");
    assert_eq!(client.bytes(2), "\r\n");
}

#[test]
fn the_binders_programs_run_on_the_small_chip() {
    binder("g2553");
}

#[test]
fn the_binders_programs_run_on_the_large_one() {
    binder("f5529");
}

#[test]
fn a_stop_byte_ends_the_move_and_what_waits_is_not_made() {
    let stand = Stand::start("g2553", "");
    let mut client = stand.client();
    assert_eq!(client.say("@07"), "0");
    // In one direction by a command with a target, in two by a line: both stop.
    for (line, far) in
        [("@0A 20000,900,0,21,0,21,0,21", 20_000), ("@0A 20000,900,900,21,0,21,0,21", 20_000)]
    {
        let from = client.position()[0];
        client.send(format!("{line}\r@0A 5000,900,0,21,0,21,0,21\r@0A 70").as_bytes());
        std::thread::sleep(Duration::from_millis(700));
        client.send(b"\xFF");
        assert_eq!(client.bytes(2), "0F", "ok for the stop, nothing of what waited");
        client.send(b"00,900,0,21,0,21,0,21\r");
        assert_eq!(client.bytes(1), "F", "the line in whose middle it came");
        let x = stand.rest();
        assert!(x > from && x < from + far / 2, "{from} {x}");
        assert_eq!(client.position()[0], x);
    }
    // What is asked for behind it is made.
    let from = client.position()[0];
    assert_eq!(client.say("@0A 100,900,0,21,0,21,0,21"), "0");
    assert_eq!(client.position()[0], from + 100);
    // A reset is an emergency stop: nothing but a reference run takes it back.
    client.send(b"@0A 20000,900,900,900,0,21,0,21\r");
    std::thread::sleep(Duration::from_millis(500));
    client.send(b"\xFE");
    let x = stand.rest();
    assert_eq!(client.say("@0A 100,900,0,21,0,21,0,21"), "4");
    assert_eq!(client.say("@07"), "0");
    assert_eq!(client.say("@0A 100,900,0,21,0,21,0,21"), "F");
    assert_eq!(stand.rest(), x);
    assert_eq!(client.say("@0R1"), "0");
    assert_eq!(client.position()[0], 0);
}

#[test]
fn a_stored_program_is_halted_and_goes_on_or_ends() {
    let stand = Stand::start("f5529", "");
    let mut client = stand.client();
    for line in
        ["@07", "@0i", "0 3000,1000,0,21,0,21,0,21", "2 50", "0 500,1000,0,21,0,21,0,21", "9"]
    {
        assert_eq!(client.say(line), "0", "{line}");
    }
    client.send(b"@0S\r");
    std::thread::sleep(Duration::from_millis(800));
    client.send(b"\xFD");
    assert_eq!(client.bytes(1), "F");
    let [x, ..] = client.position();
    assert!(x > 0 && x < 3000, "{x}");
    assert_eq!(client.say("@0A 1,900,0,21,0,21,0,21"), "5", "not while a program is halted");
    client.send(b"@0S\r");
    // It comes to its wait for a character.
    let begun = Instant::now();
    while stand.at("X") < 3000 {
        assert!(begun.elapsed() < PATIENCE);
    }
    client.send(b"2");
    assert_eq!(client.bytes(1), "0");
    assert_eq!(client.position()[0], 3500);
    client.send(b"@0S\r");
    std::thread::sleep(Duration::from_millis(800));
    client.send(b"\xFD");
    assert_eq!(client.bytes(1), "F");
    assert_eq!(client.say("@0Q"), "0");
    assert_eq!(client.bytes(1), "F", "the run's own answer: it was stopped");
    assert!(stand.rest() < 6500);
}

/// The binder's remedy for a limit is the program begun again, with a reference run in it.
#[test]
fn a_new_program_clears_the_error_of_the_last() {
    let stand = Stand::start("f5529", "");
    let mut client = stand.client();
    for line in ["@07", "@0R7", "@0i", "0 2000000,1000,0,21,0,21,0,21", "9"] {
        assert_eq!(client.say(line), "0", "{line}");
    }
    assert_eq!(client.say("@0S"), "2");
    assert_eq!(client.say("@0S"), "2", "the same again: what was wrong, not the Stop key");
    for line in ["@0i", "7 7", "0 100,1000,0,21,0,21,0,21", "9", "@0S"] {
        assert_eq!(client.say(line), "0", "{line}");
    }
    assert_eq!(client.position()[0], 100);
    // An emergency stop is no error of a program.
    stand.emergency_stop();
    for line in ["@0i", "0 100,1000,0,21,0,21,0,21", "9"] {
        assert_eq!(client.say(line), "0", "{line}");
    }
    assert_eq!(client.say("@0S"), "F");
}

#[test]
fn who_leaves_rubbish_or_half_a_line_moves_nothing() {
    let stand = Stand::start("g2553", "");
    let mut client = stand.client();
    assert_eq!(client.say("@07"), "0");
    client.send(
        b"@0A 1500,1000,0,21,0,21,0,21\r@0A 9000,1000,0,21,0,21,0,21\r@0A 5000,900,0,21,0,21,0,21",
    );
    std::thread::sleep(Duration::from_millis(300));
    drop(client);
    assert_eq!(stand.rest(), 1500, "what was begun comes to its end, what waited does not begin");
    let mut client = stand.client();
    assert_eq!(client.position(), [1500, 0, 0], "nobody hears another one's answers");
    drop(client);
    let mut random = 88_172_645_463_325_252_u64;
    for _ in 0..40 {
        let mut client = stand.client();
        let rubbish: Vec<u8> = (0..300)
            .map(|_| {
                random ^= random << 13;
                random ^= random >> 7;
                random ^= random << 17;
                // Everything but what begins a command.
                match (random >> 32) as u8 {
                    b'@' => b'?',
                    byte => byte,
                }
            })
            .collect();
        client.send(&rubbish);
    }
    for half in [
        "@0A 500,900,0,21,0,21,0,2",
        "A 500,900,0,21,0,21,0,21\r",
        "@1A 500,900,0,21,0,21,0,21\r",
        "@0A 5 0 0 , 9",
    ] {
        stand.client().send(half.as_bytes());
    }
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(stand.rest(), 1500);
    assert_eq!(stand.status()["outputs"], serde_json::json!([]));
}

#[test]
fn when_the_gateway_is_killed_a_line_ends_on_the_board() {
    let stand = Stand::start("g2553", "");
    let mut client = stand.client();
    assert_eq!(client.say("@07"), "0");
    // 20 seconds of a line.
    client.send(b"@0A 20000,700,20000,700,0,21,0,21\r");
    std::thread::sleep(Duration::from_millis(700));
    let port = stand.board.port();
    drop(stand.gateway);
    std::thread::sleep(Duration::from_secs(4));
    let at = || {
        let (code, said) = pasapas(&["status", "--format", "json", "--port", text(&port)]);
        assert_eq!(code, 0, "{said}");
        let status: serde_json::Value = serde_json::from_str(&said).expect("JSON");
        status["pos"]["X"].as_i64().expect("a position")
    };
    let x = at();
    assert!(x > 0 && x < 8_000, "{x}");
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(at(), x);
}

/// What programs of others send, byte by byte: an iMC-S8's, one that ends lines by CR LF and reads
/// nothing, one that ends them by LF CR.
#[test]
fn sequences_of_other_programs_are_answered_as_they_await_it() {
    let stand = Stand::start("f5529", "dialect = \"imcs8\"");
    let mut client = stand.client();
    for line in ["@07", "@0IX", "@0d3000,3000,3000", "@0IR7", "@0IW", "@0z1", "@0J1000", "@0R7"] {
        assert_eq!(client.say(line), "0", "{line}");
    }
    assert_eq!(client.say("@0A 320,900,640,900,160,900,0,100"), "0", "a blank behind the letter");
    assert_eq!(client.say("@0M3200,10000,6400,10000,1600,10000,0,20"), "0");
    assert_eq!(client.position(), [3200, 6400, 1600]);
    client.send(b"\n\r@0a0,2000,-400,2000,0,2000,0,400\n\r@0r7\n\r@0P\n\r");
    assert_eq!(client.bytes(3), "000");
    assert_eq!(client.bytes(18), "0".repeat(18));
    drop(client);

    let folder = tempfile::tempdir().expect("a folder");
    let link = folder.path().join("card");
    let stand = Stand::start("g2553", &format!("pty = {:?}\nanswer = \"cr\"", text(&link)));
    let mut port = std::fs::OpenOptions::new().write(true).open(&link).expect("a pseudo-terminal");
    // All at once, and nothing read.
    port.write_all(b"@01\r\n@0d2000\r\n@0i\r\n71\r\n0400,1000\r\n9\r\n@0S\r\n").expect("open");
    let begun = Instant::now();
    while stand.status()["program_counter"].is_null() || stand.status()["runs"] != 1 {
        assert!(begun.elapsed() < PATIENCE, "it does not run: {}", stand.status());
    }
}
