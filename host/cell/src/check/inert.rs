//! Keys that a cell file may have and this program does not support yet: each is reported.

use super::super::problem::Problem;
use super::super::scene::{Drive, Eye, Scene, ToolKind, Vary};

/// A fault that is read and strikes nobody yet.
const FAULT: &str = "power";

/// A warning C016 for everything in a scene that has no effect. `text` is the file.
#[must_use]
pub fn inert(scene: &Scene, text: &str) -> Vec<Problem> {
    let mut found: Vec<Problem> = Vec::new();
    let mut tell = |name: &str, words: String| {
        let quoted = text.find(&format!("\"{name}\"")).map(|at| at..at + name.len() + 2);
        let span = quoted.or_else(|| text.find(name).map(|at| at..at + name.len()));
        found.push(Problem::warning("C016", span.unwrap_or(0..0), words));
    };
    for tool in &scene.tools {
        let name = &tool.name;
        if let ToolKind::Drill { flute, plunge_mm_s, .. } = &tool.kind {
            if flute.is_some() {
                tell(name, format!("`flute` of tool \"{name}\" has no effect yet"));
            }
            if plunge_mm_s.is_some() {
                tell(name, format!("`plunge_max_mm_min` of tool \"{name}\" has no effect yet"));
            }
        }
        if tool.turn.is_some() {
            tell(
                name,
                format!(
                    "`turn` of tool \"{name}\" has no effect yet: no machine has a fourth axis"
                ),
            );
        }
    }
    if let [_, second, ..] = scene.tools.as_slice() {
        tell(
            &second.name,
            format!(
                "tool \"{}\" has no effect yet: the first tool is always in the head",
                second.name
            ),
        );
    }
    if scene.stock.as_ref().is_some_and(|stock| stock.heights.is_some()) {
        tell("heights", "`heights` of [stock] has no effect yet; `tilt` has".to_owned());
    }
    for conveyor in &scene.conveyors {
        let name = &conveyor.name;
        if matches!(conveyor.drive, Drive::Axis(_)) {
            tell(name, format!("conveyor \"{name}\" does not move yet: an axis drives it"));
        }
        if conveyor.ramp_us > 0 {
            tell(
                name,
                format!(
                    "`ramp_ms` of conveyor \"{name}\" has no effect yet: it runs at full speed at once"
                ),
            );
        }
    }
    for sensor in &scene.sensors {
        let name = &sensor.name;
        if sensor.analog.is_some() && !matches!(sensor.eye, Eye::Distance(..)) {
            tell(name, format!("`analog` of sensor \"{name}\" has no effect: a distance has it"));
        }
    }
    for vary in &scene.varies {
        if let Vary::Fault { fault, .. } = vary
            && fault == FAULT
        {
            tell(fault, format!("fault \"{fault}\" strikes nobody yet"));
        }
    }
    if !scene.stop_on.is_empty() {
        tell("stop_on", "`stop_on` has no effect yet: a run goes on to its end".to_owned());
    }
    found
}
