//! The analog output: a second PWM, behind which a filter or a converter makes a voltage.

use serde::{Deserialize, Serialize};

use super::analog::HIGHEST_MV;
use super::{Profile, ProfileError};

/// Analog outputs of a part that has some.
const AOUTS: i32 = 1;
/// The greatest value of one, mV or steps of a share.
pub const AOUT_MOST: u16 = 30_000;

/// An analog output.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Aout {
    /// Number, from 1.
    pub n: i32,
    /// Name for scripts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Periods in a second, 50..=20000; those of the PWM where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<u16>,
    /// Voltage with the pin high all the time, mV: that behind the converter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub full_mv: Option<i32>,
    /// Scripts write a share instead of a voltage: a Number from 0 to this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<i32>,
    /// Value after a reset, at a fault and at the end of a run, mV or steps of the share.
    #[serde(default)]
    pub safe: i32,
    /// What it does in a pause.
    #[serde(default)]
    pub pause: AoutPause,
}

/// An analog output in a pause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AoutPause {
    /// It stays as it is.
    #[default]
    Keep,
    /// It has its safe value.
    Safe,
}

impl Aout {
    /// Value with the pin high all the time, mV or steps of the share.
    pub fn full(&self) -> i32 {
        self.range.or(self.full_mv).unwrap_or(HIGHEST_MV)
    }

    /// Whether scripts write a share.
    pub fn is_share(&self) -> bool {
        self.range.is_some()
    }
}

impl Profile {
    /// Periods in a second of the analog output.
    pub fn aout_hz(&self) -> u16 {
        let own = self.aouts.first().and_then(|aout| aout.frequency_hz);
        self.pwm.as_ref().map(super::Pwm::hz).or(own).unwrap_or(1000)
    }

    /// Whether all of `[[aout]]` may stand in a profile; `range` refuses a value by name.
    pub(super) fn check_aout(
        &self,
        range: fn(&str, i64, i64, i64) -> Result<(), ProfileError>,
    ) -> Result<(), ProfileError> {
        for (at, aout) in self.aouts.iter().enumerate() {
            range("aout.n", aout.n.into(), 1, AOUTS.into())?;
            if at > 0 {
                return Err(ProfileError(
                    "two [[aout]] have n = 1; write one section with all of its keys".to_owned(),
                ));
            }
            if let (Some(own), Some(pwm)) = (aout.frequency_hz, &self.pwm)
                && own != pwm.hz()
            {
                return Err(ProfileError(format!(
                    "aout.frequency_hz is {own} and that of [pwm] {}; one timer makes both, so leave it out of [[aout]]",
                    pwm.hz()
                )));
            }
            range("aout.frequency_hz", self.aout_hz().into(), 50, 20_000)?;
            if aout.full_mv.is_some() && aout.range.is_some() {
                return Err(ProfileError(
                    "aout has full_mv and range; write full_mv for voltages, or range for a share"
                        .to_owned(),
                ));
            }
            let key = if aout.is_share() { "aout.range" } else { "aout.full_mv" };
            range(key, aout.full().into(), 1, AOUT_MOST.into())?;
            range("aout.safe", aout.safe.into(), 0, aout.full().into())?;
        }
        Ok(())
    }
}
