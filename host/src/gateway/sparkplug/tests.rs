//! The edge node against the specification's assertions, by a host of the test's own: what it says
//! stands in Sparkplug 3.0, chapter 6 and the list of assertions.

use std::collections::BTreeMap;

use super::node::{Asked, BD_SEQ, Node, Publish, REBIRTH};
use super::payload::{DataType, Metric, Payload, Value};
use emulator::Rng;
use prost::Message as _;

/// A host that checks each message as it comes.
#[derive(Default)]
struct Host {
    /// Sequence number of the newest message; none: no birth yet.
    seq: Option<u64>,
    bd_seq: Option<u64>,
    /// Metrics of each device that is born.
    devices: BTreeMap<String, BTreeMap<String, Metric>>,
    historical: usize,
}

impl Host {
    fn hear(&mut self, message: &Publish) {
        // As another decoder sees it.
        let bytes = message.payload.encode_to_vec();
        let payload = Payload::decode(&bytes[..]).expect("a payload");
        let parts: Vec<&str> = message.topic.split('/').collect();
        let (kind, device) = (parts[2], parts.get(4).map(|name| (*name).to_owned()));
        assert_eq!((parts[0], parts[1], parts[3]), ("spBv1.0", "hall", "gw"));
        let time = payload.timestamp.expect("each payload has its time");
        assert!(payload.metrics.iter().all(|metric| metric.timestamp.is_some_and(|at| at <= time)));
        if kind == "NDEATH" {
            assert_eq!(payload.seq, None, "tck-id-payloads-ndeath-seq");
            assert_eq!(payload.metrics.len(), 1);
            assert_eq!(payload.metrics[0].name.as_deref(), Some(BD_SEQ));
            return;
        }
        let seq = payload.seq.expect("all but the death have a number");
        if kind == "NBIRTH" {
            assert_eq!(seq, 0, "tck-id-payloads-nbirth-seq");
            self.devices.clear();
            let of = |name: &str| {
                payload.metrics.iter().find(|metric| metric.name.as_deref() == Some(name))
            };
            let bd = of(BD_SEQ).expect("tck-id-payloads-nbirth-bdseq");
            assert_eq!(bd.datatype, Some(DataType::Int64 as u32));
            let Some(Value::Long(number)) = bd.value else { panic!("{bd:?}") };
            self.bd_seq = Some(number);
            let rebirth = of(REBIRTH).expect("tck-id-payloads-nbirth-rebirth-req");
            assert_eq!(rebirth.value, Some(Value::Boolean(false)));
        } else {
            let before = self.seq.expect("nothing comes before the node's birth");
            assert_eq!(seq, (before + 1) % 256, "tck-id-payloads-sequence-num-incrementing");
            let device = device.expect("a device's message");
            match kind {
                "DBIRTH" => {
                    let named =
                        |metric: &Metric| (metric.name.clone().expect("a name"), metric.clone());
                    assert!(payload.metrics.iter().all(|metric| metric.datatype.is_some()));
                    self.devices.insert(device, payload.metrics.iter().map(named).collect());
                }
                "DDEATH" => {
                    assert!(self.devices.remove(&device).is_some(), "{device} was not born");
                }
                "DDATA" => {
                    let born = self.devices.get_mut(&device).expect("data of a device not born");
                    assert!(!payload.metrics.is_empty());
                    for metric in payload.metrics {
                        let name = metric.name.clone().expect("a name");
                        let known = born.get_mut(&name).expect("every metric is in the birth");
                        if metric.is_historical == Some(true) {
                            self.historical += 1;
                        } else {
                            *known = metric;
                        }
                    }
                }
                other => panic!("{other}"),
            }
        }
        self.seq = Some(seq);
    }

    fn all(&mut self, messages: Vec<Publish>) -> usize {
        messages.iter().for_each(|message| self.hear(message));
        messages.len()
    }
}

fn metrics(value: i32) -> Option<Vec<Metric>> {
    Some(vec![
        Metric::new("State", DataType::String, Value::Text("ready".to_owned())),
        Metric::new("Runs", DataType::Int32, Value::Int(value.cast_unsigned())),
        Metric::null("Fault", DataType::String),
    ])
}

fn bd(death: &Publish) -> u64 {
    match death.payload.metrics[0].value {
        Some(Value::Long(number)) => number,
        _ => panic!("{death:?}"),
    }
}

fn rebirth() -> Vec<u8> {
    let metrics = vec![Metric::new(REBIRTH, DataType::Boolean, Value::Boolean(true))];
    Payload { timestamp: Some(1), metrics, seq: None }.encode_to_vec()
}

fn names(count: usize) -> Vec<String> {
    (0..count).map(|n| format!("b{n}")).collect()
}

#[test]
fn whatever_happens_the_host_sees_numbers_without_a_gap_and_births_before_data() {
    let mut rng = Rng::new(7);
    let mut node = Node::new("hall", "gw", None, &names(20));
    let mut messages = 0;
    for connection in 0..300u64 {
        let mut host = Host::default();
        let death = node.connect(connection * 1000);
        host.hear(&death);
        assert_eq!(bd(&death), connection % 256, "bdSeq");
        // Boards change before the birth too.
        for step in 0..rng.below(400) {
            let now = connection * 1000 + step;
            if step == 20 {
                messages += host.all(node.birth(now));
                assert_eq!(host.bd_seq, Some(bd(&death)));
            }
            let place = rng.below(20) as usize;
            let shows = if rng.below(5) == 0 { None } else { metrics(rng.below(3) as i32) };
            messages += host.all(node.device(place, shows, now));
            if step > 20 && rng.below(100) == 0 {
                assert_eq!(node.hear("spBv1.0/hall/NCMD/gw", &rebirth()), [Asked::Rebirth]);
                messages += host.all(node.birth(now));
            }
        }
    }
    assert!(messages > 30_000, "{messages}");
}

#[test]
fn births_wait_for_the_primary_host_and_what_it_missed_is_historical() {
    let state = |online: bool, time: u64| {
        serde_json::json!({ "online": online, "timestamp": time }).to_string().into_bytes()
    };
    let topic = "spBv1.0/STATE/scada";
    let mut host = Host::default();
    let mut node = Node::new("hall", "gw", Some("scada"), &names(1));
    assert!(!node.is_free() && node.filters().contains(&topic.to_owned()));
    host.hear(&node.connect(1));
    assert_eq!(node.hear(topic, &state(false, 10)), [Asked::Nothing]);
    for n in 0..5 {
        assert_eq!(node.device(0, metrics(n), 20 + n as u64), []);
    }
    assert_eq!(node.hear(topic, &state(true, 30)), [Asked::HostUp]);
    assert_eq!(host.all(node.birth(31)), 2 + 4);
    assert_eq!(host.historical, 4);
    // Late news of an older time does not end it.
    assert_eq!(node.hear(topic, &state(false, 29)), [Asked::Nothing]);
    assert_eq!(node.hear(topic, &state(false, 40)), [Asked::HostDown]);
    node.leave();
    assert_eq!(node.device(0, metrics(9), 50), []);
    host.hear(&node.connect(60));
    assert_eq!(node.hear(topic, &state(true, 70)), [Asked::HostUp]);
    assert_eq!(host.all(node.birth(71)), 3);
    assert_eq!(host.devices["b0"]["Runs"].value, Some(Value::Int(9)));
}

#[test]
fn another_program_is_another_birth_and_what_it_has_not_is_not_told() {
    let with = |name: &str, value: u32| {
        let variable = Metric::new(name, DataType::Int32, Value::Int(value)).with_unit("mm");
        metrics(1).map(|mut all| {
            all.push(variable);
            all
        })
    };
    let kind = |message: &Publish| message.topic.split('/').nth(2).map(str::to_owned);
    let (mut host, mut node) = (Host::default(), Node::new("hall", "gw", None, &names(1)));
    host.hear(&node.connect(1));
    assert_eq!(node.device(0, metrics(1), 2), []);
    host.all(node.birth(3));
    for (shows, wanted) in [
        (with("Variables/a", 1), "DBIRTH"),
        (with("Variables/a", 2), "DDATA"),
        (with("Variables/b", 2), "DBIRTH"),
        (metrics(1), "DBIRTH"),
    ] {
        let told = node.device(0, shows, 4);
        assert_eq!(told.iter().map(kind).collect::<Vec<_>>(), [Some(wanted.to_owned())]);
        // The unit is told at the birth alone.
        let units = told[0].payload.metrics.iter().filter(|metric| metric.properties.is_some());
        assert!(wanted == "DBIRTH" || units.count() == 0);
        host.all(told);
    }
    // While nobody hears it a variable comes, changes and goes.
    node.leave();
    for shows in [with("Variables/a", 1), with("Variables/a", 2), metrics(1)] {
        assert_eq!(node.device(0, shows, 5), []);
    }
    host.hear(&node.connect(6));
    assert_eq!(host.all(node.birth(7)), 2);
    assert_eq!(host.historical, 0);
}

#[test]
fn what_hosts_send_is_read_or_left_and_never_harms() {
    let mut node = Node::new("hall", "gw", None, &names(2));
    let metric = Metric::new("Control", DataType::String, Value::Text("start".to_owned()));
    let payload = Payload { timestamp: Some(1), metrics: vec![metric], seq: None }.encode_to_vec();
    let write = Asked::Write(1, "Control".to_owned(), Value::Text("start".to_owned()));
    assert_eq!(node.hear("spBv1.0/hall/DCMD/gw/b1", &payload), [write]);
    for topic in ["spBv1.0/hall/DCMD/gw/b9", "spBv1.0/hall/DCMD/other/b1", "", "x/y"] {
        assert_eq!(node.hear(topic, &payload), [Asked::Nothing], "{topic}");
    }
    let mut rng = Rng::new(3);
    for _ in 0..20_000 {
        let bytes: Vec<u8> = (0..rng.below(60)).map(|_| rng.below(256) as u8).collect();
        let _ = node.hear("spBv1.0/hall/NCMD/gw", &bytes);
        let _ = node.hear("spBv1.0/hall/DCMD/gw/b0", &bytes);
    }
}
