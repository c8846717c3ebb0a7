//! What stays in force until it is said anew: F and S.

use firmware::motion::path::Feed;
use lang::effect::Rate;
use lang::fault::Fault;
use lang::profile::Profile;

use super::Machine;

/// F and S as they are in force, and the F that handlers have set aside.
#[derive(Debug)]
pub struct Modal {
    /// F.
    pub feed: Option<Rate>,
    /// S, a laser's power.
    pub power: i32,
    feeds_aside: Vec<Option<Rate>>,
}

impl Modal {
    /// No F, full power.
    pub fn new(profile: &Profile) -> Modal {
        Modal { feed: None, power: profile.full_power(), feeds_aside: Vec::new() }
    }

    /// A handler has no F of its own at first.
    pub fn enter_handler(&mut self) {
        self.feeds_aside.push(self.feed.take());
    }

    /// Behind a handler the F before it is in force again.
    pub fn leave_handler(&mut self) {
        if let Some(feed) = self.feeds_aside.pop() {
            self.feed = feed;
        }
    }

    /// Every handler was left by GOTO: F stays as it is.
    pub fn leave_all(&mut self) {
        self.feeds_aside.clear();
    }

    /// S as the path takes it.
    pub fn beam(&self) -> u16 {
        self.power.clamp(0, i16::MAX.into()) as u16
    }
}

impl Machine {
    /// Speed of G1 to G3: F, or what the profile has in its place.
    ///
    /// # Errors
    /// F08 without either.
    pub(super) fn programmed_feed(&self) -> Result<Feed, Fault> {
        match self.modal.feed {
            Some(Rate::Um(um)) => Ok(Feed::Um(um.unsigned_abs())),
            Some(Rate::Steps(steps)) => Ok(Feed::Steps(steps.unsigned_abs())),
            None => match self.profile.default_feed_um_s {
                Some(um) => Ok(Feed::Um(um.unsigned_abs())),
                None => Err(Fault::SpeedRange),
            },
        }
    }

    /// S.
    pub(super) fn set_power(&mut self, value: i32) -> Result<(), Fault> {
        let graded = self.profile.has_power();
        if graded && !(0..=self.profile.full_power()).contains(&value) {
            return Err(Fault::ValueRange);
        }
        self.modal.power = value;
        Ok(())
    }

    /// Power of the laser in what moves next, if the machine has one.
    pub(super) fn light(&self) -> Option<i32> {
        let laser = self.profile.laser()?;
        Some(if self.outputs.read(laser) == Ok(true) { self.modal.power } else { 0 })
    }
}
