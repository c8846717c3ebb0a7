//! What hangs on the board: wiring, inputs and outputs with their roles.

use serde::{Deserialize, Serialize};

use crate::axis::Axis;

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
    /// Chooses the program that Start runs, with the other ones of its kind: 1 of the binary number.
    #[serde(rename = "select_1")]
    Select1,
    /// Chooses the program that Start runs, with the other ones of its kind: 2 of the binary number.
    #[serde(rename = "select_2")]
    Select2,
    /// Chooses the program that Start runs, with the other ones of its kind: 4 of the binary number.
    #[serde(rename = "select_3")]
    Select3,
    /// Chooses the program that Start runs, with the other ones of its kind: 8 of the binary number.
    #[serde(rename = "select_4")]
    Select4,
    /// Chooses the program that Start runs, with the other ones of its kind: 16 of the binary number.
    #[serde(rename = "select_5")]
    Select5,
    /// Chooses the program that Start runs, with the other ones of its kind: 32 of the binary number.
    #[serde(rename = "select_6")]
    Select6,
    /// A button that chooses the next program of the library.
    NextProgram,
}

impl InputRole {
    /// All roles.
    pub const ALL: [InputRole; 16] = [
        InputRole::Start,
        InputRole::Stop,
        InputRole::Hold,
        InputRole::Door,
        InputRole::Probe,
        InputRole::ReferenceX,
        InputRole::ReferenceY,
        InputRole::ReferenceZ,
        InputRole::EmergencyStop,
        InputRole::Select1,
        InputRole::Select2,
        InputRole::Select3,
        InputRole::Select4,
        InputRole::Select5,
        InputRole::Select6,
        InputRole::NextProgram,
    ];

    /// Those that choose a program, the lowest bit of its number first.
    pub const SELECT: [InputRole; 6] = [
        InputRole::Select1,
        InputRole::Select2,
        InputRole::Select3,
        InputRole::Select4,
        InputRole::Select5,
        InputRole::Select6,
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
            InputRole::Select1 => "select_1",
            InputRole::Select2 => "select_2",
            InputRole::Select3 => "select_3",
            InputRole::Select4 => "select_4",
            InputRole::Select5 => "select_5",
            InputRole::Select6 => "select_6",
            InputRole::NextProgram => "next_program",
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

fn default_filter() -> u8 {
    5
}

fn keep() -> SafeState {
    SafeState::Keep
}
