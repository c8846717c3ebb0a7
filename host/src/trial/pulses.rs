//! Input pulses that a user draws on the timeline of a simulation. They are lines at the end of the script's
//! world, so that `sim` and `board` play them too, and an editor of the world can change them.

use serde::{Deserialize, Serialize};

/// An input is on for a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pulse {
    /// The input's number, from 1.
    pub input: u32,
    /// When it goes on, ms since the run began.
    pub from: u32,
    /// When it goes off, ms.
    pub to: u32,
}

/// Pulses of one script.
const MOST: usize = 1_000;
/// Highest number of an input of any wiring.
const INPUTS: u32 = 17;
/// Latest end, ms: a day.
const LATEST: u32 = 86_400_000;
/// Stands before the pulses in a world.
const MARK: &str = "// Drawn in the workbench:";
/// What a world says that has nothing but pulses: all else is as without a world.
const ALONE: &str = "unattended();\n";

impl Pulse {
    fn line(self) -> String {
        let Pulse { input, from, to } = self;
        format!("at({from}, || set_in({input}, true)); at({to}, || set_in({input}, false));")
    }

    /// Reads what [`Pulse::line`] wrote.
    fn of_line(line: &str) -> Option<Pulse> {
        let numbers = line.split(|c: char| !c.is_ascii_digit()).filter(|word| !word.is_empty());
        let numbers = numbers.map(str::parse).collect::<Result<Vec<u32>, _>>().ok()?;
        let [from, input, to, _] = numbers[..] else { return None };
        let pulse = Pulse { input, from, to };
        (pulse.line() == line.trim_end()).then_some(pulse)
    }
}

/// Parts a world's text: what a person wrote, and the pulses behind it.
pub fn split(world: &str) -> (String, Vec<Pulse>) {
    let mut rest = String::new();
    let mut pulses = Vec::new();
    for line in world.lines() {
        match Pulse::of_line(line) {
            Some(pulse) => pulses.push(pulse),
            None if line == MARK => {}
            None => {
                rest.push_str(line);
                rest.push('\n');
            }
        }
    }
    (rest, pulses)
}

/// The world's text with these pulses; empty where there is nothing in it.
pub fn join(rest: &str, pulses: &[Pulse]) -> String {
    if pulses.is_empty() {
        return if rest == ALONE { String::new() } else { rest.to_owned() };
    }
    let mut text = if rest.trim().is_empty() { ALONE } else { rest }.to_owned();
    if !text.ends_with('\n') {
        text.push('\n');
    }
    text.push_str(MARK);
    text.push('\n');
    for pulse in pulses {
        text.push_str(&pulse.line());
        text.push('\n');
    }
    text
}

/// The pulses in order of their inputs and times; those of one input that meet become one.
///
/// # Errors
/// There are too many, or one is none; in words.
pub fn tidy(mut pulses: Vec<Pulse>) -> Result<Vec<Pulse>, String> {
    if pulses.len() > MOST {
        return Err(format!("a simulation has at most {MOST} pulses: write a world instead"));
    }
    for Pulse { input, from, to } in &pulses {
        if !(1..=INPUTS).contains(input) {
            return Err(format!("there is no input {input}: inputs are 1 to {INPUTS}"));
        }
        if from >= to || *to > LATEST {
            return Err("a pulse ends after it begins, and within a day".to_owned());
        }
    }
    pulses.sort_unstable();
    pulses.dedup_by(|next, before| {
        let meet = next.input == before.input && next.from <= before.to;
        if meet {
            before.to = before.to.max(next.to);
        }
        meet
    });
    Ok(pulses)
}

#[cfg(test)]
mod tests {
    use super::{Pulse, join, split, tidy};
    use crate::sim::world::World;

    fn pulse(input: u32, from: u32, to: u32) -> Pulse {
        Pulse { input, from, to }
    }

    #[test]
    fn a_world_keeps_what_a_person_wrote_and_the_pulses() {
        let own = "// a part comes\nat(100, || set_in(2, true));\n";
        let pulses = [pulse(3, 1_200, 1_500), pulse(4, 0, 20)];
        let text = join(own, &pulses);
        assert!(
            text.starts_with(own) && text.contains("at(1200, || set_in(3, true)); at(1500,"),
            "{text}"
        );
        assert!(World::parse("a.rhai", &text).is_ok());
        assert_eq!(split(&text), (own.to_owned(), pulses.to_vec()));
        // A second one does not pile up, and without pulses the world is as it was.
        assert_eq!(join(&split(&text).0, &split(&text).1), text);
        assert_eq!(join(&split(&text).0, &[]), own);
    }

    #[test]
    fn pulses_alone_leave_all_else_as_without_a_world() {
        let text = join("", &[pulse(3, 5, 9)]);
        let world = World::parse("a.rhai", &text).expect("a world");
        let scenario = world.start(&Default::default()).expect("it starts");
        assert!(scenario.is_unattended(), "{text}");
        assert_eq!(join(&split(&text).0, &[]), "");
        // A world of somebody's own is one with somebody in it.
        let world =
            World::parse("a.rhai", &join("let n = 1;\n", &[pulse(3, 5, 9)])).expect("a world");
        assert!(!world.start(&Default::default()).expect("it starts").is_unattended());
    }

    #[test]
    fn pulses_that_meet_are_one_and_wrong_ones_are_refused() {
        let tidied =
            tidy(vec![pulse(3, 50, 90), pulse(2, 0, 5), pulse(3, 10, 50), pulse(3, 100, 110)]);
        assert_eq!(tidied, Ok(vec![pulse(2, 0, 5), pulse(3, 10, 90), pulse(3, 100, 110)]));
        for wrong in [pulse(0, 1, 2), pulse(18, 1, 2), pulse(3, 5, 5), pulse(3, 5, 86_400_001)] {
            assert!(tidy(vec![wrong]).is_err(), "{wrong:?}");
        }
        assert!(tidy(vec![pulse(1, 0, 1); 1_001]).is_err());
        // What only looks like one stays a person's line.
        for line in
            ["at(1, || set_in(3, true)); at(2, || set_in(4, false));", "at(1, || set_in(3, true));"]
        {
            assert_eq!(split(line), (format!("{line}\n"), Vec::new()));
        }
    }
}
