//! Grbl's `$` settings, from the machine's profile.

use lang::axis::Axis;
use lang::profile::{AxisProfile, Direction, OutputRole, Profile, PwmKind};

use super::Error;

/// An axis for a session. Lengths in mm.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisFacts {
    /// Steps and the um that they make.
    pub scale: (f64, f64),
    /// Lowest machine place.
    pub min: f64,
    /// Highest machine place.
    pub max: f64,
    /// Top speed, um/s.
    pub top: f64,
    /// The lesser one of the ramps, mm/s2.
    ramp: f64,
    invert: bool,
    home_negative: bool,
    homing: [f64; 4],
}

/// A machine for a session.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// The profile's name.
    pub name: String,
    /// X, Y, Z.
    pub axes: [Option<AxisFacts>; 3],
    /// Moves need homed axes.
    pub require_homing: bool,
    /// S of full power, where S is a power.
    pub power: Option<i32>,
    /// A laser: dark in jogs.
    pub laser: bool,
    /// The output that M3 switches, from 1.
    pub spindle: Option<u16>,
    /// The output that M8 switches, from 1.
    pub coolant: Option<u16>,
    /// Outputs that M42 may set, bit n - 1.
    pub outputs: u32,
    /// Inputs that there are.
    pub inputs: u16,
    /// The probe's input, from 1.
    pub probe: i32,
    fixed: [f64; 8],
    inverted_probe: bool,
    inverted_reference: bool,
    inverted_enable: bool,
}

impl Machine {
    /// The machine of a profile.
    pub fn of(profile: &Profile) -> Machine {
        let output = |role| profile.output_with(role).and_then(|o| u16::try_from(o.n).ok());
        let own = |output: &lang::profile::Output| {
            matches!(output.role, Some(OutputRole::Lamp | OutputRole::Enable))
        };
        let count = profile.wiring.outputs();
        let mut outputs = (1u32 << count) - 1;
        for output in profile.outputs.iter().filter(|output| own(output)) {
            outputs &= !(1 << (output.n - 1));
        }
        let inverted = |n: i32| profile.inputs.iter().any(|input| input.n == n && input.invert);
        let laser = profile.laser().is_some();
        let pwm = profile.pwm.as_ref();
        let range = f64::from(profile.full_power());
        let minimum = pwm.map_or(0.0, |pwm| range * f64::from(pwm.minimum) / 1000.0);
        Machine {
            name: profile.name.clone(),
            axes: Axis::ALL.map(|axis| profile.axis(axis).map(facts)),
            require_homing: profile.require_homing,
            power: profile.has_power().then(|| profile.full_power()),
            laser: laser || pwm.is_some_and(|pwm| pwm.kind == PwmKind::Laser),
            spindle: profile.switched().and_then(|n| u16::try_from(n).ok()),
            coolant: output(OutputRole::Coolant),
            outputs,
            inputs: profile.wiring.inputs().unsigned_abs() as u16,
            probe: profile.probe_input(),
            fixed: [
                f64::from(profile.pulse_us),
                255.0,
                f64::from(profile.corner_um) / 1000.0,
                0.002,
                range,
                minimum,
                f64::from(u8::from(laser)),
                0.0,
            ],
            inverted_probe: inverted(profile.probe_input()),
            inverted_reference: Axis::ALL.iter().any(|axis| {
                profile.axis(*axis).is_some() && inverted(profile.reference_input(*axis))
            }),
            inverted_enable: profile.output_with(OutputRole::Enable).is_some_and(|o| o.invert),
        }
    }

    /// A machine place of motor steps, mm; 0 where there is no such axis.
    pub fn place(&self, steps: [i32; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| match &self.axes[i] {
            Some(axis) => f64::from(steps[i]) * axis.scale.1 / axis.scale.0 / 1000.0,
            None => 0.0,
        })
    }

    /// Grbl's settings and their values, in order.
    pub fn settings(&self, report: u8, inches: bool) -> Vec<(u16, String)> {
        let [pulse, idle, corner, arc, range, minimum, laser, _] = self.fixed;
        let there = || self.axes.iter().flatten();
        let bits = |of: &dyn Fn(&AxisFacts) -> bool| {
            let on = |i: usize| self.axes[i].as_ref().is_some_and(of);
            (0..3).fold(0, |all, i| all | u8::from(on(i)) << i).to_string()
        };
        let least = |n: usize| there().map(|a| a.homing[n]).fold(f64::MAX, f64::min);
        let most = |n: usize| there().map(|a| a.homing[n]).fold(0.0, f64::max);
        let whole = |value: f64| format!("{value:.0}");
        let three = |value: f64| format!("{value:.3}");
        let flag = |on: bool| u8::from(on).to_string();
        let mut list = vec![
            (0, whole(pulse)),
            (1, whole(idle)),
            (2, "0".to_owned()),
            (3, bits(&|axis| axis.invert)),
            (4, flag(self.inverted_enable)),
            (5, flag(self.inverted_reference)),
            (6, flag(self.inverted_probe)),
            (10, report.to_string()),
            (11, three(corner)),
            (12, three(arc)),
            (13, flag(inches)),
            (20, "1".to_owned()),
            (21, "1".to_owned()),
            (22, flag(there().next().is_some())),
            (23, bits(&|axis| axis.home_negative)),
            (24, three(least(0))),
            (25, three(least(1))),
            (26, whole(most(2))),
            (27, three(most(3))),
            (30, whole(range)),
            (31, whole(minimum)),
            (32, whole(laser)),
        ];
        // What an axis has that the machine has not: clients want all 34 lines.
        let each = |first: u16, missing: f64, of: &dyn Fn(&AxisFacts) -> f64| {
            let value = |axis: &Option<AxisFacts>| axis.as_ref().map_or(missing, of);
            (first..).zip(self.axes.iter().map(value).map(three)).collect::<Vec<_>>()
        };
        list.extend(each(100, 250.0, &|axis| 1000.0 * axis.scale.0 / axis.scale.1));
        list.extend(each(110, 500.0, &|axis| axis.top * 0.06));
        list.extend(each(120, 10.0, &|axis| axis.ramp));
        list.extend(each(130, 0.0, &|axis| axis.max - axis.min));
        list
    }

    /// The profile's key of a setting.
    fn key(number: u16) -> &'static str {
        match number {
            0 => "pulse_us",
            3 => "invert of an axis",
            4 => "invert of the output with role enable",
            5 | 6 => "invert of an input",
            11 => "corner_um",
            22 | 23 => "home.direction",
            24 => "home.slow_rate",
            25 => "home.fast_rate",
            26 => "home.pause_ms",
            27 => "home.clearance_um",
            30 => "pwm.range",
            31 => "pwm.minimum",
            32 => "role = \"laser\" of an output",
            100..=102 => "scale",
            110..=112 => "top_rate",
            120..=122 => "accel and decel",
            130..=132 => "min_um and max_um",
            _ => "",
        }
    }

    /// Whether a setting may be written so: only with what it holds.
    ///
    /// # Errors
    /// The answer, and what to change instead.
    pub fn write(&self, number: u16, value: f64) -> Result<(), (Error, String)> {
        if value < 0.0 {
            return Err((Error::NEGATIVE, String::new()));
        }
        let list = self.settings(1, false);
        let Some((_, held)) = list.iter().find(|(own, _)| *own == number) else {
            return Err((Error::STATEMENT, String::new()));
        };
        let held: f64 = held.parse().unwrap_or(-1.0);
        if (held - value).abs() <= 0.000_5 + held.abs() * 1e-5 {
            return Ok(());
        }
        let key = Machine::key(number);
        let words = if key.is_empty() {
            format!("${number} is fixed at {held}")
        } else {
            format!(
                "${number} belongs to the profile {}; change {key} there, then pasapas profile set",
                self.name
            )
        };
        Err((Error::STATEMENT, words))
    }
}

fn facts(axis: &AxisProfile) -> AxisFacts {
    let (steps, um) = (f64::from(axis.scale.steps), f64::from(axis.scale.um));
    let per_minute = |rate: i32| f64::from(rate) * um / steps * 0.06;
    let ramp = axis.accel.min(axis.decel.unwrap_or(axis.accel));
    AxisFacts {
        scale: (steps, um),
        min: f64::from(axis.min_um) / 1000.0,
        max: f64::from(axis.max_um) / 1000.0,
        top: f64::from(axis.top_rate) * um / steps,
        ramp: f64::from(ramp) * um / steps / 1000.0,
        invert: axis.invert,
        home_negative: axis.home.direction == Direction::Negative,
        homing: [
            per_minute(axis.home.slow_rate),
            per_minute(axis.home.fast_rate),
            f64::from(axis.home.pause_ms),
            f64::from(axis.home.clearance_um) / 1000.0,
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::Machine;
    use crate::grbl::Error;
    use lang::profile::Profile;

    #[test]
    fn there_are_all_34_settings_in_order_and_they_are_the_profiles() {
        for name in ["mill", "laser", "charly", "thesis"] {
            let machine = Machine::of(&Profile::built_in(name).expect("built in"));
            let list = machine.settings(1, false);
            let numbers: Vec<u16> = list.iter().map(|(number, _)| *number).collect();
            let wanted: Vec<u16> = [0, 1, 2, 3, 4, 5, 6, 10, 11, 12, 13]
                .into_iter()
                .chain(20..=27)
                .chain(30..=32)
                .chain([100, 101, 102, 110, 111, 112, 120, 121, 122, 130, 131, 132])
                .collect();
            assert_eq!((numbers.len(), &numbers), (34, &wanted), "{name}");
            for (number, value) in &list {
                let value = value.parse().expect("a number");
                assert_eq!(machine.write(*number, value), Ok(()), "{name} ${number}");
            }
        }
    }

    #[test]
    fn another_value_is_refused_with_the_key_to_change() {
        let machine = Machine::of(&Profile::built_in("mill").expect("built in"));
        let list = machine.settings(1, false);
        let of = |n| list.iter().find(|(own, _)| *own == n).map(|(_, value)| value.as_str());
        assert_eq!(of(100), Some("100.000"));
        assert_eq!(of(110), Some("4800.000"));
        assert_eq!(of(120), Some("250.000"));
        assert_eq!([of(130), of(132)], [Some("300.000"), Some("80.000")]);
        let (error, words) = machine.write(110, 5000.0).expect_err("another one");
        assert_eq!(error, Error::STATEMENT);
        assert!(words.contains("change top_rate there"), "{words}");
        assert_eq!(machine.write(99, 1.0), Err((Error::STATEMENT, String::new())));
        assert_eq!(machine.write(110, -1.0), Err((Error::NEGATIVE, String::new())));
    }
}
