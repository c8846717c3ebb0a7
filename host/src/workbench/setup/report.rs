//! The report of a set-up: a page for the printer and the machine's folder.

use lang::axis::Axis;
use lang::profile::Profile;

use super::{Done, pins};

const STYLE: &str = "body{font:11pt/1.4 sans-serif;max-width:19cm;margin:1cm auto;color:#111}\
    h1{font-size:18pt}h2{font-size:13pt;margin-top:1.2em}table{border-collapse:collapse;width:100%}\
    td,th{border:1px solid #999;padding:3px 7px;text-align:left;vertical-align:top}\
    .open{color:#a00}pre{font:9pt/1.35 monospace;border:1px solid #999;padding:8px;white-space:pre-wrap}\
    tr,pre{break-inside:avoid}";

/// What a step is called.
pub fn title(id: &str) -> String {
    let (step, letter) = id.split_once('_').unwrap_or((id, ""));
    let words = match step {
        "wiring" => "Wiring and pins",
        "link" => "Link",
        "switches" => "Switches and other inputs",
        "stop" => "Emergency stop",
        "outputs" => "Outputs and safe states",
        "direction" => "Direction",
        "scale" => "Steps per millimetre",
        "home" => "Reference run",
        "travel" => "Travel",
        "rate" => "Top rate and ramp",
        other => other,
    };
    if letter.is_empty() { words.to_owned() } else { format!("{}: {words}", letter.to_uppercase()) }
}

/// A word of the profile as its file has it.
fn plain(word: impl serde::Serialize) -> String {
    let value = serde_json::to_value(word).ok();
    value.as_ref().and_then(serde_json::Value::as_str).unwrap_or_default().to_owned()
}

fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c => out.push(c),
        }
    }
    out
}

/// The page; a step without what was found is open. `when` is the day as the person writes it.
pub fn page(profile: &Profile, steps: &[(&str, Option<&Done>)], file: &str, when: &str) -> String {
    let name = escaped(&profile.name);
    let when: String = when.chars().filter(|c| !c.is_control()).take(60).collect();
    let row = |(id, done): &(&str, Option<&Done>)| {
        let found = match done {
            Some(done) => format!("<td>{}</td>", escaped(&done.words)),
            None => "<td class=\"open\">not tried with the machine as it is now</td>".to_owned(),
        };
        format!("<tr><th>{}</th>{found}</tr>", escaped(&title(id)))
    };
    let rows: String = steps.iter().map(row).collect();
    let axes = profile.axes().map(|(axis, own)| {
        let per_mm = f64::from(own.scale.steps) * 1000.0 / f64::from(own.scale.um);
        let mm = |um: i32| f64::from(um) / 1000.0;
        format!(
            "<tr><th>{}</th><td>{per_mm:.3} steps per mm{}</td><td>{} to {} mm</td><td>{:.2} mm/s, {} \
             steps/s</td><td>{} steps/s<sup>2</sup></td><td>input {}</td></tr>",
            axis.letter(),
            if own.invert { ", inverted" } else { "" },
            mm(own.min_um),
            mm(own.max_um),
            f64::from(own.top_rate) / per_mm,
            own.top_rate,
            own.accel,
            profile.reference_input(axis)
        )
    });
    let axes: String = axes.collect();
    let inputs = profile.inputs.iter().map(|own| {
        let role = own.role.map_or("", lang::profile::InputRole::name);
        let closed = if own.invert { "on when open" } else { "on when closed" };
        let name = own.name.as_deref().unwrap_or_default();
        format!(
            "<tr><th>input {}</th><td>{} {role}</td><td>{closed}</td></tr>",
            own.n,
            escaped(name)
        )
    });
    let outputs = profile.outputs.iter().map(|own| {
        let role = own.role.map_or("", lang::profile::OutputRole::name);
        let name = own.name.as_deref().unwrap_or_default();
        format!(
            "<tr><th>output {}</th><td>{} {role}{}</td><td>reset {}, pause {}, fault {}, end {}</td></tr>",
            own.n,
            escaped(name),
            if own.invert { ", inverted" } else { "" },
            plain(own.reset),
            plain(own.pause),
            plain(own.fault),
            plain(own.end)
        )
    });
    let terminals: String = inputs.chain(outputs).collect();
    let pins = pins::chips().map(|(chip, heading)| {
        let rows = pins::table(heading, profile.wiring);
        let rows = rows.iter().map(|[pins, words]| {
            format!("<tr><th>{}</th><td>{}</td></tr>", escaped(pins), escaped(words))
        });
        format!("<h2>{chip}: pins</h2><table>{}</table>", rows.collect::<String>())
    });
    let order: Vec<String> =
        profile.home_order.iter().map(|name| Axis::from(*name).letter().to_string()).collect();
    let order = order.join(", ");
    format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>{name}: set-up</title>\
         <style>{STYLE}</style><h1>Set-up of {name}</h1><p>{when}. Pasapas {}. Reference runs in the order \
         {order}. Link: address {}, {} bit/s.</p><h2>What was tried</h2><table>{rows}</table>\
         <h2>Axes</h2><table>{axes}</table><h2>Inputs and outputs</h2><table>{terminals}</table>{}\
         <h2>The profile</h2><pre>{}</pre></html>\n",
        env!("CARGO_PKG_VERSION"),
        profile.link.address,
        profile.link.rate,
        pins.collect::<String>(),
        escaped(file),
        when = escaped(&when),
    )
}
