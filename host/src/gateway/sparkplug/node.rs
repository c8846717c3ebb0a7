//! The edge node as a state machine without a network: received messages go in, messages to publish come out.
//!
//! One writer owns the sequence number, so that the order on the wire is the order of the numbers
//! (Sparkplug 3.0, 6.4.5): births before data, each number one more than the one before.

use std::collections::{BTreeSet, VecDeque};

use prost::Message as _;

use super::payload::{DataType, Metric, Payload, Value};

/// Root of all topics (4.1).
pub const NAMESPACE: &str = "spBv1.0";
/// The metric by which a host asks for a birth.
pub const REBIRTH: &str = "Node Control/Rebirth";
/// The metric by which birth and death belong together.
pub const BD_SEQ: &str = "bdSeq";
/// Changes that are kept while the host is away.
const MOST_KEPT: usize = 10_000;

/// A message to publish; QoS 0 and not retained, but for a death by will.
#[derive(Clone, Debug, PartialEq)]
pub struct Publish {
    /// Where to.
    pub topic: String,
    /// What.
    pub payload: Payload,
}

/// What a message of a host asks.
#[derive(Clone, Debug, PartialEq)]
pub enum Asked {
    /// All births again.
    Rebirth,
    /// A metric of a device is to be written: its number, name and value.
    Write(usize, String, Value),
    /// The primary host is there.
    HostUp,
    /// The primary host is gone: say so, leave, and come back when it is there.
    HostDown,
    /// Nothing that concerns us.
    Nothing,
}

struct Device {
    name: String,
    /// All of its metrics; none while it does not answer.
    metrics: Option<Vec<Metric>>,
    born: bool,
}

/// The node.
pub struct Node {
    group: String,
    name: String,
    primary: Option<String>,
    devices: Vec<Device>,
    seq: u8,
    /// Number of this connection.
    bd_seq: u8,
    /// Births are told: data may follow.
    born: bool,
    /// Newest timestamp of the primary host's state, ms.
    host_time: u64,
    /// What changed while nobody could be told: device, when and what.
    kept: VecDeque<(usize, u64, Vec<Metric>)>,
}

/// What of the new metrics differs from the old ones.
fn changes(old: &[Metric], new: &[Metric]) -> Vec<Metric> {
    new.iter().filter(|metric| !old.contains(metric)).cloned().collect()
}

/// Names of metrics with their types.
fn names(metrics: &[Metric]) -> BTreeSet<(&Option<String>, Option<u32>)> {
    metrics.iter().map(|metric| (&metric.name, metric.datatype)).collect()
}

impl Node {
    /// A node that has never connected.
    pub fn new(group: &str, name: &str, primary: Option<&str>, devices: &[String]) -> Node {
        let device = |name: &String| Device { name: name.clone(), metrics: None, born: false };
        Node {
            group: group.to_owned(),
            name: name.to_owned(),
            primary: primary.map(str::to_owned),
            devices: devices.iter().map(device).collect(),
            seq: 0,
            // The first connection has number 0.
            bd_seq: u8::MAX,
            born: false,
            host_time: 0,
            kept: VecDeque::new(),
        }
    }

    /// A topic of the node's, or of one of its devices.
    fn topic(&self, kind: &str, device: Option<&str>) -> String {
        let node = format!("{NAMESPACE}/{}/{kind}/{}", self.group, self.name);
        device.map_or(node.clone(), |device| format!("{node}/{device}"))
    }

    /// Filters to subscribe to before the birth (5.3).
    pub fn filters(&self) -> Vec<String> {
        let host = self.primary.as_ref().map(|host| format!("{NAMESPACE}/STATE/{host}"));
        let own = [self.topic("NCMD", None), format!("{}/#", self.topic("DCMD", None))];
        own.into_iter().chain(host).collect()
    }

    /// A new connection begins: its death, for the will. It has no sequence number.
    pub fn connect(&mut self, now: u64) -> Publish {
        self.bd_seq = self.bd_seq.wrapping_add(1);
        self.leave();
        self.death(now)
    }

    /// The node's death with the number of its birth.
    pub fn death(&self, now: u64) -> Publish {
        let metrics = vec![self.bd_metric(now)];
        let payload = Payload { timestamp: Some(now), metrics, seq: None };
        Publish { topic: self.topic("NDEATH", None), payload }
    }

    /// The connection is over: what happens from now on is kept.
    pub fn leave(&mut self) {
        self.born = false;
        self.devices.iter_mut().for_each(|device| device.born = false);
    }

    fn bd_metric(&self, now: u64) -> Metric {
        let value = Value::Long(self.bd_seq.into());
        Metric { timestamp: Some(now), ..Metric::new(BD_SEQ, DataType::Int64, value) }
    }

    /// Whether a birth may be told as soon as the subscriptions stand: without a primary host.
    pub fn is_free(&self) -> bool {
        self.primary.is_none()
    }

    /// Whether births are told.
    pub fn is_born(&self) -> bool {
        self.born
    }

    fn next_seq(&mut self) -> Option<u64> {
        let seq = self.seq;
        self.seq = self.seq.wrapping_add(1);
        Some(seq.into())
    }

    /// All births, the node's first with number 0, then what was kept as historical.
    pub fn birth(&mut self, now: u64) -> Vec<Publish> {
        self.seq = 0;
        self.born = true;
        let rebirth = Metric {
            timestamp: Some(now),
            ..Metric::new(REBIRTH, DataType::Boolean, Value::Boolean(false))
        };
        let metrics = vec![self.bd_metric(now), rebirth];
        let payload = Payload { timestamp: Some(now), metrics, seq: self.next_seq() };
        let mut told = vec![Publish { topic: self.topic("NBIRTH", None), payload }];
        for place in 0..self.devices.len() {
            told.extend(self.birth_of(place, now));
        }
        while let Some((place, then, metrics)) = self.kept.pop_front() {
            // A device that does not answer any more has no birth that data could follow.
            // What it does not show any more, a variable of another program, is in no birth.
            let shown = self.devices[place].metrics.as_ref().map(|all| names(all));
            let mut metrics = metrics;
            metrics.retain(|metric| {
                shown.as_ref().is_some_and(|all| all.contains(&(&metric.name, metric.datatype)))
            });
            if self.devices[place].born && !metrics.is_empty() {
                told.push(self.data(place, then, metrics, true));
            }
        }
        told
    }

    fn birth_of(&mut self, place: usize, now: u64) -> Option<Publish> {
        let mut metrics = self.devices[place].metrics.clone()?;
        metrics.iter_mut().for_each(|metric| metric.timestamp = Some(now));
        self.devices[place].born = true;
        let topic = self.topic("DBIRTH", Some(&self.devices[place].name));
        Some(Publish {
            topic,
            payload: Payload { timestamp: Some(now), metrics, seq: self.next_seq() },
        })
    }

    fn data(&mut self, place: usize, then: u64, mut metrics: Vec<Metric>, old: bool) -> Publish {
        for metric in &mut metrics {
            metric.timestamp = Some(then);
            metric.properties = None;
            metric.is_historical = old.then_some(true);
        }
        let topic = self.topic("DDATA", Some(&self.devices[place].name));
        let payload = Payload { timestamp: Some(then), metrics, seq: self.next_seq() };
        Publish { topic, payload }
    }

    /// A device shows these metrics, or none because it does not answer.
    pub fn device(&mut self, place: usize, metrics: Option<Vec<Metric>>, now: u64) -> Vec<Publish> {
        let old = std::mem::replace(&mut self.devices[place].metrics, metrics.clone());
        if !self.born {
            if let (Some(old), Some(new)) = (&old, &metrics) {
                let changed = changes(old, new);
                if !changed.is_empty() {
                    self.kept.push_back((place, now, changed));
                }
                if self.kept.len() > MOST_KEPT {
                    self.kept.pop_front();
                }
            }
            return Vec::new();
        }
        match (self.devices[place].born, metrics) {
            (true, None) => {
                self.devices[place].born = false;
                let topic = self.topic("DDEATH", Some(&self.devices[place].name));
                let seq = self.next_seq();
                let payload = Payload { timestamp: Some(now), metrics: Vec::new(), seq };
                vec![Publish { topic, payload }]
            }
            (false, Some(_)) => self.birth_of(place, now).into_iter().collect(),
            // Another program has other variables: a birth has every metric.
            (true, Some(new)) if old.as_ref().is_none_or(|old| names(old) != names(&new)) => {
                self.birth_of(place, now).into_iter().collect()
            }
            (true, Some(new)) => {
                let changed = changes(&old.unwrap_or_default(), &new);
                if changed.is_empty() {
                    Vec::new()
                } else {
                    vec![self.data(place, now, changed, false)]
                }
            }
            (false, None) => Vec::new(),
        }
    }

    /// What a message to us asks.
    pub fn hear(&mut self, topic: &str, payload: &[u8]) -> Vec<Asked> {
        if self.primary.as_ref().is_some_and(|host| topic == format!("{NAMESPACE}/STATE/{host}")) {
            return vec![self.host(payload)];
        }
        let command = topic.strip_prefix(&format!("{}/", self.topic("DCMD", None)));
        let device = command.and_then(|name| self.devices.iter().position(|one| one.name == name));
        if topic != self.topic("NCMD", None) && device.is_none() {
            return vec![Asked::Nothing];
        }
        let Ok(payload) = Payload::decode(payload) else { return vec![Asked::Nothing] };
        let asked = |metric: Metric| match (device, metric.name, metric.value) {
            (None, Some(name), Some(Value::Boolean(true))) if name == REBIRTH => Asked::Rebirth,
            (Some(place), Some(name), Some(value)) => Asked::Write(place, name, value),
            _ => Asked::Nothing,
        };
        payload.metrics.into_iter().map(asked).collect()
    }

    /// The primary host's state (6.4.22 in 3.0: JSON with `online` and `timestamp`); one that is older
    /// than what is known comes late and says nothing.
    fn host(&mut self, payload: &[u8]) -> Asked {
        let Ok(state) = serde_json::from_slice::<serde_json::Value>(payload) else {
            return Asked::Nothing;
        };
        let (Some(online), Some(time)) = (state["online"].as_bool(), state["timestamp"].as_u64())
        else {
            return Asked::Nothing;
        };
        if time < self.host_time {
            return Asked::Nothing;
        }
        self.host_time = time;
        match (online, self.born) {
            (true, false) => Asked::HostUp,
            (false, true) => Asked::HostDown,
            _ => Asked::Nothing,
        }
    }
}
