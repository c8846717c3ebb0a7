//! Runs on a board: the real firmware in the emulator, in the adapter or behind a port.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

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

/// A board behind a port.
struct Served(Child, String);

impl Served {
    fn start() -> Served {
        let mut child = Command::new(env!("CARGO_BIN_EXE_pasapas"))
            .args(["board", "--tcp", "0", "--speed", "max"])
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

#[test]
fn a_board_at_a_port_is_launched_and_attached_to() {
    let board = Served::start();
    let (_folder, file) = script(COUNTS);
    let mut client = Client::start();
    let launch = json!({ "program": file, "board": board.1 });
    let attach = json!({ "program": file, "board": board.1, "attach": true });
    // Another program, or none, is on it.
    client.ask("attach", attach.clone());
    client.event("initialized");
    assert!(client.refused("configurationDone", json!({})).contains("upload"));
    client.close();
    let mut client = Client::start();
    client.launch(launch, json!([]));
    client.event("terminated");
    assert_eq!(client.output("stdout"), "30\n");
    client.close();
    let mut client = Client::start();
    client.launch(attach, json!([{ "line": 3 }]));
    assert_eq!(client.halt(), ("breakpoint".to_owned(), vec![3]));
    // The end of the session ends the run.
    client.close();
}
