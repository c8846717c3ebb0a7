//! Whether the next line is planned in time.
//!
//! The chip goes on in the program when all segments of a line are made. At that moment the step engine's two slots hold the
//! line's last two segments, and the first of them plays. Until it has been played the chip executes the statements before the
//! next line, plans that line and makes its first segment; the slot for it is free when the last segment begins. For a line
//! of one segment that segment is the whole window.
//!
//! A segment of a line that ends at speed takes 2^n events, as many as last 4.1 to 8.2 ms at the speed that it begins with
//! ([`firmware::motion::ramp`]), and the last one more than a quarter of that. The speed at the end of a line also depends on
//! overrides and pauses, so all speeds from which it can reach an end are considered, with the fewest events and the least
//! time that the ramps allow.

/// The least time of 2^n events at the speed at which they begin, s: 2^16 ticks of 16 MHz.
const SEGMENT_S: f64 = 65_536.0 / 16e6;
/// Events of a segment at most, a power of two.
const MOST_EVENTS: f64 = 16_384.0;
/// The part of the processor that a busy link and the millisecond take. It is in all times of [`Work`].
pub const LINK: f64 = 0.08;

/// What the chip has to do before a line has been played, s of the processor between step interrupts.
#[derive(Clone, Copy, Debug)]
pub struct Work {
    /// From making the last segment to planning the next line, all that is executed on the way among it.
    pub planned: f64,
    /// The last segment of two.
    pub segment: f64,
    /// The first segment of the next line.
    pub shaped: f64,
    /// An interrupt of the step engine.
    pub event: f64,
}

impl Work {
    /// Whether so much work fits into a time with so many step interrupts.
    fn fits(&self, work: f64, time: f64, events: f64) -> bool {
        time * (1.0 - LINK) - events * self.event >= work * (1.0 - LINK)
    }
}

/// A line as its end is reached. Lengths in um, speeds in um/s.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// Steps of the axis with most steps.
    pub events: f64,
    /// The way of each.
    pub pitch: f64,
    /// Speed from rest.
    pub start: f64,
    /// What it may have under an override of 200 %.
    pub top: f64,
    /// Ramps, um/s2.
    pub accel: f64,
    pub decel: f64,
}

impl Way {
    /// The highest speed up to `most` at which the line may begin and end so that the work is done in time; nothing where it
    /// is at none.
    pub fn passed(&self, most: f64, work: &Work) -> Option<f64> {
        if self.is_in_time(most, work) {
            return Some(most);
        }
        let mut found = None;
        let (mut low, mut high) = (self.start.min(most), most);
        for _ in 0..12 {
            let middle = (low + high) / 2.0;
            if self.is_in_time(middle, work) {
                (low, found) = (middle, Some(middle));
            } else {
                high = middle;
            }
        }
        found
    }

    /// Whether the work is done in time when the line begins and ends no faster than at `end`.
    ///
    /// For each count 2^n of events that a segment may have: the highest speed at which it has so many (each count lasts
    /// `SEGMENT_S` at the least), the fewest events that the last two segments have then, and the least time in which the
    /// ramps let the axes make them. The work must fit into that time, and the next line's first segment into the last one.
    fn is_in_time(&self, end: f64, work: &Work) -> bool {
        let cap = self.top.max(end);
        let mut count = 1.0;
        while count <= MOST_EVENTS {
            // The fastest that takes so many.
            let fastest = count * self.pitch / SEGMENT_S;
            let rest = (count / 4.0).floor();
            let single = self.events <= count + rest;
            let events = if single { self.events } else { count + rest + 1.0 };
            let braked = (end * end + 2.0 * self.decel * events * self.pitch).sqrt();
            let top = if single { end } else { braked.min(cap) };
            let from = fastest.min(top);
            if from >= self.start {
                let time = self.least_s(from, end, cap, events * self.pitch);
                let all = work.planned + work.shaped;
                let all = if single { all } else { all + work.segment };
                if !work.fits(all, time, events) {
                    return false;
                }
                let last = rest + 1.0;
                let way = last * self.pitch;
                // No faster than it can have become since the first of both.
                let gained = (from * from + 2.0 * self.accel * events * self.pitch).sqrt();
                let fast = (end * end + 2.0 * self.decel * way).sqrt().min(cap).min(gained);
                if !single && !work.fits(work.shaped, way / fast, last) {
                    return false;
                }
            }
            if fastest >= top {
                break;
            }
            count *= 2.0;
        }
        true
    }

    /// The least time of a way from one speed to another that is no higher than `end`, s.
    ///
    /// Full ramp up, then `cap` or the speed at which both ramps meet, then full ramp down:
    /// `v^2 = (from^2 d + end^2 a + 2 a d way) / (a + d)`. If the way is too short to reach either end speed, one ramp takes
    /// all of it: `way = v t + a t^2 / 2`, solved for t.
    fn least_s(&self, from: f64, end: f64, cap: f64, way: f64) -> f64 {
        let (up, down) = (self.accel, self.decel);
        let meet = (from * from * down + end * end * up + 2.0 * up * down * way) / (up + down);
        if meet >= from.max(end).powi(2) {
            let peak = meet.sqrt().min(cap);
            let ramps =
                (peak * peak - from * from) / (2.0 * up) + (peak * peak - end * end) / (2.0 * down);
            return (peak - from) / up + (peak - end) / down + (way - ramps).max(0.0) / peak;
        }
        if from > end {
            return (from - (from * from - 2.0 * down * way).max(0.0).sqrt()) / down;
        }
        ((from * from + 2.0 * up * way).sqrt() - from) / up
    }
}

#[cfg(test)]
mod tests {
    use super::{Way, Work};

    const WORK: Work = Work { planned: 2.7e-3, segment: 0.45e-3, shaped: 0.7e-3, event: 10e-6 };

    /// Of the built-in mill's X axis, of so many steps.
    fn mill(events: f64) -> Way {
        Way { events, pitch: 10.0, start: 4e3, top: 8e4, accel: 2.5e5, decel: 2.5e5 }
    }

    #[test]
    fn a_slow_line_is_passed_at_any_speed_and_a_fast_one_no_faster_than_the_next_is_planned() {
        assert_eq!(mill(1_000.0).passed(8e4, &WORK), Some(8e4));
        // Chords of 0.1 mm are the window.
        let passed = mill(10.0).passed(8e4, &WORK).expect("one");
        assert!((20e3..30e3).contains(&passed), "{passed}");
        // The step interrupt leaves too little time at 60 000 steps/s.
        let fast = Way { pitch: 2.5, start: 1e3, top: 150e3, ..mill(5_000.0) };
        let passed = fast.passed(150e3, &WORK).expect("one");
        assert!((30e3..100e3).contains(&passed), "{passed}");
        // After a pause three steps before its end it is there in 2 ms, too fast to rest: it always rests.
        let steep = Way { accel: 2.5e6, decel: 2.5e6, ..fast };
        assert_eq!(steep.passed(150e3, &WORK), None);
    }

    #[test]
    fn no_length_makes_up_for_what_takes_longer_than_two_segments() {
        let passed = |planned| mill(1e6).passed(8e4, &Work { planned, ..WORK });
        assert_eq!([8e-3, 40e-3].map(passed), [None; 2]);
        // Three steps last 6.2 ms from 5 to 4.2 mm/s: hardly above the start rate.
        let slow = passed(5e-3).expect("one");
        assert!(slow < 4_200.0, "{slow}");
    }

    #[test]
    fn work_only_ever_makes_it_slower() {
        for events in [1.0, 7.0, 12.0, 40.0, 300.0] {
            let mut before = f64::INFINITY;
            for us in (0..60).map(|n| f64::from(n) * 100.0) {
                let work = Work { planned: us * 1e-6, ..WORK };
                let passed = mill(events).passed(8e4, &work).unwrap_or(0.0);
                assert!(passed <= before * 1.001, "{events} {us}");
                before = passed;
            }
        }
    }
}
