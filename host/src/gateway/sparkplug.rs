//! Sparkplug B 3.0: the gateway as an edge node, each board a device.
//!
//! `payload` is the protocol buffer, `node` the state machine with the rules, `metrics` the values of a board.
//! The thread here talks to the broker, by the connection that `[mqtt]` describes.

mod metrics;
mod node;
mod payload;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use prost::Message as _;
use rumqttc::mqttbytes::QoS;
use rumqttc::{
    AsyncClient, AsyncClientBuilder, Event, EventLoop, LastWill, MqttOptions, Packet,
    PublishOptions,
};
use serde::Deserialize;
use tokio::sync::mpsc::{self, Sender, UnboundedReceiver, UnboundedSender};
use tokio::time::{Instant, timeout, timeout_at};

use super::Gateway;
use super::line::Look;
use super::mqtt::{MqttSetting, Note, carry_out};
use node::{Asked, Node, Publish};
use payload::Metric;

/// Rest before the second try to connect; it doubles up to the longest.
const AGAIN: Duration = Duration::from_millis(100);
/// Longest rest.
const LONGEST: Duration = Duration::from_secs(15);
/// The broker takes a message by then.
const TAKE_TIME: Duration = Duration::from_secs(10);
/// Time to say goodbye.
const GOODBYE: Duration = Duration::from_secs(1);
/// A connection stands by then.
const CONNECT_TIME: Duration = Duration::from_secs(20);
/// Packets that wait between us and the library.
const ROOM: usize = 128;

/// `[sparkplug]`
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SparkplugSetting {
    /// Group of the node.
    pub group: String,
    /// Name of the node; that of `[mqtt]` without it.
    pub node: Option<String>,
    /// Births wait for this host application, and data is kept while it is away.
    pub primary_host: Option<String>,
}

impl SparkplugSetting {
    /// What is wrong with it, in words.
    ///
    /// # Errors
    /// A name has a sign that topics do not take.
    pub fn check(&self) -> Result<(), String> {
        let names = [Some(&self.group), self.node.as_ref(), self.primary_host.as_ref()];
        for name in names.into_iter().flatten() {
            if name.is_empty() || name.len() > 64 || name.contains(['+', '/', '#']) {
                return Err(format!("`{name}` is no name: 1 to 64 signs without + / #"));
            }
        }
        Ok(())
    }
}

/// The conversation; it ends with this.
pub struct Sparkplug {
    notes: UnboundedSender<Note>,
    thread: Option<JoinHandle<()>>,
}

/// Milliseconds since 1970.
fn now() -> u64 {
    let time = SystemTime::now().duration_since(UNIX_EPOCH);
    time.map_or(0, |time| u64::try_from(time.as_millis()).unwrap_or(u64::MAX))
}

/// Why a connection is over.
enum Over {
    Lost(String),
    /// The primary host is gone: come back at once, and wait for it.
    HostGone,
    Closed,
}

/// Carries out an order for a board.
type Orders = Box<dyn Fn(usize, &[u8]) + Send>;

struct Session {
    options: MqttOptions,
    node: Node,
    /// The newest picture's metrics need the newest printed line.
    printed: Vec<String>,
    orders: Orders,
    said: String,
}

/// Runs the library's loop until it fails; what we send ourselves tells us nothing.
async fn poll(mut events: EventLoop, to: Sender<Result<Packet, String>>) {
    loop {
        let packet = match events.poll().await {
            Ok(Event::Incoming(packet)) => Ok(packet),
            Ok(Event::Outgoing(_)) => continue,
            Err(error) => Err(error.to_string()),
        };
        let over = packet.is_err();
        if to.send(packet).await.is_err() || over {
            return;
        }
    }
}

impl Session {
    async fn run(&mut self, mut notes: UnboundedReceiver<Note>) {
        let mut rest = AGAIN;
        loop {
            let (mut stood, begun) = (false, Instant::now());
            let over = self.connection(&mut notes, &mut stood).await;
            let host_gone = matches!(over, Over::HostGone);
            match over {
                Over::Closed => return,
                Over::HostGone => {}
                Over::Lost(why) if self.said != why => {
                    eprintln!("pasapas: Sparkplug: {why}");
                    self.said = why;
                }
                Over::Lost(_) => {}
            }
            self.node.leave();
            // What the broker keeps for us may end each connection: it is not asked for all the time.
            stood &= begun.elapsed() > LONGEST || host_gone;
            rest = if stood { AGAIN } else { (2 * rest).min(LONGEST) };
            let until = Instant::now() + rest;
            while let Ok(note) = timeout_at(until, notes.recv()).await {
                if self.hear(note).is_none() {
                    return;
                }
            }
        }
    }

    /// What a note makes to be published; none at the end.
    fn hear(&mut self, note: Option<Note>) -> Option<Vec<Publish>> {
        match note {
            None | Some(Note::Close) => None,
            Some(Note::Reply(..)) => Some(Vec::new()),
            Some(Note::Look(board, look)) => {
                let metrics: Option<Vec<Metric>> = match look {
                    Look::Silent => None,
                    Look::Picture(seen) => Some(metrics::of(&seen, &self.printed[board])),
                    Look::Print(text) => {
                        // It shows with the next picture.
                        self.printed[board] = text;
                        return Some(Vec::new());
                    }
                };
                Some(self.node.device(board, metrics, now()))
            }
        }
    }

    async fn connection(&mut self, notes: &mut UnboundedReceiver<Note>, stood: &mut bool) -> Over {
        let death = self.node.connect(now());
        let mut options = self.options.clone();
        let bytes = death.payload.encode_to_vec();
        options.set_last_will(LastWill::new(death.topic, bytes, QoS::AtLeastOnce, false));
        let (client, events) = AsyncClientBuilder::new(options).capacity(ROOM).build();
        let (to, mut from) = mpsc::channel(ROOM);
        let mut tasks = tokio::task::JoinSet::new();
        tasks.spawn(poll(events, to));
        let limit = Instant::now() + CONNECT_TIME;
        let mut subscribed = 0;
        loop {
            tokio::select! {
                packet = from.recv() => {
                    let packet = match packet {
                        Some(Ok(packet)) => packet,
                        Some(Err(why)) => return Over::Lost(why),
                        None => return Over::Lost("the connection ended".to_owned()),
                    };
                    let told = match packet {
                        Packet::ConnAck(_) => {
                            *stood = true;
                            self.said.clear();
                            for filter in self.node.filters() {
                                if let Err(error) = client.subscribe(filter, QoS::AtLeastOnce).await {
                                    return Over::Lost(error.to_string());
                                }
                            }
                            Vec::new()
                        }
                        Packet::SubAck(_) => {
                            subscribed += 1;
                            let all = subscribed == self.node.filters().len();
                            if all && self.node.is_free() { self.node.birth(now()) } else { Vec::new() }
                        }
                        Packet::Publish(message) => {
                            let topic = String::from_utf8_lossy(&message.topic).into_owned();
                            match self.message(&topic, &message.payload) {
                                Some(told) => told,
                                None => {
                                    self.goodbye(&client, &mut from).await;
                                    return Over::HostGone;
                                }
                            }
                        }
                        _ => Vec::new(),
                    };
                    if let Err(why) = publish(&client, told).await {
                        return Over::Lost(why);
                    }
                }
                note = notes.recv() => {
                    let Some(told) = self.hear(note) else {
                        self.goodbye(&client, &mut from).await;
                        return Over::Closed;
                    };
                    if let Err(why) = publish(&client, told).await {
                        return Over::Lost(why);
                    }
                }
                () = tokio::time::sleep_until(limit), if !*stood => {
                    return Over::Lost("the broker does not answer".to_owned());
                }
            }
        }
    }

    /// What a message of a host makes to be published; none when the primary host is gone.
    fn message(&mut self, topic: &str, payload: &[u8]) -> Option<Vec<Publish>> {
        let mut told = Vec::new();
        for asked in self.node.hear(topic, payload) {
            match asked {
                Asked::HostUp => told.extend(self.node.birth(now())),
                Asked::Rebirth if self.node.is_born() => told.extend(self.node.birth(now())),
                Asked::HostDown => return None,
                Asked::Write(board, name, value) => {
                    if let Some(order) = metrics::order(&name, &value) {
                        (self.orders)(board, order.as_bytes());
                    }
                }
                Asked::Rebirth | Asked::Nothing => {}
            }
        }
        Some(told)
    }

    /// The death that the will would tell, and the end of the connection.
    async fn goodbye(
        &mut self,
        client: &AsyncClient,
        from: &mut mpsc::Receiver<Result<Packet, String>>,
    ) {
        let Publish { topic, payload } = self.node.death(now());
        let all = async {
            let bytes = payload.encode_to_vec();
            let sent = client.publish(topic, bytes, PublishOptions::at_least_once()).await;
            if sent.is_ok() && client.disconnect().await.is_ok() {
                while let Some(Ok(_)) = from.recv().await {}
            }
        };
        let _ = timeout(GOODBYE, all).await;
    }
}

async fn publish(client: &AsyncClient, told: Vec<Publish>) -> Result<(), String> {
    for Publish { topic, payload } in told {
        let sent = client.publish(topic, payload.encode_to_vec(), PublishOptions::at_most_once());
        // A broker that takes nothing, while what it says waits for us.
        let sent =
            timeout(TAKE_TIME, sent).await.map_err(|_| "the broker takes nothing".to_owned())?;
        sent.map_err(|error| error.to_string())?;
    }
    Ok(())
}

impl Sparkplug {
    /// Starts the conversation.
    ///
    /// # Errors
    /// A file of the connection cannot be read; in words.
    pub fn start(
        setting: &SparkplugSetting,
        mqtt: &MqttSetting,
        gateway: &Arc<Gateway>,
        (notes, heard): (UnboundedSender<Note>, UnboundedReceiver<Note>),
    ) -> Result<Sparkplug, String> {
        let mut options = mqtt.options()?;
        let name = setting.node.as_ref().unwrap_or(&mqtt.name);
        options.set_client_id(format!("pasapas-{}-sparkplug-{name}", mqtt.name));
        let boards = &gateway.names;
        let node = Node::new(&setting.group, name, setting.primary_host.as_deref(), boards);
        let (own, weak) = (notes.clone(), Arc::downgrade(gateway));
        let orders = Box::new(move |board: usize, text: &[u8]| {
            if let Some(gateway) = weak.upgrade() {
                // A host sees what came of it in the data.
                carry_out(&gateway, board, text, (String::new(), &[]), &own);
            }
        });
        let printed = vec![String::new(); boards.len()];
        let mut session = Session { options, node, printed, orders, said: String::new() };
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(|error| error.to_string())?;
        let thread = std::thread::spawn(move || {
            runtime.block_on(session.run(heard));
            runtime.shutdown_background();
        });
        Ok(Sparkplug { notes, thread: Some(thread) })
    }
}

impl Drop for Sparkplug {
    fn drop(&mut self) {
        let _ = self.notes.send(Note::Close);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
