//! Modal values: F and S.

use lang::effect::Rate;
use lang::profile::Profile;

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
