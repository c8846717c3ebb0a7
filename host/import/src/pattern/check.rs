//! What a pattern means on a machine: its travel, and whether the compiler takes its script.

use lang::axis::Axis;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::{AxisProfile, Profile};

use super::{Pattern, Point};
use crate::script::mm;

/// The axis that a pattern needs.
///
/// # Errors
/// The machine has none; in words.
pub(super) fn needed(profile: &Profile, axis: Axis) -> Result<&AxisProfile, String> {
    profile
        .axis(axis)
        .ok_or_else(|| format!("the machine `{}` has no axis {}", profile.name, axis.letter()))
}

/// What lies outside of the travel, in words.
pub(super) fn travel(pattern: &Pattern, points: &[Point], profile: &Profile) -> Vec<String> {
    let mut notes = Vec::new();
    let outside = |axis: Axis, um: i64| {
        let within = |own: &AxisProfile| (i64::from(own.min_um)..=own.max_um.into()).contains(&um);
        profile.axis(axis).is_some_and(|own| !within(own))
    };
    let out = |point: &&Point| outside(Axis::X, point.at[0]) || outside(Axis::Y, point.at[1]);
    let count = points.iter().filter(out).count();
    if let Some(first) = points.iter().find(out) {
        notes.push(format!(
            "{count} of {} points lie outside of the machine's travel, the first at X {}, Y {}",
            points.len(),
            mm(first.at[0]),
            mm(first.at[1])
        ));
    }
    if let (Some(down), Some(z)) = (&pattern.work.down, &profile.z) {
        let up = i64::from(z.upward());
        let ends = [down.surface - up * down.depth, down.surface + up * down.clear];
        if let Some(um) = ends.into_iter().find(|um| outside(Axis::Z, *um)) {
            notes.push(format!("Z {} lies outside of the machine's travel", mm(um)));
        }
    }
    notes
}

/// Compiles what was written.
///
/// # Errors
/// What the compiler says of it.
pub(super) fn try_out(text: &str, profile: &Profile) -> Result<(), String> {
    let source = Source::new("pattern", text.to_owned());
    let (_, found) = compile(&source, ProfileChoice::Given(Box::new(profile.clone())));
    match found.into_sorted().into_iter().find(|diag| diag.is_error()) {
        None => Ok(()),
        Some(diag) => {
            let line = source.line(diag.span.start);
            Err(format!("{} (in the script: `{}`)", diag.message, source.line_text(line).trim()))
        }
    }
}
