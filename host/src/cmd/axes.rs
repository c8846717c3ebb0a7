//! `pasapas home`, `jog` and `io`: commissioning, one line each.
//!
//! They use InterpCNC's commands 106 and 103 with the parameters of the machine that `--profile` names, so they
//! work on a board without a program, too; without `--profile` the board's own axes are used.

use std::time::Duration;

use clap::Args;
use lang::axis::Axis;
use lang::fault::Fault;
use lang::profile::{AxisProfile, Profile};
use lang::record::MachineRecord;
use lang::wire::{self, RunState, command};
use serde_json::json;

use super::console::{Console, Options};
use super::port::{Board, Port};
use super::upload;
use crate::client::status::{Status, long};
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
    /// How fast: 10mm/s, 600mm/min, 500um/s or 800st/s, and a number alone is steps/s; without it a quarter of the
    /// profile's top
    #[arg(long, value_parser = speed)]
    speed: Option<Speed>,
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

/// A speed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Speed {
    /// um/s.
    Um(f64),
    /// Steps/s.
    Steps(f64),
}

impl Speed {
    /// In whole steps/s, at least 1.
    fn steps(self, own: &AxisProfile) -> u32 {
        let steps = match self {
            Speed::Steps(steps) => steps,
            Speed::Um(um) => um * f64::from(own.scale.steps) / f64::from(own.scale.um),
        };
        (steps.round() as u32).max(1)
    }
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

fn speed(text: &str) -> Result<Speed, String> {
    let wrong = || {
        "a speed is a number with mm/s, mm/min, um/s or st/s: 10mm/s, 600mm/min, 800st/s".to_owned()
    };
    let unit = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let value: f64 = text[..unit].parse().map_err(|_| wrong())?;
    if !(value > 0.0 && value < 1e9) {
        return Err(wrong());
    }
    match &text[unit..] {
        "" | "st/s" => Ok(Speed::Steps(value)),
        "mm/s" => Ok(Speed::Um(value * 1e3)),
        "mm/min" => Ok(Speed::Um(value * 1e3 / 60.0)),
        "um/s" => Ok(Speed::Um(value)),
        _ => Err(wrong()),
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
            let status = tell(&mut board, axis, console)?;
            if !status.homed.contains(&axis.letter()) {
                let what = format!("{} is not homed", axis.letter());
                return Err(cut_short(&what, &status, &profile));
            }
            remind(&status, console);
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
        let speed = self.speed.map_or((top / 4).max(1), |speed| speed.steps(own));
        if speed > top {
            let letter = self.axis.letter();
            console.complain(&format!("{letter} goes at its top, {top} st/s, not at {speed} st/s"));
        }
        let speed = speed.min(top);
        // By the place to go to, which is told.
        let target = i64::from(work_place(&mut board, self.axis)?) + steps;
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
        let place = i64::from(work_place(&mut board, self.axis)?);
        let status = tell(&mut board, self.axis, console)?;
        if place == target {
            remind(&status, console);
            return Ok(());
        }
        let what = format!(
            "{} came {} of its {steps} steps far",
            self.axis.letter(),
            place - (target - steps)
        );
        Err(cut_short(&what, &status, &profile))
    }
}

/// Work position of an axis in steps.
fn work_place(board: &mut Board, axis: Axis) -> Result<i32, ClientError> {
    let words = board.input(wire::WORK_POSITIONS + 2 * axis.index() as u16, 2)?;
    Ok(long(words[0], words[1]))
}

/// What kept a move from its end, and what to do about it.
fn cut_short(what: &str, status: &Status, profile: &Profile) -> Failure {
    let (latched, text) = (latched(status), status.text.unwrap_or_default());
    let input = status.input.map_or(String::new(), |input| format!(" (input {input})"));
    let is_limit = |fault: &&String| **fault == Fault::LimitSwitch.to_string();
    let off = latched.filter(is_limit).and(status.input);
    Failure::Board(match (latched, off.and_then(|input| orders::off_switch(profile, input))) {
        (Some(fault), Some((axis, jog))) => format!(
            "{what}: {fault} {text} of {}{input}; `{jog}` leaves the switch, then `pasapas start` \
             acknowledges the fault",
            axis.letter()
        ),
        (Some(fault), None) => format!(
            "{what}: {fault} {text}{input}; put that right, then `pasapas start` acknowledges the fault"
        ),
        (None, _) => match status.blocked_by {
            Some(input) => format!("{what}: input {input} keeps it from moving"),
            None => format!("{what}: somebody stopped it"),
        },
    })
}

/// A fault that keeps programs from running.
fn latched(status: &Status) -> Option<&String> {
    status.fault.as_ref().filter(|_| status.run_state == Some(RunState::Fault))
}

/// A move went well although a fault is there: what the fault still keeps from working.
fn remind(status: &Status, console: &Console) {
    if let Some(fault) = latched(status) {
        let text = status.text.unwrap_or_default();
        console.complain(&format!("{fault} {text} is latched; `pasapas start` acknowledges"));
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

/// Tells where an axis is; the board's state.
fn tell(board: &mut Board, axis: Axis, console: &Console) -> Result<Status, Failure> {
    let status = board.status()?;
    let place = status.pos.get(axis).unwrap_or(0);
    let letter = axis.letter();
    let homed = status.homed.contains(&letter);
    if console.json() {
        console.json_line(&json!({ "axis": letter, "pos": place, "homed": homed }))?;
    } else {
        let homed = if homed { "" } else { " (not homed)" };
        console.result(&format!("{letter} {place} st{homed}\n"))?;
    }
    Ok(status)
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
    use super::{Distance, Speed, axis, distance, setting, speed, steps};
    use lang::axis::Axis;
    use lang::profile::Profile;

    #[test]
    fn arguments_are_read_strictly() {
        assert_eq!(distance("-0.25mm"), Ok(Distance::Um(-250)));
        assert_eq!(distance("40st"), Ok(Distance::Steps(40)));
        for wrong in ["5", "mm", "1.5st", "nanmm", "5 mm", "1e300mm"] {
            assert!(distance(wrong).is_err(), "{wrong}");
        }
        assert_eq!(speed("800"), Ok(Speed::Steps(800.0)));
        assert_eq!(speed("800st/s"), speed("800"));
        assert_eq!(speed("10mm/s"), Ok(Speed::Um(10_000.0)));
        assert_eq!(speed("600mm/min"), speed("10mm/s"));
        assert_eq!(speed("500um/s"), Ok(Speed::Um(500.0)));
        for wrong in ["0", "-5mm/s", "10mm", "10 mm/s", "nan", "mm/s", "infmm/s", "1e99"] {
            let told = speed(wrong).expect_err(wrong);
            assert!(told.contains("10mm/s") && told.contains("800st/s"), "{told}");
        }
        assert_eq!(setting("4=OFF"), Ok((4, false)));
        assert!(setting("4").is_err() && setting("x=on").is_err());
        assert!(axis("W").is_err() && axis("XY").is_err());
    }

    #[test]
    fn a_speed_is_made_steps_by_the_axis() {
        let mill = Profile::built_in("mill").expect("built in");
        let x = mill.axis(Axis::X).expect("it has X");
        let scale = f64::from(x.scale.steps) / f64::from(x.scale.um);
        assert_eq!(Speed::Um(10_000.0).steps(x), (10_000.0 * scale).round() as u32);
        assert_eq!([Speed::Steps(0.2), Speed::Steps(90.0)].map(|speed| speed.steps(x)), [1, 90]);
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
