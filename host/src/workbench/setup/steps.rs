//! The steps of a set-up, and what each of them changes in the profile.

use lang::axis::Axis;
use lang::profile::{AxisProfile, Direction, InputRole, OutputRole, Profile, Scale};
use serde_json::{Map, Value, json};

/// Steps of the whole machine, in the order in which they are safe.
const MACHINE: [&str; 5] = ["wiring", "link", "switches", "stop", "outputs"];
/// Steps of each axis.
const AXIS: [&str; 5] = ["direction", "scale", "home", "travel", "rate"];
/// Room beyond the switch for a look at where it closes, um.
const BEYOND: i32 = 5000;

/// Names of the steps: those of an axis with its letter, `home_x`.
pub fn list(profile: &Profile) -> Vec<String> {
    let axes = profile.axes().flat_map(|(axis, _)| {
        AXIS.iter().map(move |step| format!("{step}_{}", axis.letter().to_ascii_lowercase()))
    });
    MACHINE.iter().map(|step| (*step).to_owned()).chain(axes).collect()
}

/// The part of a profile that a step was tried with.
pub fn basis(profile: &Profile, id: &str) -> Value {
    let whole = serde_json::to_value(profile).unwrap_or_default();
    let (step, letter) = id.split_once('_').unwrap_or((id, ""));
    let axis = &whole[letter];
    let pick = |names: &[&str]| {
        let list = names.iter().map(|name| ((*name).to_owned(), axis[*name].clone()));
        Value::Object(list.collect::<Map<String, Value>>())
    };
    match step {
        "wiring" => json!([whole["wiring"], whole["pulse_us"], whole["dir_setup_us"]]),
        "link" => whole["link"].clone(),
        "switches" => json!([whole["wiring"], whole["input"]]),
        "stop" => {
            let stops =
                profile.inputs.iter().filter(|own| own.role == Some(InputRole::EmergencyStop));
            json!([
                whole["wiring"],
                serde_json::to_value(stops.collect::<Vec<_>>()).unwrap_or_default()
            ])
        }
        "outputs" => json!([whole["wiring"], whole["output"]]),
        "direction" => pick(&["invert"]),
        "scale" => pick(&["invert", "scale"]),
        "home" => json!([pick(&["invert", "scale", "home"]), reference(profile, letter)]),
        "travel" => pick(&["invert", "scale", "home", "min_um", "max_um"]),
        "rate" => pick(&["scale", "start_rate", "accel", "decel", "top_rate"]),
        _ => Value::Null,
    }
}

fn reference(profile: &Profile, letter: &str) -> i32 {
    let axis = letter.chars().next().and_then(|c| Axis::from_letter(c.to_ascii_uppercase()));
    axis.map_or(0, |axis| profile.reference_input(axis))
}

/// Input numbers of the reference switches and the probe.
pub fn references(profile: &Profile) -> Value {
    let axes = profile.axes().map(|(axis, _)| {
        (
            format!("reference_{}", axis.letter().to_ascii_lowercase()),
            json!(profile.reference_input(axis)),
        )
    });
    let mut all: Map<String, Value> = axes.collect();
    all.insert("probe".to_owned(), json!(profile.probe_input()));
    Value::Object(all)
}

/// What inputs and outputs can be.
pub fn roles() -> Value {
    json!({
        "inputs": InputRole::ALL.map(InputRole::name),
        "outputs": OutputRole::ALL.map(OutputRole::name),
    })
}

/// A JSON merge patch (RFC 7396): null takes a key out, an object goes deeper, all else replaces.
pub fn merge(target: &mut Value, patch: &Value) {
    let Value::Object(patch) = patch else {
        *target = patch.clone();
        return;
    };
    if !target.is_object() {
        *target = Value::Object(Map::new());
    }
    let Value::Object(own) = target else { return };
    for (key, value) in patch {
        if value.is_null() {
            own.remove(key);
        } else {
            merge(own.entry(key.clone()).or_insert(Value::Null), value);
        }
    }
}

/// The axis's part that may be changed.
pub(super) fn part(profile: &mut Profile, axis: Axis) -> Option<&mut AxisProfile> {
    match axis {
        Axis::X => profile.x.as_mut(),
        Axis::Y => profile.y.as_mut(),
        Axis::Z => profile.z.as_mut(),
    }
}

/// The profile with more travel: everywhere where it is not known yet, and a little toward the switch.
pub fn opened(profile: &Profile, known: impl Fn(char) -> bool) -> Profile {
    let mut open = profile.clone();
    for axis in Axis::ALL {
        let Some(own) = part(&mut open, axis) else { continue };
        let stroke = own.home.stroke_um.min(4_000_000);
        if known(axis.letter().to_ascii_lowercase()) {
            match own.home.direction {
                Direction::Negative => own.min_um = own.min_um.min(own.home.position_um) - BEYOND,
                Direction::Positive => own.max_um = own.max_um.max(own.home.position_um) + BEYOND,
            }
        } else {
            own.min_um = own.min_um.min(own.home.position_um) - stroke;
            own.max_um = own.max_um.max(own.home.position_um) + stroke;
        }
        own.min_um = own.min_um.max(-9_000_000);
        own.max_um = own.max_um.min(9_000_000);
    }
    open
}

/// The profile with the scale that makes `asked` what was `measured`, um, and what changed in words.
///
/// # Errors
/// A length is wrong, they differ by more than a factor of ten, or no such scale exists.
pub fn scaled(
    profile: &Profile,
    letter: char,
    asked: i64,
    measured: i64,
) -> Result<(Profile, String), String> {
    let axis = Axis::from_letter(letter).filter(|axis| profile.axis(*axis).is_some());
    let axis = axis.ok_or_else(|| format!("the machine has no axis {letter}"))?;
    let wide = |um: i64| (1000..=2_000_000).contains(&um);
    if !wide(asked) || !wide(measured) || asked > 10 * measured || measured > 10 * asked {
        return Err(
            "what was asked and measured are lengths of 1 to 2000 mm that differ by less than \
                    a factor of ten; a wrong direction is the step before"
                .to_owned(),
        );
    }
    let mut next = profile.clone();
    let own = part(&mut next, axis).ok_or("the machine has no such axis")?;
    let before = own.scale;
    // Steps that were made, over the way that they gave.
    let (steps, um) = (i64::from(before.steps) * asked, i64::from(before.um) * measured);
    own.scale = fraction(steps, um).ok_or("no scale of the profile's range comes of this")?;
    let per_mm = |scale: Scale| f64::from(scale.steps) * 1000.0 / f64::from(scale.um);
    let words = format!(
        "asked {} mm, measured {} mm: {:.3} steps per mm instead of {:.3}",
        asked as f64 / 1000.0,
        measured as f64 / 1000.0,
        per_mm(own.scale),
        per_mm(before)
    );
    Ok((next, words))
}

/// The fraction that is nearest to `steps / um` with both parts in 1..65535: by continued fractions.
fn fraction(steps: i64, um: i64) -> Option<Scale> {
    let (mut a, mut b) = (steps, um);
    let (mut before, mut last) = ((0_i64, 1_i64), (1_i64, 0_i64));
    while b != 0 {
        let whole = a / b;
        let next = (whole.checked_mul(last.0)? + before.0, whole.checked_mul(last.1)? + before.1);
        if next.0 > 65_535 || next.1 > 65_535 {
            break;
        }
        (before, last) = (last, next);
        (a, b) = (b, a % b);
    }
    let (steps, um) = (u16::try_from(last.0).ok()?, u16::try_from(last.1).ok()?);
    (steps > 0 && um > 0).then_some(Scale { steps, um })
}
