//! What others at the broker send that they should not: the gateway stays small and goes on.

use std::time::Duration;

use super::common::{Board, has, memory, pasapas, text};
use super::{Ear, broker, free_port, gateway, mosquitto, publish, python, upload};

/// KB by which the gateway may grow.
const MOST_GROWTH: u64 = 16 << 10;

/// Topics of 60 KB, orders of 4 KB to 1 MB, once and retained, thousands of them at once.
const RUDE: &str = r#"
import random, sys
import paho.mqtt.client as mqtt

args = [mqtt.CallbackAPIVersion.VERSION2] if hasattr(mqtt, "CallbackAPIVersion") else []
client = mqtt.Client(*args)
client.max_inflight_messages_set(0)
client.connect("127.0.0.1", int(sys.argv[1]))
client.loop_start()
def send(topic, text, retain=False):
    client.publish(topic, text, qos=1, retain=retain).wait_for_publish(20)
base = "pasapas/gateway/"
send(base + "x" * 60000 + "/command", "start")
for size in (4_000, 60_000, 250_000, 300_000, 1_000_000):
    send(base + "drill/command", "x" * size)
    send(base + "drill/command", '{"do":"set","reply":"' + "y" * size + '","value":1,"output":1}')
for _ in range(5000):
    client.publish(base + "drill/command", random.choice([b"", b"{", b"jump", random.randbytes(50)]), qos=1)
send(base + "nobody/command", "z" * 1_000_000, True)
send(base + "drill/command", "z" * 1_000_000, True)
"#;

#[test]
fn oversized_topics_and_orders_harm_nobody() {
    let Some(program) = mosquitto() else { return };
    if !has("python3", &["-c", "import paho.mqtt.client"]) {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let board = Board::start(&[]);
    upload(&board, "MoveAxe X, 1mm\n");
    let port = free_port();
    let _broker = broker(&program, folder.path(), port, "max_queued_messages 100000\n");
    let setting = format!("broker = \"127.0.0.1:{port}\"\nwrite = [\"RUN_CONTROL\"]");
    let gateway_process = gateway(&board, &folder, &setting);
    let state = Ear::new(port, "pasapas/gateway/drill/state", &[]);
    state.wait("ready", |_, text| text.contains("\"state\":\"ready\""));
    let ear = Ear::new(port, "pasapas/gateway/drill/event", &[]);
    let before = memory(gateway_process.0.id());
    python(RUDE, &[&port.to_string()]);
    // The run that the board begins by itself is told as ever.
    let (code, said) = pasapas(&["start", "--port", text(&board.port())]);
    assert_eq!(code, 0, "{said}");
    ear.event("start");
    ear.event("end");
    // One that the broker keeps would end each connection: orders are let be, states and events go on.
    let connections = Ear::new(port, "pasapas/gateway/status", &[]);
    connections.wait("online", |_, text| text == "online");
    std::thread::sleep(Duration::from_secs(3));
    let lost = connections.heard.try_iter().filter(|(_, text)| text == "offline").count();
    assert_eq!(lost, 0, "the connection breaks again and again");
    let grown = memory(gateway_process.0.id()).saturating_sub(before);
    println!("grown by {grown} KB");
    assert!(grown < MOST_GROWTH, "{grown} KB more");
}

/// One large message, not kept, soon after the connection's begin: it ends the connection, and the
/// next one takes orders at once.
#[test]
fn one_large_message_does_not_silence_the_orders() {
    let Some(program) = mosquitto() else { return };
    if !has("python3", &["-c", "import paho.mqtt.client"]) {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let board = Board::start(&[]);
    let port = free_port();
    let _broker = broker(&program, folder.path(), port, "");
    let setting = format!("broker = \"127.0.0.1:{port}\"\nwrite = [\"RUN_CONTROL\"]");
    let _gateway = gateway(&board, &folder, &setting);
    let state = Ear::new(port, "pasapas/gateway/drill/state", &[]);
    state.wait("a state", |_, text| text.contains("\"state\""));
    let replies = Ear::new(port, "pasapas/gateway/drill/reply", &[]);
    let large = RUDE.split("base =").next().unwrap_or_default().to_owned()
        + "send(\"pasapas/gateway/drill/command\", \"y\" * 300_000)\n";
    python(&large, &[&port.to_string()]);
    let begun = std::time::Instant::now();
    // Within the first tries to connect again one is heard.
    let heard = (0..20).any(|id| {
        let order = format!(r#"{{"do":"stop","id":{id}}}"#);
        publish(port, "pasapas/gateway/drill/command", &order);
        std::thread::sleep(Duration::from_millis(500));
        replies.heard.try_iter().count() > 0
    });
    assert!(heard, "no order was heard for {} s", begun.elapsed().as_secs());
}
