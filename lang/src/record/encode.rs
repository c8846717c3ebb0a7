//! From a profile to its records, and to bytes.

use super::{
    AxisRecord, BoardRecord, MachineRecord, MoreRecord, OutputStates, RECORD_VERSION,
    ThresholdRecord,
};
use crate::axis::Axis;
use crate::profile::{
    AoutPause, AxisProfile, Direction, FIRST_THRESHOLD, InputRole, Output, OutputRole, Parity,
    Profile, PwmKind, SafeState, Wiring,
};
use crate::wire::{CRC_START, crc16};

/// An axis that the machine does not have. Its scale is 1, as the planner divides by it.
const ABSENT: AxisRecord = AxisRecord {
    flags: 0,
    steps: 1,
    um: 1,
    start_rate: 0,
    home_fast: 0,
    home_slow: 0,
    home_pause: 0,
    top_rate: 0,
    accel: 0,
    decel: 0,
    min: 0,
    max: 0,
    home_stroke: 0,
    home_position: 0,
    home_clearance: 0,
};

fn rate16(rate: i32) -> u16 {
    u16::try_from(rate).unwrap_or(u16::MAX)
}

fn number(n: i32) -> u8 {
    u8::try_from(n).unwrap_or(0)
}

fn bit(n: i32) -> u16 {
    u32::try_from(n - 1).ok().and_then(|shift| 1u16.checked_shl(shift)).unwrap_or(0)
}

impl AxisRecord {
    fn of(profile: &AxisProfile) -> AxisRecord {
        let home = &profile.home;
        let mut flags = AxisRecord::PRESENT;
        if profile.invert {
            flags |= AxisRecord::INVERT;
        }
        if home.direction == Direction::Positive {
            flags |= AxisRecord::HOME_POSITIVE;
        }
        AxisRecord {
            flags,
            steps: profile.scale.steps,
            um: profile.scale.um,
            start_rate: rate16(profile.start_rate),
            home_fast: rate16(home.fast_rate),
            home_slow: rate16(home.slow_rate),
            home_pause: home.pause_ms,
            top_rate: profile.top_rate.unsigned_abs(),
            accel: profile.accel.unsigned_abs(),
            decel: profile.decel.unwrap_or(profile.accel).unsigned_abs(),
            min: profile.min_um,
            max: profile.max_um,
            home_stroke: home.stroke_um,
            home_position: home.position_um,
            home_clearance: home.clearance_um,
        }
    }

    fn write(&self, out: &mut Vec<u8>) {
        for word in [
            self.flags,
            self.steps,
            self.um,
            self.start_rate,
            self.home_fast,
            self.home_slow,
            self.home_pause,
        ] {
            out.extend(word.to_le_bytes());
        }
        for rate in [self.top_rate, self.accel, self.decel] {
            out.extend(rate.to_le_bytes());
        }
        for place in [self.min, self.max, self.home_stroke, self.home_position, self.home_clearance]
        {
            out.extend(place.to_le_bytes());
        }
    }
}

impl MachineRecord {
    /// The axes' part of `profile`.
    pub fn of(profile: &Profile) -> MachineRecord {
        let mut flags = 0;
        if profile.require_homing {
            flags |= MachineRecord::REQUIRE_HOMING;
        }
        if profile.rapid_z_apart {
            flags |= MachineRecord::RAPID_Z_APART;
        }
        MachineRecord {
            flags,
            keeps: 0,
            corner: rate16(profile.corner_um),
            default_feed: profile.default_feed_um_s.unwrap_or(0).unsigned_abs(),
            axes: Axis::ALL.map(|axis| profile.axis(axis).map_or(ABSENT, AxisRecord::of)),
        }
    }

    /// What an image's header holds of it: tells machines apart.
    pub fn hash(&self) -> u16 {
        self.to_bytes().iter().fold(CRC_START, |crc, &byte| crc16(crc, byte))
    }

    /// The record as the image holds it, [`MachineRecord::SIZE`] bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Vec::with_capacity(MachineRecord::SIZE);
        out.extend([self.flags, self.keeps]);
        out.extend(self.corner.to_le_bytes());
        out.extend(self.default_feed.to_le_bytes());
        for axis in &self.axes {
            axis.write(&mut out);
        }
        out
    }
}

impl BoardRecord {
    /// The board's part of `profile`, with this sequence number and a valid CRC.
    pub fn of(profile: &Profile, sequence: u16) -> BoardRecord {
        let input = |role| number(profile.input_with(role).map_or(0, |input| input.n));
        let inputs = |role| {
            let mut with = profile.inputs.iter().filter(move |input| input.role == Some(role));
            move || with.next().map_or(0, |input| number(input.n))
        };
        let output = |role| number(profile.output_with(role).map_or(0, |output| output.n));
        let mut flags = 0;
        if profile.wiring == Wiring::Chain {
            flags |= BoardRecord::CHAIN;
        }
        if profile.run.autorun {
            flags |= BoardRecord::AUTORUN;
        }
        if profile.step_invert {
            flags |= BoardRecord::STEP_LOW;
        }
        let inverted = |n: i32| profile.inputs.iter().any(|input| input.n == n && input.invert);
        // A laser never stays on in a pause.
        let pause = |output: &Output| match output.role {
            Some(OutputRole::Laser) => SafeState::Off,
            _ => output.pause,
        };
        let (mut stop, mut hold) = (inputs(InputRole::Stop), inputs(InputRole::Hold));
        let (mut door, mut emergency) = (inputs(InputRole::Door), inputs(InputRole::EmergencyStop));
        let record = BoardRecord {
            sequence,
            version: RECORD_VERSION,
            flags,
            address: profile.link.address,
            rate: rate_code(profile.link.rate, profile.link.parity),
            pulse: profile.pulse_us,
            setup: profile.dir_setup_us,
            filter: profile.inputs.iter().map(|input| input.filter_ms).max().unwrap_or(5),
            probe: number(profile.probe_input()),
            input_invert: (1..=16).filter(|&n| inverted(n)).map(bit).sum(),
            input_invert_high: inverted(17).into(),
            reference: Axis::ALL.map(|axis| number(profile.reference_input(axis))),
            stop: core::array::from_fn(|_| stop()),
            hold: core::array::from_fn(|_| hold()),
            door: core::array::from_fn(|_| door()),
            emergency: core::array::from_fn(|_| emergency()),
            end_of_stops: BoardRecord::END_OF_STOPS,
            start: input(InputRole::Start),
            select: select(profile),
            output_invert: profile.outputs.iter().filter(|o| o.invert).map(|o| bit(o.n)).sum(),
            reset_on: states(profile, |output| output.reset, SafeState::Off).on,
            pause: states(profile, pause, SafeState::Keep),
            fault: states(profile, |output| output.fault, SafeState::Off),
            end: states(profile, |output| output.end, SafeState::Off),
            laser: output(OutputRole::Laser),
            lamp: output(OutputRole::Lamp),
            enable: output(OutputRole::Enable),
            spindle: output(OutputRole::Spindle),
            spin_up: profile.run.spin_up_ms,
            lock: [0; 2],
            emergency_pin: 0,
            emergency_falls: 0,
            more_crc: 0,
            crc: 0,
            more: MoreRecord::of(profile),
        };
        let emergency_pin = record.emergency.iter().fold(0, |pins, n| pins | record.pin(*n));
        let emergency_falls = emergency_pin & record.falling();
        BoardRecord { emergency_pin, emergency_falls, ..record }.sealed()
    }

    /// The record with the CRCs that its other fields make.
    #[must_use]
    pub fn sealed(mut self) -> BoardRecord {
        self.more = self.more.sealed();
        self.more_crc = self.more.crc;
        let bytes = self.to_bytes();
        self.crc = bytes[..BoardRecord::SIZE - 2].iter().fold(CRC_START, |crc, &b| crc16(crc, b));
        self
    }

    /// The record as the information memory holds it.
    pub fn to_bytes(&self) -> [u8; BoardRecord::SIZE] {
        let mut out = Vec::with_capacity(BoardRecord::SIZE);
        let mut words = |words: &[u16]| {
            for word in words {
                out.extend(word.to_le_bytes());
            }
        };
        let pair = |low: u8, high: u8| u16::from_le_bytes([low, high]);
        words(&[self.sequence, self.version, self.flags]);
        words(&[
            pair(self.address, self.rate),
            pair(self.pulse, self.setup),
            pair(self.filter, self.probe),
            self.input_invert,
            self.input_invert_high,
            pair(self.reference[0], self.reference[1]),
            pair(self.reference[2], self.stop[0]),
            pair(self.stop[1], self.hold[0]),
            pair(self.hold[1], self.door[0]),
            pair(self.door[1], self.emergency[0]),
            pair(self.emergency[1], self.emergency[2]),
            pair(self.emergency[3], self.end_of_stops),
            pair(self.start, self.select),
            self.reset_on,
            self.output_invert,
        ]);
        for states in [self.pause, self.fault, self.end] {
            words(&[states.keep, states.on]);
        }
        words(&[pair(self.laser, self.lamp), pair(self.enable, self.spindle), self.spin_up]);
        words(&self.lock);
        words(&[pair(self.emergency_pin, self.emergency_falls)]);
        words(&[self.more_crc]);
        words(&[self.crc]);
        let mut bytes = [0; BoardRecord::SIZE];
        bytes.copy_from_slice(&out);
        bytes
    }
}

/// [`BoardRecord::rate`]
fn rate_code(rate: u32, parity: Parity) -> u8 {
    let rate = match rate {
        9_600 => 0,
        19_200 => 1,
        57_600 => 2,
        _ => 3,
    };
    let parity = match parity {
        Parity::None => 0,
        Parity::Even => 1,
        Parity::Odd => 2,
    };
    rate | parity << 4
}

impl MoreRecord {
    /// What `profile` says of them, with its CRC.
    fn of(profile: &Profile) -> MoreRecord {
        let mut more = MoreRecord::NONE;
        if let Some(rs485) = &profile.rs485 {
            more.rs485_address = rs485.address;
            more.rs485_rate = rate_code(rs485.rate, rs485.parity);
        }
        more.thresholds = thresholds(profile);
        if let Some(aout) = profile.aouts.first() {
            let value = |value: i32| u16::try_from(value).unwrap_or(0) & MoreRecord::VALUE;
            more.aout_hz = profile.aout_hz();
            more.aout_full =
                value(aout.full()) | if aout.is_share() { MoreRecord::SHARE } else { 0 };
            let pauses = aout.pause == AoutPause::Safe;
            more.aout_safe = value(aout.safe) | if pauses { MoreRecord::PAUSES } else { 0 };
        }
        let Some(pwm) = &profile.pwm else { return more };
        MoreRecord {
            pwm_hz: pwm.hz(),
            pwm_range: rate16(pwm.range),
            pwm_minimum: pwm.minimum,
            servo_low: pwm.low_us,
            servo_high: pwm.high_us,
            pwm_output: number(pwm.output),
            pwm_kind: match pwm.kind {
                PwmKind::Laser => MoreRecord::LASER,
                PwmKind::Spindle => MoreRecord::SPINDLE,
                PwmKind::Servo => MoreRecord::SERVO,
            },
            ..more
        }
    }

    /// The record with the CRC that its other fields make, which is never 0; 0 of nothing.
    fn sealed(mut self) -> MoreRecord {
        self.crc = 0;
        if self == MoreRecord::NONE {
            return self;
        }
        let crc = |record: &MoreRecord| {
            record.to_bytes()[..MoreRecord::SIZE - 2]
                .iter()
                .fold(CRC_START, |crc, &b| crc16(crc, b))
        };
        self.crc = crc(&self);
        if self.crc == 0 {
            self.thresholds[3].on |= ThresholdRecord::SPARE;
            self.crc = crc(&self);
        }
        self
    }

    /// The record as the information memory holds it.
    pub fn to_bytes(&self) -> [u8; MoreRecord::SIZE] {
        let kind = u16::from_le_bytes([self.pwm_output, self.pwm_kind]);
        let pwm = [self.pwm_hz, self.pwm_range, self.pwm_minimum];
        let rs485 = u16::from_le_bytes([self.rs485_address, self.rs485_rate]);
        let words = pwm.into_iter().chain([self.servo_low, self.servo_high, kind, rs485]);
        let levels = self.thresholds.into_iter().flat_map(|levels| [levels.on, levels.off]);
        let aout = [self.aout_hz, self.aout_full, self.aout_safe];
        let words = words.chain(levels).chain(aout).chain([self.crc]);
        let mut bytes = [0; MoreRecord::SIZE];
        for (place, word) in bytes.chunks_exact_mut(2).zip(words) {
            place.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }
}

/// The thresholds' levels, and the analog inputs with their filters.
fn thresholds(profile: &Profile) -> [ThresholdRecord; 4] {
    let level = |mv: i32| u16::try_from(mv).unwrap_or(0) & ThresholdRecord::LEVEL;
    core::array::from_fn(|place| {
        let at = place as i32;
        let mut record = ThresholdRecord::default();
        if let Some(threshold) = profile.thresholds.iter().find(|t| t.input == FIRST_THRESHOLD + at)
        {
            let analog = u16::try_from(threshold.analog).unwrap_or(0);
            record.on = level(threshold.on_mv) | analog << ThresholdRecord::ABOVE;
            record.off = level(threshold.off_mv);
        }
        if let Some(analog) = profile.analogs.iter().find(|analog| analog.n == at + 1) {
            let filter = analog.slowest_ms().max(1).ilog2() as u16;
            record.off |= ThresholdRecord::USED | filter << ThresholdRecord::ABOVE;
        }
        record
    })
}

/// The masks of one occasion; outputs that the profile does not name do as `others`.
fn states(profile: &Profile, of: impl Fn(&Output) -> SafeState, others: SafeState) -> OutputStates {
    let mut states = OutputStates { keep: 0, on: 0 };
    for n in 1..=16 {
        let state = profile.outputs.iter().find(|output| output.n == n).map_or(others, &of);
        match state {
            SafeState::Off => {}
            SafeState::On => states.on |= bit(n),
            SafeState::Keep => states.keep |= bit(n),
        }
    }
    states
}

/// [`BoardRecord::select`]
fn select(profile: &Profile) -> u8 {
    let at = |role| profile.input_with(role).map_or(0, |input| input.n as u8);
    let count = InputRole::SELECT.into_iter().filter(|role| at(*role) != 0).count() as u8;
    match at(InputRole::NextProgram) {
        0 if count == 0 => 0,
        0 => at(InputRole::Select1) | count << 5,
        next => next | BoardRecord::NEXT << 5,
    }
}

#[cfg(test)]
mod tests {
    use super::{BoardRecord, MachineRecord, MoreRecord, Profile};

    #[test]
    fn a_board_without_a_profile_is_a_mill() {
        let mill = Profile::built_in("mill").unwrap();
        let record = BoardRecord::of(&mill, 0);
        assert_eq!(BoardRecord { crc: 0, ..record }, BoardRecord::DEFAULT);
    }

    #[test]
    fn several_inputs_of_a_role_come_back_from_the_record() {
        let roles = [("emergency_stop", 1), ("hold", 2), ("emergency_stop", 5), ("door", 6)]
            .into_iter()
            .chain([("stop", 7), ("emergency_stop", 17), ("hold", 4), ("door", 8), ("stop", 3)])
            .chain([("emergency_stop", 16), ("start", 12), ("probe", 13)]);
        let text: String =
            roles.map(|(role, n)| format!("\n[[input]]\nn = {n}\nrole = \"{role}\"\n")).collect();
        let mill = include_str!("../../../examples/profiles/mill.toml");
        let profile = Profile::parse(&(mill.to_owned() + &text)).expect("the profile");
        let record = BoardRecord::of(&profile, 7);
        assert_eq!(record.emergency, [1, 5, 17, 16]);
        assert_eq!((record.hold, record.door, record.stop), ([2, 4], [6, 8], [7, 3]));
        let again = BoardRecord::from_bytes(&record.to_bytes());
        assert_eq!(again, record);
        let base = Profile::built_in("mill").expect("built in");
        let back = BoardRecord::of(&again.into_profile(&base), 7);
        let sorted = |mut numbers: [u8; 4]| {
            numbers.sort_unstable();
            numbers
        };
        assert_eq!(sorted(back.emergency), sorted(record.emergency));
        assert_eq!((back.hold, back.door, back.stop), ([2, 4], [6, 8], [3, 7]));
        assert_eq!((back.start, back.probe), (12, 13));
    }

    #[test]
    fn encoded_sizes_are_those_of_the_structures() {
        let mill = Profile::built_in("mill").unwrap();
        assert_eq!(MachineRecord::of(&mill).to_bytes().len(), MachineRecord::SIZE);
        assert_eq!(core::mem::offset_of!(BoardRecord, more), BoardRecord::SIZE);
        assert_eq!(size_of::<MoreRecord>(), MoreRecord::SIZE);
    }
}
