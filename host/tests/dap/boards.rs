//! Runs on a board: the real firmware in the emulator, in the adapter or behind a port.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::json;

use crate::client::Client;
use crate::simulator::script;

const COUNTS: &str = "DIM i, last\nFOR i = 1 TO 3\n  SetOut 1, ON\n  last = i * 10\n  SetOut 1, OFF\nNEXT\nPRINT last\n";

#[test]
fn a_virtual_board_halts_before_the_next_effect() {
    let (_folder, file) = script(COUNTS);
    let mut client = Client::start();
    let launch = json!({ "program": file, "board": "virtual", "stopOnEntry": true });
    client.launch(launch, json!([{ "line": 5 }]));
    assert_eq!(client.halt().0, "entry");
    assert_eq!(client.go("continue"), ("breakpoint".to_owned(), vec![5]));
    assert_eq!(client.watch("last"), "10");
    // No register of a board has it: a time of 0 would be a wrong one.
    let why = client.refused("evaluate", json!({ "expression": "TIMER()", "frameId": 1 }));
    assert!(why.contains("t = TIMER()"), "{why}");
    assert!(
        client.list("Outputs").iter().any(|entry| entry.starts_with("1") && entry.ends_with("=ON"))
    );
    assert!(client.list("Axes").iter().any(|entry| entry.starts_with("X=")));
    // A step leads to the next effect.
    assert_eq!(client.go("next").0, "step");
    client.ask(
        "setBreakpoints",
        json!({
            "source": { "path": file }, "breakpoints": [{ "line": 5, "condition": "i = 3" }]
        }),
    );
    assert_eq!(client.go("continue"), ("breakpoint".to_owned(), vec![5]));
    assert_eq!(client.watch("i"), "3");
    let arguments = json!({ "expression": "last", "value": "77", "frameId": 1 });
    client.ask("setExpression", arguments);
    client.ask("continue", json!({ "threadId": 1 }));
    assert_eq!(client.event("exited")["exitCode"], 0);
    client.event("terminated");
    assert_eq!(client.output("stdout"), "77\n");
    client.close();
}

#[test]
fn hits_and_log_points_are_a_boards_too() {
    let (_folder, file) = script(COUNTS);
    let mut client = Client::start();
    let breaks = json!([
        { "line": 3, "logMessage": "turn {i}" }, { "line": 5, "hitCondition": "3" },
    ]);
    client.launch(json!({ "program": file, "board": "virtual" }), breaks);
    assert_eq!(client.halt(), stop("breakpoint", &[5]));
    assert_eq!(client.watch("i"), "3");
    assert_eq!(client.output("console"), "turn 1\nturn 2\nturn 3\n");
    // Anew, and stopped by hand while it is halted.
    client.ask("restart", json!({}));
    assert_eq!(client.halt(), stop("breakpoint", &[5]));
    client.ask("terminate", json!({}));
    client.event("terminated");
    client.close();
}

/// Lines: 1 DIM, 2 FOR, 3 square, 4 SetOut, 5 NEXT, 6 PRINT, 7 END; 8 SUB square to 13, 14 SUB side to 17.
const CALLS: &str = "DIM i\nFOR i = 1 TO 3\n  square i\n  SetOut 2, ON\nNEXT\nPRINT i\nEND\n\
    SUB square(n)\n  MoveAxe X, n * 1mm\n  SetOut 1, ON\n  side n\n  SetOut 1, OFF\nEND SUB\n\
    SUB side(m)\n  MoveAxe Y, m * 1mm\n  MoveAxe Y, 0mm\nEND SUB\n";

fn stop(reason: &str, lines: &[u64]) -> (String, Vec<u64>) {
    (reason.to_owned(), lines.to_vec())
}

fn breaks(client: &mut Client, file: &str, lines: &[u32]) -> serde_json::Value {
    let list: Vec<_> = lines.iter().map(|line| json!({ "line": line })).collect();
    client.ask("setBreakpoints", json!({ "source": { "path": file }, "breakpoints": list }))
}

/// The axes' places in steps.
fn places(client: &mut Client) -> Vec<String> {
    client
        .list("Axes")
        .iter()
        .filter_map(|axis| axis.split(", ").nth(1).map(str::to_owned))
        .collect()
}

/// A walk through calls on a board that tells them.
fn walks(board: &str) {
    let (_folder, file) = script(CALLS);
    let mut client = Client::start();
    let set = client.launch(
        json!({ "program": file, "board": board, "stopOnEntry": true }),
        json!([{ "line": 14 }]),
    );
    // Nothing but an effect halts a board.
    assert_eq!((&set[0]["verified"], &set[0]["line"]), (&json!(true), &json!(15)));
    assert_eq!(client.halt(), stop("entry", &[9, 3]));
    assert_eq!(places(&mut client)[..2], ["0st", "0st"], "nothing has moved yet");
    assert_eq!(client.go("continue"), stop("breakpoint", &[15, 11, 3]));
    assert_eq!(client.calls(), ["side", "square", "main program"]);
    assert_eq!(client.list("Locals"), ["m=1"]);
    // The move before is done, this one has not begun; and the board waits as long as people do.
    std::thread::sleep(Duration::from_millis(2600));
    assert_eq!(places(&mut client)[..2], ["100st", "0st"]);
    assert_eq!(client.go("next"), stop("step", &[16, 11, 3]));
    assert_eq!(places(&mut client)[..2], ["100st", "100st"]);
    assert_eq!(client.go("stepOut"), stop("step", &[12, 3]));
    assert_eq!(places(&mut client)[..2], ["100st", "0st"]);
    assert_eq!(client.go("next"), stop("step", &[4]));
    breaks(&mut client, &file, &[]);
    // Over a call with all that it calls, then into it.
    assert_eq!(client.go("next"), stop("step", &[4]));
    assert_eq!(client.watch("i"), "2");
    assert_eq!(client.go("stepIn"), stop("step", &[9, 3]));
    assert_eq!(client.go("next"), stop("step", &[10, 3]));
    assert_eq!(client.go("next"), stop("step", &[12, 3]));
    assert_eq!(client.go("stepOut"), stop("step", &[4]));
    client.ask("continue", json!({ "threadId": 1 }));
    assert_eq!(client.event("exited")["exitCode"], 0);
    client.event("terminated");
    assert_eq!(client.output("stdout"), "4\n");
    client.close();
}

#[test]
fn calls_and_steps_on_a_virtual_board() {
    walks("virtual");
}

#[test]
fn a_board_that_does_not_tell_calls_says_so_and_steps_by_the_lines() {
    steps_by_the_lines(&Served::start("g2553"));
    steps_by_the_lines(&Served::start("g2553-handlers"));
}

fn steps_by_the_lines(board: &Served) {
    let (_folder, file) = script(CALLS);
    let mut client = Client::start();
    client.launch(json!({ "program": file, "board": board.1 }), json!([{ "line": 12 }]));
    assert_eq!(client.halt(), stop("breakpoint", &[12, 0]));
    assert!(client.output("console").contains("does not tell the open calls"));
    assert_eq!(client.calls(), ["square", "its callers: not known on this board"]);
    breaks(&mut client, &file, &[]);
    assert_eq!(client.go("stepOut"), stop("step", &[4]));
    assert_eq!(client.calls(), ["main program"]);
    client.ask("continue", json!({ "threadId": 1 }));
    client.event("terminated");
    assert_eq!(client.output("stdout"), "4\n");
    client.close();
}

/// A board behind a port.
struct Served(Child, String);

impl Served {
    fn start(part: &str) -> Served {
        let mut child = Command::new(env!("CARGO_BIN_EXE_pasapas"))
            .args(["board", "--tcp", "0", "--part", part])
            .stdout(Stdio::piped())
            .spawn()
            .expect("it starts");
        let mut said = String::new();
        let mut output = BufReader::new(child.stdout.take().expect("an output"));
        output.read_line(&mut said).expect("its port");
        let digits =
            said.trim().rsplit(|c: char| !c.is_ascii_digit()).find(|text| !text.is_empty());
        Served(child, format!("tcp:{}", digits.expect("a port")))
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.0.kill().and_then(|()| self.0.wait());
    }
}

/// What `pasapas status` tells of a board.
fn status(board: &Served) -> serde_json::Value {
    let told = Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .args(["status", "--port", &board.1, "--format", "json"])
        .output()
        .expect("it runs");
    serde_json::from_slice(&told.stdout).unwrap_or_else(|error| panic!("{error}: {told:?}"))
}

#[test]
fn a_run_is_attached_to_as_it_goes_on_and_left_as_it_is() {
    let board = Served::start("f5529");
    let (_folder, file) =
        script("DIM i\nWHILE i < 30000\n  SetOut 1, ON\n  i = i + 1\n  Wait 5ms\nWEND\n");
    let launch = json!({ "program": file, "board": board.1 });
    let attach = json!({ "program": file, "board": board.1, "attach": true });
    // Another program, or none, is on it.
    let mut client = Client::start();
    client.ask("attach", attach.clone());
    client.event("initialized");
    assert!(client.refused("configurationDone", json!({})).contains("upload"));
    client.close();
    // A debugger that goes leaves a run that it is told to leave.
    let mut client = Client::start();
    client.launch(launch, json!([{ "line": 5 }]));
    assert_eq!(client.halt(), stop("breakpoint", &[5]));
    assert_eq!(client.watch("i"), "1");
    client.ask("disconnect", json!({ "terminateDebuggee": false }));
    let mut client = Client::start();
    client.launch(attach.clone(), json!([{ "line": 3 }]));
    assert_eq!(client.halt(), stop("breakpoint", &[3]));
    let seen: u32 = client.watch("i").parse().expect("a number");
    assert!(seen > 1, "it began anew");
    assert_eq!(client.go("next"), stop("step", &[5]));
    assert_eq!(client.watch("i"), (seen + 1).to_string());
    client.close();
    let told = status(&board);
    assert_eq!((&told["state"], &told["runs"]), (&json!("running"), &json!(1)), "{told}");
    // Told to, it ends it.
    let mut client = Client::start();
    client.launch(attach.clone(), json!([]));
    client.ask("pause", json!({ "threadId": 1 }));
    assert_eq!(client.halt().0, "pause");
    client.ask("disconnect", json!({ "terminateDebuggee": true }));
    let told = status(&board);
    assert_eq!((&told["state"], &told["last_end"]), (&json!("ready"), &json!("stopped")), "{told}");
    // Nothing runs: it waits for Start, and starts nothing unasked.
    let mut client = Client::start();
    client.launch(attach, json!([{ "line": 3 }]));
    std::thread::sleep(Duration::from_millis(2500));
    client.ask("threads", json!({}));
    assert!(client.output("console").contains("press Start"));
    client.ask("restart", json!({}));
    assert_eq!(client.halt(), stop("breakpoint", &[3]));
    assert_eq!(client.watch("i"), "0");
    client.ask("disconnect", json!({ "terminateDebuggee": true }));
    assert_eq!(status(&board)["runs"], 2);
}
