//! paho, a client library of others, against the broker that the gateway talks to.

use super::common::{Board, has};
use super::{broker, free_port, gateway, mosquitto, python, upload};

/// Watches, orders, sets a variable by its name, and is away while things happen.
const CLIENT: &str = r#"
import json, sys, threading, time
import paho.mqtt.client as mqtt

port = int(sys.argv[1])
heard, news = [], threading.Condition()

def client(name, clean):
    # Its second version wants to be told whose callbacks these are.
    args = [mqtt.CallbackAPIVersion.VERSION2] if hasattr(mqtt, "CallbackAPIVersion") else []
    made = mqtt.Client(*args, client_id=name, clean_session=clean)
    def on_message(client, data, message):
        with news:
            heard.append((message.topic, message.payload.decode(), message.retain))
            news.notify_all()
    made.on_message = on_message
    made.connect("127.0.0.1", port)
    made.subscribe("pasapas/#", qos=1)
    made.loop_start()
    return made

def wait(what, fits):
    end, at = time.time() + 30, 0
    with news:
        while True:
            for message in heard[at:]:
                at += 1
                if fits(*message):
                    return message
            assert news.wait(end - time.time()) or time.time() < end, (what, heard)

def state(fits):
    def is_it(topic, text, retain):
        return topic == "pasapas/gateway/drill/state" and fits(json.loads(text))
    return is_it

def event(name, more=lambda event: True):
    def is_it(topic, text, retain):
        if topic != "pasapas/gateway/drill/event":
            return False
        told = json.loads(text)
        return told["event"] == name and more(told)
    return is_it

def order(by, **what):
    number = order.number = getattr(order, "number", 0) + 1
    by.publish("pasapas/gateway/drill/command", json.dumps({**what, "id": number}), qos=1)
    def is_reply(topic, text, retain):
        return topic == "pasapas/gateway/drill/reply" and json.loads(text).get("id") == number
    return json.loads(wait(what, is_reply)[1])

first = client("paho", False)
wait("online", lambda topic, text, retain: topic == "pasapas/gateway/status" and text == "online")
wait("a state", state(lambda told: told.get("state") == "ready" and "depth" in told.get("variables", {})))
assert order(first, do="set", variable="depth", value=2.5)["ok"]
wait("the variable", state(lambda told: told["variables"]["depth"] == 2.5))
reply = order(first, do="set", variable="width", value=1)
assert not reply["ok"] and "width" in reply["error"], reply
reply = order(first, do="set", register=3010, value=1)
assert not reply["ok"] and "does not allow" in reply["error"], reply
assert order(first, do="start")["ok"]
wait("its line", event("print", lambda told: told["text"] == "piece 1"))
wait("its end", event("end", lambda told: told["status"] == "done"))
wait("a KEEP", state(lambda told: told["variables"]["made"] == 1))
# It goes; another one starts the board twice; what happened waits for it at the broker.
first.disconnect()
first.loop_stop()
heard.clear()
second = client("other", True)
for piece in (2, 3):
    assert order(second, do="start")["ok"]
    wait("an end", event("end", lambda told: told["run"] == piece))
second.disconnect()
second.loop_stop()
heard.clear()
first = client("paho", False)
wait("the last end", event("end", lambda told: told["run"] == 3))
told = [json.loads(text) for topic, text, _ in heard if topic.endswith("/drill/event")]
new, newest = [], 0
for one in told:
    if one["id"] > newest:
        new.append((one["event"], one.get("text")))
        newest = one["id"]
wanted = []
for piece in (2, 3):
    wanted += [("start", None), ("print", f"piece {piece}"), ("end", None)]
assert new == wanted, new
# A fault has its line, though the program itself tells none.
assert order(first, do="set", variable="depth", value=0)["ok"]
assert order(first, do="start")["ok"]
fault = json.loads(wait("a fault", event("fault"))[1])
assert (fault["fault"], fault["line"], fault["run"]) == ("F13", 6, 4) and fault["text"], fault
# A state that is retained comes to whoever subscribes.
third = client("third", True)
wait("retained", lambda topic, text, retain: retain and topic == "pasapas/gateway/drill/state")
"#;

#[test]
fn paho_watches_orders_and_misses_nothing_while_it_is_away() {
    let Some(program) = mosquitto() else { return };
    if !has("python3", &["-c", "import paho.mqtt.client"]) {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let board = Board::start(&["--part", "f5529"]);
    upload(
        &board,
        "DIM depth AS LENGTH AT 3000\nKEEP made\nmade = made + 1\nPRINT \"piece \"; made\n\
         IF depth = 0mm THEN\n  WaitIn 5, RISE, 50ms\nEND IF\n",
    );
    let port = free_port();
    let _broker = broker(&program, folder.path(), port, "max_queued_messages 1000\n");
    let setting = format!(
        "broker = \"127.0.0.1:{port}\"\nwrite = [\"RUN_CONTROL\", \"registers 3000..3001\"]"
    );
    let _gateway = gateway(&board, &folder, &setting);
    python(CLIENT, &[&port.to_string()]);
}
