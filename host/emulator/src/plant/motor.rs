//! Stepper drivers and motors: pulses to positions, and the drivers' timing limits.

/// What a driver asks of its signals, in ticks of the board's chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DriverLimits {
    /// Shortest high time of STEP.
    pub pulse: u64,
    /// Shortest low time of STEP.
    pub low: u64,
    /// Shortest time from a change of DIR to the rising edge of STEP.
    pub setup: u64,
    /// Shortest time from the falling edge of STEP to a change of DIR.
    pub hold: u64,
}

impl DriverLimits {
    /// 1.9 us and 0.65 us: DRV8825, the slower of the usual modules. Its hold time counts from STEP's rise; 1 us from the fall is
    /// more, and what `pasapas selftest` asks of a board.
    #[must_use]
    pub fn usual(ticks_per_second: u64) -> DriverLimits {
        let ticks = |ns: u64| (ns * ticks_per_second).div_ceil(1_000_000_000);
        DriverLimits {
            pulse: ticks(1_900),
            low: ticks(1_900),
            setup: ticks(650),
            hold: ticks(1_000),
        }
    }
}

impl Default for DriverLimits {
    fn default() -> Self {
        DriverLimits::usual(crate::TICKS_PER_SECOND)
    }
}

/// Which limit was broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ViolationKind {
    /// STEP was high for too short a time.
    PulseHigh,
    /// STEP was low for too short a time.
    PulseLow,
    /// DIR changed too shortly before STEP rose.
    DirSetup,
    /// DIR changed while STEP was high, or too shortly after it fell.
    DirHold,
}

/// A broken limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Violation {
    /// When, in ticks.
    pub cycle: u64,
    /// Axis number, 0 for X.
    pub axis: usize,
    /// Which limit.
    pub kind: ViolationKind,
    /// Ticks that there were; of [`ViolationKind::DirHold`] 0 while STEP was high.
    pub ticks: u64,
}

/// One axis: driver, motor and what it moves.
#[derive(Debug, Clone, Default)]
pub struct Motor {
    /// Full position in steps from where it stood at power-up.
    pub position: i64,
    /// Rising edges of STEP, stalled ones included.
    pub pulses: u64,
    /// DIR low means positive.
    pub inverted: bool,
    /// Steps that will be lost.
    pub stalled: u64,
    step: bool,
    dir: bool,
    rose: Option<u64>,
    fell: Option<u64>,
    dir_changed: Option<u64>,
}

impl Motor {
    /// DIR is `level` from `now` on. A broken limit goes to `report`.
    pub fn dir(
        &mut self,
        level: bool,
        now: u64,
        limits: DriverLimits,
        mut report: impl FnMut(ViolationKind, u64),
    ) {
        if level == self.dir {
            return;
        }
        self.dir = level;
        self.dir_changed = Some(now);
        let stood = if self.step { Some(0) } else { self.fell.map(|fell| now - fell) };
        if let Some(ticks) = stood.filter(|ticks| *ticks < limits.hold) {
            report(ViolationKind::DirHold, ticks);
        }
    }

    /// Whether DIR says negative.
    #[must_use]
    pub fn is_negative(&self) -> bool {
        self.dir == self.inverted
    }

    /// Whether DIR has changed since the last step.
    pub(super) fn has_turned(&self) -> bool {
        self.dir_changed > self.rose
    }

    /// So many pulses, each as the driver wants it. The next edge is not held against them.
    pub(super) fn travel(&mut self, pulses: u64) {
        if pulses == 0 {
            return;
        }
        let lost = pulses.min(self.stalled);
        self.stalled -= lost;
        self.pulses += pulses;
        let way = (pulses - lost).cast_signed();
        self.position += if self.is_negative() { -way } else { way };
        (self.rose, self.fell, self.dir_changed) = (None, None, None);
    }

    /// The chip is reset and drives no pin any more: the pulse under way is not held to the driver's limits.
    pub(super) fn cut_short(&mut self) {
        (self.step, self.rose, self.fell, self.dir_changed) = (false, None, None, None);
    }

    /// STEP is `level` from `now` on. Returns whether the motor moved; broken limits go to `report`.
    pub fn step(
        &mut self,
        level: bool,
        now: u64,
        limits: DriverLimits,
        mut report: impl FnMut(ViolationKind, u64),
    ) -> bool {
        if level == self.step {
            return false;
        }
        self.step = level;
        let mut check = |since: Option<u64>, least: u64, kind| {
            if let Some(ticks) = since.map(|t| now - t).filter(|t| *t < least) {
                report(kind, ticks);
            }
        };
        if !level {
            check(self.rose, limits.pulse, ViolationKind::PulseHigh);
            self.fell = Some(now);
            return false;
        }
        check(self.fell, limits.low, ViolationKind::PulseLow);
        check(self.dir_changed, limits.setup, ViolationKind::DirSetup);
        self.rose = Some(now);
        self.pulses += 1;
        if self.stalled > 0 {
            self.stalled -= 1;
            return false;
        }
        self.position += if self.dir != self.inverted { 1 } else { -1 };
        true
    }
}
