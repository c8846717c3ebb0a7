//! The power of the desktop's chip, which may fail in the middle of an operation of its flash.

use std::cell::Cell;

use emulator::Rng;

use super::Desk;

/// What the power has done and is to do.
#[derive(Default)]
pub struct Power {
    /// There is none.
    off: Cell<bool>,
    /// Operations of the flash so far: words written, segments erased.
    operations: Cell<u64>,
    /// Operations until it fails, the one included in which it does, and what the bits then come out as; 0: it does not.
    left: Cell<u64>,
    /// See `left`.
    seed: Cell<u64>,
}

/// How far an operation of the flash came.
pub enum Done {
    /// To its end.
    Whole,
    /// Some bits were changed, others not.
    Torn(Rng),
    /// There was no power.
    Nothing,
}

impl Done {
    /// Bits of the next word that were changed.
    pub fn bits(&mut self) -> u16 {
        match self {
            Done::Whole => 0xFFFF,
            Done::Torn(noise) => noise.bits() as u16,
            Done::Nothing => 0,
        }
    }
}

impl Desk {
    /// Begins an operation of the flash.
    pub(super) fn operate(&self) -> Done {
        let power = &self.0.power;
        if power.off.get() {
            return Done::Nothing;
        }
        power.operations.set(power.operations.get() + 1);
        let left = power.left.get();
        power.left.set(left.saturating_sub(1));
        if left != 1 {
            return Done::Whole;
        }
        self.switch(false);
        Done::Torn(Rng::new(power.seed.get()))
    }

    /// Operations of the flash so far.
    pub(super) fn operations(&self) -> u64 {
        self.0.power.operations.get()
    }

    /// Power fails in the operation `n` of the flash from now on, from 1; `seed` makes the bits that it leaves.
    pub(super) fn fail_at(&self, n: u64, seed: u64) {
        self.0.power.left.set(n);
        self.0.power.seed.set(seed);
    }

    /// Power comes or goes: without it no step is made and no output is on.
    pub(super) fn switch(&self, on: bool) {
        self.0.power.off.set(!on);
        self.0.power.left.set(0);
        if !on {
            self.rest_pins();
        }
    }

    pub(super) fn has_power(&self) -> bool {
        !self.0.power.off.get()
    }
}
