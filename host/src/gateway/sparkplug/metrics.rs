//! A board's values as metrics of a Sparkplug device, and what a host may write.

use serde_json::json;

use super::payload::{DataType, Metric, Value};
use crate::helm::Picture;

/// The metric that takes a word: start, stop, pause, resume, acknowledge.
pub const CONTROL: &str = "Control";
/// First part of the outputs' names, before their number.
pub const OUTPUT: &str = "Outputs/";

fn text(name: &str, value: Option<&str>) -> Metric {
    match value {
        Some(value) => Metric::new(name, DataType::String, Value::Text(value.to_owned())),
        None => Metric::null(name, DataType::String),
    }
}

fn long(name: &str, value: i32) -> Metric {
    Metric::new(name, DataType::Int32, Value::Int(value.cast_unsigned()))
}

/// All metrics of a board that shows a picture, and the line that it printed last. They have the same
/// names each time, as a birth promises.
pub fn of(picture: &Picture, printed: &str) -> Vec<Metric> {
    let Some(status) = &picture.status else { return Vec::new() };
    let on = |list: &[u16], n: u16| Value::Boolean(list.contains(&n));
    let mut metrics = vec![
        text("State", Some(status.state)),
        text("Fault", status.fault.as_deref()),
        text("Fault Text", status.text),
        long("Fault Line", status.line.unwrap_or(0).into()),
        long("Fault Input", status.input.unwrap_or(0).into()),
        text("Last End", status.last_end),
        Metric::new("Runs", DataType::UInt32, Value::Int(status.runs.into())),
        Metric::new("Moving", DataType::Boolean, Value::Boolean(!status.moving.is_empty())),
        text("Print", Some(printed)),
        text(CONTROL, Some("")),
    ];
    let positions = serde_json::to_value(status.pos).unwrap_or_default();
    for axis in lang::axis::Axis::ALL {
        let name = axis.letter().to_string();
        let at = positions[&name].as_i64().and_then(|at| i32::try_from(at).ok());
        metrics.push(long(&format!("Position/{name}"), at.unwrap_or(0)));
    }
    for n in 1..=16 {
        let (name, value) = (format!("{OUTPUT}{n}"), on(&status.outputs, n));
        metrics.push(Metric::new(&name, DataType::Boolean, value));
    }
    for n in 1..=17 {
        let (name, value) = (format!("Inputs/{n}"), on(&status.inputs, n));
        metrics.push(Metric::new(&name, DataType::Boolean, value));
    }
    let firmware = picture.identity.as_ref().map(|identity| identity.firmware.as_str());
    metrics.push(text("Properties/Firmware", firmware));
    metrics
}

/// The order that a written metric is; none for one that is not written.
pub fn order(name: &str, value: &Value) -> Option<String> {
    match (name, value) {
        (CONTROL, Value::Text(word)) => Some(json!({ "do": word }).to_string()),
        (name, Value::Boolean(on)) => {
            let n: u16 = name.strip_prefix(OUTPUT)?.parse().ok()?;
            Some(json!({ "do": "set", "output": n, "value": i32::from(*on) }).to_string())
        }
        _ => None,
    }
}
