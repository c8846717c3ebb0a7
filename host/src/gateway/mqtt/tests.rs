//! The conversation with a broker that records what arrives, forgets every session, withholds
//! acknowledgements and cuts the connection anywhere.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use emulator::Rng;
use tokio::sync::mpsc::unbounded_channel;

use super::report::Report;
use super::session::Session;
use super::{MqttSetting, Note};
use crate::gateway::line::Look;
use crate::gateway::outbox::Outbox;

/// Messages of the long test.
const MESSAGES: u64 = 3_000;
/// Breaks in it.
const BREAKS: usize = 50;

/// What came: topic, text, retained.
type Record = Arc<Mutex<Vec<(String, String, bool)>>>;

/// One packet: its first byte and what follows its length (MQTT 3.1.1, 2.2).
fn packet(stream: &mut TcpStream) -> Option<(u8, Vec<u8>)> {
    let mut byte = || {
        let mut one = [0];
        stream.read_exact(&mut one).ok().map(|()| one[0])
    };
    let first = byte()?;
    let mut length = 0;
    for shift in [0, 7, 14, 21] {
        let part = byte()?;
        length |= usize::from(part & 0x7F) << shift;
        if part & 0x80 == 0 {
            break;
        }
    }
    let mut body = vec![0; length];
    stream.read_exact(&mut body).ok()?;
    Some((first, body))
}

/// Serves a connection; `stop_at`: so many messages are acknowledged, a few more are taken and not,
/// then the connection is cut.
fn serve(stream: &mut TcpStream, record: &Record, stop_at: usize, withheld: usize) -> Option<()> {
    let mut messages = 0;
    loop {
        let (first, body) = packet(stream)?;
        match first >> 4 {
            // CONNECT: no session is there, ever.
            1 => stream.write_all(&[0x20, 2, 0, 0]).ok()?,
            3 => {
                let topic_length = usize::from(u16::from_be_bytes([body[0], body[1]]));
                let topic = String::from_utf8_lossy(&body[2..2 + topic_length]).into_owned();
                let number = &body[2 + topic_length..4 + topic_length];
                let text = String::from_utf8_lossy(&body[4 + topic_length..]).into_owned();
                record.lock().expect("whole").push((topic, text, first & 1 != 0));
                messages += 1;
                if messages <= stop_at {
                    stream.write_all(&[0x40, 2, number[0], number[1]]).ok()?;
                } else if messages > stop_at + withheld {
                    return None;
                }
            }
            8 => stream.write_all(&[0x90, 3, body[0], body[1], 1]).ok()?,
            12 => stream.write_all(&[0xD0, 0]).ok()?,
            14 => return None,
            _ => {}
        }
    }
}

fn setting(broker: String, folder: &std::path::Path) -> MqttSetting {
    let path = folder.join("outbox");
    let text = format!("broker = \"{broker}\"\noutbox = {path:?}\nhome_assistant = true\n");
    toml::from_str(&text).expect("a setting")
}

/// Runs a conversation in a thread of its own until a note closes it.
fn converse(
    setting: &MqttSetting,
) -> (tokio::sync::mpsc::UnboundedSender<Note>, std::thread::JoinHandle<usize>) {
    let (notes, heard) = unbounded_channel();
    let options = setting.options().expect("options");
    let outbox = Outbox::open(&setting.outbox, setting.keep).expect("an outbox");
    let mut session = Session::new(setting, options, outbox, vec![Report::new("drill")]);
    let thread = std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        let runtime = runtime.expect("a runtime");
        runtime.block_on(session.run(heard, Box::new(|_, _, _| {})));
        session.waiting()
    });
    (notes, thread)
}

/// Numbers of the events in the order in which they came.
fn ids(record: &Record) -> Vec<u64> {
    let record = record.lock().expect("whole");
    let events = record.iter().filter(|(topic, ..)| topic.ends_with("/event"));
    events
        .map(|(_, text, _)| {
            let event: serde_json::Value = serde_json::from_str(text).expect("JSON");
            event["id"].as_u64().expect("a number")
        })
        .collect()
}

#[test]
fn no_event_is_lost_or_out_of_order_over_fifty_breaks() {
    let folder = tempfile::tempdir().expect("a folder");
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener.local_addr().expect("a port").port();
    let record: Record = Arc::default();
    let own = record.clone();
    std::thread::spawn(move || {
        let mut rng = Rng::new(20_261_122);
        let mut listener = listener;
        for connection in 1.. {
            let Ok((mut stream, _)) = listener.accept() else { continue };
            // Some are cut before anything is acknowledged, the last one stays.
            let all = if connection > BREAKS { usize::MAX / 2 } else { rng.below(90) as usize };
            // Fewer than the window, but for one broker that acknowledges nothing and cuts nothing.
            let withheld = if connection == BREAKS / 2 { 1_000 } else { rng.below(30) as usize };
            let _ = serve(&mut stream, &own, all, withheld);
            // Every other one is killed and is gone for a while, the others cut the line alone.
            if connection % 2 == 0 {
                drop((stream, listener));
                std::thread::sleep(Duration::from_millis(rng.below(80)));
                listener = TcpListener::bind(("127.0.0.1", port)).expect("the port again");
            }
        }
    });
    let setting = setting(format!("127.0.0.1:{port}"), folder.path());
    let (notes, thread) = converse(&setting);
    for n in 0..MESSAGES {
        notes.send(Note::Look(0, Look::Print(format!("line {n}")))).expect("it hears");
        notes.send(Note::Look(0, Look::Silent)).expect("it hears");
        if n % 10 == 0 {
            std::thread::sleep(Duration::from_millis(10));
        }
    }
    let begun = Instant::now();
    while ids(&record).last() != Some(&MESSAGES) {
        assert!(begun.elapsed() < Duration::from_secs(60), "{:?}", ids(&record).last());
        std::thread::sleep(Duration::from_millis(50));
    }
    notes.send(Note::Close).expect("it hears");
    assert_eq!(thread.join().expect("it ends"), 0, "all arrived");
    // What a receiver has that drops by number: everything, in order.
    let mut newest = 0;
    let mut doubled = 0;
    for id in ids(&record) {
        if id <= newest {
            doubled += 1;
            continue;
        }
        assert_eq!(id, newest + 1, "{newest} is followed by {id}");
        newest = id;
    }
    assert!(doubled > 0, "no acknowledgement was withheld");
    let record = record.lock().expect("whole");
    let status: Vec<_> =
        record.iter().filter(|(topic, ..)| topic == "pasapas/gateway/status").collect();
    assert!(status.len() > BREAKS && status.iter().all(|(.., retained)| *retained));
    assert_eq!(status.last().map(|(_, text, _)| text.as_str()), Some("offline"));
    assert!(record.iter().any(|(topic, ..)| topic.starts_with("homeassistant/sensor/")));
}

#[test]
fn what_waits_when_the_gateway_ends_is_told_by_the_next_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener.local_addr().expect("a port").port();
    // Nobody accepts: a broker that hangs.
    let setting = setting(format!("127.0.0.1:{port}"), folder.path());
    let (notes, thread) = converse(&setting);
    for n in 0..20 {
        notes.send(Note::Look(0, Look::Print(format!("line {n}")))).expect("it hears");
        notes.send(Note::Look(0, Look::Silent)).expect("it hears");
    }
    notes.send(Note::Close).expect("it hears");
    assert_eq!(thread.join().expect("it ends"), 20);
    let record: Record = Arc::default();
    let own = record.clone();
    std::thread::spawn(move || {
        for mut stream in listener.incoming().flatten() {
            let _ = serve(&mut stream, &own, usize::MAX / 2, 0);
        }
    });
    let (notes, thread) = converse(&setting);
    let begun = Instant::now();
    while ids(&record).len() < 20 {
        assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", ids(&record));
        std::thread::sleep(Duration::from_millis(20));
    }
    notes.send(Note::Close).expect("it hears");
    assert_eq!(thread.join().expect("it ends"), 0);
    assert_eq!(ids(&record), (1..=20).collect::<Vec<u64>>());
}
