//! Analog inputs: filter, voltage, and digital inputs made of them by two thresholds.
//!
//! A sample is the sum of four conversions of 12 bits in one millisecond, 0 to [`FULL`], against the supply of
//! [`RANGE_MV`]. The filter is of the first order: each millisecond the value moves by the difference divided by a power of
//! two, so it follows a step to 63 % within that many milliseconds. It moves by 1 at least, so it arrives exactly.

use lang::record::ThresholdRecord;

/// Analog inputs.
pub const ANALOGS: usize = 4;
/// The input that the first threshold makes.
pub const FIRST_THRESHOLD: u8 = 18;
/// The one that the last makes.
pub const LAST_THRESHOLD: u8 = FIRST_THRESHOLD + ANALOGS as u8 - 1;
/// The greatest sample.
pub const FULL: u16 = 4 * 4095;
/// Voltage of the greatest sample, mV.
pub const RANGE_MV: u16 = 3300;
// RANGE_MV / FULL in lowest terms: what follows is exact, and its products fit into 32 bits.
const UP: u32 = 55;
const DOWN: u32 = 273;
const _: () = assert!(RANGE_MV as u32 * DOWN == FULL as u32 * UP);

/// The sample that a steady voltage gives, mV; those beyond the supply give the greatest.
pub fn sample(mv: i32) -> u16 {
    let mv = mv.clamp(0, i32::from(RANGE_MV)).unsigned_abs();
    4 * ((mv * 4095 + u32::from(RANGE_MV) / 2) / u32::from(RANGE_MV)) as u16
}

/// The filtered value after another millisecond with a sample; `filter` is the power of two.
pub fn filtered(value: u16, sample: u16, filter: u16) -> u16 {
    if value < sample {
        value + ((sample - value) >> filter).max(1)
    } else {
        value - ((value - sample) >> filter).max(u16::from(value != sample))
    }
}

/// A value in 1/273 mV, half a millivolt up.
const fn fine(value: u16) -> u32 {
    value as u32 * UP + DOWN / 2
}

/// A value as mV, rounded to the nearest. `mul_div` is the chip's `a * b / c`.
pub fn millivolts(value: u16, mul_div: impl FnOnce(u32, u32, u32) -> u32) -> u16 {
    mul_div(fine(value), 1, DOWN) as u16
}

/// What the input of a threshold becomes at a value; between the two levels it stays what it `was`.
pub fn crosses(levels: ThresholdRecord, value: u16, was: bool) -> bool {
    let mv = fine(value);
    let at = |level: u16| u32::from(level & ThresholdRecord::LEVEL) * DOWN;
    let (on, off) = (at(levels.on), at(levels.off));
    // A value of so many mV lies within [mv, mv + 1) here.
    if on > off { mv >= on || was && mv >= off + DOWN } else { mv < on + DOWN || was && mv < off }
}

/// Analog inputs, from 0.
#[derive(Default)]
pub struct Analog {
    /// Their filtered values.
    pub values: [u16; ANALOGS],
    /// Inputs that thresholds make and that are on, 18 in bit 0.
    pub on: u8,
    /// They have been sampled: the first value is taken as it is.
    pub begun: bool,
}

#[cfg(any(test, feature = "physics"))]
impl Analog {
    /// Whether nothing changes as long as the samples stay these.
    pub fn is_settled(&self, sample: impl Fn(u8) -> u16, used: u8) -> bool {
        (0..).zip(self.values).all(|(n, value)| used >> n & 1 == 0 || sample(n) == value)
    }
}

#[cfg(test)]
mod tests {
    use super::{FULL, crosses, filtered, millivolts, sample};
    use lang::record::ThresholdRecord;
    use proptest::prelude::*;

    fn mv(value: u16) -> u16 {
        millivolts(value, |a, b, c| (u64::from(a) * u64::from(b) / u64::from(c)) as u32)
    }

    #[test]
    fn a_steady_voltage_is_read_as_it_is() {
        for volts in 0..=3300 {
            assert_eq!(mv(sample(volts)), volts as u16);
        }
        assert_eq!((sample(-5), sample(5000)), (0, FULL));
    }

    #[test]
    fn a_filter_arrives_and_takes_its_time() {
        for filter in 0..=5 {
            let (mut value, mut ms) = (0, 0);
            while value < (u32::from(FULL) * 63 / 100) as u16 {
                value = filtered(value, FULL, filter);
                ms += 1;
            }
            assert!((1..=1 << filter).contains(&ms), "{filter}: 63 % after {ms} ms");
            for _ in 0..1000 {
                value = filtered(value, FULL, filter);
            }
            assert_eq!(value, FULL);
            for _ in 0..1000 {
                value = filtered(value, 8, filter);
            }
            assert_eq!(value, 8);
        }
    }

    proptest! {
        /// The levels are those of AIN, to the millivolt: a script that asks for the voltage sees what the input does.
        #[test]
        fn an_input_goes_on_and_off_at_its_levels(on in 0_u16..=3300, off in 0_u16..=3300, value in 0..=FULL, was: bool) {
            prop_assume!(on != off);
            let now = mv(value);
            let expected = match (on > off, now) {
                (true, now) if now >= on => true,
                (true, now) if now <= off => false,
                (false, now) if now <= on => true,
                (false, now) if now >= off => false,
                _ => was,
            };
            prop_assert_eq!(crosses(ThresholdRecord { on, off }, value, was), expected);
        }
    }
}
