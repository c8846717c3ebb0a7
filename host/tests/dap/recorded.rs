//! A recorded session of another debugger: the test client that the protocol's authors publish
//! (`@vscode/debugadapter-testsupport`), whose questions are asked again as they were.

use std::io::Write;
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::Value;

use crate::client::listen;
use crate::simulator::{DRILL, script};

/// What was said, a line each: `to` the adapter and `from` it, with PROGRAM for the script's path.
const SESSION: &str = include_str!("session.jsonl");

#[test]
fn another_debuggers_session_goes_as_it_went() {
    let (_folder, file) = script(DRILL);
    let mut adapter = Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .arg("dap")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut to = adapter.stdin.take().expect("an input");
    let heard = listen(adapter.stdout.take().expect("an output"));
    let (mut asked, mut answered) = (0, 0);
    for line in SESSION.lines() {
        let path = serde_json::to_string(&file).expect("JSON");
        let line = line.replace("PROGRAM", path.trim_matches('"'));
        let said: Value = serde_json::from_str(&line).expect("JSON");
        if said["to"].is_object() {
            let text = said["to"].to_string();
            write!(to, "Content-Length: {}\r\n\r\n{text}", text.len()).expect("it takes it");
            asked += 1;
            continue;
        }
        let now = heard.recv_timeout(Duration::from_secs(60)).expect("a message");
        let then = &said["from"];
        answered += 1;
        if then["command"] == "initialize" {
            // More may be offered by now, but nothing less.
            for (name, value) in then["body"].as_object().expect("capabilities") {
                assert_eq!(&now["body"][name], value, "{name}");
            }
        } else {
            assert_eq!(&now, then);
        }
    }
    assert!(asked >= 15 && answered >= 20, "{asked} asked, {answered} answered");
    drop(to);
    assert!(adapter.wait().expect("an end").success());
}
