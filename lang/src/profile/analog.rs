//! Analog inputs, and the inputs that thresholds make of them.

use serde::{Deserialize, Serialize};

use super::{Profile, ProfileError, Wiring};

/// Analog inputs of a part that has some.
pub const ANALOGS: i32 = 4;
/// Number of the first input that a threshold may make: the next after those of the wirings.
pub const FIRST_THRESHOLD: i32 = Wiring::Chain.inputs() + 1;
/// Number of the last one.
pub const LAST_THRESHOLD: i32 = FIRST_THRESHOLD + 3;
/// Highest voltage that is told apart, mV: the converter measures against the supply.
pub const HIGHEST_MV: i32 = 3300;
/// What [`Analog::filter_ms`] may be.
pub const FILTERS_MS: [u8; 6] = [1, 2, 4, 8, 16, 32];

/// An analog input.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Analog {
    /// Number, from 1.
    pub n: i32,
    /// Name for scripts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Conversions that count in a value at least: 4, 8, 16, 32, 64 or 128. Four are made in each millisecond, so that more of
    /// them are a filter of a quarter as many ms.
    #[serde(default = "four")]
    pub oversampling: u8,
    /// Time constant of the filter, ms: 1 (none), 2, 4, 8, 16 or 32.
    #[serde(default = "unfiltered")]
    pub filter_ms: u8,
}

/// An input that an analog input makes by two levels.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Threshold {
    /// Number of the input, 18 to 21.
    pub input: i32,
    /// Number of the analog input.
    pub analog: i32,
    /// The input goes on at this voltage, mV.
    pub on_mv: i32,
    /// It goes off at this one, mV: below `on_mv` an input of high voltages, above it one of low voltages.
    pub off_mv: i32,
}

fn unfiltered() -> u8 {
    1
}

fn four() -> u8 {
    4
}

impl Analog {
    /// Time constant of what the board does, ms: the longer one of filter and oversampling.
    pub fn slowest_ms(&self) -> u8 {
        self.filter_ms.max(self.oversampling / 4)
    }
}

impl Profile {
    /// Whether the machine has the input: one of the wiring, or one that a threshold makes.
    pub fn has_input(&self, n: i32) -> bool {
        (1..=self.wiring.inputs()).contains(&n) || self.thresholds.iter().any(|t| t.input == n)
    }

    /// What the machine's inputs are, in words: `1 to 17`, or `1 to 17 and 18`.
    pub fn input_numbers(&self) -> String {
        let wired = format!("1 to {}", self.wiring.inputs());
        let mut numbers: Vec<i32> = self.thresholds.iter().map(|t| t.input).collect();
        numbers.sort_unstable();
        numbers.iter().fold(wired, |text, n| format!("{text}, {n}"))
    }

    /// Numbers, levels and filters, each number once.
    pub(super) fn check_analog(&self) -> Result<(), ProfileError> {
        let refuse = |text: String| Err(ProfileError(text));
        for (at, analog) in self.analogs.iter().enumerate() {
            let n = analog.n;
            if !(1..=ANALOGS).contains(&n) {
                return refuse(format!("analog.n is {n}; it must lie in 1..{ANALOGS}"));
            }
            if self.analogs[..at].iter().any(|other| other.n == n) {
                return refuse(format!(
                    "two [[analog]] have n = {n}; write one section with all of its keys"
                ));
            }
            if !FILTERS_MS.map(|ms| 4 * ms).contains(&analog.oversampling) {
                return refuse(format!(
                    "analog {n}: oversampling is {}; it must be 4, 8, 16, 32, 64 or 128",
                    analog.oversampling
                ));
            }
            if !FILTERS_MS.contains(&analog.filter_ms) {
                return refuse(format!(
                    "analog {n}: filter_ms is {}; it must be 1 (no filter), 2, 4, 8, 16 or 32",
                    analog.filter_ms
                ));
            }
        }
        for (at, threshold) in self.thresholds.iter().enumerate() {
            let Threshold { input, analog, on_mv, off_mv } = *threshold;
            if !(FIRST_THRESHOLD..=LAST_THRESHOLD).contains(&input) {
                return refuse(format!(
                    "threshold.input is {input}; a threshold makes one of the inputs {FIRST_THRESHOLD} to {LAST_THRESHOLD}"
                ));
            }
            if self.thresholds[..at].iter().any(|other| other.input == input) {
                return refuse(format!(
                    "two [[threshold]] make input {input}; take another number for one of them"
                ));
            }
            if !self.analogs.iter().any(|other| other.n == analog) {
                return refuse(format!(
                    "threshold of input {input}: there is no analog input {analog}; write [[analog]] with n = {analog}"
                ));
            }
            for (key, mv) in [("on_mv", on_mv), ("off_mv", off_mv)] {
                if !(0..=HIGHEST_MV).contains(&mv) {
                    return refuse(format!(
                        "threshold of input {input}: {key} is {mv}; it must lie in 0..{HIGHEST_MV}"
                    ));
                }
            }
            if on_mv == off_mv {
                return refuse(format!(
                    "threshold of input {input}: on_mv and off_mv are both {on_mv}; set them apart by more than the noise, or \
                     the input goes on and off at random"
                ));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::profile::{BUILT_IN, Profile};
    use crate::record::{BoardRecord, MoreRecord};

    const PUMP: &str = "\n[[analog]]\nn = 2\nname = \"vacuum\"\nfilter_ms = 8\n\n[[analog]]\nn = 4\n\n[[threshold]]\n\
                        input = 18\nanalog = 2\non_mv = 1200\noff_mv = 1400\n";

    fn with(text: &str) -> Result<Profile, String> {
        Profile::parse(&(BUILT_IN[0].1.to_owned() + text)).map_err(|error| error.0)
    }

    #[test]
    fn analog_inputs_and_thresholds_come_back_from_the_record() {
        let profile = with(PUMP).expect("a machine with a vacuum sensor");
        let record = BoardRecord::of(&profile, 3);
        let head = BoardRecord::from_bytes(&record.to_bytes());
        let more = MoreRecord::from_bytes(&record.more.to_bytes());
        let again = BoardRecord { more, ..head }.into_profile(&profile);
        assert_eq!(
            (again.analogs, again.thresholds),
            (profile.analogs.clone(), profile.thresholds.clone())
        );
        assert!(profile.has_input(18) && !profile.has_input(19) && !profile.has_input(0));
        // More conversions are a longer filter to the board.
        let more = with(&PUMP.replace("filter_ms = 8", "oversampling = 32")).expect("oversampled");
        assert_eq!(BoardRecord::of(&more, 3), record);
        let plain = with("").expect("the mill");
        assert_eq!(BoardRecord::of(&plain, 3).more_crc, 0, "nothing of it, no second record");
    }

    #[test]
    fn what_no_board_can_do_is_refused_with_the_remedy() {
        let change = |from: &str, to: &str| with(&PUMP.replace(from, to)).expect_err(to);
        assert!(change("n = 4", "n = 5").contains("1..4"));
        assert!(change("n = 4", "n = 2").contains("two [[analog]]"));
        assert!(change("filter_ms = 8", "filter_ms = 3").contains("2, 4, 8"));
        assert!(change("filter_ms = 8", "oversampling = 5").contains("4, 8, 16"));
        assert!(change("input = 18", "input = 17").contains("18 to 21"));
        assert!(change("analog = 2", "analog = 1").contains("[[analog]] with n = 1"));
        assert!(change("on_mv = 1200", "on_mv = 3301").contains("0..3300"));
        assert!(change("on_mv = 1200", "on_mv = 1400").contains("set them apart"));
        let twice =
            PUMP.to_owned() + "\n[[threshold]]\ninput = 18\nanalog = 4\non_mv = 5\noff_mv = 1\n";
        assert!(with(&twice).expect_err("twice").contains("two [[threshold]]"));
    }
}
