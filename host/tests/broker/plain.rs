//! State, events, orders, the will, and a broker that goes and comes back.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use rustix::process::Signal;

use super::common::{Board, end_of, signal};
use super::{Ear, PATIENCE, broker, free_port, gateway, mosquitto, publish, upload};

#[test]
fn state_events_orders_will_and_what_happened_while_the_broker_was_away() {
    let Some(program) = mosquitto() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let board = Board::start(&[]);
    upload(&board, "PRINT \"hello\"\nMoveAxe X, 1mm\n");
    let port = free_port();
    let mut first = broker(&program, folder.path(), port, "");
    let ear = Ear::new(port, "pasapas/#", &[]);
    let setting = format!(
        "broker = \"127.0.0.1:{port}\"\nwrite = [\"RUN_CONTROL\", \"coils 0..3\"]\nreplies = [\"my/\"]"
    );
    let mut gateway_process = gateway(&board, &folder, &setting);
    ear.wait("online", |topic, text| topic == "pasapas/gateway/status" && text == "online");
    let ready = |topic: &str, text: &str| {
        topic == "pasapas/gateway/drill/state" && text.contains("\"state\":\"ready\"")
    };
    ear.wait("ready", ready);
    // An order with a reply, and the events of the run.
    publish(port, "pasapas/gateway/drill/command", r#"{"do":"start","id":77,"reply":"my/reply"}"#);
    let replies = Ear::new(port, "my/reply", &[]);
    let begun = ear.event("start");
    assert_eq!(ear.event("print")["text"], "hello");
    let end = ear.event("end");
    assert_eq!((&end["status"], &begun["run"]), (&"done".into(), &end["run"]));
    assert!(end["id"].as_u64() > begun["id"].as_u64());
    // What is not allowed is not done, and told.
    publish(port, "pasapas/gateway/drill/command", r#"{"do":"set","output":5,"value":1,"id":5}"#);
    let refused =
        |topic: &str, text: &str| topic.ends_with("/drill/reply") && text.contains("\"id\":5");
    let (_, text) = ear.wait("refusal", refused);
    assert!(text.contains("\"ok\":false") && text.contains("does not allow"), "{text}");
    publish(
        port,
        "pasapas/gateway/drill/command",
        r#"{"do":"set","output":2,"value":1,"reply":"my/reply"}"#,
    );
    replies.wait("reply", |_, text| text.contains("\"ok\":true"));
    ear.wait("output 2", |topic, text| {
        topic.ends_with("/state") && text.contains("\"outputs\":[2]")
    });
    // The broker goes; the board runs meanwhile; a new broker that knows nothing hears of it.
    signal(&first.0, Signal::TERM);
    assert!(end_of(&mut first.0, PATIENCE).is_some());
    let start = Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .args([Path::new("start"), Path::new("--port"), &board.port()])
        .status();
    assert!(start.expect("it starts").success());
    std::thread::sleep(Duration::from_secs(1));
    let _second = broker(&program, folder.path(), port, "");
    // It comes back by itself within its rests, the subscriber too.
    let ear = Ear::new(port, "pasapas/#", &[]);
    let again = ear.event("end");
    assert!(again["id"].as_u64() > end["id"].as_u64(), "{again} behind {end}");
    assert_eq!(again["status"], "done");
    // The gateway is killed: its will is heard.
    gateway_process.0.kill().expect("it lives");
    ear.wait("will", |topic, text| topic == "pasapas/gateway/status" && text == "offline");
}
