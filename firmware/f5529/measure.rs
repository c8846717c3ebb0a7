//! Pin measurements for the self-test: TA2 counts edges, or captures them, without any help of the processor.
//!
//! Counting: STEP is wired to P2.2, TA2's clock input. Each rising edge is one count, independent of what the step engine
//! reports.
//!
//! Capturing: TA2.0 takes the time of edges at P2.3, TA2.1 that of edges at P2.4. The main loop reads both registers now
//! and then; two reads that agree are the last edge of each kind. The later one less the earlier one is a sample of the time
//! from the one kind to the other. Edges between two reads are missed, so shortest and longest are those of samples.
//! With ticks of eight cycles, where the timer wraps after 21 ms, samples whose edges are 5 ms old are left out. With
//! ticks of one cycle it wraps after 2.6 ms, so the measured edges must alternate faster than that.

use crate::chip::capture;
use core::ptr::addr_of_mut;

/// Bit of `Measure::mode`: ticks of eight cycles.
const SLOW: u16 = 1 << 3;
/// An edge of that age, ticks of eight cycles, is no edge to measure from: 5 ms.
const OLD: u16 = 16_000;

/// The test under way.
struct Measure {
    /// The register as written.
    mode: u16,
    samples: u16,
    /// Shortest and longest, P2.3 to P2.4 and back.
    times: [[u16; 2]; 2],
    /// The last sample; before the first one, what stood in the register of P2.4 as the test began.
    last: u16,
    /// The edge at P2.3 that was seen last, and whether it has come since the test began and is young.
    from: u16,
    fresh: bool,
    /// Whether an edge at P2.4 has come since the test began: what stood there before is none to measure to.
    came: bool,
}

static mut MEASURE: Measure = Measure::NONE;

/// The only one who knows the test, for as long as one of the functions below takes.
fn measure() -> &'static mut Measure {
    // SAFETY: only the main loop calls these functions, and none of them another.
    unsafe { &mut *addr_of_mut!(MEASURE) }
}

/// Begins another test, by the mode that [`lang::wire::MEASURE`] takes; `false`: there is no such mode.
pub fn set(mode: u16) -> bool {
    measure().set(mode)
}

/// The mode of the test under way, 0 for none.
pub fn mode() -> u16 {
    measure().mode
}

/// Looks at the captured edges.
#[inline(never)]
pub fn poll() {
    measure().poll();
}

/// Register `n` of [`lang::wire::MEASURED`], from 0.
pub fn found(n: u16) -> u16 {
    measure().found(n)
}

impl Measure {
    /// Nothing is measured.
    const NONE: Measure = Measure {
        mode: 0,
        samples: 0,
        times: [[u16::MAX, 0]; 2],
        last: 0,
        from: 0,
        fresh: false,
        came: false,
    };

    fn set(&mut self, mode: u16) -> bool {
        match mode & 7 {
            0 if mode == 0 => capture::close(),
            1 if mode == 1 => capture::count(),
            2 if mode < 1 << 8 => capture::open(mode & SLOW != 0, mode >> 4 & 3, mode >> 6 & 3),
            _ => return false,
        }
        let (from, last) = capture::edges();
        *self = Measure { mode, from, last, ..Measure::NONE };
        true
    }

    fn poll(&mut self) {
        if self.mode & 7 != 2 {
            return;
        }
        let (from, to) = capture::edges();
        if capture::edges() != (from, to) {
            return;
        }
        if from != self.from {
            self.from = from;
            self.fresh = true;
        } else if self.mode & SLOW != 0 && capture::now().wrapping_sub(from) > OLD {
            self.fresh = false;
        }
        self.came |= to != self.last;
        if !self.fresh || !self.came {
            return;
        }
        let time = to.wrapping_sub(from);
        self.last = time;
        let back = time as i16 >= 0;
        let (size, times) = if back {
            (time, &mut self.times[0])
        } else {
            (time.wrapping_neg(), &mut self.times[1])
        };
        times[0] = times[0].min(size);
        times[1] = times[1].max(size);
        self.samples = self.samples.saturating_add(1);
    }

    fn found(&self, n: u16) -> u16 {
        match n {
            0 if self.mode == 1 => capture::now(),
            0 => self.samples,
            1..=4 => {
                let [low, high] = self.times[usize::from(n - 1) >> 1 & 1];
                if n & 1 != 0 { low } else { high }
            }
            _ => self.last,
        }
    }
}
