//! Keys that a cell file may have and this program does not support yet: each is reported.

use super::super::build::tool::roles_of;
use super::super::problem::Problem;
use super::super::scene::{Drive, Eye, Scene, Vary};

/// A fault that is read and strikes nobody yet.
const FAULT: &str = "power";

/// A warning C016 for everything in a scene that has no effect. `text` is the file, `profile` the machine's name.
#[must_use]
pub fn inert(scene: &Scene, text: &str, profile: &str) -> Vec<Problem> {
    let mut found: Vec<Problem> = Vec::new();
    let mut tell = |name: &str, words: String| {
        let quoted = text.find(&format!("\"{name}\"")).map(|at| at..at + name.len() + 2);
        let span = quoted.or_else(|| text.find(name).map(|at| at..at + name.len()));
        found.push(Problem::warning("C016", span.unwrap_or(0..0), words));
    };
    for tool in &scene.tools {
        let name = &tool.name;
        if tool.output.is_none() && !matches!(tool.word.as_str(), "probe" | "none") {
            let roles = roles_of(&tool.word).join(" or ");
            let none = if roles.is_empty() {
                String::new()
            } else {
                format!(", and no output of the profile \"{profile}\" has the role {roles}")
            };
            tell(
                name,
                format!("tool \"{name}\" is never on: it has no `output`{none}; write `output`"),
            );
        }
        if tool.number > 0 {
            tell(
                name,
                format!(
                    "`number` of tool \"{name}\" has no effect yet: it is always in the head, whatever a T word says"
                ),
            );
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
    if scene.stock.as_ref().is_some_and(|stock| stock.heights.is_some()) {
        tell("heights", "`heights` of [stock] has no effect yet; `tilt` has".to_owned());
    }
    for part in scene.parts.iter().filter(|part| !part.metal) {
        let name = &part.name;
        tell(name, format!("`metal` of part \"{name}\" has no effect yet: no sensor is inductive"));
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
    for class in scene.stop_on.iter().filter(|class| *class != "collision") {
        tell(
            class,
            format!(
                "`stop_on` \"{class}\" has no effect: only a collision is known before the end"
            ),
        );
    }
    found
}
