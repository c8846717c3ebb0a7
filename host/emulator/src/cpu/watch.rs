//! Instructions in front of which runs stop for an observer.
//!
//! They are never kept decoded, so that only the slow way through the decoder tests for them and nothing
//! else pays.

/// See the module.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    addresses: Vec<u32>,
    /// The observer has been told of the instruction that comes next.
    told: bool,
    /// The instruction that the last burst stopped in front of.
    trapped: Option<u32>,
}

impl Watch {
    /// Stops in front of the instruction at `addr` from now on.
    pub fn add(&mut self, addr: u32) {
        if !self.addresses.contains(&addr) {
            self.addresses.push(addr);
        }
    }

    /// Whether somebody watches the instruction at `pc`.
    pub fn has(&self, pc: u32) -> bool {
        self.addresses.contains(&pc)
    }

    /// The instruction at `pc`, which is watched, comes next: whether to stop in front of it. The second
    /// time it is to be executed.
    pub fn stops(&mut self, pc: u32) -> bool {
        self.told = !self.told;
        if self.told {
            self.trapped = Some(pc);
        }
        self.told
    }

    /// Whether a burst has stopped and nobody was told yet.
    pub fn has_trapped(&self) -> bool {
        self.trapped.is_some()
    }

    /// Where the last burst stopped, once.
    pub fn take(&mut self) -> Option<u32> {
        self.trapped.take()
    }

    /// The chip was reset: another instruction comes next.
    pub fn reset(&mut self) {
        self.told = false;
        self.trapped = None;
    }
}
