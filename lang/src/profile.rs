//! The machine description that the host works with: axes, wiring, inputs, outputs, link.
//!
//! A profile is a TOML file (examples/profiles); the built-in ones are those very files. What the
//! device needs of it travels in two records: the axes' part in each program image, the board's
//! part by `pasapas profile set`.

mod analog;
mod aout;
mod check;
mod ports;
mod pwm;

use serde::{Deserialize, Serialize};

pub use self::analog::{
    ANALOGS, Analog, FILTERS_MS, FIRST_THRESHOLD, HIGHEST_MV, LAST_THRESHOLD, Threshold,
};
pub use self::aout::{AOUT_MOST, Aout, AoutPause};
pub use self::ports::{Input, InputRole, Output, OutputRole, SafeState, Wiring};
pub use self::pwm::{Pwm, PwmKind};
use crate::axis::Axis;

/// A machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// The name that `PROFILE "name"` and `--profile` take.
    pub name: String,
    /// First axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<AxisProfile>,
    /// Second axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<AxisProfile>,
    /// Third axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<AxisProfile>,
    /// Order of a bare `Home`, axis letters.
    pub home_order: Vec<AxisName>,
    /// An absolute move of an axis that is not homed is F07.
    #[serde(default)]
    pub require_homing: bool,
    /// Feed of a G1 that no F reaches, um/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub default_feed_um_s: Option<i32>,
    /// How far a path may round a corner without stopping (junction deviation), um.
    #[serde(default = "default_corner")]
    pub corner_um: i32,
    /// G0 lifts Z first and lowers it last instead of moving all axes at once.
    #[serde(default)]
    pub rapid_z_apart: bool,
    /// M1 waits for Start.
    #[serde(default)]
    pub optional_stop: bool,
    /// STEP pulse width, us, 2..=30.
    #[serde(default = "default_pulse")]
    pub pulse_us: u8,
    /// DIR set-up time before a STEP edge, us, 1..=30.
    #[serde(default = "default_setup")]
    pub dir_setup_us: u8,
    /// STEP is active when low (firmware/README.md, "Step drivers with optocouplers", says for which circuits).
    #[serde(default)]
    pub step_invert: bool,
    /// What hangs on port 1.
    #[serde(default)]
    pub wiring: Wiring,
    /// Start and Stop buttons, autorun.
    #[serde(default)]
    pub run: RunOptions,
    /// The serial link.
    #[serde(default)]
    pub link: Link,
    /// The RS-485 line beside it, of parts that have one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rs485: Option<Link>,
    /// The hardware PWM, of parts that have one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pwm: Option<Pwm>,
    /// Inputs that have a name, a role or a polarity of their own.
    #[serde(default, rename = "input")]
    pub inputs: Vec<Input>,
    /// Outputs, in the same way.
    #[serde(default, rename = "output")]
    pub outputs: Vec<Output>,
    /// Analog inputs, of parts that have some.
    #[serde(default, rename = "analog", skip_serializing_if = "Vec::is_empty")]
    pub analogs: Vec<Analog>,
    /// Inputs made of analog ones.
    #[serde(default, rename = "threshold", skip_serializing_if = "Vec::is_empty")]
    pub thresholds: Vec<Threshold>,
    /// Analog outputs, of parts that have one.
    #[serde(default, rename = "aout", skip_serializing_if = "Vec::is_empty")]
    pub aouts: Vec<Aout>,
}

/// An axis letter in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum AxisName {
    /// X
    X,
    /// Y
    Y,
    /// Z
    Z,
}

impl From<AxisName> for Axis {
    fn from(name: AxisName) -> Axis {
        match name {
            AxisName::X => Axis::X,
            AxisName::Y => Axis::Y,
            AxisName::Z => Axis::Z,
        }
    }
}

/// One axis.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisProfile {
    /// `steps` motor steps move the axis by `um` micrometres, exactly.
    pub scale: Scale,
    /// Start and stop rate, steps/s.
    pub start_rate: i32,
    /// Ramp up, steps/s2.
    pub accel: i32,
    /// Ramp down, steps/s2; as `accel` when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decel: Option<i32>,
    /// Top rate, steps/s.
    pub top_rate: i32,
    /// Lowest machine position, um.
    pub min_um: i32,
    /// Highest machine position, um.
    pub max_um: i32,
    /// DIR is low for the positive direction.
    #[serde(default)]
    pub invert: bool,
    /// Reference run.
    pub home: Homing,
}

impl AxisProfile {
    /// Of Z: whether its positions grow downward, toward the work, as on `charly`. The reference switch of Z is taken to be
    /// at the top: at the negative end of a travel that lies on the positive side.
    pub const fn counts_down(&self) -> bool {
        matches!(self.home.direction, Direction::Negative)
            && self.min_um as i64 + self.max_um as i64 > 0
    }

    /// -1 where [`counts_down`](AxisProfile::counts_down), else 1: what a height is multiplied by to be a position.
    pub const fn upward(&self) -> i32 {
        if self.counts_down() { -1 } else { 1 }
    }
}

/// A ratio of steps to micrometres.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scale {
    /// Steps, 1..=65535.
    pub steps: u16,
    /// Micrometres, 1..=65535.
    pub um: u16,
}

impl Scale {
    /// Steps as um, half away from zero; `None` when they do not fit.
    pub fn length(self, steps: i32) -> Option<i32> {
        let product = i64::from(steps) * i64::from(self.um);
        let by = i64::from(self.steps.max(1));
        // An odd divisor has no tie; for an even one its half rounds the tie away from zero.
        let magnitude = (product.abs() + by / 2) / by;
        i32::try_from(magnitude * product.signum()).ok()
    }
}

/// Reference run of an axis (InterpCNC command 106).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Homing {
    /// Where the switch is.
    pub direction: Direction,
    /// Rate toward the switch, steps/s.
    pub fast_rate: i32,
    /// Rate off the switch, steps/s.
    pub slow_rate: i32,
    /// How far to look for it, um.
    pub stroke_um: i32,
    /// Rest between the two, ms.
    pub pause_ms: u16,
    /// Machine position where the switch opens, um.
    #[serde(default)]
    pub position_um: i32,
    /// Move away from there afterwards, um, away from the switch when positive.
    #[serde(default)]
    pub clearance_um: i32,
}

/// A direction of travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// Toward smaller positions.
    Negative,
    /// Toward larger positions.
    Positive,
}

impl Direction {
    /// -1 or 1.
    pub const fn sign(self) -> i32 {
        match self {
            Direction::Negative => -1,
            Direction::Positive => 1,
        }
    }
}

/// Start, Stop and power-up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RunOptions {
    /// Run the stored program at power-up.
    pub autorun: bool,
    /// Spin-up time after a pause, ms.
    pub spin_up_ms: u16,
}

/// The serial link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Link {
    /// Modbus address, 1..=247.
    pub address: u8,
    /// Bits per second: 9600, 19200, 57600 or 115200.
    pub rate: u32,
    /// Parity bit.
    pub parity: Parity,
}

impl Default for Link {
    fn default() -> Link {
        Link { address: 1, rate: 115_200, parity: Parity::None }
    }
}

/// Parity of the link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Parity {
    /// 8N1
    #[default]
    None,
    /// 8E1
    Even,
    /// 8O1
    Odd,
}

fn default_corner() -> i32 {
    20
}

fn default_pulse() -> u8 {
    3
}

fn default_setup() -> u8 {
    2
}

/// Names and texts of the built-in profiles.
pub const BUILT_IN: [(&str, &str); 5] = [
    ("mill", include_str!("../../examples/profiles/mill.toml")),
    ("charly", include_str!("../../examples/profiles/charly.toml")),
    ("thesis", include_str!("../../examples/profiles/thesis.toml")),
    ("laser", include_str!("../../examples/profiles/laser.toml")),
    ("picker", include_str!("../../examples/profiles/picker.toml")),
];

/// Name of the profile that holds without any other word.
pub const DEFAULT_NAME: &str = "mill";

/// A profile that cannot be used, with the field and the remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProfileError(pub String);

impl core::fmt::Display for ProfileError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for ProfileError {}

impl Profile {
    /// The built-in profile of that name in any case.
    ///
    /// # Errors
    /// No profile has that name; the text lists those that exist.
    pub fn built_in(name: &str) -> Result<Profile, ProfileError> {
        match BUILT_IN.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)) {
            Some((_, text)) => Profile::parse(text),
            None => {
                let known: Vec<&str> = BUILT_IN.iter().map(|(known, _)| *known).collect();
                Err(ProfileError(format!(
                    "no profile is called `{name}`; built in are {}",
                    known.join(", ")
                )))
            }
        }
    }

    /// Reads a profile from TOML and checks it.
    ///
    /// # Errors
    /// The text is not TOML, a field is missing or unknown, or a value lies outside its range.
    pub fn parse(text: &str) -> Result<Profile, ProfileError> {
        let profile: Profile =
            toml::from_str(text).map_err(|error| ProfileError(error.to_string()))?;
        profile.check()?;
        Ok(profile)
    }

    /// The axis's part, if the machine has the axis.
    pub fn axis(&self, axis: Axis) -> Option<&AxisProfile> {
        match axis {
            Axis::X => self.x.as_ref(),
            Axis::Y => self.y.as_ref(),
            Axis::Z => self.z.as_ref(),
        }
    }

    /// The axes that the machine has, in order X, Y, Z.
    pub fn axes(&self) -> impl Iterator<Item = (Axis, &AxisProfile)> {
        Axis::ALL.into_iter().filter_map(|axis| self.axis(axis).map(|part| (axis, part)))
    }

    /// The first output with this role.
    pub fn output_with(&self, role: OutputRole) -> Option<&Output> {
        self.outputs.iter().find(|output| output.role == Some(role))
    }

    /// The first input with this role.
    pub fn input_with(&self, role: InputRole) -> Option<&Input> {
        self.inputs.iter().find(|input| input.role == Some(role))
    }

    /// Input number of the probe, 0 for none.
    pub fn probe_input(&self) -> i32 {
        self.input_with(InputRole::Probe).map_or(self.unless_taken(self.wiring.probe()), |i| i.n)
    }

    /// The wiring's input of a purpose, 0 when the profile gives that input a role of its own.
    fn unless_taken(&self, n: i32) -> i32 {
        if self.inputs.iter().any(|input| input.n == n && input.role.is_some()) { 0 } else { n }
    }

    /// Input number of the axis's reference switch, 0 for none.
    pub fn reference_input(&self, axis: Axis) -> i32 {
        let role = match axis {
            Axis::X => InputRole::ReferenceX,
            Axis::Y => InputRole::ReferenceY,
            Axis::Z => InputRole::ReferenceZ,
        };
        self.input_with(role).map_or(self.unless_taken(self.wiring.reference(axis)), |i| i.n)
    }
}

#[cfg(test)]
mod tests {
    use super::{BUILT_IN, Profile};

    #[test]
    fn every_built_in_profile_parses_under_its_name() {
        for (name, text) in BUILT_IN {
            assert_eq!(Profile::parse(text).map(|profile| profile.name), Ok(name.to_owned()));
        }
    }
}
