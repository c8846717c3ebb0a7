//! `pasapas home`, `jog` and `io`: commissioning, one line each.
//!
//! They use InterpCNC's commands 106 and 103 with the parameters of the machine that `--profile` names, so they
//! work on a board without a program too, or with those of the axes that the board itself tells.

use std::time::Duration;

use clap::Args;
use lang::axis::Axis;
use lang::profile::Profile;
use lang::record::MachineRecord;
use lang::wire::{self, command};
use serde_json::json;

use super::console::{Console, Options};
use super::port::{Board, Port};
use super::upload;
use crate::client::status::long;
use crate::client::{ClientError, orders};
use crate::failure::Failure;
use crate::link::Link;

/// Longest jog, mm: a mistyped digit must not cross the machine.
const LONGEST_JOG_UM: i64 = 100_000;
/// Longest time that a jog or a reference run may take.
const MOVE_PATIENCE: Duration = Duration::from_secs(600);

/// `pasapas home`
#[derive(Debug, Args)]
pub struct Home {
    /// Axes in order; without any the profile's order
    #[arg(value_parser = axis)]
    axes: Vec<Axis>,
    /// Home although the board's machine is another one
    #[arg(long)]
    any_profile: bool,
    #[command(flatten)]
    port: Port,
}

/// `pasapas jog`
#[derive(Debug, Args)]
pub struct Jog {
    /// The axis
    #[arg(value_parser = axis)]
    axis: Axis,
    /// How far: 5mm, -0.1mm, 250um, -40st; at most 100 mm
    #[arg(value_parser = distance, allow_hyphen_values = true)]
    distance: Distance,
    /// Speed in steps/s; without it a quarter of the profile's top
    #[arg(long, value_name = "ST/S")]
    speed: Option<u32>,
    /// Move although the board's machine is another one
    #[arg(long)]
    any_profile: bool,
    #[command(flatten)]
    port: Port,
}

/// `pasapas io`
#[derive(Debug, Args)]
pub struct Io {
    /// Outputs to set, such as 1=on 4=off
    #[arg(value_parser = setting, value_name = "N=on|off")]
    set: Vec<(u16, bool)>,
    #[command(flatten)]
    port: Port,
}

/// A relative distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Distance {
    Um(i64),
    Steps(i64),
}

fn axis(text: &str) -> Result<Axis, String> {
    let mut letters = text.chars();
    match (letters.next().and_then(Axis::from_letter), letters.next()) {
        (Some(axis), None) => Ok(axis),
        _ => Err("an axis is X, Y or Z".to_owned()),
    }
}

fn distance(text: &str) -> Result<Distance, String> {
    let number = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let wrong = || "a distance is a number with mm, um or st: 5mm, -40st".to_owned();
    let value: f64 = number.parse().map_err(|_| wrong())?;
    let um = match &text[number.len()..] {
        "mm" => value * 1000.0,
        "um" => value,
        "st" if value.fract() == 0.0 && value.abs() < 1e9 => {
            return Ok(Distance::Steps(value as i64));
        }
        _ => return Err(wrong()),
    };
    if um.is_finite() && um.abs() < 1e9 {
        Ok(Distance::Um(um.round() as i64))
    } else {
        Err(wrong())
    }
}

fn setting(text: &str) -> Result<(u16, bool), String> {
    let wrong = || "write a number, = and on or off: 3=on".to_owned();
    let (number, state) = text.split_once('=').ok_or_else(wrong)?;
    let number = number.parse().map_err(|_| wrong())?;
    match state.to_ascii_lowercase().as_str() {
        "on" | "1" => Ok((number, true)),
        "off" | "0" => Ok((number, false)),
        _ => Err(wrong()),
    }
}

/// Motor steps of a distance, half away from zero.
fn steps(profile: &Profile, axis: Axis, distance: Distance) -> Result<i64, Failure> {
    let own = orders::present(profile, axis).map_err(Failure::Usage)?;
    let (up, down) = (i64::from(own.scale.steps), i64::from(own.scale.um));
    let (steps, um) = match distance {
        Distance::Steps(steps) => (steps, steps * down / up),
        Distance::Um(um) => (orders::steps(own, um), um),
    };
    if um.abs() > LONGEST_JOG_UM {
        let text = format!("{} mm is more than a jog may go: 100 mm", um as f64 / 1000.0);
        return Err(Failure::Usage(text));
    }
    Ok(steps)
}

/// Axes that another machine has would be moved too far, or the wrong way.
///
/// # Errors
/// The board's profile is another one, or the program on it was made for other axes.
fn must_be(board: &mut Board, profile: &Profile) -> Result<(), Failure> {
    match board.board_record() {
        // What a lock hides cannot be compared; the program's axes can.
        Err(ClientError::Locked) => {}
        held => upload::must_match(&held?, profile)?,
    }
    if board.identity()?.program_bytes == 0 {
        return Ok(());
    }
    if board.holding(wire::PROGRAM_PROFILE, 1)?[0] == MachineRecord::of(profile).hash() {
        return Ok(());
    }
    Err(Failure::Board(format!(
        "the program on the board was made for other axes than those of `{}`: name its machine with \
         --profile, or upload a program for this one; --any-profile goes on all the same",
        profile.name
    )))
}

impl Options {
    /// The profile for commands that have no script.
    pub(super) fn machine(&self, console: &Console) -> Result<Profile, Failure> {
        match self.profile(console)? {
            Some(profile) => Ok(profile),
            None => Profile::built_in(lang::profile::DEFAULT_NAME)
                .map_err(|error| Failure::Usage(error.to_string())),
        }
    }
}

/// The machine of a board that is to move: that of `--profile`, which must be the board's own unless `any`, or what the
/// board itself tells. Never another one.
///
/// # Errors
/// The machines differ, or the board tells none.
fn machine_of(
    board: &mut Board,
    any: bool,
    options: &Options,
    console: &Console,
) -> Result<Profile, Failure> {
    if let Some(profile) = options.profile(console)? {
        if !any {
            must_be(board, &profile)?;
        }
        return Ok(profile);
    }
    let axes = board.axes()?;
    let base = axes.profile().ok_or_else(|| {
        Failure::Usage(format!(
            "{axes}: name its machine with --profile, or bring it with `pasapas profile set FILE`"
        ))
    })?;
    match board.board_record() {
        Ok(record) => Ok(record.into_profile(&base)),
        // What a lock hides nobody reads: a built-in machine is known all the same.
        Err(ClientError::Locked) => Ok(base),
        Err(error) => Err(error.into()),
    }
}

impl Home {
    /// References the axes one after the other.
    ///
    /// # Errors
    /// A switch is not found, or the board does not do it.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let mut board = self.port.connect(options, console)?;
        let profile = machine_of(&mut board, self.any_profile, options, console)?;
        let axes = match self.axes.as_slice() {
            [] => profile.home_order.iter().map(|name| Axis::from(*name)).collect(),
            axes => axes.to_vec(),
        };
        for axis in axes {
            let order = orders::home(&profile, axis).map_err(Failure::Usage)?;
            let wrong = || {
                format!(
                    "the board does not home {} so: check rates, stroke and switch in the profile `{}`",
                    axis.letter(),
                    profile.name
                )
            };
            board.order(&order, wrong).map_err(Failure::Board)?;
            wait(&mut board, axis, "homing")?;
            let homing = board.input(wire::HOMING, 1)?[0];
            if homing >> (8 + axis.index()) & 1 != 0 {
                let letter = axis.letter();
                return Err(Failure::Board(format!(
                    "{letter} did not find its switch or it stayed closed: check the switch, its \
                     wiring, and direction and stroke in the profile"
                )));
            }
            tell(&mut board, axis, console)?;
        }
        Ok(())
    }
}

impl Jog {
    /// Moves one axis and waits until it rests.
    ///
    /// # Errors
    /// The distance is too long, or the board does not do it.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let mut board = self.port.connect(options, console)?;
        let profile = machine_of(&mut board, self.any_profile, options, console)?;
        let steps = steps(&profile, self.axis, self.distance)?;
        let Some(own) = profile.axis(self.axis) else { return Ok(()) };
        let top = own.top_rate.unsigned_abs();
        let speed = self.speed.unwrap_or((top / 4).max(1)).clamp(1, top);
        // By the place to go to, which is told.
        let place = board.input(wire::WORK_POSITIONS + 2 * self.axis.index() as u16, 2)?;
        let target = i64::from(long(place[0], place[1])) + steps;
        let order = orders::move_to(self.axis, orders::ramps(own), speed, target);
        let wrong = || {
            let mm = |steps: i64| {
                let um = steps * i64::from(own.scale.um) / i64::from(own.scale.steps);
                format!("{} mm", um as f64 / 1000.0)
            };
            let (least, most) = (own.min_um, own.max_um);
            format!(
                "{letter} does not go from {} to {}: the travel of `{}` is {} to {} mm in machine \
                 positions, and a homed axis keeps to it",
                mm(target - steps),
                mm(target),
                profile.name,
                f64::from(least) / 1000.0,
                f64::from(most) / 1000.0,
                letter = self.axis.letter(),
            )
        };
        board.order(&order, wrong).map_err(Failure::Board)?;
        wait(&mut board, self.axis, "the move")?;
        tell(&mut board, self.axis, console)
    }
}

/// Waits until the axis neither moves nor homes.
fn wait(board: &mut Board, axis: Axis, what: &str) -> Result<(), Failure> {
    let end = board.link().now() + MOVE_PATIENCE;
    loop {
        // A command is taken within some ms: a look at once would see the axis still at rest.
        board.link().pause(Duration::from_millis(30));
        let words = board.input(wire::MOVING, 2)?;
        if (words[0] | words[1]) >> axis.index() & 1 == 0 {
            return Ok(());
        }
        if board.link().now() > end {
            let _ = board.write_all(wire::COMMAND, &[command::STOP_AXES, 0b111]);
            return Err(Failure::Board(format!("{what} did not end; the axes are stopped")));
        }
    }
}

fn tell(board: &mut Board, axis: Axis, console: &Console) -> Result<(), Failure> {
    let status = board.status()?;
    let place = status.pos.get(axis).unwrap_or(0);
    if let Some(fault) = &status.fault {
        let text = status.text.unwrap_or_default();
        console.complain(&format!("{fault} {text} is latched; `pasapas start` acknowledges"));
    }
    if console.json() {
        return console.json_line(&json!({
            "axis": axis.letter(), "pos": place, "homed": status.homed.contains(&axis.letter()),
        }));
    }
    let homed = if status.homed.contains(&axis.letter()) { "" } else { " (not homed)" };
    console.result(&format!("{} {place} st{homed}\n", axis.letter()))
}

impl Io {
    /// Sets outputs, then shows inputs and outputs.
    ///
    /// # Errors
    /// The board refuses or does not answer.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let mut board = self.port.connect(options, console)?;
        for &(n, on) in &self.set {
            let coil = n.checked_sub(1).filter(|coil| *coil < 16);
            let coil =
                coil.ok_or_else(|| Failure::Usage("outputs count from 1 to 16".to_owned()))?;
            board.set_coil(wire::COILS + coil, on)?;
        }
        let status = board.status()?;
        if console.json() {
            return console
                .json_line(&json!({ "inputs": status.inputs, "outputs": status.outputs }));
        }
        let list = |numbers: &[u16]| {
            let words: Vec<String> = numbers.iter().map(u16::to_string).collect();
            if words.is_empty() { "none".to_owned() } else { words.join(" ") }
        };
        console.result(&format!(
            "inputs on: {}; outputs on: {}\n",
            list(&status.inputs),
            list(&status.outputs)
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::{Distance, axis, distance, setting, steps};
    use lang::axis::Axis;
    use lang::profile::Profile;

    #[test]
    fn arguments_are_read_strictly() {
        assert_eq!(distance("-0.25mm"), Ok(Distance::Um(-250)));
        assert_eq!(distance("40st"), Ok(Distance::Steps(40)));
        for wrong in ["5", "mm", "1.5st", "nanmm", "5 mm", "1e300mm"] {
            assert!(distance(wrong).is_err(), "{wrong}");
        }
        assert_eq!(setting("4=OFF"), Ok((4, false)));
        assert!(setting("4").is_err() && setting("x=on").is_err());
        assert!(axis("W").is_err() && axis("XY").is_err());
    }

    #[test]
    fn a_jog_is_rounded_and_bounded() {
        let thesis = Profile::built_in("thesis").expect("built in");
        assert_eq!(steps(&thesis, Axis::X, Distance::Um(20)).ok(), Some(1));
        assert_eq!(steps(&thesis, Axis::X, Distance::Um(-20)).ok(), Some(-1));
        assert_eq!(steps(&thesis, Axis::X, Distance::Um(19)).ok(), Some(0));
        assert!(steps(&thesis, Axis::X, Distance::Um(100_001)).is_err());
        assert!(steps(&thesis, Axis::X, Distance::Steps(900_000_000)).is_err());
    }
}
