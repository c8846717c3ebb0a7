//! A board's values as metrics of a Sparkplug device, and those that a host may write.

use serde_json::json;

use super::payload::{DataType, Metric, Value};
use crate::gateway::line::Seen;
use crate::gateway::named::Named;

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

/// First part of the names of a program's variables.
pub const VARIABLE: &str = "Variables/";

/// All metrics of what a board shows, and the line that it printed last. They have the same names each
/// time while the program is the same, as a birth promises.
pub fn of(seen: &Seen, printed: &str) -> Vec<Metric> {
    let picture = &seen.picture;
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
    metrics.extend(seen.variables.iter().map(variable));
    metrics
}

fn variable(named: &Named) -> Metric {
    let name = format!("{VARIABLE}{}", named.name);
    let metric = match named.real() {
        Some(real) => Metric::new(&name, DataType::Double, Value::Double(real)),
        None => long(&name, named.value),
    };
    metric.with_unit(named.unit)
}

/// A number that a host writes: whole ones come signed or not.
fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Int(bits) => Some(bits.cast_signed().into()),
        Value::Long(bits) => i32::try_from(bits.cast_signed()).ok().map(f64::from),
        Value::Float(real) => Some((*real).into()),
        Value::Double(real) => Some(*real),
        Value::Boolean(_) | Value::Text(_) => None,
    }
}

/// The order that a written metric is; none for one that is not written.
pub fn order(name: &str, value: &Value) -> Option<String> {
    match (name, value) {
        (CONTROL, Value::Text(word)) => Some(json!({ "do": word }).to_string()),
        (name, value) if name.starts_with(VARIABLE) => {
            let variable = name.strip_prefix(VARIABLE)?;
            let value = number(value)?;
            Some(json!({ "do": "set", "variable": variable, "value": value }).to_string())
        }
        (name, Value::Boolean(on)) => {
            let n: u16 = name.strip_prefix(OUTPUT)?.parse().ok()?;
            Some(json!({ "do": "set", "output": n, "value": i32::from(*on) }).to_string())
        }
        _ => None,
    }
}
