//! The hardware PWM of parts that have one: power of a laser, speed of a spindle, place of a servo.

use serde::{Deserialize, Serialize};

use super::{OutputRole, Profile, ProfileError};
use crate::record::FULL_POWER;

/// What hangs on the PWM pin.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pwm {
    /// Number of the output that switches it on and off.
    pub output: i32,
    /// What it drives.
    pub kind: PwmKind,
    /// Periods in a second, 50..=20000; see [`Pwm::hz`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<u16>,
    /// S of full power, 1..=32767.
    #[serde(default = "full_power")]
    pub range: i32,
    /// Part of the period that is on at the least S above 0, thousandths, 0..=999.
    #[serde(default)]
    pub minimum: u16,
    /// A servo's pulse at S0, us, 500..=`high_us`.
    #[serde(default = "low")]
    pub low_us: u16,
    /// A servo's pulse at full S, us, `low_us`..=2500.
    #[serde(default = "high")]
    pub high_us: u16,
}

/// What the PWM drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PwmKind {
    /// A laser: dark at rest and in rapid moves; under M4 its power follows the speed.
    Laser,
    /// A spindle: as S says, whatever the axes do.
    Spindle,
    /// An RC servo: pulses all the time, S0's while the output is off.
    Servo,
}

fn full_power() -> i32 {
    FULL_POWER
}

fn low() -> u16 {
    1000
}

fn high() -> u16 {
    2000
}

/// A servo wants a pause behind its longest pulse.
const SERVO_HZ: u16 = 333;

impl Pwm {
    /// Periods in a second.
    pub fn hz(&self) -> u16 {
        self.frequency_hz.unwrap_or(if self.kind == PwmKind::Servo { 50 } else { 1000 })
    }
}

impl Profile {
    /// S of full power.
    pub fn full_power(&self) -> i32 {
        self.pwm.as_ref().map_or(FULL_POWER, |pwm| pwm.range)
    }

    /// Whether S is a power, at most [`Profile::full_power`]; elsewhere it is a spindle's speed, which no output
    /// follows.
    pub fn has_power(&self) -> bool {
        self.pwm.is_some() || self.output_with(OutputRole::Laser).is_some()
    }

    /// Whether M4 lets a laser's power follow the speed.
    pub fn follows_speed(&self) -> bool {
        self.pwm.as_ref().is_some_and(|pwm| pwm.kind == PwmKind::Laser)
    }

    /// The output of a laser.
    pub fn laser(&self) -> Option<i32> {
        let pwm = self.pwm.as_ref().filter(|pwm| pwm.kind == PwmKind::Laser);
        pwm.map(|pwm| pwm.output).or_else(|| self.output_with(OutputRole::Laser).map(|o| o.n))
    }

    /// The output that M3, M4 and M5 switch.
    pub fn switched(&self) -> Option<i32> {
        let role = |role| self.output_with(role).map(|output| output.n);
        role(OutputRole::Spindle)
            .or_else(|| role(OutputRole::Laser))
            .or_else(|| self.pwm.as_ref().map(|pwm| pwm.output))
    }

    /// Whether all of `[pwm]` may stand in a profile; `range` refuses a value by name.
    pub(super) fn check_pwm(
        &self,
        range: fn(&str, i64, i64, i64) -> Result<(), ProfileError>,
    ) -> Result<(), ProfileError> {
        let Some(pwm) = &self.pwm else { return Ok(()) };
        range("pwm.output", pwm.output.into(), 1, self.wiring.outputs().into())?;
        let role = self.outputs.iter().find(|o| o.n == pwm.output).and_then(|o| o.role);
        if let Some(role @ (OutputRole::Lamp | OutputRole::Enable)) = role {
            return Err(ProfileError(format!(
                "pwm.output is {}, which has role = \"{}\"; take one that scripts may set",
                pwm.output,
                role.name()
            )));
        }
        let servo = pwm.kind == PwmKind::Servo;
        let most = if servo { SERVO_HZ } else { 20_000 };
        range("pwm.frequency_hz", pwm.hz().into(), 50, most.into())?;
        range("pwm.range", pwm.range.into(), 1, i16::MAX.into())?;
        range("pwm.minimum", pwm.minimum.into(), 0, 999)?;
        range("pwm.low_us", pwm.low_us.into(), 500, pwm.high_us.into())?;
        range("pwm.high_us", pwm.high_us.into(), pwm.low_us.into(), 2500)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Profile;

    fn laser(rest: &str) -> Result<Profile, String> {
        let text = include_str!("../../../examples/profiles/laser.toml").to_owned() + rest;
        Profile::parse(&text).map_err(|error| error.0)
    }

    #[test]
    fn a_servo_has_a_frequency_of_its_own() {
        let servo = laser("[pwm]\noutput = 1\nkind = \"servo\"\n").expect("a servo");
        assert_eq!(servo.pwm.map(|pwm| pwm.hz()), Some(50));
        let fast = laser("[pwm]\noutput = 1\nkind = \"servo\"\nfrequency_hz = 334\n");
        assert_eq!(fast.expect_err("too fast"), "pwm.frequency_hz is 334; it must lie in 50..333");
    }

    #[test]
    fn an_output_of_the_controller_itself_switches_no_pwm() {
        let text = "[[output]]\nn = 4\nrole = \"lamp\"\n[pwm]\noutput = 4\nkind = \"spindle\"\n";
        assert!(laser(text).expect_err("a lamp").contains("which has role = \"lamp\""));
    }
}
