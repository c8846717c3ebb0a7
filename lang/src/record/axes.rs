//! From the bytes of the axes' part of a profile to its fields, and back into a profile.

use super::{AxisRecord, MachineRecord};
use crate::axis::Axis;
use crate::profile::{AxisProfile, Direction, Homing, Profile, Scale};

impl AxisRecord {
    fn from_bytes(bytes: &[u8]) -> AxisRecord {
        let word = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let long = |at: usize| u32::from(word(at + 2)) << 16 | u32::from(word(at));
        let place = |at: usize| long(at).cast_signed();
        AxisRecord {
            flags: word(0),
            steps: word(2),
            um: word(4),
            start_rate: word(6),
            home_fast: word(8),
            home_slow: word(10),
            home_pause: word(12),
            top_rate: long(14),
            accel: long(18),
            decel: long(22),
            min: place(26),
            max: place(30),
            home_stroke: place(34),
            home_position: place(38),
            home_clearance: place(42),
        }
    }

    fn profile(&self) -> Option<AxisProfile> {
        let has = |flag| self.flags & flag != 0;
        let rate = |rate: u32| i32::try_from(rate).unwrap_or(i32::MAX);
        has(AxisRecord::PRESENT).then(|| AxisProfile {
            scale: Scale { steps: self.steps, um: self.um },
            start_rate: self.start_rate.into(),
            accel: rate(self.accel),
            decel: (self.decel != self.accel).then(|| rate(self.decel)),
            top_rate: rate(self.top_rate),
            min_um: self.min,
            max_um: self.max,
            invert: has(AxisRecord::INVERT),
            home: Homing {
                direction: match has(AxisRecord::HOME_POSITIVE) {
                    true => Direction::Positive,
                    false => Direction::Negative,
                },
                fast_rate: self.home_fast.into(),
                slow_rate: self.home_slow.into(),
                stroke_um: self.home_stroke,
                pause_ms: self.home_pause,
                position_um: self.home_position,
                clearance_um: self.home_clearance,
            },
        })
    }
}

impl MachineRecord {
    /// Reads [`MachineRecord::SIZE`] bytes, as an image and the link give them; what a program has in them besides its
    /// profile is left out.
    pub fn from_bytes(bytes: &[u8; MachineRecord::SIZE]) -> MachineRecord {
        let word = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let axis = |n: usize| AxisRecord::from_bytes(&bytes[8 + n * AxisRecord::SIZE..]);
        MachineRecord {
            flags: bytes[0] & (MachineRecord::REQUIRE_HOMING | MachineRecord::RAPID_Z_APART),
            keeps: 0,
            corner: word(2),
            default_feed: u32::from(word(6)) << 16 | u32::from(word(4)),
            axes: [axis(0), axis(1), axis(2)],
        }
    }

    /// `base` with the axes taken from this record. Of the order of a bare `Home`, which the record does not keep, the
    /// axes that there are stay.
    pub fn into_profile(&self, base: &Profile) -> Profile {
        let mut profile = base.clone();
        let [x, y, z] = self.axes.map(|axis| axis.profile());
        (profile.x, profile.y, profile.z) = (x, y, z);
        profile.require_homing = self.flags & MachineRecord::REQUIRE_HOMING != 0;
        profile.rapid_z_apart = self.flags & MachineRecord::RAPID_Z_APART != 0;
        profile.corner_um = self.corner.into();
        profile.default_feed_um_s = i32::try_from(self.default_feed).ok().filter(|feed| *feed != 0);
        let there = [profile.x.is_some(), profile.y.is_some(), profile.z.is_some()];
        profile.home_order.retain(|name| there[Axis::from(*name).index()]);
        profile
    }
}

#[cfg(test)]
mod tests {
    use crate::profile::{BUILT_IN, Profile};
    use crate::record::MachineRecord;

    #[test]
    fn a_record_and_its_profile_are_the_same_machine() {
        let other = Profile::built_in("mill").expect("built in");
        for (name, _) in BUILT_IN {
            let profile = Profile::built_in(name).expect("built in");
            let record = MachineRecord::of(&profile);
            let mut bytes: [u8; MachineRecord::SIZE] =
                record.to_bytes().try_into().expect("as long as that");
            // What a program has of its own.
            bytes[0] |= MachineRecord::AT_LIMITS | MachineRecord::COURSES;
            bytes[1] = 0x5A;
            let read = MachineRecord::from_bytes(&bytes);
            assert_eq!(read, record, "{name}");
            let back = read.into_profile(&other);
            assert_eq!(MachineRecord::of(&back), record, "{name}");
            assert_eq!([&back.x, &back.y, &back.z], [&profile.x, &profile.y, &profile.z], "{name}");
        }
    }
}
