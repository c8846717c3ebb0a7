//! Kinds: what a 32-bit value means. They exist at compile time only.

use crate::effect::Unit;

/// The kind of an expression or a variable (lang/README.md, Values and kinds).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A plain whole number.
    Number,
    /// 1 or 0.
    Truth,
    /// um
    Length,
    /// Motor steps.
    Steps,
    /// ms
    Time,
    /// um/s
    Speed,
    /// steps/s
    StepRate,
    /// um/s2
    Accel,
    /// steps/s2
    StepAccel,
    /// 1/1000 degree
    Angle,
    /// mV
    Voltage,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Kind; 11] = [
        Kind::Number,
        Kind::Truth,
        Kind::Length,
        Kind::Steps,
        Kind::Time,
        Kind::Speed,
        Kind::StepRate,
        Kind::Accel,
        Kind::StepAccel,
        Kind::Angle,
        Kind::Voltage,
    ];

    /// The name, as `AS` takes it and diagnostics write it.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Number => "Number",
            Kind::Truth => "Truth",
            Kind::Length => "Length",
            Kind::Steps => "Steps",
            Kind::Time => "Time",
            Kind::Speed => "Speed",
            Kind::StepRate => "StepRate",
            Kind::Accel => "Accel",
            Kind::StepAccel => "StepAccel",
            Kind::Angle => "Angle",
            Kind::Voltage => "Voltage",
        }
    }

    /// The kind of that name in any case.
    pub fn from_name(name: &str) -> Option<Kind> {
        Kind::ALL.into_iter().find(|kind| kind.name().eq_ignore_ascii_case(name))
    }

    /// The unit that PRINT appends.
    pub const fn unit(self) -> Unit {
        match self {
            Kind::Number | Kind::Truth => Unit::None,
            Kind::Length => Unit::Um,
            Kind::Steps => Unit::Steps,
            Kind::Time => Unit::Ms,
            Kind::Speed => Unit::UmPerS,
            Kind::StepRate => Unit::StepsPerS,
            Kind::Accel => Unit::UmPerS2,
            Kind::StepAccel => Unit::StepsPerS2,
            Kind::Angle => Unit::MilliDeg,
            Kind::Voltage => Unit::MilliVolt,
        }
    }
}

impl core::fmt::Display for Kind {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.name())
    }
}
