//! A broker that is killed again and again while a board prints, then the gateway itself.

use std::path::Path;
use std::time::Duration;

use super::common::{Board, pasapas, text};
use super::relay::relay;
use super::{Ear, PATIENCE, broker, free_port, gateway, mosquitto, upload};

/// How often the broker is killed.
const KILLS: usize = 10;

#[test]
fn nothing_is_lost_when_the_broker_is_killed_and_a_board_outlives_the_gateway() {
    let Some(program) = mosquitto() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let board = Board::start(&[]);
    upload(&board, "DIM n\nFOR n = 1 TO 30000\n  PRINT n\n  Wait 40ms\nNEXT\n");
    let port = free_port();
    // The broker keeps what it has acknowledged, but for what came since its loop last wrote its file: mosquitto
    // acknowledges first. What is missing must be of that kind, which a witness between the two tells.
    let more = format!(
        "persistence true\npersistence_location {}/\nautosave_interval 1\n\
         autosave_on_changes true\nmax_queued_messages 100000\n",
        text(folder.path())
    );
    let start = || broker(&program, folder.path(), port, &more);
    let mut process = start();
    // It comes back by itself; what it missed waits at the broker.
    let ear = Ear::new(port, "pasapas/gateway/drill/event", &["-c", "-i", "ear"]);
    let between = free_port();
    let acknowledged = relay(between, port);
    let mut gateway_process =
        gateway(&board, &folder, &format!("broker = \"127.0.0.1:{between}\""));
    std::thread::sleep(Duration::from_secs(1));
    let (code, said) = pasapas(&["start", "--port", text(&board.port())]);
    assert_eq!(code, 0, "{said}");
    ear.event("start");
    for n in 0..KILLS {
        std::thread::sleep(Duration::from_millis(100 + 37 * n as u64));
        process.0.kill().expect("it lives");
        process.0.wait().expect("it ends");
        std::thread::sleep(Duration::from_millis(20 * n as u64));
        process = start();
    }
    // All that the board printed so far, and some of what it prints behind the last kill.
    let (mut newest, mut printed, mut doubled, mut forgotten) = (None, 0, 0, 0);
    let begun = std::time::Instant::now();
    let wanted = 25 * KILLS as u64;
    while printed < wanted {
        assert!(begun.elapsed() < PATIENCE, "{printed} of {wanted} lines came");
        let (_, said) = ear.wait("event", |_, _| true);
        let event: serde_json::Value = serde_json::from_str(&said).expect("JSON");
        let id = event["id"].as_u64().expect("a number");
        if newest.is_some_and(|newest| id <= newest) {
            doubled += 1;
            continue;
        }
        for missing in newest.map_or(id, |newest| newest + 1)..id {
            let known = acknowledged.lock().expect("whole").contains(&missing);
            assert!(known, "{missing} was never acknowledged, and {id} follows {newest:?}");
            forgotten += 1;
            printed += 1;
        }
        newest = Some(id);
        if event["event"] == "print" {
            printed += 1;
            assert_eq!(event["text"], printed.to_string(), "in its order");
        }
    }
    println!(
        "{printed} lines over {KILLS} kills, {doubled} came twice, the broker forgot {forgotten}"
    );
    assert!(forgotten <= KILLS, "the broker forgot {forgotten}");
    // The gateway is killed: the board runs on.
    gateway_process.0.kill().expect("it lives");
    gateway_process.0.wait().expect("it ends");
    std::thread::sleep(Duration::from_millis(500));
    let (code, said) = pasapas(&["status", "--format", "json", "--port", text(&board.port())]);
    assert_eq!(code, 0, "{said}");
    let status: serde_json::Value = serde_json::from_str(&said).expect("JSON");
    assert_eq!(status["state"], "running", "{said}");
    assert!(Path::new(&board.port()).exists());
}
