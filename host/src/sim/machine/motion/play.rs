//! A segment as it is played, and what the step engine holds of an axis on its own.

use firmware::motion::ramp::Segment;
use firmware::motion::scaled::Scaled;
use firmware::motion::single::Single;

/// From the beginning of a segment to the fetch of the next one, and between two fetches for a path
/// whose next block is not known: a pass of the board's main loop with a statement in it.
pub(super) const FETCH_US: u64 = 200;

/// A segment and when it began.
#[derive(Clone, Copy, Debug)]
pub(super) struct Play {
    /// Fine units, as [`Segment::duration`] has them.
    pub(super) begin: u64,
    pub(super) segment: Segment,
    pub(super) clock: Clock,
}

/// The step timer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock {
    /// Ticks in a second.
    pub(super) hz: u32,
}

impl Clock {
    /// Units of [`Segment::duration`] in a microsecond: 1/65536 of a tick.
    pub(super) fn fine_per_us(self) -> u64 {
        u64::from(self.hz) / 1_000_000 * 65_536
    }

    /// Fine units as us, rounded up.
    pub(super) fn us(self, fine: u64) -> u64 {
        fine.div_ceil(self.fine_per_us())
    }

    /// For the planner.
    pub(super) fn rate(self) -> Scaled {
        Scaled::constant(self.hz)
    }
}

/// Whether the segment after this one is fetched by `us`.
pub(super) fn is_fetched(play: &Play, us: u64) -> bool {
    let fine = play.clock.fine_per_us();
    us * fine >= play.begin + FETCH_US * fine
}

impl Play {
    /// Time of the `n`th sub-event after the beginning, fine units.
    pub(super) fn offset(&self, n: u32) -> u64 {
        let n = i64::from(n);
        let s = &self.segment;
        (n * i64::from(s.interval) + n * (n - 1) / 2 * i64::from(s.dif)).unsigned_abs()
    }

    /// Sub-events of a step.
    pub(super) fn per_step(&self) -> u32 {
        u32::from(self.segment.mask) + 1
    }

    /// When it ends, us, rounded up.
    pub(super) fn end_us(&self) -> u64 {
        self.clock.us(self.begin + self.segment.duration())
    }

    /// When its `step`th step comes, us, rounded up.
    pub(super) fn step_us(&self, step: u16) -> u64 {
        self.clock.us(self.begin + self.offset(u32::from(step) * self.per_step()))
    }

    /// Steps made until `us`.
    pub(super) fn steps_at(&self, us: u64) -> u16 {
        let gone = (us * self.clock.fine_per_us()).saturating_sub(self.begin);
        let (mut low, mut high) = (0_u32, u32::from(self.segment.events));
        while low < high {
            let middle = (low + high).div_ceil(2);
            if self.offset(middle) <= gone {
                low = middle;
            } else {
                high = middle - 1;
            }
        }
        (low / self.per_step()) as u16
    }

    /// Speed at its end, events/s.
    pub(super) fn rate(&self) -> f64 {
        let s = &self.segment;
        let events = i64::from(s.events);
        let last = i64::from(s.interval) + (events - 1).max(0) * i64::from(s.dif);
        let ticks = last.max(1) as f64 * f64::from(self.per_step()) / 65_536.0;
        f64::from(self.clock.hz) / ticks
    }
}

/// An axis on its own.
#[derive(Debug)]
pub(super) struct Solo {
    pub(super) single: Single,
    pub(super) play: Option<Play>,
    /// Direction of the segment that plays.
    pub(super) negative: bool,
    /// The segment that the engine plays next, and its direction.
    pub(super) next: Option<(Segment, bool)>,
}

impl Solo {
    /// The planner's next segment for the engine.
    pub(super) fn fetch(&mut self) {
        let mut segment = Segment::default();
        if self.next.is_none() && self.single.next_segment(&mut segment) {
            self.next = Some((segment, self.single.negative()));
        }
    }

    /// Nothing is left of what the engine holds.
    pub(super) fn is_empty(&self) -> bool {
        self.play.is_none() && self.next.is_none()
    }

    /// Steps with the sign of the direction.
    pub(super) fn signed(&self, steps: u16) -> i32 {
        if self.negative { -i32::from(steps) } else { i32::from(steps) }
    }
}
