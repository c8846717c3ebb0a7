//! Charts of speed over time of two jobs of the set: resting at every corner, as the F5529 runs it, and by
//! the ideal planner.

use std::path::Path;

use emulator::{Edge, Signal, TICKS_PER_SECOND};
use lang::profile::Profile;

use super::ideal::Machine;
use super::jobs::{self, Job};
use super::pace::{Pace, paces};
use super::{Way, program};
use crate::board::F5529;
use crate::output;

/// The jobs that are drawn: one of corners, one of a curve.
const JOBS: [&str; 2] = ["outlines_f3000_table", "circle_r5_100um_f3000_table"];
/// Events over which a speed is measured: as few as let those of two axes in between say little.
const EVENTS: usize = 8;

/// Writes a picture of each, `JOB.svg`, into a folder that is there.
///
/// # Errors
/// A job does not run, or the folder takes no file.
pub fn draw(folder: &Path) -> Result<(), String> {
    let mill = Profile::built_in("mill").map_err(|error| error.to_string())?;
    let machine = Machine::of(&mill);
    let mut way = Way::on(&F5529, &mill, false)?;
    for job in jobs::all().iter().filter(|job| JOBS.contains(&job.name.as_str())) {
        // Exact stops at the corners.
        let rests = job.text.replacen("G90\n", "G90\nG61\n", 1);
        let runs = [
            measured("resting at every corner", job, &rests, &mut way, &mill)?,
            measured("as it is", job, &job.text, &mut way, &mill)?,
            Pace {
                name: "ideal planner",
                seconds: machine.best(&job.legs).seconds,
                points: machine.speeds(&job.legs).iter().map(|[s, um]| [*s, um / 1e3]).collect(),
            },
        ];
        let path = folder.join(format!("{}.svg", job.name));
        output::replace(&path, paces(&job.name, &runs).as_bytes())
            .map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(())
}

/// A run of a job's script at the pins.
fn measured(
    name: &'static str,
    job: &Job,
    text: &str,
    way: &mut Way,
    mill: &Profile,
) -> Result<Pace, String> {
    let (checked, _) = program(&job.name, text)?;
    let edges = way.edges(&checked)?.ok_or_else(|| format!("no room for {}", job.name))?;
    let points = speeds(&edges, mill);
    Ok(Pace { name, seconds: points.last().map_or(0.0, |last| last[0]), points })
}

/// Times from output 1 going on, s, and speeds along the path, mm/s, until it goes off.
fn speeds(edges: &[Edge], profile: &Profile) -> Vec<[f64; 2]> {
    let gate = |level: bool| {
        let found = edges.iter().rev().find(|e| e.signal == Signal::Out(1) && e.level == level);
        found.map_or(0, |edge| edge.cycle)
    };
    let (on, off) = (gate(true), gate(false));
    let seconds = |cycle: u64| (cycle - on) as f64 / TICKS_PER_SECOND as f64;
    let mm = [&profile.x, &profile.y, &profile.z].map(|axis| {
        axis.as_ref().map_or(0.0, |own| f64::from(own.scale.um) / f64::from(own.scale.steps) / 1e3)
    });
    // A direction whose line is never switched may be either: distances are the same.
    let mut negative: [bool; 3] = std::array::from_fn(|axis| {
        let first = edges.iter().find(|edge| edge.signal == Signal::Dir(axis as u8));
        first.is_some_and(|edge| !edge.level)
    });
    let (mut at, mut places) = ([0.0; 3], vec![(on, [0.0; 3])]);
    for edge in edges {
        match edge.signal {
            Signal::Dir(axis) => negative[usize::from(axis)] = edge.level,
            Signal::Step(axis) if edge.level && (on..off).contains(&edge.cycle) => {
                let axis = usize::from(axis);
                at[axis] += if negative[axis] { -mm[axis] } else { mm[axis] };
                match places.last_mut() {
                    Some(last) if last.0 == edge.cycle => last.1 = at,
                    _ => places.push((edge.cycle, at)),
                }
            }
            _ => {}
        }
    }
    let mut points = vec![[0.0; 2]];
    for pair in places.chunks(EVENTS).map(|run| run[0]).collect::<Vec<_>>().windows(2) {
        let [(from, a), (to, b)] = [pair[0], pair[1]];
        let way: f64 = (0..3).map(|n| (b[n] - a[n]).powi(2)).sum();
        let (from, to) = (seconds(from), seconds(to));
        points.push([(from + to) / 2.0, way.sqrt() / (to - from)]);
    }
    points.push([seconds(off), 0.0]);
    points
}

#[cfg(test)]
mod tests {
    use super::{JOBS, draw};

    #[test]
    fn a_picture_of_each_job_names_its_curves_and_what_they_take() {
        let folder = tempfile::tempdir().expect("a folder");
        draw(folder.path()).expect("pictures");
        for job in JOBS {
            let path = folder.path().join(format!("{job}.svg"));
            let svg = std::fs::read_to_string(path).expect("a picture");
            for name in ["resting at every corner", "as it is", "ideal planner", "mm/s", "Time, s"]
            {
                assert!(svg.contains(name), "{job} without {name}");
            }
            // Of all three in the title, and of each beside its name.
            assert_eq!(svg.matches(" s, ").count(), 2, "{job}: what they take");
        }
    }
}
