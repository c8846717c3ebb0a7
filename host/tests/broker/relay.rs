//! A witness between the gateway and its broker: passes bytes on and reads which messages the broker acknowledged.
//!
//! Frames are those of MQTT 3.1.1 (OASIS, 2.2 and 3.3): a byte of type and flags, a length of up to four bytes, and
//! a PUBLISH of QoS 1 has its topic and its packet's number in front of its text.

use std::collections::{BTreeSet, HashMap};
use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::{Arc, Mutex};

const PUBLISH: u8 = 3;
const PUBACK: u8 = 4;

/// Numbers (`id`) of the events that the broker acknowledged.
pub type Acknowledged = Arc<Mutex<BTreeSet<u64>>>;

/// Takes what comes to `port` to the broker at `to`.
pub fn relay(port: u16, to: u16) -> Acknowledged {
    let acknowledged = Acknowledged::default();
    let listener = TcpListener::bind(("127.0.0.1", port)).expect("a port");
    let all = acknowledged.clone();
    std::thread::spawn(move || {
        for client in listener.incoming().map_while(Result::ok) {
            // A broker that is away: the client sees its connection close.
            let Ok(broker) = TcpStream::connect(("127.0.0.1", to)) else { continue };
            let given = Arc::new(Mutex::new(HashMap::new()));
            let (ours, theirs) =
                (client.try_clone().expect("a socket"), broker.try_clone().expect("a socket"));
            let (published, answered, all) = (given.clone(), given, all.clone());
            std::thread::spawn(move || {
                pass(ours, broker, |kind, body| {
                    if let (PUBLISH, Some((number, id))) = (kind >> 4, event(body)) {
                        published.lock().expect("whole").insert(number, id);
                    }
                });
            });
            std::thread::spawn(move || {
                pass(theirs, client, |kind, body| {
                    let &[high, low, ..] = body else { return };
                    let number = u16::from_be_bytes([high, low]);
                    if kind >> 4 == PUBACK
                        && let Some(id) = answered.lock().expect("whole").remove(&number)
                    {
                        all.lock().expect("whole").insert(id);
                    }
                });
            });
        }
    });
    acknowledged
}

/// Packet's number and `id` of an event.
fn event(body: &[u8]) -> Option<(u16, u64)> {
    let (&[high, low], rest) = body.split_first_chunk()?;
    let (_, rest) = rest.split_at_checked(u16::from_be_bytes([high, low]).into())?;
    let (&number, text) = rest.split_first_chunk()?;
    let event: serde_json::Value = serde_json::from_slice(text).ok()?;
    Some((u16::from_be_bytes(number), event["id"].as_u64()?))
}

/// Passes bytes on until one side is gone; each whole frame is shown before its last bytes go on.
fn pass(mut from: TcpStream, mut to: TcpStream, mut seen: impl FnMut(u8, &[u8])) {
    let (mut frames, mut piece) = (Vec::new(), [0; 4096]);
    while let Ok(length @ 1..) = from.read(&mut piece) {
        frames.extend_from_slice(&piece[..length]);
        while let Some((head, body)) = frame(&frames) {
            seen(frames[0], &frames[head..head + body]);
            frames.drain(..head + body);
        }
        if to.write_all(&piece[..length]).is_err() {
            break;
        }
    }
    let _ = (from.shutdown(Shutdown::Both), to.shutdown(Shutdown::Both));
}

/// Bytes of the head and of the body of the frame in front, when it is whole.
fn frame(bytes: &[u8]) -> Option<(usize, usize)> {
    let mut body = 0;
    for (n, byte) in bytes.get(1..)?.iter().take(4).enumerate() {
        body |= usize::from(byte & 0x7F) << (7 * n);
        if byte & 0x80 == 0 {
            return (bytes.len() >= n + 2 + body).then_some((n + 2, body));
        }
    }
    None
}
