//! The analog output of a board, with the unit that its profile gives it.

use std::fmt;

use lang::profile::AOUT_MOST;
use lang::record::MoreRecord;
use lang::wire::{self, Exception};
use serde::Serialize;

use super::{Client, ClientError};
use crate::link::Link;

/// Place of [`MoreRecord::aout_full`] among the words of its record.
const FULL: u16 = (std::mem::offset_of!(MoreRecord, aout_full) / 2) as u16;

/// The unit of an analog output's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AoutUnit {
    /// mV.
    Voltage,
    /// Steps of the range of its profile.
    Share,
}

/// An analog output and its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct AoutValue {
    /// Its number, from 1.
    pub n: u16,
    /// Its value in mV, where the profile counts in these.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mv: Option<u16>,
    /// Its value in steps of a share, where the profile counts in these.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<u16>,
}

impl AoutValue {
    /// Output 1.
    fn new(unit: AoutUnit, value: u16) -> AoutValue {
        let (mv, share) = match unit {
            AoutUnit::Voltage => (Some(value), None),
            AoutUnit::Share => (None, Some(value)),
        };
        AoutValue { n: 1, mv, share }
    }
}

impl fmt::Display for AoutValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.mv, self.share) {
            (Some(mv), _) => write!(f, "{} at {mv} mV", self.n),
            (None, share) => write!(f, "{} at {}", self.n, share.unwrap_or(0)),
        }
    }
}

impl<L: Link> Client<L> {
    /// The unit of the analog output; `None` where the board has none, its profile says nothing of one, or a lock hides it.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn aout_unit(&mut self) -> Result<Option<AoutUnit>, ClientError> {
        let full = match self.holding(wire::PROFILE_MORE + FULL, 1) {
            Ok(words) => words[0],
            Err(error) if error.is_exception(Exception::IllegalAddress) => 0,
            Err(error) => return Err(error),
        };
        let unit = if full & MoreRecord::SHARE == 0 { AoutUnit::Voltage } else { AoutUnit::Share };
        // A board whose profile was never written has 0xFFFF there.
        Ok(Some(unit).filter(|_| (1..=AOUT_MOST).contains(&(full & MoreRecord::VALUE))))
    }

    /// The analog outputs that [`Client::aout_unit`] has found.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn aouts(&mut self, unit: Option<AoutUnit>) -> Result<Vec<AoutValue>, ClientError> {
        let Some(unit) = unit else { return Ok(Vec::new()) };
        Ok(vec![AoutValue::new(unit, self.holding(wire::ANALOG_OUTPUT, 1)?[0])])
    }
}
