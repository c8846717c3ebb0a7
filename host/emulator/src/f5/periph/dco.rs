//! The digitally controlled oscillator of the UCS: rate by range, tap and modulator.

/// Values of tap and modulator together: 32 taps of 32 steps.
pub const STEPS: u16 = 1024;

/// Rates in kHz at tap 0 and at tap 31 for each DCORSEL: middles of the ranges of the data sheet
/// (SLAS590, "DCO Frequency"); of ranges 0 to 2 and 7 from memory of it.
const RANGES: [(f64, f64); 8] = [
    (110.0, 1_200.0),
    (230.0, 2_400.0),
    (500.0, 5_200.0),
    (1_075.0, 10_000.0),
    (2_250.0, 20_250.0),
    (4_250.0, 38_900.0),
    (7_650.0, 63_500.0),
    (14_000.0, 97_500.0),
];

/// Rate in hertz at a tap and modulator value, 0 to 1023.
pub fn hertz(range: u16, value: u16) -> f64 {
    let (low, high) = RANGES[usize::from(range & 7)];
    // Taps are steps of equal ratio; the modulator mixes two of them.
    let (tap, part) = (f64::from(value / 32), f64::from(value % 32) / 32.0);
    let at = |tap: f64| low * 1000.0 * (high / low).powf(tap / 31.0);
    at(tap) + (at(tap + 1.0) - at(tap)) * part
}

/// The value whose rate is the nearest at or below `hz`.
pub fn value_for(range: u16, hz: f64) -> u16 {
    let (mut low, mut high) = (0, STEPS - 1);
    while low < high {
        let middle = (low + high).div_ceil(2);
        if hertz(range, middle) <= hz { low = middle } else { high = middle - 1 }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_range_rises_with_tap_and_modulator() {
        for range in 0..8 {
            for value in 1..STEPS {
                assert!(hertz(range, value) > hertz(range, value - 1), "{range} {value}");
                assert_eq!(value_for(range, hertz(range, value) * 1.000_01), value);
            }
        }
    }

    #[test]
    fn a_step_of_the_modulator_is_a_few_tenths_of_a_percent() {
        for range in 3..7 {
            let step = hertz(range, 700) / hertz(range, 699) - 1.0;
            assert!((0.000_6..0.004).contains(&step), "{step}");
        }
    }
}
