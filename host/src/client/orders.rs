//! InterpCNC commands that move a machine by hand, made from its profile (InterpCNC V3
//! Modbus protocol, Commands).

use lang::axis::Axis;
use lang::profile::{AxisProfile, Direction, Profile};
use lang::wire::{self, Exception, command};

use super::Client;
use super::status::holds;
use crate::link::Link;

/// A 32-bit value as two registers, low word first; saturates.
pub fn words(value: i64) -> [u16; 2] {
    let value = value.clamp(i32::MIN.into(), i32::MAX.into()) as i32;
    let value = value.cast_unsigned();
    [value as u16, (value >> 16) as u16]
}

/// Motor steps of a length in um, half away from zero.
pub fn steps(axis: &AxisProfile, um: i64) -> i64 {
    let (up, down) = (i64::from(axis.scale.steps), i64::from(axis.scale.um));
    let twice = 2 * um.abs() * up + down;
    twice / (2 * down) * um.signum()
}

/// Command 103: to a work position in steps, at a speed in steps/s, with ramps in steps/s2.
pub fn move_to(axis: Axis, [accel, decel]: [u32; 2], speed: u32, target: i64) -> Vec<u16> {
    let mut order = vec![command::MOVE_TO, axis.index() as u16 + 1];
    for value in [accel.into(), speed.into(), decel.into(), target] {
        order.extend(words(value));
    }
    order
}

/// The axis's ramps up and down, steps/s2.
pub fn ramps(axis: &AxisProfile) -> [u32; 2] {
    [axis.accel.unsigned_abs(), axis.decel.unwrap_or(axis.accel).unsigned_abs()]
}

/// Command 106 with the profile's parameters.
///
/// # Errors
/// The machine has no such axis, or no reference switch of it.
pub fn home(profile: &Profile, axis: Axis) -> Result<Vec<u16>, String> {
    let own = present(profile, axis)?;
    let home = &own.home;
    let to_steps = |um: i32| i64::from(um) * i64::from(own.scale.steps) / i64::from(own.scale.um);
    let away = -i64::from(home.direction.sign()) * to_steps(home.clearance_um);
    let input = u16::try_from(profile.reference_input(axis) - 1).map_err(|_| {
        format!("the machine `{}` has no reference switch of {}", profile.name, axis.letter())
    })?;
    let mut order = vec![
        command::HOME,
        axis.index() as u16 + 1,
        0,
        input,
        1,
        (home.direction == Direction::Positive).into(),
    ];
    order.extend(words(home.fast_rate.into()));
    order.extend(words(home.slow_rate.into()));
    order.extend(words(own.accel.into()));
    order.extend(words(own.decel.unwrap_or(own.accel).into()));
    order.extend(words(to_steps(home.stroke_um)));
    order.push(home.pause_ms);
    order.extend(words(to_steps(home.position_um)));
    order.extend(words(away));
    Ok(order)
}

/// Command 107: along an axis by at most a distance in steps until the probe answers.
///
/// # Errors
/// The machine has no such axis, or no probe.
pub fn probe(profile: &Profile, axis: Axis, speed: u32, distance: i64) -> Result<Vec<u16>, String> {
    let own = present(profile, axis)?;
    let input = u16::try_from(profile.probe_input() - 1)
        .map_err(|_| format!("the machine `{}` has no probe", profile.name))?;
    let [accel, decel] = ramps(own);
    let mut order = vec![command::PROBE, axis.index() as u16 + 1, input, 1];
    for value in [accel.into(), speed.into(), decel.into(), distance] {
        order.extend(words(value));
    }
    Ok(order)
}

/// The axis of a machine.
///
/// # Errors
/// It has none.
pub fn present(profile: &Profile, axis: Axis) -> Result<&AxisProfile, String> {
    profile
        .axis(axis)
        .ok_or_else(|| format!("the machine `{}` has no {}", profile.name, axis.letter()))
}

/// The axis whose reference switch an input is, and the command that moves it off that switch.
pub fn off_switch(profile: &Profile, input: u16) -> Option<(Axis, String)> {
    let is_its = |(axis, _): &(Axis, _)| profile.reference_input(*axis) == i32::from(input);
    let (axis, own) = profile.axes().find(is_its)?;
    let sign = if own.home.direction == Direction::Positive { "-" } else { "" };
    Some((axis, format!("pasapas jog {} {sign}5mm", axis.letter())))
}

impl<L: Link> Client<L> {
    /// Writes a command once: a move that is repeated because its reply was lost would be made twice.
    /// What the board takes for out of range is told by `wrong`.
    ///
    /// # Errors
    /// The board refuses or does not answer; in words.
    pub fn order(&mut self, order: &[u16], wrong: impl FnOnce() -> String) -> Result<(), String> {
        match self.once(|board| board.write_all(wire::COMMAND, order)) {
            Ok(()) => Ok(()),
            Err(error) if error.is_exception(Exception::Busy) => {
                let status = self.status().map_err(|error| error.to_string())?;
                let why = match (status.blocked_by, &status.fault) {
                    (Some(input), _) => holds(input),
                    (None, _) if !status.moving.is_empty() => "an axis moves already".to_owned(),
                    (None, Some(fault)) => {
                        let text = status.text.unwrap_or_default();
                        format!("{fault} {text}; `pasapas start` acknowledges it")
                    }
                    (None, None) => format!("it is {}", status.state),
                };
                Err(format!("the board cannot move now: {why}"))
            }
            Err(error) if error.is_exception(Exception::IllegalValue) => Err(wrong()),
            Err(error) if error.may_be_done() => {
                // Nothing tells whether the board took it: the axes are stopped, whatever it began.
                let _ = self.write_all(wire::COMMAND, &[command::STOP_AXES, 0b111]);
                Err(error.to_string())
            }
            Err(error) => Err(error.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{home, off_switch, probe, steps, words};
    use lang::axis::Axis;
    use lang::profile::Profile;

    #[test]
    fn homing_sends_the_profiles_parameters() {
        let mill = Profile::built_in("mill").expect("built in");
        let order = home(&mill, Axis::Z).expect("mill has Z");
        assert_eq!(order[..6], [106, 3, 0, 10, 1, 1]);
        assert_eq!(order[6..10], [2000, 0, 200, 0]);
        assert_eq!(order[14..16], words(11_000));
        assert_eq!((order[16], order.len()), (100, 21));
    }

    #[test]
    fn a_switch_is_left_away_from_its_side() {
        let mill = Profile::built_in("mill").expect("built in");
        let off = |axis| off_switch(&mill, mill.reference_input(axis) as u16);
        assert_eq!(off(Axis::X), Some((Axis::X, "pasapas jog X 5mm".to_owned())));
        assert_eq!(off(Axis::Z), Some((Axis::Z, "pasapas jog Z -5mm".to_owned())));
        assert_eq!(off_switch(&mill, 3), None);
    }

    #[test]
    fn probing_takes_the_wirings_input() {
        let mill = Profile::built_in("mill").expect("built in");
        let order = probe(&mill, Axis::Z, 400, -500).expect("mill has a probe");
        assert_eq!(order[..4], [107, 3, 16, 1]);
        assert_eq!(order[4..], [words(25_000), words(400), words(25_000), words(-500)].concat());
    }

    #[test]
    fn lengths_are_rounded_half_away_from_zero() {
        let thesis = Profile::built_in("thesis").expect("built in");
        let x = thesis.axis(Axis::X).expect("it has X");
        assert_eq!([20, -20, 19].map(|um| steps(x, um)), [1, -1, 0]);
    }
}
