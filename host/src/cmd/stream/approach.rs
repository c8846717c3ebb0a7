//! Start in the middle of a job: the line is found, shown and confirmed, and the board is brought there.

use std::io::{BufRead, IsTerminal};

use lang::fault::Fault;
use lang::profile::Profile;

use super::Stream;
use crate::cmd::console::Console;
use crate::cmd::port::Board;
use crate::failure::Failure;
use crate::stream::feed::Feed;
use crate::stream::job::Goal;
use crate::stream::near;
use crate::stream::way::{self, NoWay, Way};
use crate::track::Track;

/// A length in mm, as um.
///
/// # Errors
/// It is none, or longer than 1 km.
pub fn mm(text: &str) -> Result<i32, String> {
    let value = text.trim_end_matches("mm").trim().parse::<f64>();
    let um = value.ok().map(|value| value * 1000.0).filter(|um| um.abs() <= 1e9);
    um.map(|um| um.round() as i32).ok_or_else(|| "write a number of mm: 5, -1.5".to_owned())
}

/// Two lengths, X and Y.
///
/// # Errors
/// As [`mm`].
pub fn place(text: &str) -> Result<[i32; 2], String> {
    let (x, y) = text.split_once(',').ok_or("write two numbers of mm with a comma: 20,35.5")?;
    Ok([mm(x)?, mm(y)?])
}

fn list(steps: [i32; 3], profile: &Profile) -> String {
    let axes = profile.axes().map(|(axis, _)| format!("{} {}", axis.letter(), steps[axis.index()]));
    axes.collect::<Vec<_>>().join(", ")
}

impl Stream {
    /// Where the job is to go on.
    ///
    /// # Errors
    /// No line comes near the place that was named.
    pub(super) fn goal(
        &self,
        feed: &Feed<'_>,
        profile: &Profile,
        console: &Console,
    ) -> Result<Goal, Failure> {
        let Some(place) = self.from_place else {
            return Ok(Goal::Line { line: self.from_line, pass: self.pass });
        };
        let (goal, far) = near::nearest(feed.clone(), profile, place)
            .map_err(|refused| self.refuse(refused, console))?;
        if let Goal::Effect { line, .. } = goal {
            let far = far / 1000.0;
            console.complain(&format!("line {line} is the first to pass there, {far:.2} mm away"));
        }
        Ok(goal)
    }

    /// Shows how the board comes to where the job goes on, and asks.
    ///
    /// # Errors
    /// The board has a fault latched, or has not homed what the job had; the user says no.
    pub(super) fn approach(
        &self,
        track: &Track,
        goal: Goal,
        board: &mut Board,
        console: &Console,
    ) -> Result<Way, Failure> {
        let way = way::find(board, track, self.lift).map_err(|none| match none {
            NoWay::Link(error) => error.into(),
            NoWay::Latched => Failure::Board(
                "a fault is latched: `pasapas status` tells, `pasapas start` acknowledges".to_owned(),
            ),
            NoWay::NotHomed(axis) => {
                let letter = axis.letter();
                Failure::Board(format!(
                    "the job has homed {letter} before that line, and the board has not: nobody knows where {letter} \
                     stands; `pasapas home {letter}` first"
                ))
            }
            NoWay::Wrong(fault) => self.wrong_place(fault),
        })?;
        self.confirm(&way, goal, track.profile(), console)?;
        Ok(way)
    }

    /// A place that no board can go to.
    pub(super) fn wrong_place(&self, fault: Fault) -> Failure {
        Failure::Usage(format!("{}: the way to that line: {fault} {}", self.file, fault.text()))
    }

    fn confirm(
        &self,
        way: &Way,
        goal: Goal,
        profile: &Profile,
        console: &Console,
    ) -> Result<(), Failure> {
        let (line, pass) = match goal {
            Goal::Line { line, pass } => (line, pass),
            Goal::Effect { line, .. } => (line, 1),
        };
        console.complain(&format!(
            "line {line}{} begins at {}; the board stands at {} (machine steps)",
            if pass > 1 { format!(", pass {pass},") } else { String::new() },
            list(way.approach.steps, profile),
            list(way.there, profile)
        ));
        if !way.approach.legs.is_empty() {
            console.complain(&format!(
                "it goes there first, with its outputs off: {} (machine positions); then outputs are as the job has \
                 them there",
                way::told(&way.approach)
            ));
        }
        if self.yes {
            return Ok(());
        }
        if !std::io::stdin().is_terminal() {
            return Err(Failure::Usage(
                "where nobody can be asked, --yes says that this way is free".to_owned(),
            ));
        }
        console.complain("Is this way free? yes, or anything else:");
        let mut answer = String::new();
        match std::io::stdin().lock().read_line(&mut answer) {
            Ok(_) if answer.trim() == "yes" => Ok(()),
            _ => Err(Failure::Usage("nothing was moved".to_owned())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{mm, place};

    #[test]
    fn places_are_millimetres() {
        assert_eq!(mm("5"), Ok(5_000));
        assert_eq!(mm("-1.5mm"), Ok(-1_500));
        assert!(mm("1e99").is_err() && mm("nan").is_err() && mm("").is_err());
        assert_eq!(place("20,35.5"), Ok([20_000, 35_500]));
        assert!(place("20").is_err());
    }
}
