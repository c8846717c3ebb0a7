//! The law of motion: where each axis is at a time. The machine tells it, the cell asks.

/// Axes of a machine: X, Y, Z, A.
pub const AXES: usize = 4;

/// Places of all axes in whole steps of the cell's frame.
pub type Steps = [i32; AXES];

/// What a machine tells of its motion.
///
/// Times are microseconds of the run. Places are *true* steps from power-up, stalls included. Until [`Law::until`] no
/// axis turns: it stands, or goes one way. So every question of geometry has an exact answer without sampling.
pub trait Law {
    /// Changes whenever the motion is another one than was told before.
    fn id(&self) -> u64;
    /// Where the axes are at a time within the law.
    fn at(&self, us: u64) -> Steps;
    /// When this law ends; `None` while all axes rest and nothing is planned.
    fn until(&self) -> Option<u64>;
    /// When an axis first stands at `place` in this law, not before `us`; `None` if it does not come there.
    fn reaches(&self, axis: usize, place: i32, us: u64) -> Option<u64>;
    /// Speed of an axis at a time, steps/s, with its sign.
    fn speed(&self, axis: usize, us: u64) -> f64;
}

/// All axes at rest.
#[derive(Clone, Copy, Debug)]
pub struct Rest(pub Steps);

impl Law for Rest {
    fn id(&self) -> u64 {
        0
    }
    fn at(&self, _: u64) -> Steps {
        self.0
    }
    fn until(&self) -> Option<u64> {
        None
    }
    fn reaches(&self, axis: usize, place: i32, us: u64) -> Option<u64> {
        (self.0[axis] == place).then_some(us)
    }
    fn speed(&self, _: usize, _: u64) -> f64 {
        0.0
    }
}

/// A straight way at constant speed: what a test or a replayed trace knows.
#[derive(Clone, Copy, Debug)]
pub struct Straight {
    /// See [`Law::id`].
    pub id: u64,
    /// Where it begins.
    pub from: Steps,
    /// Where it ends.
    pub to: Steps,
    /// When it begins, us.
    pub begins: u64,
    /// How long it takes, us; above 0.
    pub takes: u64,
}

impl Law for Straight {
    fn id(&self) -> u64 {
        self.id
    }
    fn at(&self, us: u64) -> Steps {
        let gone = us.saturating_sub(self.begins).min(self.takes);
        std::array::from_fn(|axis| {
            let way = i64::from(self.to[axis]) - i64::from(self.from[axis]);
            // A step is made when its whole way is done: toward zero.
            let made = i128::from(way) * i128::from(gone) / i128::from(self.takes);
            (i128::from(self.from[axis]) + made) as i32
        })
    }
    fn until(&self) -> Option<u64> {
        Some(self.begins + self.takes)
    }
    fn reaches(&self, axis: usize, place: i32, us: u64) -> Option<u64> {
        let way = i64::from(self.to[axis]) - i64::from(self.from[axis]);
        let wanted = i64::from(place) - i64::from(self.from[axis]);
        if wanted == 0 {
            let leaves = if way == 0 {
                u64::MAX
            } else {
                self.begins + self.takes.div_ceil(way.unsigned_abs())
            };
            return (us < leaves).then_some(us.max(self.begins));
        }
        if wanted.signum() != way.signum() || wanted.abs() > way.abs() {
            return None;
        }
        let when = self.begins + (wanted.unsigned_abs() * self.takes).div_ceil(way.unsigned_abs());
        // It stands there until the next step.
        let next =
            self.begins + ((wanted.unsigned_abs() + 1) * self.takes).div_ceil(way.unsigned_abs());
        if us <= when {
            Some(when)
        } else if us < next || wanted == way {
            Some(us)
        } else {
            None
        }
    }
    fn speed(&self, axis: usize, us: u64) -> f64 {
        if us < self.begins || us >= self.begins + self.takes {
            return 0.0;
        }
        (f64::from(self.to[axis]) - f64::from(self.from[axis])) * 1e6 / self.takes as f64
    }
}
