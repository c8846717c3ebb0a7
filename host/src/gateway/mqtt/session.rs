//! The conversation with the broker, over any number of connections.
//!
//! Each connection begins with a new client of the library and without state of the one before: messages that the
//! broker has not acknowledged are in the outbox and are sent again from its head. The library's
//! loop has its own task, because a connection attempt that is cancelled never succeeds.

use std::collections::{BTreeSet, VecDeque};
use std::time::Duration;

use rumqttc::mqttbytes::QoS;
use rumqttc::{
    AsyncClient, AsyncClientBuilder, ConnectionError, Event, EventLoop, MqttOptions, Outgoing,
    Packet, PublishOptions, StateError, mqttbytes,
};
use serde_json::json;
use tokio::sync::mpsc::{self, Receiver, Sender, UnboundedReceiver};
use tokio::time::{Instant, sleep_until, timeout, timeout_at};

use super::report::Report;
use super::{MqttSetting, Note};
use crate::gateway::outbox::Outbox;

/// Messages that may be on their way at a time.
const WINDOW: usize = 32;
/// A broker that answers pings and acknowledges nothing is as good as none.
const ACK_TIME: Duration = Duration::from_secs(10);
/// A connection stands by then.
const CONNECT_TIME: Duration = Duration::from_secs(20);
/// Rest before the second try to connect; it doubles up to the longest.
const AGAIN: Duration = Duration::from_millis(100);
/// Longest rest.
const LONGEST: Duration = Duration::from_secs(15);
/// Time to say goodbye.
const GOODBYE: Duration = Duration::from_secs(1);
/// A packet larger than any order that ends two connections one after the other, each within this time
/// of its begin, is one that the broker keeps and gives to each new connection. One alone is somebody's
/// message, which the broker does not send again.
const KEPT_TIME: Duration = Duration::from_secs(5);
/// No orders are taken for so long behind such a one: events must not wait for whoever takes it away.
const DEAF_TIME: Duration = Duration::from_secs(60);
/// Replies to orders that may wait for the broker.
const MOST_REPLIES: usize = 256;

/// Why the conversation is over.
pub enum End {
    /// The gateway ends.
    Closed,
    /// The outbox cannot be written.
    Disk(std::io::Error),
}

/// Why a connection is over.
enum Over {
    Lost(String),
    /// A packet came that is larger than any order.
    Oversized(String),
    End(End),
}

impl From<std::io::Error> for Over {
    fn from(error: std::io::Error) -> Over {
        Over::End(End::Disk(error))
    }
}

/// Carries out an order for a board; the reply goes to the topic.
pub type Orders = Box<dyn Fn(usize, &[u8], String) + Send>;

/// A message that is told once and not kept.
struct Once {
    topic: String,
    text: String,
    retain: bool,
}

/// All that outlives a connection.
pub struct Session {
    options: MqttOptions,
    outbox: Outbox,
    boards: Vec<Report>,
    /// Boards whose state is to be told.
    dirty: BTreeSet<usize>,
    once: VecDeque<Once>,
    base: String,
    status: String,
    home_assistant: bool,
    /// Until then no orders are taken.
    deaf_until: Option<Instant>,
    /// The connection before ended by a packet that is larger than any order, soon after its begin.
    oversized: bool,
    /// What was said of the last lost connection.
    said: String,
}

/// What is on its way.
#[derive(Default)]
struct Flight {
    /// Given to the library, which has not told their packet's number yet; a letter's number.
    given: VecDeque<Option<u64>>,
    /// Sent: packet's number, letter's number, when.
    sent: VecDeque<(u16, Option<u64>, Instant)>,
    /// Letters that arrived before the one at the head.
    arrived: BTreeSet<u64>,
    /// Number of the newest letter that was given.
    newest: u64,
}

impl Flight {
    fn has_room(&self) -> bool {
        self.given.len() + self.sent.len() < WINDOW
    }
}

/// Runs the library's loop until it fails.
async fn poll(mut events: EventLoop, to: Sender<Result<Event, Over>>) {
    let why = |error: ConnectionError| {
        let words = error.to_string();
        match error {
            ConnectionError::MqttState(StateError::Deserialization(
                mqttbytes::Error::PayloadSizeLimitExceeded(_),
            )) => Over::Oversized(words),
            _ => Over::Lost(words),
        }
    };
    loop {
        let event = events.poll().await.map_err(why);
        let over = event.is_err();
        if to.send(event).await.is_err() || over {
            return;
        }
    }
}

impl Session {
    /// A conversation that has not begun.
    pub fn new(
        setting: &MqttSetting,
        options: MqttOptions,
        outbox: Outbox,
        boards: Vec<Report>,
    ) -> Session {
        Session {
            options,
            outbox,
            boards,
            dirty: BTreeSet::new(),
            once: VecDeque::new(),
            base: setting.base(),
            status: setting.status(),
            home_assistant: setting.home_assistant,
            deaf_until: None,
            oversized: false,
            said: String::new(),
        }
    }

    /// Messages that have not arrived.
    #[cfg(test)]
    pub fn waiting(&self) -> usize {
        self.outbox.len()
    }

    /// Talks until the gateway ends.
    pub async fn run(&mut self, mut notes: UnboundedReceiver<Note>, orders: Orders) -> End {
        let mut rest = AGAIN;
        loop {
            let (mut stood, begun) = (false, Instant::now());
            let why = match self.connection(&mut notes, &orders, &mut stood).await {
                Ok(never) => match never {},
                Err(Over::End(end)) => return end,
                Err(Over::Lost(why)) => why,
                Err(Over::Oversized(why)) if begun.elapsed() > KEPT_TIME => {
                    self.oversized = false;
                    why
                }
                Err(Over::Oversized(why)) if !std::mem::replace(&mut self.oversized, true) => why,
                Err(Over::Oversized(why)) => {
                    self.oversized = false;
                    self.deaf_until = Some(Instant::now() + DEAF_TIME);
                    format!("{why}: no orders are taken for {} s", DEAF_TIME.as_secs())
                }
            };
            if self.said != why {
                eprintln!("pasapas: MQTT: {why}");
                self.said = why;
            }
            rest = if stood { AGAIN } else { (2 * rest).min(LONGEST) };
            let until = Instant::now() + rest;
            // What happens meanwhile is kept.
            while let Ok(note) = timeout_at(until, notes.recv()).await {
                if let Err(Over::End(end)) = self.hear(note, &mut notes) {
                    return end;
                }
            }
        }
    }

    /// Takes a note and all that came with it; what must arrive is on disk behind this.
    fn hear(
        &mut self,
        note: Option<Note>,
        notes: &mut UnboundedReceiver<Note>,
    ) -> Result<(), Over> {
        let mut next = note.or(Some(Note::Close));
        while let Some(note) = next {
            match note {
                Note::Close => return Err(Over::End(End::Closed)),
                Note::Reply(topic, text) => {
                    if self.once.len() >= MOST_REPLIES {
                        self.once.pop_front();
                    }
                    self.once.push_back(Once { topic, text, retain: false });
                }
                Note::Look(board, look) => {
                    let (changed, events) = self.boards[board].hear(look);
                    if changed {
                        self.dirty.insert(board);
                    }
                    let topic = format!("{}/{}/event", self.base, self.boards[board].name);
                    for event in events {
                        self.keep(&topic, event)?;
                    }
                }
            }
            next = notes.try_recv().ok();
        }
        let dropped = self.outbox.take_dropped();
        if dropped > 0 {
            let topic = format!("{}/event", self.base);
            self.keep(&topic, json!({ "event": "dropped", "count": dropped }))?;
        }
        Ok(self.outbox.sync()?)
    }

    fn keep(&mut self, topic: &str, mut event: serde_json::Value) -> Result<(), Over> {
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
        event["ms"] = json!(now.map_or(0, |time| time.as_millis() as u64));
        Ok(self.outbox.push(topic, |id| {
            event["id"] = json!(id);
            event.to_string()
        })?)
    }

    async fn connection(
        &mut self,
        notes: &mut UnboundedReceiver<Note>,
        orders: &Orders,
        stood: &mut bool,
    ) -> Result<std::convert::Infallible, Over> {
        let (client, events) =
            AsyncClientBuilder::new(self.options.clone()).capacity(4 * WINDOW).build();
        let (to, mut from) = mpsc::channel(WINDOW);
        let mut tasks = tokio::task::JoinSet::new();
        // It ends with this connection.
        tasks.spawn(poll(events, to));
        let mut flight = Flight { newest: self.outbox.done(), ..Flight::default() };
        let begun = Instant::now();
        loop {
            if *stood {
                self.send(&client, &mut flight).map_err(Over::Lost)?;
            }
            let oldest = flight.sent.front().map(|(_, _, when)| *when + ACK_TIME);
            let limit = match *stood {
                false => begun + CONNECT_TIME,
                true => oldest.unwrap_or_else(|| Instant::now() + ACK_TIME),
            };
            tokio::select! {
                event = from.recv() => {
                    let ended = || Err(Over::Lost("the connection ended".to_owned()));
                    self.event(event.unwrap_or_else(ended)?, &client, &mut flight, orders, stood)?;
                }
                note = notes.recv() => {
                    if let Err(over) = self.hear(note, notes) {
                        if *stood {
                            self.goodbye(&client, &mut from, &mut flight).await;
                        }
                        return Err(over);
                    }
                }
                () = sleep_until(self.deaf_until.unwrap_or(begun)), if *stood && self.deaf_until.is_some() => {
                    self.deaf_until = None;
                    self.listen(&client)?;
                }
                () = sleep_until(limit), if !*stood || oldest.is_some() => {
                    let why = if *stood { "acknowledges nothing" } else { "does not answer" };
                    return Err(Over::Lost(format!("the broker {why}")));
                }
            }
        }
    }

    /// Gives the library what there is, as far as the window has room.
    fn send(&mut self, client: &AsyncClient, flight: &mut Flight) -> Result<(), String> {
        let publish = |topic: &str, text: &str, retain: bool| {
            let how = PublishOptions::at_least_once().retain(retain);
            client.try_publish(topic, text.to_owned(), how).map_err(|error| error.to_string())
        };
        while flight.has_room() {
            if let Some(once) = self.once.pop_front() {
                publish(&once.topic, &once.text, once.retain)?;
                flight.given.push_back(None);
            } else if let Some(board) = self.dirty.pop_first() {
                let report = &self.boards[board];
                publish(&format!("{}/{}/state", self.base, report.name), &report.state, true)?;
                flight.given.push_back(None);
            } else if let Some(letter) = self.outbox.behind(flight.newest) {
                publish(&letter.topic, &letter.text, false)?;
                flight.given.push_back(Some(letter.id));
                flight.newest = letter.id;
            } else {
                break;
            }
        }
        Ok(())
    }

    fn event(
        &mut self,
        event: Event,
        client: &AsyncClient,
        flight: &mut Flight,
        orders: &Orders,
        stood: &mut bool,
    ) -> Result<(), Over> {
        match event {
            Event::Incoming(Packet::ConnAck(_)) => {
                *stood = true;
                self.said.clear();
                self.welcome();
                if self.deaf_until.is_none() {
                    self.listen(client)?;
                }
            }
            // 0 is the number of what is not acknowledged.
            Event::Outgoing(Outgoing::Publish(number)) if number != 0 => {
                if let Some(letter) = flight.given.pop_front() {
                    flight.sent.push_back((number, letter, Instant::now()));
                }
            }
            Event::Incoming(Packet::PubAck(ack)) => {
                let place = flight.sent.iter().position(|(number, ..)| *number == ack.pkid);
                if let Some((_, Some(letter), _)) = place.and_then(|at| flight.sent.remove(at)) {
                    flight.arrived.insert(letter);
                }
                while let Some(head) = self.outbox.behind(self.outbox.done()).map(|one| one.id) {
                    if !flight.arrived.remove(&head) {
                        break;
                    }
                    self.outbox.arrived(head)?;
                }
            }
            Event::Incoming(Packet::Publish(message)) => self.order(&message, orders),
            _ => {}
        }
        Ok(())
    }

    /// Takes orders.
    fn listen(&self, client: &AsyncClient) -> Result<(), Over> {
        let filter = format!("{}/+/command", self.base);
        let asked = client.try_subscribe(filter, QoS::AtLeastOnce);
        asked.map_err(|error| Over::Lost(error.to_string()))
    }

    /// What a new connection is told first.
    fn welcome(&mut self) {
        let online = Once { topic: self.status.clone(), text: "online".into(), retain: true };
        self.once.push_front(online);
        self.dirty = (0..self.boards.len()).collect();
        if self.home_assistant {
            for report in &self.boards {
                let (topic, text) = discovery(&self.base, &self.status, &report.name);
                self.once.push_back(Once { topic, text, retain: true });
            }
        }
    }

    fn order(&self, message: &rumqttc::Publish, orders: &Orders) {
        let topic = String::from_utf8_lossy(&message.topic);
        let own = topic.strip_prefix(&self.base).and_then(|rest| rest.strip_prefix('/'));
        let Some(name) = own.and_then(|rest| rest.strip_suffix("/command")) else { return };
        // One that the broker kept may be days old: nothing starts by it.
        if message.retain {
            return;
        }
        if let Some(board) = self.boards.iter().position(|report| report.name == name) {
            orders(board, &message.payload, format!("{}/{name}/reply", self.base));
        }
    }

    /// Says that the gateway goes; what has not arrived is told by the next one.
    async fn goodbye(
        &mut self,
        client: &AsyncClient,
        from: &mut Receiver<Result<Event, Over>>,
        flight: &mut Flight,
    ) {
        let how = PublishOptions::at_least_once().retained();
        if client.try_publish(self.status.as_str(), "offline", how).is_err() {
            return;
        }
        flight.given.push_back(None);
        let nobody: Orders = Box::new(|_, _, _| {});
        let all = async {
            while !(flight.given.is_empty() && flight.sent.is_empty()) {
                let Some(Ok(event)) = from.recv().await else { return };
                if self.event(event, client, flight, &nobody, &mut true).is_err() {
                    return;
                }
            }
            if client.disconnect().await.is_ok() {
                while let Some(Ok(_)) = from.recv().await {}
            }
        };
        let _ = timeout(GOODBYE, all).await;
    }
}

/// What Home Assistant wants to know of a board (MQTT discovery: a sensor by its configuration).
fn discovery(base: &str, status: &str, board: &str) -> (String, String) {
    let id = format!("pasapas_{}_{board}", base.replace(['/', '.'], "_"));
    let config = json!({
        "name": "State",
        "unique_id": format!("{id}_state"),
        "state_topic": format!("{base}/{board}/state"),
        "value_template": "{{ value_json.state | default(value_json.health) }}",
        "json_attributes_topic": format!("{base}/{board}/state"),
        "availability_topic": status,
        "device": { "identifiers": [id], "name": board, "manufacturer": "Pasapas" },
    });
    (format!("homeassistant/sensor/{id}/config"), config.to_string())
}
