//! A machine that reports its steps instead of its laws of motion.

use super::{About, Cell};
use crate::law::{Rest, Steps};
use crate::region::{Region, quiet};

/// A chord of a bead is at least so long, mm: the steps of two axes come one after the other, and their sum would be
/// longer than the way.
const CHORD_MM: f64 = 0.25;
/// Widest box over a tilted stock, steps to each side.
const WIDEST: i32 = 256;

impl Cell {
    /// The box of head places around `at` in which nothing changes; the machine calls [`Cell::advance`] at the first
    /// step out of it.
    pub fn quiet_box(&mut self, at: &Steps) -> Region {
        let mut stays = quiet(self.watches.iter().map(|watch| (&watch.region, watch.inside)), at);
        let tools = 0..self.parked.len();
        if tools.clone().any(|tool| self.state_of(tool).drills() || self.holds(tool).is_some()) {
            // How deep a hole is, whether the drill stays in it, and the acceleration are known at each step.
            stays = narrowed(stays, at, [0; 3]);
        } else if self.states().any(|tool| tool.is_working()) {
            let chord = self.frame.scale.map(|scale| (scale.abs() * CHORD_MM).ceil() as i32);
            stays = narrowed(stays, at, chord);
        }
        if !self.is_tilted() {
            return stays;
        }
        tools.fold(stays, |stays, tool| self.over_slope(tool, stays, at))
    }

    /// When the cell must be called next by itself while all axes rest, not before `now`.
    pub fn due(&mut self, at: &Steps, now: u64) -> Option<u64> {
        self.next_us(&Rest(*at), now)
    }

    fn is_tilted(&self) -> bool {
        self.scene.stock.as_ref().is_some_and(|stock| stock.tilt != [0.0; 2])
    }

    /// Over a tilted stock the height of its top depends on the place: the box is so small that the tip stays on its
    /// side of the top everywhere in it.
    fn over_slope(&self, tool: usize, stays: Region, at: &Steps) -> Region {
        let inside = self
            .watches
            .iter()
            .any(|watch| watch.about == About::Stock && watch.tool == tool && watch.inside);
        let up = self.frame.scale[2] > 0.0;
        let mut wide = WIDEST;
        loop {
            let mut small = narrowed(stays, at, [wide, wide, i32::MAX]);
            // The top is a plane: its extremes over the box are at the corners.
            let corners = [0, 1, 2, 3].map(|corner| {
                let x = if corner & 1 == 0 { small.low[0] } else { small.high[0] };
                let y = if corner & 2 == 0 { small.low[1] } else { small.high[1] };
                self.top_in_steps(tool, [x, y])
            });
            // With the sign of "upward" all heights are compared alike.
            let sign = if up { 1.0 } else { -1.0 };
            let (least, most) =
                corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), top| {
                    (a.min(top * sign), b.max(top * sign))
                });
            let here = f64::from(at[2]) * sign;
            let fits = if inside { here <= least + 1e-6 } else { here > most + 1e-6 };
            if fits || wide == 0 {
                // The last step on this side of the top.
                let edge =
                    if inside { (least + 1e-6).floor() } else { (most + 1e-6).floor() + 1.0 };
                let edge = (edge * sign) as i32;
                let bounds_above = inside == up;
                if bounds_above {
                    small.high[2] = small.high[2].min(edge.max(at[2]));
                } else {
                    small.low[2] = small.low[2].max(edge.min(at[2]));
                }
                return small;
            }
            wide /= 2;
        }
    }

    /// The top of the stock as a place of Z in steps for the tip of a tool, where X and Y stand so.
    pub(super) fn top_in_steps(&self, tool: usize, [x, y]: [i32; 2]) -> f64 {
        let top = self.top_of_stock(self.tip_of(tool, &[x, y, 0, 0]));
        (top - self.frame.start[2] - self.offset(tool)[2]) * self.frame.scale[2]
    }

    /// The region of a tilted stock has the height of its top where the tip is now.
    pub(super) fn tilt_here(&mut self, at: &Steps) {
        if !self.is_tilted() {
            return;
        }
        let tops: Vec<f64> =
            (0..self.parked.len()).map(|tool| self.top_in_steps(tool, [at[0], at[1]])).collect();
        let up = self.frame.scale[2] > 0.0;
        for watch in self.watches.iter_mut().filter(|watch| watch.about == About::Stock) {
            let steps = tops[watch.tool];
            if up {
                watch.region.high[2] = (steps + 1e-6).floor() as i32;
            } else {
                watch.region.low[2] = (steps - 1e-6).ceil() as i32;
            }
        }
    }
}

/// A box no wider than `wide` steps to each side of a place.
fn narrowed(stays: Region, at: &Steps, wide: [i32; 3]) -> Region {
    Region {
        low: std::array::from_fn(|axis| stays.low[axis].max(at[axis].saturating_sub(wide[axis]))),
        high: std::array::from_fn(|axis| stays.high[axis].min(at[axis].saturating_add(wide[axis]))),
    }
}
