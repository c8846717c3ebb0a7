//! The machine description that the host works with: axes, wiring, inputs, outputs, link.
//!
//! A profile is a TOML file (examples/profiles); the built-in ones are those very files. What the
//! device needs of it travels in two records: the axes' part in each program image, the board's
//! part by `pasapas profile set`.

use serde::{Deserialize, Serialize};

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
    /// What hangs on port 1.
    #[serde(default)]
    pub wiring: Wiring,
    /// Start and Stop buttons, autorun.
    #[serde(default)]
    pub run: RunOptions,
    /// The serial link.
    #[serde(default)]
    pub link: Link,
    /// Inputs that have a name, a role or a polarity of their own.
    #[serde(default, rename = "input")]
    pub inputs: Vec<Input>,
    /// Outputs likewise.
    #[serde(default, rename = "output")]
    pub outputs: Vec<Output>,
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

/// A ratio of steps to micrometres.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scale {
    /// Steps, 1..=65535.
    pub steps: u16,
    /// Micrometres, 1..=65535.
    pub um: u16,
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

/// What hangs on port 1 (firmware/README.md, Pins).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Wiring {
    /// Switches and outputs on the pins: inputs 1..3 references, 4 probe, outputs 1, 2.
    Direct,
    /// Shift registers: inputs 1..16 and probe 17, outputs 1..16.
    #[default]
    Chain,
}

impl Wiring {
    /// Number of inputs, probe included.
    pub const fn inputs(self) -> i32 {
        match self {
            Wiring::Direct => 4,
            Wiring::Chain => 17,
        }
    }

    /// Number of outputs.
    pub const fn outputs(self) -> i32 {
        match self {
            Wiring::Direct => 2,
            Wiring::Chain => 16,
        }
    }

    /// Input number of the axis's reference switch unless an input has the role.
    pub const fn reference(self, axis: Axis) -> i32 {
        match self {
            Wiring::Direct => 1 + axis as i32,
            Wiring::Chain => 9 + axis as i32,
        }
    }

    /// Input number of the probe unless an input has the role.
    pub const fn probe(self) -> i32 {
        match self {
            Wiring::Direct => 4,
            Wiring::Chain => 17,
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

/// An input.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// Number, from 1.
    pub n: i32,
    /// Name for scripts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// What the controller itself does with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<InputRole>,
    /// On when open (normally closed contact).
    #[serde(default)]
    pub invert: bool,
    /// Filter time, ms, 1..=50.
    #[serde(default = "default_filter")]
    pub filter_ms: u8,
}

/// What an input means to the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InputRole {
    /// A second Start button.
    Start,
    /// A second Stop button.
    Stop,
    /// Feed hold.
    Hold,
    /// Safety door: as hold.
    Door,
    /// Probe.
    Probe,
    /// Reference switch X.
    ReferenceX,
    /// Reference switch Y.
    ReferenceY,
    /// Reference switch Z.
    ReferenceZ,
    /// Emergency stop, normally closed.
    EmergencyStop,
}

impl InputRole {
    /// All roles.
    pub const ALL: [InputRole; 9] = [
        InputRole::Start,
        InputRole::Stop,
        InputRole::Hold,
        InputRole::Door,
        InputRole::Probe,
        InputRole::ReferenceX,
        InputRole::ReferenceY,
        InputRole::ReferenceZ,
        InputRole::EmergencyStop,
    ];

    /// As a profile names it.
    pub const fn name(self) -> &'static str {
        match self {
            InputRole::Start => "start",
            InputRole::Stop => "stop",
            InputRole::Hold => "hold",
            InputRole::Door => "door",
            InputRole::Probe => "probe",
            InputRole::ReferenceX => "reference_x",
            InputRole::ReferenceY => "reference_y",
            InputRole::ReferenceZ => "reference_z",
            InputRole::EmergencyStop => "emergency_stop",
        }
    }

    /// How many inputs of a machine may have it, as the board's record has room for.
    pub const fn most(self) -> usize {
        match self {
            InputRole::Stop | InputRole::Hold | InputRole::Door => 2,
            InputRole::EmergencyStop => 4,
            _ => 1,
        }
    }
}

/// An output.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Number, from 1.
    pub n: i32,
    /// Name for scripts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// What the controller itself does with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<OutputRole>,
    /// On is a low level.
    #[serde(default)]
    pub invert: bool,
    /// State after reset: on or off.
    #[serde(default)]
    pub reset: SafeState,
    /// State in a pause.
    #[serde(default = "keep")]
    pub pause: SafeState,
    /// State at a fault that ends the run.
    #[serde(default)]
    pub fault: SafeState,
    /// State at any other end.
    #[serde(default)]
    pub end: SafeState,
}

/// What an output means to the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OutputRole {
    /// M3, M4, M5.
    Spindle,
    /// M7, M8, M9.
    Coolant,
    /// As spindle, and off whenever no axis moves.
    Laser,
    /// Status lamp; scripts may not set it.
    Lamp,
    /// Drivers' enable; scripts may not set it but by Motors.
    Enable,
}

impl OutputRole {
    /// All roles.
    pub const ALL: [OutputRole; 5] = [
        OutputRole::Spindle,
        OutputRole::Coolant,
        OutputRole::Laser,
        OutputRole::Lamp,
        OutputRole::Enable,
    ];

    /// As a profile names it.
    pub const fn name(self) -> &'static str {
        match self {
            OutputRole::Spindle => "spindle",
            OutputRole::Coolant => "coolant",
            OutputRole::Laser => "laser",
            OutputRole::Lamp => "lamp",
            OutputRole::Enable => "enable",
        }
    }
}

/// What becomes of an output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SafeState {
    /// Off.
    #[default]
    Off,
    /// On.
    On,
    /// Unchanged.
    Keep,
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

fn default_filter() -> u8 {
    5
}

fn keep() -> SafeState {
    SafeState::Keep
}

/// Names and texts of the built-in profiles.
pub const BUILT_IN: [(&str, &str); 4] = [
    ("mill", include_str!("../../examples/profiles/mill.toml")),
    ("charly", include_str!("../../examples/profiles/charly.toml")),
    ("thesis", include_str!("../../examples/profiles/thesis.toml")),
    ("laser", include_str!("../../examples/profiles/laser.toml")),
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

    /// Each number, name and role once, but for roles that a machine may have several of.
    fn check_roles(&self) -> Result<(), ProfileError> {
        fn twice<T: PartialEq>(list: &[Option<T>]) -> Option<(usize, usize)> {
            let known = list.iter().enumerate().filter(|(_, item)| item.is_some());
            known.clone().find_map(|(at, item)| {
                known
                    .clone()
                    .find(|(other, same)| *other > at && *same == item)
                    .map(|(b, _)| (at, b))
            })
        }
        let refuse = |what: &str, section: &str, (a, b): (usize, usize), remedy: &str| {
            let (a, b) = (a + 1, b + 1);
            Err(ProfileError(format!(
                "[[{section}]] number {a} and {b} both have {what}; {remedy}"
            )))
        };
        let inputs: Vec<_> = self.inputs.iter().map(|input| Some(input.n)).collect();
        if let Some(at) = twice(&inputs) {
            let what = format!("n = {}", self.inputs[at.0].n);
            return refuse(&what, "input", at, "write one section with all of its keys");
        }
        let outputs: Vec<_> = self.outputs.iter().map(|output| Some(output.n)).collect();
        if let Some(at) = twice(&outputs) {
            let what = format!("n = {}", self.outputs[at.0].n);
            return refuse(&what, "output", at, "write one section with all of its keys");
        }
        for role in InputRole::ALL {
            let with: Vec<usize> =
                (0..self.inputs.len()).filter(|at| self.inputs[*at].role == Some(role)).collect();
            let (name, most) = (role.name(), role.most());
            if let Some(last) = with.get(most) {
                let remedy = if most == 1 {
                    "a machine has one".to_owned()
                } else {
                    format!("a machine has at most {most}; join contacts of more in series")
                };
                let what = format!("role = \"{name}\"");
                return refuse(&what, "input", (with[0], *last), &remedy);
            }
            let start_17 = role == InputRole::Start
                && with.iter().any(|at| self.inputs[*at].n == Wiring::Chain.probe());
            if start_17 {
                return Err(ProfileError(
                    "input 17 has role = \"start\", but no filter; take one of the inputs 1 to 16"
                        .to_owned(),
                ));
            }
        }
        for role in OutputRole::ALL {
            let with: Vec<_> = self
                .outputs
                .iter()
                .map(|output| (output.role == Some(role)).then_some(role))
                .collect();
            if let Some(at) = twice(&with) {
                let what = format!("role = \"{}\"", role.name());
                return refuse(&what, "output", at, "a machine has one");
            }
        }
        let names: Vec<_> = self.inputs.iter().map(|input| input.name.as_deref()).collect();
        if let Some(at) = twice(&names) {
            let what = format!("the name {:?}", names[at.0].unwrap_or_default());
            return refuse(&what, "input", at, "give one of them another");
        }
        let names: Vec<_> = self.outputs.iter().map(|output| output.name.as_deref()).collect();
        if let Some(at) = twice(&names) {
            let what = format!("the name {:?}", names[at.0].unwrap_or_default());
            return refuse(&what, "output", at, "give one of them another");
        }
        let order: Vec<_> = self.home_order.iter().map(|name| Some(Axis::from(*name))).collect();
        if let Some((a, b)) = twice(&order) {
            return Err(ProfileError(format!(
                "home_order names {:?} at place {} and {}; name each axis once",
                self.home_order[a],
                a + 1,
                b + 1
            )));
        }
        Ok(())
    }

    fn check(&self) -> Result<(), ProfileError> {
        fn range(field: &str, value: i64, low: i64, high: i64) -> Result<(), ProfileError> {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(ProfileError(format!("{field} is {value}; it must lie in {low}..{high}")))
        }
        if self.axes().next().is_none() {
            return Err(ProfileError("the profile has no axis; write a section [x]".to_owned()));
        }
        range("pulse_us", self.pulse_us.into(), 2, 30)?;
        for (axis, part) in self.axes() {
            let at = |field: &str| format!("{}.{field}", axis.letter().to_ascii_lowercase());
            range(&at("scale.steps"), part.scale.steps.into(), 1, 65_535)?;
            range(&at("scale.um"), part.scale.um.into(), 1, 65_535)?;
            range(&at("start_rate"), part.start_rate.into(), 1, part.top_rate.into())?;
            range(&at("accel"), part.accel.into(), 100, 10_000_000)?;
            range(&at("decel"), part.decel.unwrap_or(part.accel).into(), 100, 10_000_000)?;
            range(&at("top_rate"), part.top_rate.into(), 1, i64::from(i32::MAX))?;
            let possible = crate::part::top_rate(self.pulse_us);
            if part.top_rate.unsigned_abs() > possible {
                return Err(ProfileError(format!(
                    "{} is {}; with pulses of {} us the controller makes {possible} steps/s",
                    at("top_rate"),
                    part.top_rate,
                    self.pulse_us
                )));
            }
            range(&at("min_um"), part.min_um.into(), -10_000_000, part.max_um.into())?;
            range(&at("max_um"), part.max_um.into(), part.min_um.into(), 10_000_000)?;
            range(&at("home.fast_rate"), part.home.fast_rate.into(), 1, part.top_rate.into())?;
            range(
                &at("home.slow_rate"),
                part.home.slow_rate.into(),
                1,
                part.home.fast_rate.into(),
            )?;
            range(&at("home.stroke_um"), part.home.stroke_um.into(), 1, 20_000_000)?;
            range(&at("home.position_um"), part.home.position_um.into(), -10_000_000, 10_000_000)?;
            range(&at("home.clearance_um"), part.home.clearance_um.into(), -1_000_000, 1_000_000)?;
            // Sums of two places in steps fit into 32 bits.
            let reach = [part.min_um, part.max_um, part.home.stroke_um, part.home.position_um];
            let longest = reach.map(|um| i64::from(um).abs()).into_iter().max().unwrap_or_default();
            let steps = longest * i64::from(part.scale.steps) / i64::from(part.scale.um);
            range(&format!("the longest way of {}, steps,", axis.letter()), steps, 0, 1 << 30)?;
        }
        if let Some(name) = self.home_order.iter().find(|name| self.axis((**name).into()).is_none())
        {
            return Err(ProfileError(format!(
                "home_order names {name:?}, which the machine does not have"
            )));
        }
        range("dir_setup_us", self.dir_setup_us.into(), 1, 30)?;
        range("corner_um", self.corner_um.into(), 0, 10_000)?;
        range("default_feed_um_s", self.default_feed_um_s.unwrap_or(1).into(), 1, 1_000_000)?;
        range("link.address", self.link.address.into(), 1, 247)?;
        if ![9_600, 19_200, 57_600, 115_200].contains(&self.link.rate) {
            return Err(ProfileError(format!(
                "link.rate is {}; it must be 9600, 19200, 57600 or 115200",
                self.link.rate
            )));
        }
        for input in &self.inputs {
            range("input.n", input.n.into(), 1, self.wiring.inputs().into())?;
            range("input.filter_ms", input.filter_ms.into(), 1, 50)?;
        }
        self.check_roles()?;
        for output in &self.outputs {
            range("output.n", output.n.into(), 1, self.wiring.outputs().into())?;
            if output.reset == SafeState::Keep {
                return Err(ProfileError(format!("output {}: reset must be on or off", output.n)));
            }
        }
        Ok(())
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

    #[test]
    fn doubled_numbers_names_and_roles_are_refused_with_their_places() {
        let input = |n: u8, role: &str| format!("\n[[input]]\nn = {n}\nrole = \"{role}\"\n");
        let mill = BUILT_IN[0].1;
        let error = |text: String| Profile::parse(&(mill.to_owned() + &text)).expect_err(&text).0;
        let base = mill.matches("[[input]]").count();
        let many = |role: &str, count: u8| (1..=count).map(|n| input(n, role)).collect::<String>();
        for (role, most) in [("emergency_stop", 4), ("hold", 2), ("door", 2), ("stop", 2)] {
            let text = mill.to_owned() + &many(role, most);
            assert!(Profile::parse(&text).is_ok(), "{most} of {role}");
            let told = error(many(role, most + 1));
            let (first, last) = (base + 1, base + 1 + usize::from(most));
            let start = format!("[[input]] number {first} and {last} both have role = \"{role}\"");
            assert!(told.starts_with(&start), "{told}");
        }
        for role in ["start", "probe", "reference_x", "reference_y", "reference_z"] {
            assert!(error(many(role, 2)).ends_with("a machine has one"), "{role}");
        }
        assert!(error(input(5, "hold") + &input(5, "emergency_stop")).contains("n = 5"));
        assert!(error(input(17, "start")).contains("no filter"));
        let output = |n: u8, rest: &str| format!("\n[[output]]\nn = {n}\n{rest}\n");
        assert!(error(output(9, "") + &output(9, "")).contains("both have n = 9"));
        for role in ["coolant", "lamp", "enable", "laser"] {
            let text = output(9, &format!("role = \"{role}\""))
                + &output(10, &format!("role = \"{role}\""));
            assert!(error(text).contains(role), "{role}");
        }
        let named = |n: u8| format!("\n[[input]]\nn = {n}\nname = \"same\"\n");
        assert!(error(named(5) + &named(6)).contains("\"same\""));
        let line = mill.lines().find(|line| line.starts_with("home_order")).expect("a home order");
        let text = mill.replace(line, "home_order = [\"X\", \"Y\", \"X\"]");
        let told = Profile::parse(&text).expect_err("X twice").0;
        assert!(told.contains("place 1 and 3"), "{told}");
    }

    #[test]
    fn a_value_out_of_range_is_named() {
        let text = BUILT_IN[0].1.replace("pulse_us = 3", "pulse_us = 31");
        let error = Profile::parse(&text).unwrap_err();
        assert_eq!(error.0, "pulse_us is 31; it must lie in 2..30");
    }
}
