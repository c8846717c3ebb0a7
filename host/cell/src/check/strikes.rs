//! The parts that a fault strikes. A fault that strikes none changes no run, and a proof with it proves nothing: the file or the
//! command line that asks for it is refused.

use crate::build::meant;
use crate::read::{Names, Port};
use crate::scene::{Scene, ToolKind};
use crate::vary::{self, Deviation};

/// Faults that come at a time of the run.
const TIMED: [&str; 6] = ["pause", "stop", "estop", "door", "gone", "stall"];
/// Faults that make something later: by how much must be said.
const LATER: [&str; 3] = ["slow", "late", "bounce"];

/// Whether a fault comes at a time of the run.
#[must_use]
pub fn needs_time(fault: &str) -> bool {
    TIMED.contains(&fault)
}

/// Whether a fault only makes something later, by a time that must be said.
#[must_use]
pub fn needs_delay(fault: &str) -> bool {
    LATER.contains(&fault)
}

/// What a fault can strike: the words for it, and the names that a scene has. `None` for a fault of the run, and for one
/// that has no effect yet.
fn targets(scene: &Scene, axes: &str, fault: &str) -> Option<(&'static str, Vec<String>)> {
    let tools = |all: bool| {
        let chosen = scene.tools.iter().filter(move |tool| {
            all || match &tool.kind {
                ToolKind::Vacuum(vacuum) => vacuum.input.is_some(),
                ToolKind::Gripper(gripper) => gripper.input_gripped.is_some(),
                ToolKind::Probe { input, .. } => input.is_some(),
                _ => false,
            }
        });
        chosen.map(|tool| tool.name.clone())
    };
    let sensors = |all: bool| {
        let chosen = scene.sensors.iter().filter(move |sensor| all || sensor.input.is_some());
        chosen.map(|sensor| sensor.name.clone())
    };
    let feeders = || scene.feeders.iter().map(|feeder| feeder.name.clone());
    Some(match fault {
        "missing" | "stuck" | "lost" | "double" | "turned" => {
            let parts = scene.parts.iter().filter(|part| part.at.is_some());
            let belts = scene.conveyors.iter().map(|belt| belt.name.clone());
            (
                "feeder, belt, thing of these or part with `at`",
                feeders().chain(belts).chain(parts.map(|part| part.name.clone())).collect(),
            )
        }
        "slow" => {
            ("tool, sensor or feeder", tools(true).chain(sensors(true)).chain(feeders()).collect())
        }
        "bounce" => ("sensor", sensors(true).collect()),
        "late" => ("person", scene.persons.iter().map(|person| person.name.clone()).collect()),
        "dead_on" | "dead_off" => {
            ("sensor or tool with an input", sensors(false).chain(tools(false)).collect())
        }
        "stall" => ("axis of the profile", axes.chars().map(String::from).collect()),
        _ => return None,
    })
}

/// Whether a thing of this name is in the scene, or may come: a part with a place, or a thing of a feeder or belt as
/// `tray.3`. A tape, a tube, a bowl and a belt bring things one after the other.
#[must_use]
pub fn is_thing(scene: &Scene, name: &str) -> bool {
    if scene.parts.iter().any(|part| part.name == name && part.at.is_some()) {
        return true;
    }
    name.rsplit_once('.').is_some_and(|(feeder, pocket)| {
        let pocket = pocket.parse::<usize>().unwrap_or(0);
        let belt = scene.conveyors.iter().any(|own| own.name == feeder);
        let feeder = scene.feeders.iter().find(|own| own.name == feeder);
        pocket > 0
            && (belt
                || feeder.is_some_and(|own| {
                    own.pockets.len() == 1
                        || pocket <= own.pockets.len() && !own.empty.contains(&(pocket - 1))
                }))
    })
}

/// Whether a fault strikes somebody: `of` is what it names.
///
/// # Errors
/// What is wrong, in a line: the fault, the name and what there is.
pub fn target(
    scene: &Scene,
    names: &dyn Names,
    fault: &str,
    of: Option<&str>,
) -> Result<(), String> {
    if fault == "door" && names.with_role(Port::Input, "door").is_none() {
        return Err(format!(
            "fault door strikes nothing: the profile \"{}\" has no door; an input with role = \"door\" is one",
            names.profile()
        ));
    }
    let Some((word, known)) = targets(scene, names.axes(), fault) else { return Ok(()) };
    let Some(of) = of.filter(|of| !of.is_empty()) else {
        let names: Vec<&str> = known.iter().map(String::as_str).collect();
        let has = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        return Err(format!("missing `of` of fault {fault}: a {word}; there is {has}"));
    };
    if word.contains("thing") && is_thing(scene, of) || known.iter().any(|name| name == of) {
        return Ok(());
    }
    let names: Vec<&str> = known.iter().map(String::as_str).collect();
    Err(format!("fault {fault} names no {word}: \"{of}\"{}", meant(of, &names)))
}

/// Whether a deviation of this number changes anything in the scene.
#[must_use]
pub fn changes(scene: &Scene, key: &str) -> bool {
    let deviation =
        Deviation { what: key.to_owned(), of: String::new(), by: vec![0.125; 2], at_us: None };
    let after = vary::applied(scene.clone(), &[deviation]);
    let same = after.tools == scene.tools
        && after.parts == scene.parts
        && after.feeders == scene.feeders
        && after.places == scene.places
        && after.fixtures == scene.fixtures
        && after.stock == scene.stock
        && after.conveyors == scene.conveyors
        && after.sensors == scene.sensors
        && after.start == scene.start;
    !same
}

/// Whether a deviation that the command line gives strikes somebody.
///
/// # Errors
/// What is wrong, in a line, with the remedy.
pub fn deviation(scene: &Scene, names: &dyn Names, deviation: &Deviation) -> Result<(), String> {
    let Deviation { what, of, by, at_us } = deviation;
    if what.contains('.') {
        if !changes(scene, what) {
            return Err(format!("`{what}` is no number of the cell that varies"));
        }
        let feeder = what.split('.').next().unwrap_or_default();
        let own = (!of.is_empty()).then_some(of.as_str()).filter(|of| *of != feeder);
        if let Some(of) = own
            && (of.rsplit_once('.').is_none_or(|(name, _)| name != feeder)
                || target(scene, names, "missing", Some(of)).is_err())
        {
            return Err(format!("`{what}`: \"{of}\" is no thing of \"{feeder}\""));
        }
        if by.iter().all(|by| *by == 0.0) {
            return Err(format!("`{what}` changes by nothing: write for example \"{what} 0.3\""));
        }
        return Ok(());
    }
    target(scene, names, what, Some(of))?;
    if needs_time(what) && at_us.is_none() {
        return Err(format!("`{what}` needs a time: write \"{} at 12.5s\"", deviation.text()));
    }
    if needs_delay(what) && by.iter().all(|by| *by <= 0.0) {
        return Err(format!("`{what}` needs a delay: write \"{what} {of} 40ms\""));
    }
    if what == "stall" && by.iter().all(|by| *by == 0.0) {
        return Err(format!("`stall` needs the steps lost: write \"stall {of} 300st at 12.5s\""));
    }
    Ok(())
}
