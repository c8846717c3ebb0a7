//! Input filter, forcing and edges: sixteen inputs at once, in vertical counters.

/// The filter of sixteen inputs.
///
/// A change is accepted after it was seen in four samples in a row. Samples are a quarter of the
/// filter time apart, so a disturbance shorter than that time is ignored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inputs {
    /// Accepted levels.
    state: u16,
    /// Low and high bit of each input's counter.
    low: u16,
    high: u16,
    /// Inputs whose level is forced, and to what.
    forced: u16,
    level: u16,
}

impl Inputs {
    /// All off, nothing forced.
    pub const fn new() -> Inputs {
        Inputs { state: 0, low: 0, high: 0, forced: 0, level: 0 }
    }

    /// Takes `raw` for accepted at once: the state at power-up.
    pub fn settle(&mut self, raw: u16) {
        self.state = raw;
    }

    /// One sample; bits that differ from the state count, others start again.
    pub fn sample(&mut self, raw: u16) {
        let differs = raw ^ self.state;
        let carry = differs & self.low;
        let done = carry & self.high;
        self.low = differs & !self.low;
        self.high = differs & (self.high ^ carry);
        self.state ^= done;
    }

    /// Whether no change is on its way.
    pub fn is_settled(&self) -> bool {
        self.low | self.high == 0
    }

    /// Levels, forced ones included.
    pub fn levels(&self) -> u16 {
        self.forced(self.state)
    }

    /// These levels, which no filter has seen, with forced inputs as they are forced.
    pub fn forced(&self, raw: u16) -> u16 {
        raw & !self.forced | self.level
    }

    /// Inputs whose level is forced.
    pub fn is_forced(&self) -> u16 {
        self.forced
    }

    /// Levels without forcing.
    pub fn accepted(&self) -> u16 {
        self.state
    }

    /// Forces the inputs of `mask` on or off, or frees them.
    pub fn force(&mut self, mask: u16, level: Option<bool>) {
        self.forced &= !mask;
        self.level &= !mask;
        if let Some(on) = level {
            self.forced |= mask;
            if on {
                self.level |= mask;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Inputs;

    #[test]
    fn a_change_counts_after_four_samples() {
        let mut inputs = Inputs::new();
        for _ in 0..3 {
            inputs.sample(0b101);
            assert_eq!(inputs.levels(), 0);
        }
        inputs.sample(0b100);
        assert_eq!(inputs.levels(), 0b100, "input 1 bounced, input 3 did not");
        for _ in 0..3 {
            inputs.sample(0b101);
        }
        assert_eq!(inputs.levels(), 0b100);
        inputs.sample(0b101);
        assert_eq!(inputs.levels(), 0b101);
    }

    #[test]
    fn a_forced_input_shows_what_it_is_forced_to() {
        let mut inputs = Inputs::new();
        inputs.settle(0b11);
        inputs.force(0b01, Some(false));
        inputs.force(0b100, Some(true));
        assert_eq!(inputs.levels(), 0b110);
        assert_eq!((inputs.forced(0b1001), inputs.is_forced()), (0b1100, 0b101));
        inputs.force(0b101, None);
        assert_eq!(inputs.levels(), 0b11);
    }
}
