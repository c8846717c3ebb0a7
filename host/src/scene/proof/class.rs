//! Outcomes of a run under variation.

use cell::scene::Scene;
use cell::vary::Deviation;
use lang::fault::Fault;

use super::super::Report;
use crate::sim::End;
use crate::sim::record::StopReason;
use crate::sim::trace::Status;

/// An outcome: the first that fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Everything holds, and nothing struck that the script had to handle.
    Passed,
    /// It is done; what is missing was hit by a fault and stayed in its feeder, or lies where rejects do.
    Handled,
    /// An expectation does not hold, and nothing was said.
    Wrong,
    /// The tool or a part ran into something.
    Collision,
    /// A tool is on at the end, or holds something.
    Unsafe,
    /// Nothing could happen any more, or the limit came.
    Hang,
    /// It ended in a fault that no handler took.
    Fault,
}

impl Class {
    /// All, in the order of tables.
    pub const ALL: [Class; 7] = [
        Class::Passed,
        Class::Handled,
        Class::Wrong,
        Class::Collision,
        Class::Unsafe,
        Class::Hang,
        Class::Fault,
    ];

    /// Its word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Class::Passed => "passed",
            Class::Handled => "handled",
            Class::Wrong => "wrong",
            Class::Collision => "collision",
            Class::Unsafe => "unsafe",
            Class::Hang => "hang",
            Class::Fault => "fault",
        }
    }

    /// Whether the script is not right.
    #[must_use]
    pub const fn fails(self) -> bool {
        !matches!(self, Class::Passed | Class::Handled)
    }
}

/// A fault, not a tolerance.
fn is_fault(deviation: &Deviation) -> bool {
    !deviation.what.contains('.')
}

/// The outcome of a run.
pub fn classify(
    report: &Report,
    end: &End,
    stopped: Option<StopReason>,
    deviations: &[Deviation],
    scene: &Scene,
) -> Class {
    if report.log.iter().any(cell::log::Event::is_collision) {
        return Class::Collision;
    }
    // A person who stops the machine leaves it as it is: nothing is to be expected of that run but that it is safe. A
    // fault of the script's own is one, whatever was to strike later.
    let struck = |words: &[&str]| deviations.iter().any(|own| words.contains(&own.what.as_str()));
    let broken_off = match end.status {
        Status::Stopped => stopped == Some(StopReason::Button) && struck(&["stop"]),
        Status::Fault => end.fault == Some(Fault::EmergencyStop) && struck(&["estop"]),
        _ => false,
    };
    let is_on = |tool: &cell::scene::Tool| tool.output.is_some_and(|n| report.end.on.contains(&n));
    if scene.tools.iter().any(is_on) || !broken_off && !report.held.is_empty() {
        return Class::Unsafe;
    }
    let expects_end = report.judges_end();
    match end.status {
        Status::Stopped if stopped != Some(StopReason::Button) => return Class::Hang,
        Status::Fault if !broken_off && !expects_end => return Class::Fault,
        _ => {}
    }
    if broken_off {
        return Class::Handled;
    }
    let excused = |thing: &String| {
        let hit = deviations.iter().any(|own| is_fault(own) && own.of == *thing);
        let missing = deviations.iter().any(|own| own.what == "missing" && own.of == *thing);
        hit && (missing || report.stayed.contains(thing) || report.rejected.contains(thing))
    };
    let mut handled = false;
    for row in report.rows.iter().filter(|row| !row.holds) {
        let late = row.what == "time" && struck(&["pause", "late", "door", "stop"]);
        // Of parts that `count` does not ask for, those that stayed in their feeder are no matter.
        let (open, known) = (row.things.iter().filter(|thing| !excused(thing)), &report.stayed);
        let (stayed, others): (Vec<_>, Vec<_>) = open.partition(|thing| known.contains(thing));
        let by_things = !row.things.is_empty() && others.is_empty() && stayed.len() <= row.spare;
        if !late && !by_things {
            return Class::Wrong;
        }
        handled = true;
    }
    if handled { Class::Handled } else { Class::Passed }
}
