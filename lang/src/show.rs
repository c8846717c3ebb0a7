//! How PRINT writes a quantity: in the unit that is stored, or in the one after its `IN`, with decimals.
//!
//! A value in a unit with decimals is `value * times / over` of its last digit, rounded half away from zero. No
//! ratio is above 1, so nothing overflows.

use crate::effect::Unit;
use crate::kind::Kind;
use core::fmt;

/// A unit with decimals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decimals {
    /// Numerator of the ratio from the stored unit to the last digit.
    pub times: i32,
    /// Its denominator.
    pub over: i32,
    /// Digits behind the point, 1 to 4.
    pub digits: u8,
}

impl Decimals {
    /// The value in units of its last digit.
    pub const fn scaled(self, value: i32) -> i32 {
        let part = value % self.over * self.times;
        // Half away from zero: an odd number of halves goes to the next whole one.
        let halves = 2 * part / self.over;
        value / self.over * self.times + (halves + halves % 2) / 2
    }

    /// The greatest negative value that is written with a minus: those above round to 0.
    pub const fn minus(self) -> i32 {
        -((self.over + 2 * self.times - 1) / (2 * self.times))
    }
}

impl Unit {
    /// Every unit of a value; [`Unit::None`] is none.
    pub const ALL: [Unit; 19] = [
        Unit::Um,
        Unit::Mm,
        Unit::Inch,
        Unit::Steps,
        Unit::Ms,
        Unit::Second,
        Unit::Minute,
        Unit::UmPerS,
        Unit::MmPerS,
        Unit::MmPerMin,
        Unit::InchPerMin,
        Unit::StepsPerS,
        Unit::UmPerS2,
        Unit::MmPerS2,
        Unit::StepsPerS2,
        Unit::MilliDeg,
        Unit::Deg,
        Unit::MilliVolt,
        Unit::Volt,
    ];

    /// As it is written, empty for [`Unit::None`].
    pub const fn suffix(self) -> &'static str {
        match self {
            Unit::None => "",
            Unit::Um => "um",
            Unit::Steps => "st",
            Unit::Ms => "ms",
            Unit::UmPerS => "um/s",
            Unit::StepsPerS => "st/s",
            Unit::UmPerS2 => "um/s2",
            Unit::StepsPerS2 => "st/s2",
            Unit::Mm => "mm",
            Unit::Inch => "in",
            Unit::Second => "s",
            Unit::Minute => "min",
            Unit::MmPerS => "mm/s",
            Unit::MmPerMin => "mm/min",
            Unit::InchPerMin => "in/min",
            Unit::MmPerS2 => "mm/s2",
            Unit::MilliDeg => "mdeg",
            Unit::Deg => "deg",
            Unit::MilliVolt => "mV",
            Unit::Volt => "V",
        }
    }

    /// The unit of that text in any case.
    pub fn from_text(text: &str) -> Option<Unit> {
        Unit::ALL.into_iter().find(|unit| unit.suffix().eq_ignore_ascii_case(text))
    }

    /// The kind of the quantities that it measures.
    pub const fn kind(self) -> Kind {
        match self {
            Unit::None => Kind::Number,
            Unit::Um | Unit::Mm | Unit::Inch => Kind::Length,
            Unit::Steps => Kind::Steps,
            Unit::Ms | Unit::Second | Unit::Minute => Kind::Time,
            Unit::UmPerS | Unit::MmPerS | Unit::MmPerMin | Unit::InchPerMin => Kind::Speed,
            Unit::StepsPerS => Kind::StepRate,
            Unit::UmPerS2 | Unit::MmPerS2 => Kind::Accel,
            Unit::StepsPerS2 => Kind::StepAccel,
            Unit::MilliDeg | Unit::Deg => Kind::Angle,
            Unit::MilliVolt | Unit::Volt => Kind::Voltage,
        }
    }

    /// Its decimals; `None` of a unit that is stored.
    pub const fn decimals(self) -> Option<Decimals> {
        let (times, over, digits) = match self {
            Unit::Mm | Unit::Second | Unit::MmPerS | Unit::MmPerS2 | Unit::Deg | Unit::Volt => {
                (1, 1, 3)
            }
            // 25 400 um and 10 000 digits.
            Unit::Inch => (50, 127, 4),
            Unit::Minute => (1, 600, 2),
            Unit::MmPerMin => (3, 5, 1),
            Unit::InchPerMin => (30, 127, 2),
            _ => return None,
        };
        Some(Decimals { times, over, digits })
    }

    /// A stored value as PRINT writes it: `2540um`, `2.540mm`.
    pub const fn show(self, value: i32) -> Shown {
        Shown { value, unit: self }
    }
}

/// A value with its unit, to be written.
#[derive(Clone, Copy, Debug)]
pub struct Shown {
    value: i32,
    unit: Unit,
}

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = self.unit.suffix();
        let Some(decimals) = self.unit.decimals() else {
            return write!(f, "{}{unit}", self.value);
        };
        let sign = if self.value <= decimals.minus() { "-" } else { "" };
        let one = 10_u32.pow(decimals.digits.into());
        let size = decimals.scaled(self.value).unsigned_abs();
        let width = usize::from(decimals.digits);
        write!(f, "{sign}{}.{:0width$}{unit}", size / one, size % one)
    }
}

#[cfg(test)]
mod tests {
    use super::Unit;
    use proptest::prelude::*;

    #[test]
    fn decimals_are_fixed_and_rounded() {
        let shown = |unit: Unit, value| unit.show(value).to_string();
        assert_eq!(shown(Unit::Mm, 2540), "2.540mm");
        assert_eq!(shown(Unit::Mm, -5), "-0.005mm");
        assert_eq!(shown(Unit::Mm, i32::MIN), "-2147483.648mm");
        assert_eq!(shown(Unit::Inch, 25_400), "1.0000in");
        assert_eq!(shown(Unit::Inch, -1), "0.0000in", "no minus of what rounds to 0");
        assert_eq!(shown(Unit::Inch, -2), "-0.0001in");
        assert_eq!(shown(Unit::Second, 1500), "1.500s");
        assert_eq!(shown(Unit::Minute, 90_000), "1.50min");
        assert_eq!(shown(Unit::Minute, -300), "-0.01min", "half goes away from zero");
        assert_eq!(shown(Unit::MmPerMin, 20_000), "1200.0mm/min");
        assert_eq!(shown(Unit::InchPerMin, 4233), "10.00in/min");
        assert_eq!(shown(Unit::Um, -7), "-7um");
    }

    proptest! {
        #[test]
        fn every_value_is_the_nearest(value: i32, n in 0..Unit::ALL.len()) {
            let unit = Unit::ALL[n];
            if let Some(decimals) = unit.decimals() {
                let (times, over) = (i64::from(decimals.times), i64::from(decimals.over));
                let product = i64::from(value) * times;
                let exact = (2 * product.abs() + over) / (2 * over) * product.signum();
                prop_assert_eq!(i64::from(decimals.scaled(value)), exact);
                prop_assert_eq!(value <= decimals.minus(), exact < 0);
            }
            prop_assert_eq!(Unit::from_text(unit.suffix()), Some(unit));
        }
    }
}
