//! From the bytes of a board's record to its fields, and back into a profile.

use std::collections::BTreeSet;

use super::{BoardRecord, MoreRecord, OutputStates, ThresholdRecord};
use crate::profile::{
    Analog, Aout, AoutPause, FIRST_THRESHOLD, Input, InputRole, Link, Output, OutputRole, Parity,
    Profile, Pwm, PwmKind, SafeState, Threshold, Wiring,
};

impl BoardRecord {
    /// Reads what the information memory or the link gives. Neither version nor CRC is
    /// checked; what lies behind it is not there yet ([`BoardRecord::more`]).
    pub fn from_bytes(bytes: &[u8; BoardRecord::SIZE]) -> BoardRecord {
        let byte = |at: usize| bytes[at];
        let word = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let states = |at: usize| OutputStates { keep: word(at), on: word(at + 2) };
        BoardRecord {
            sequence: word(0),
            version: word(2),
            flags: word(4),
            address: byte(6),
            rate: byte(7),
            pulse: byte(8),
            setup: byte(9),
            filter: byte(10),
            probe: byte(11),
            input_invert: word(12),
            input_invert_high: word(14),
            reference: [byte(16), byte(17), byte(18)],
            stop: [byte(19), byte(20)],
            hold: [byte(21), byte(22)],
            door: [byte(23), byte(24)],
            emergency: [byte(25), byte(26), byte(27), byte(28)],
            end_of_stops: byte(29),
            start: byte(30),
            select: byte(31),
            reset_on: word(32),
            output_invert: word(34),
            pause: states(36),
            fault: states(40),
            end: states(44),
            laser: byte(48),
            lamp: byte(49),
            enable: byte(50),
            spindle: byte(51),
            spin_up: word(52),
            lock: [word(54), word(56)],
            emergency_pin: byte(58),
            emergency_falls: byte(59),
            more_crc: word(60),
            crc: word(62),
            more: MoreRecord::NONE,
        }
    }

    /// `base` with the board's part taken from this record. Names of inputs and outputs stay those
    /// of `base`, and roles that the record does not keep (coolant) too.
    pub fn into_profile(&self, base: &Profile) -> Profile {
        let mut profile = base.clone();
        profile.wiring =
            if self.flags & BoardRecord::CHAIN != 0 { Wiring::Chain } else { Wiring::Direct };
        profile.run.autorun = self.flags & BoardRecord::AUTORUN != 0;
        profile.run.spin_up_ms = self.spin_up;
        profile.link = link(self.address, self.rate);
        profile.pulse_us = self.pulse;
        profile.dir_setup_us = self.setup;
        profile.step_invert = self.flags & BoardRecord::STEP_LOW != 0;
        profile.inputs = self.inputs(&base.inputs, profile.wiring);
        profile.outputs = self.outputs(&base.outputs, profile.wiring);
        let more = self.more();
        profile.pwm = more.pwm();
        profile.analogs = more.analogs(&base.analogs);
        profile.thresholds = more.thresholds();
        profile.aouts = more.aouts(&base.aouts);
        profile.rs485 =
            (more.rs485_address != 0).then(|| link(more.rs485_address, more.rs485_rate));
        profile
    }

    /// The inputs that are not just what the wiring gives.
    fn inputs(&self, base: &[Input], wiring: Wiring) -> Vec<Input> {
        let several = |numbers: &[u8], role| numbers.iter().map(|n| (*n, role)).collect::<Vec<_>>();
        let stops = [
            several(&self.emergency, InputRole::EmergencyStop),
            several(&self.stop, InputRole::Stop),
            several(&self.hold, InputRole::Hold),
            several(&self.door, InputRole::Door),
        ]
        .concat();
        let (first, count) = (self.select & 31, self.select >> 5);
        let chooses = match count {
            BoardRecord::NEXT => vec![(first, InputRole::NextProgram)],
            count => (first..first + count).zip(InputRole::SELECT).collect(),
        };
        let stops = [stops, chooses].concat();
        let single = [
            (self.start, InputRole::Start),
            (self.probe, InputRole::Probe),
            (self.reference[0], InputRole::ReferenceX),
            (self.reference[1], InputRole::ReferenceY),
            (self.reference[2], InputRole::ReferenceZ),
        ];
        let inverted = |n: i32| match n {
            17 => self.input_invert_high & 1 != 0,
            1..=16 => self.input_invert >> (n - 1) & 1 != 0,
            _ => false,
        };
        let input = |n: i32| {
            let role = stops.iter().chain(&single).find(|(number, _)| i32::from(*number) == n);
            let named = base.iter().find(|input| input.n == n);
            let usual = n == wiring.probe() || (9..=11).contains(&n) || wiring == Wiring::Direct;
            // What the wiring gives by itself needs no word; a stop there does.
            let plain = |role: &InputRole| {
                let own = [InputRole::Probe, InputRole::ReferenceX];
                let others = [InputRole::ReferenceY, InputRole::ReferenceZ];
                own.contains(role) || others.contains(role)
            };
            let role = role.map(|(_, role)| *role).filter(|role| !usual || !plain(role));
            let plain = role.is_none() && !inverted(n) && named.is_none();
            (!plain).then(|| Input {
                n,
                name: named.and_then(|input| input.name.clone()),
                role: role.or_else(|| named.and_then(|input| input.role)),
                invert: inverted(n),
                filter_ms: self.filter,
            })
        };
        let made = base.iter().map(|input| input.n).filter(|n| *n >= FIRST_THRESHOLD);
        let roles = stops.iter().chain(&single).map(|(n, _)| i32::from(*n));
        let made: BTreeSet<i32> = made.chain(roles.filter(|n| *n >= FIRST_THRESHOLD)).collect();
        (1..=wiring.inputs()).chain(made).filter_map(input).collect()
    }

    /// The outputs that have a role, a polarity or states of their own.
    fn outputs(&self, base: &[Output], wiring: Wiring) -> Vec<Output> {
        let roles = [
            (self.laser, OutputRole::Laser),
            (self.lamp, OutputRole::Lamp),
            (self.enable, OutputRole::Enable),
            (self.spindle, OutputRole::Spindle),
        ];
        let output = |n: i32| {
            let bit = |mask: u16| mask >> (n - 1) & 1 != 0;
            let state = |states: OutputStates| match (bit(states.keep), bit(states.on)) {
                (true, _) => SafeState::Keep,
                (_, true) => SafeState::On,
                _ => SafeState::Off,
            };
            let named = base.iter().find(|output| output.n == n);
            let role = roles.iter().find(|(number, _)| i32::from(*number) == n);
            let role = role
                .map(|(_, role)| *role)
                .or_else(|| named.and_then(|o| o.role).filter(|r| *r == OutputRole::Coolant));
            let own = Output {
                n,
                name: named.and_then(|output| output.name.clone()),
                role,
                invert: bit(self.output_invert),
                reset: if bit(self.reset_on) { SafeState::On } else { SafeState::Off },
                pause: state(self.pause),
                fault: state(self.fault),
                end: state(self.end),
            };
            let plain = own.role.is_none()
                && named.is_none()
                && !own.invert
                && own.reset == SafeState::Off
                && own.pause == SafeState::Keep
                && own.fault == SafeState::Off
                && own.end == SafeState::Off;
            (!plain).then_some(own)
        };
        (1..=wiring.outputs()).filter_map(output).collect()
    }
}

/// A line by its record.
fn link(address: u8, rate: u8) -> Link {
    Link {
        address,
        rate: [9_600, 19_200, 57_600, 115_200][usize::from(rate & 3)],
        parity: match rate >> 4 {
            1 => Parity::Even,
            2 => Parity::Odd,
            _ => Parity::None,
        },
    }
}

impl MoreRecord {
    /// Reads what the information memory or the link gives.
    pub fn from_bytes(bytes: &[u8; MoreRecord::SIZE]) -> MoreRecord {
        let word = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        MoreRecord {
            pwm_hz: word(0),
            pwm_range: word(2),
            pwm_minimum: word(4),
            servo_low: word(6),
            servo_high: word(8),
            pwm_output: bytes[10],
            pwm_kind: bytes[11],
            rs485_address: bytes[12],
            rs485_rate: bytes[13],
            thresholds: core::array::from_fn(|n| ThresholdRecord {
                on: word(14 + 4 * n),
                off: word(16 + 4 * n),
            }),
            aout_hz: word(30),
            aout_full: word(32),
            aout_safe: word(34),
            crc: word(36),
        }
    }

    /// The analog inputs; names are those of `base`.
    fn analogs(&self, base: &[Analog]) -> Vec<Analog> {
        let known = (1..).zip(&self.thresholds);
        let used = known.filter(|(_, record)| record.off & ThresholdRecord::USED != 0);
        let analog = |(n, record): (i32, &ThresholdRecord)| Analog {
            n,
            name: base.iter().find(|analog| analog.n == n).and_then(|analog| analog.name.clone()),
            oversampling: 4,
            filter_ms: 1 << record.filter().min(5),
        };
        used.map(analog).collect()
    }

    /// What makes inputs of them.
    fn thresholds(&self) -> Vec<Threshold> {
        let known = (FIRST_THRESHOLD..).zip(&self.thresholds);
        let used = known.filter(|(_, record)| record.analog() != 0);
        let threshold = |(input, record): (i32, &ThresholdRecord)| Threshold {
            input,
            analog: record.analog().into(),
            on_mv: (record.on & ThresholdRecord::LEVEL).into(),
            off_mv: (record.off & ThresholdRecord::LEVEL).into(),
        };
        used.map(threshold).collect()
    }

    /// The analog output; its name is that of `base`.
    fn aouts(&self, base: &[Aout]) -> Vec<Aout> {
        let full = i32::from(self.aout_full & MoreRecord::VALUE);
        let share = self.aout_full & MoreRecord::SHARE != 0;
        let output = (full != 0).then(|| Aout {
            n: 1,
            name: base.iter().find(|aout| aout.n == 1).and_then(|aout| aout.name.clone()),
            frequency_hz: Some(self.aout_hz),
            full_mv: (!share).then_some(full),
            range: share.then_some(full),
            safe: (self.aout_safe & MoreRecord::VALUE).into(),
            pause: match self.aout_safe & MoreRecord::PAUSES {
                0 => AoutPause::Keep,
                _ => AoutPause::Safe,
            },
        });
        output.into_iter().collect()
    }

    fn pwm(&self) -> Option<Pwm> {
        let kind = match self.pwm_kind {
            MoreRecord::LASER => PwmKind::Laser,
            MoreRecord::SPINDLE => PwmKind::Spindle,
            _ => PwmKind::Servo,
        };
        (self.pwm_hz != 0).then(|| Pwm {
            output: self.pwm_output.into(),
            kind,
            frequency_hz: Some(self.pwm_hz),
            range: self.pwm_range.into(),
            minimum: self.pwm_minimum,
            low_us: self.servo_low,
            high_us: self.servo_high,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{BoardRecord, MoreRecord, Profile};
    use crate::profile::BUILT_IN;

    #[test]
    fn bytes_come_back_as_the_record_and_the_record_as_the_profile() {
        for (name, _) in BUILT_IN {
            let profile = Profile::built_in(name).unwrap();
            let record = BoardRecord::of(&profile, 7);
            let more = MoreRecord::from_bytes(&record.more.to_bytes());
            let head = BoardRecord::from_bytes(&record.to_bytes());
            assert_eq!(BoardRecord { more, ..head }, record);
            assert_eq!(BoardRecord::of(&record.into_profile(&profile), 7), record);
        }
    }

    #[test]
    fn what_lies_behind_the_record_comes_back_and_is_bound_to_it() {
        let plain = Profile::built_in("laser").unwrap();
        assert_eq!(BoardRecord::of(&plain, 7).more_crc, 0);
        let text = include_str!("../../../examples/profiles/laser.toml").to_owned()
            + "[pwm]\noutput = 1\nkind = \"spindle\"\nfrequency_hz = 50\nrange = 24000\nminimum = 20\n";
        let record = BoardRecord::of(&Profile::parse(&text).unwrap(), 7);
        assert_ne!(record.more_crc, 0);
        let more = MoreRecord::from_bytes(&record.more.to_bytes());
        let head = BoardRecord::from_bytes(&record.to_bytes());
        assert_eq!(BoardRecord { more, ..head }, record);
        assert_eq!(BoardRecord::of(&record.into_profile(&plain), 7), record);
    }
}
