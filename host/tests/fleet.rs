//! `pasapas fleet` over two gateways with three boards of the real firmware.

#![cfg(unix)]

mod common;

use std::collections::HashMap;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::Duration;

use common::{Board, Gateway, pasapas, text};
use rustix::process::Signal;
use serde_json::Value;

/// Boards, their gateways, and the option that names these.
struct Hall {
    boards: [Board; 3],
    gateways: Vec<Gateway>,
    option: String,
}

/// A command that works.
struct Roll {
    child: Child,
    lines: BufReader<ChildStdout>,
    said: String,
}

impl Roll {
    /// Waits until it has said that.
    fn until(&mut self, what: &str) {
        while !self.said.contains(what) {
            let count = self.lines.read_line(&mut self.said).expect("text");
            assert!(count > 0, "it does not say {what}: {}", self.said);
        }
    }

    /// Its exit code, and all that it said.
    fn end(mut self) -> (i32, String) {
        self.lines.read_to_string(&mut self.said).expect("text");
        let output = self.child.wait_with_output().expect("it ends");
        let said = self.said + &String::from_utf8_lossy(&output.stderr);
        (output.status.code().unwrap_or(-1), said)
    }
}

const GOOD: &str = "KEEP made\nDIM deep AS LENGTH\nmade = made + 1\nSetOut 2, ON\nWait 60s\n";
const FAILS: &str = "DIM a\nWait 50ms\nPRINT 1 / a\n";

impl Hall {
    fn start() -> Hall {
        let small = ["--part", "g2553"];
        let boards =
            [Board::start(&small), Board::start(&small), Board::start(&["--part", "f5529"])];
        let port = |n: usize| text(&boards[n].port()).to_owned();
        let board = |name: &str, n: usize, unit: u8, tags: &str| {
            format!(
                "[[board]]\nname = \"{name}\"\nport = {:?}\nunit = {unit}\ntags = [{tags}]\n",
                port(n)
            )
        };
        let rights = "[[client]]\nfrom = \"127.0.0.1\"\nwrite = [\"all\"]\n";
        let files = [
            format!(
                "names = \"hall.json\"\n{}{}{rights}",
                board("drill", 0, 1, "\"hall\", \"wet\""),
                board("saw", 1, 2, "\"hall\"")
            ),
            format!("{}{rights}", board("press", 2, 1, "\"yard\"")),
        ];
        let folder = boards[0].folder.path();
        let start = |(n, content): (usize, &String)| {
            let file = folder.join(format!("{n}.toml"));
            std::fs::write(&file, content).expect("a file");
            Gateway::start(&[text(&file)])
        };
        let gateways: Vec<Gateway> = files.iter().enumerate().map(start).collect();
        let places: Vec<String> =
            gateways.iter().map(|one| format!("127.0.0.1:{}", one.port)).collect();
        Hall { option: places.join(","), boards, gateways }
    }

    fn script(&self, name: &str, content: &str) -> String {
        let path = self.boards[0].folder.path().join(name);
        std::fs::write(&path, content).expect("a file");
        text(&path).to_owned()
    }

    fn fleet(&self, args: &[&str]) -> (i32, String) {
        pasapas(&[&["fleet"], args, &["--gateway", &self.option]].concat())
    }

    /// Begins it, to be looked at while it works.
    fn begin(&self, args: &[&str]) -> Roll {
        let mut child = Command::new(env!("CARGO_BIN_EXE_pasapas"))
            .arg("fleet")
            .args(args)
            .args(["--gateway", &self.option])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        let lines = BufReader::new(child.stdout.take().expect("its output"));
        Roll { child, lines, said: String::new() }
    }

    /// The boards' lines of the table, by their names.
    fn standings(&self) -> HashMap<String, Value> {
        let (_, said) = self.fleet(&["status", "--format", "json"]);
        let lines = said.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
        lines.map(|line| (line["board"].as_str().unwrap_or_default().to_owned(), line)).collect()
    }

    /// A board's line of the table.
    fn standing(&self, board: &str) -> Value {
        self.standings().remove(board).unwrap_or_else(|| panic!("no {board}"))
    }
}

#[test]
fn a_program_rolls_over_the_boards_with_a_tag_and_stops_at_the_first_fault() {
    let hall = Hall::start();
    let (good, fails) = (hall.script("good.bas", GOOD), hall.script("fails.bas", FAILS));
    let (code, said) = hall.fleet(&["upload", &good]);
    assert_eq!(code, 2, "whom it concerns must be said: {said}");
    let (code, said) = hall.fleet(&["upload", &good, "--tag", "hall"]);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("drill: uploaded") && said.contains("saw: uploaded"), "{said}");
    let (code, said) = hall.fleet(&["status"]);
    assert_eq!(code, 0, "{said}");
    let (drill, press) = (hall.standing("drill"), hall.standing("press"));
    assert_eq!((&drill["script"], &drill["profile"]), (&"good.bas".into(), &"mill".into()));
    assert_eq!(drill["differs"].as_array().map(Vec::len), Some(0), "{drill}");
    let differs = press["differs"].to_string();
    assert!(differs.contains("program") && differs.contains("firmware"), "{press}");

    // What fails on the first board does not get to the second.
    let before = hall.standing("saw")["program"].clone();
    let (code, said) = hall.fleet(&["upload", &fails, "--tag", "hall", "--replace", "--start"]);
    assert_eq!(code, 4, "{said}");
    assert!(said.contains("F02") && said.contains("in line 3"), "{said}");
    assert!(said.contains("left alone: saw"), "{said}");
    assert_eq!(hall.standing("saw")["program"], before);
    assert_eq!(hall.standing("drill")["state"], "fault");

    // It gets over its fault with a program that runs.
    let (code, said) =
        hall.fleet(&["upload", &good, "--tag", "wet,yard", "--replace", "--start", "--watch", "1"]);
    assert_eq!(code, 0, "{said}");
    for board in ["drill", "press"] {
        assert_eq!(hall.standing(board)["state"], "running");
    }
    // A running board is not stopped unless that is asked for.
    let (code, said) = hall.fleet(&["upload", &fails, "--board", "drill", "--replace"]);
    assert_eq!(code, 4, "{said}");
    assert_eq!(hall.standing("drill")["state"], "running");
    let (code, said) = hall.fleet(&["start", "--board", "saw"]);
    assert_eq!(code, 0, "{said}");

    // Another machine's board ends a roll.
    let (code, said) = hall.fleet(&["stop", "--all"]);
    assert_eq!(code, 0, "{said}");
    for board in ["drill", "saw", "press"] {
        assert_eq!(hall.standing(board)["state"], "ready");
    }
    let over = format!("tcp:127.0.0.1:{}", hall.gateways[0].port);
    let (code, said) = pasapas(&["profile", "set", "charly", "--port", &over]);
    assert_eq!(code, 0, "{said}");
    let (code, said) = hall.fleet(&["upload", &fails, "--tag", "hall", "--replace"]);
    assert_eq!(code, 4, "{said}");
    assert!(said.contains("profile is not `mill`") && said.contains("left alone: saw"), "{said}");
}

#[test]
fn what_can_be_reached_is_stopped_whatever_else_fails() {
    let mut hall = Hall::start();
    let good = hall.script("good.bas", GOOD);
    let (code, said) = hall.fleet(&["upload", &good, "--all", "--start", "--watch", "1"]);
    assert_eq!(code, 0, "{said}");
    hall.gateways.pop();
    let (code, said) = hall.fleet(&["start", "--all"]);
    assert_eq!(code, 4, "nothing is started by halves: {said}");
    let (code, said) = hall.fleet(&["stop", "--all"]);
    assert_eq!(code, 4, "{said}");
    assert!(said.contains("drill: stopped") && said.contains("saw: stopped"), "{said}");
    assert_eq!(hall.standing("saw")["state"], "ready");

    // The names of the program's variables went with it, over a gateway's end as well.
    let over = format!("tcp:127.0.0.1:{}", hall.gateways[0].port);
    let row = ",holding register,4000,int32,made,,1,true,KEEP variable of the script.";
    let (code, table) = pasapas(&["gateway", "--describe", "--port", &over]);
    assert_eq!(code, 0, "{table}");
    assert!(table.contains(&format!("drill,1{row}")) && table.contains(&format!("saw,2{row}")));
    hall.gateways.clear();
    let file = hall.boards[0].folder.path().join("0.toml");
    let (code, table) = pasapas(&["gateway", "--describe", text(&file)]);
    assert_eq!(code, 0, "{table}");
    assert!(table.contains(&format!("saw,2{row}")), "{table}");
}

/// A gateway whose file says nothing of clients is there to be read: all that it lets them do is stop.
#[test]
fn a_gateway_that_is_only_read_lets_its_boards_be_stopped() {
    let board = Board::start(&["--part", "f5529"]);
    let direct = text(&board.port()).to_owned();
    let folder = board.folder.path();
    let (script, file) = (folder.join("good.bas"), folder.join("only.toml"));
    std::fs::write(&script, GOOD).expect("a file");
    std::fs::write(&file, format!("[[board]]\nname = \"press\"\nport = {direct:?}\n"))
        .expect("a file");
    let (code, said) = pasapas(&["upload", text(&script), "--port", &direct]);
    assert_eq!(code, 0, "{said}");
    let (code, said) = pasapas(&["start", "--port", &direct]);
    assert_eq!(code, 0, "{said}");
    let gateway = Gateway::start(&[text(&file)]);
    let place = format!("127.0.0.1:{}", gateway.port);
    let (code, said) = pasapas(&["fleet", "start", "--all", "--gateway", &place]);
    assert_eq!(code, 4, "{said}");
    let (code, said) = pasapas(&["fleet", "stop", "--all", "--gateway", &place]);
    assert_eq!((code, said.trim()), (0, "press: stopped"));
    // What it does not let them do is told with the place where it says so.
    let (code, said) = pasapas(&["fleet", "start", "--all", "--gateway", &place]);
    assert_eq!(code, 4, "{said}");
    assert!(said.contains("[[client]]"), "{said}");
}

/// Larger than anything that a board gets between two looks at what the tool says.
fn long_script(first: &str) -> String {
    let steps: String = (1..250).map(|n| format!("Wait {n}ms\nSetOut 2, ON\n")).collect();
    format!("KEEP made\n{first}\n{steps}")
}

#[test]
fn a_roll_that_breaks_in_the_middle_is_finished_by_the_next_one() {
    let mut hall = Hall::start();
    let all = ["--all", "--replace"];
    let upload = |hall: &Hall, script: &str| hall.fleet(&[&["upload", script], &all[..]].concat());
    let (old, new) = (long_script("made = 1"), long_script("made = 2"));
    let (old, new) = (hall.script("old.bas", &old), hall.script("new.bas", &new));
    let (code, said) = upload(&hall, &old);
    assert_eq!(code, 0, "{said}");
    // While the second one gets it, it does not answer for longer than a request is repeated: it gets it all the same.
    let mut roll = hall.begin(&[&["upload", &new], &all[..]].concat());
    roll.until("drill: uploaded");
    std::thread::sleep(Duration::from_millis(60));
    hall.boards[1].signal(Signal::STOP);
    std::thread::sleep(Duration::from_secs(4));
    hall.boards[1].signal(Signal::CONT);
    let (code, said) = roll.end();
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("once more in") && said.contains("press: uploaded"), "{said}");
    let all_of_them = hall.standings();
    let crc = all_of_them["drill"]["program"].clone();
    assert!(all_of_them.values().all(|one| one["program"] == crc), "{all_of_them:?}");

    // Its cable is pulled: the roll ends there, and what is behind it stays as it was.
    let mut roll = hall.begin(&[&["upload", &old], &all[..]].concat());
    roll.until("drill: uploaded");
    std::thread::sleep(Duration::from_millis(60));
    hall.boards[1].end(Signal::KILL);
    let (code, said) = roll.end();
    assert_eq!(code, 4, "{said}");
    assert!(said.contains("left alone: press"), "{said}");
    let all_of_them = hall.standings();
    assert_ne!(all_of_them["drill"]["program"], crc);
    assert_eq!(all_of_them["press"]["program"], crc);
    assert!(!all_of_them["saw"]["error"].is_null());

    // Another board is put there; the next roll does what is left.
    hall.boards[1].begin_again(&["--part", "g2553"]);
    let (code, said) = upload(&hall, &old);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("drill: it has the program already"), "{said}");
    assert!(said.contains("saw: uploaded") && said.contains("press: uploaded"), "{said}");
}

#[test]
fn a_gateway_that_ends_in_the_middle_ends_the_roll() {
    let mut hall = Hall::start();
    let new = hall.script("new.bas", &long_script("made = 2"));
    // What hangs on the other one is left alone.
    let mut roll = hall.begin(&["upload", &new, "--all"]);
    roll.until("drill: uploaded");
    drop(hall.gateways.remove(0));
    let (code, said) = roll.end();
    assert_eq!(code, 4, "{said}");
    assert!(said.contains("left alone: press"), "{said}");
    assert_eq!(hall.standing("press")["state"], "empty");
}
