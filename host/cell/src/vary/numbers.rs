//! The numbers that may vary, by their keys: one table for the check of a file, for the draw and for a run.

use crate::scene::{Block, Eye, Gap, Scene, ToolKind, V3};

/// Is given a number in the unit of its key, its index among the numbers of the key, and the least that it may be.
type With<'a> = &'a mut dyn FnMut(usize, &mut f64, f64);

/// Least length of a thing, mm.
const LEAST_MM: f64 = 0.001;

/// The numbers of a key as the file says them, in the unit of the key: X and Y of a place; none where nothing varies by
/// this key.
#[must_use]
pub fn values(scene: &Scene, key: &str) -> Vec<f64> {
    let mut values = Vec::new();
    each(&mut scene.clone(), key, "", &mut |index, number, _| {
        // The pockets of a feeder have the same numbers.
        if index == values.len() {
            values.push(*number);
        }
    });
    values
}

/// The number that a share refers to; 0 where the key has none or several.
#[must_use]
pub fn value(scene: &Scene, key: &str) -> f64 {
    match values(scene, key)[..] {
        [value] => value,
        _ => 0.0,
    }
}

/// X and Y of a place.
fn place(at: &mut V3, with: With) {
    for (axis, number) in at.iter_mut().enumerate().take(2) {
        with(axis, number, f64::NEG_INFINITY);
    }
}

/// The same of a block, whose size stays.
fn moved(block: &mut Block, with: With) {
    let from = std::array::from_fn(|axis| (block.low[axis] + block.high[axis]) / 2.0);
    let mut to = from;
    place(&mut to, with);
    *block = block.moved(std::array::from_fn(|axis| to[axis] - from[axis]));
}

fn size(size: &mut V3, with: With) {
    for (axis, number) in size.iter_mut().enumerate() {
        with(axis, number, LEAST_MM);
    }
}

/// A time in ms that is kept as us.
fn ms(us: &mut f64, with: With) {
    let mut ms = *us / 1000.0;
    with(0, &mut ms, 0.0);
    *us = (ms * 1000.0).max(0.0);
}

/// The same, kept as whole us.
fn whole(us: &mut u64, with: With) {
    let mut exact = *us as f64;
    ms(&mut exact, with);
    *us = exact.round() as u64;
}

/// Hands the numbers of a key to `with`; `of` names a single thing of a feeder, or is empty.
pub(super) fn each(scene: &mut Scene, path: &str, of: &str, with: With) {
    let Some((name, key)) = path.split_once('.') else { return };
    if let Some(tool) = scene.tools.iter_mut().find(|tool| tool.name == name) {
        match key {
            "tip" => place(&mut tool.tip, with),
            _ => tool_number(&mut tool.kind, key, with),
        }
    } else if let Some(feeder) = scene.feeders.iter_mut().find(|feeder| feeder.name == name) {
        match key {
            "advance_ms" => return whole(&mut feeder.advance_us, with),
            "spread" => return with(0, &mut feeder.spread[0], 0.0),
            "spread_deg" => return with(0, &mut feeder.spread[1], 0.0),
            _ => {}
        }
        // A part that a feeder brings later differs when it comes.
        if !of.is_empty() && feeder.advances() {
            return;
        }
        let only: Option<usize> = of.rsplit('.').next().and_then(|pocket| pocket.parse().ok());
        for (index, (at, turn)) in feeder.pockets.iter_mut().enumerate() {
            if only.is_none_or(|only| only == index + 1) {
                match key {
                    "at" | "corner" => place(at, with),
                    "turn_deg" => with(0, turn, f64::NEG_INFINITY),
                    _ => {}
                }
            }
        }
    } else if let Some(own) = scene.places.iter_mut().find(|own| own.name == name) {
        if key == "at" {
            let from = own.at;
            place(&mut own.at, with);
            own.block = own.block.moved(std::array::from_fn(|axis| own.at[axis] - from[axis]));
        }
    } else if let Some(fixture) = scene.fixtures.iter_mut().find(|fixture| fixture.name == name) {
        match (key, &mut fixture.door) {
            ("at" | "corner", _) => place(&mut fixture.at, with),
            ("size", _) => size(&mut fixture.form.size, with),
            ("turn_deg", _) => with(0, &mut fixture.form.turn_deg, f64::NEG_INFINITY),
            ("open_at", Some((_, open_at, _))) => place(open_at, with),
            ("move_ms", Some((.., move_us))) => whole(move_us, with),
            _ => {}
        }
    } else if let Some(part) = scene.parts.iter_mut().find(|part| part.name == name) {
        match (key, &mut part.at) {
            ("at" | "corner", Some(at)) => place(at, with),
            ("size", _) => size(&mut part.form.size, with),
            ("turn_deg", _) => with(0, &mut part.form.turn_deg, f64::NEG_INFINITY),
            _ => {}
        }
    } else if let Some(belt) = scene.conveyors.iter_mut().find(|belt| belt.name == name) {
        match (key, &mut belt.feeds) {
            ("at", _) => moved(&mut belt.block, with),
            // A belt does not turn back.
            ("mm_s", _) => with(0, &mut belt.mm_s, 0.0),
            ("every_ms", Some((_, Gap::Time(us)))) => whole(us, with),
            ("gap", Some((_, Gap::Way(mm)))) => with(0, mm, LEAST_MM),
            _ => {}
        }
    } else if let Some(sensor) = scene.sensors.iter_mut().find(|sensor| sensor.name == name) {
        match (key, &mut sensor.eye) {
            ("on_ms", _) => whole(&mut sensor.on_us, with),
            ("off_ms", _) => whole(&mut sensor.off_us, with),
            ("bounce_ms", _) => whole(&mut sensor.bounce_us, with),
            ("from", Eye::Beam(from, _) | Eye::Distance(from, ..)) => place(from, with),
            ("to", Eye::Beam(_, to) | Eye::Distance(_, to, _)) => place(to, with),
            ("at", Eye::Box(block)) => moved(block, with),
            ("at", Eye::Colour(at, _)) => place(at, with),
            ("place", Eye::Switch(_, at, _)) => with(0, at, f64::NEG_INFINITY),
            _ => {}
        }
    } else if let Some(stock) = scene.stock.as_mut().filter(|_| name == "stock") {
        match key {
            "at" => place(&mut stock.at, with),
            "size" => size(&mut stock.size, with),
            "tilt" => {
                for (axis, slope) in stock.tilt.iter_mut().enumerate() {
                    with(axis, slope, f64::NEG_INFINITY);
                }
            }
            _ => {}
        }
    }
}

fn tool_number(kind: &mut ToolKind, key: &str, with: With) {
    let number = match (kind, key) {
        (ToolKind::Vacuum(vacuum), "build_ms") => return ms(&mut vacuum.build_us, with),
        (ToolKind::Vacuum(vacuum), "vent_ms") => return ms(&mut vacuum.vent_us, with),
        (ToolKind::Vacuum(vacuum), "sealed_kpa") => &mut vacuum.sealed_kpa,
        (ToolKind::Vacuum(vacuum), "open_kpa") => &mut vacuum.open_kpa,
        (ToolKind::Vacuum(vacuum), "hold_kpa") => &mut vacuum.hold_kpa,
        (ToolKind::Vacuum(vacuum), "leak_kpa_s") => &mut vacuum.leak_kpa_s,
        (ToolKind::Vacuum(vacuum), "reach") => &mut vacuum.reach,
        (ToolKind::Vacuum(vacuum), "gap") => &mut vacuum.gap,
        (ToolKind::Vacuum(vacuum), "press") => &mut vacuum.press,
        (ToolKind::Vacuum(vacuum), "on_kpa") => &mut vacuum.on_kpa,
        (ToolKind::Vacuum(vacuum), "off_kpa") => &mut vacuum.off_kpa,
        (ToolKind::Gripper(gripper), "opens") => &mut gripper.opens,
        (ToolKind::Gripper(gripper), "close_ms") => return whole(&mut gripper.close_us, with),
        (ToolKind::Drill { diameter, .. }, "diameter") => diameter,
        (ToolKind::Drill { spin_us, .. }, "spin_ms") => return whole(spin_us, with),
        (ToolKind::Flow { flow_mg_s, .. }, "flow_mg_s") => flow_mg_s,
        (ToolKind::Flow { open_us, .. }, "open_ms") => return whole(open_us, with),
        (ToolKind::Flow { close_us, .. }, "close_ms") => return whole(close_us, with),
        (ToolKind::Flow { reach, .. }, "reach") => reach,
        _ => return,
    };
    with(0, number, 0.0);
}
