//! Regions: boxes of head places, in steps. Whatever geometry decides in a cell is "is the head in this box": a box that
//! moves with the head meets a box that stands exactly when the head is in their Minkowski sum. Entering and leaving are
//! found from the law of motion, to the microsecond, so nothing is too thin or too fast to be met.

use super::law::{Law, Steps};
use super::scene::{Block, V3};

/// A box of head places in steps, both ends within; only X, Y and Z count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// Least place of each axis.
    pub low: [i32; 3],
    /// Greatest place of each axis.
    pub high: [i32; 3],
}

/// Steps of the cell's frame in a millimetre, X, Y, Z; negative where the axis counts the other way.
pub type Scale = V3;

/// The head places from which a block that moves with the head (`moving`, from the head) is within `shrink` mm of
/// overlapping a block that stands. A `shrink` above 0 lets blocks touch.
#[must_use]
pub fn meeting(standing: &Block, moving: &Block, shrink: f64, scale: Scale) -> Region {
    let low: V3 = std::array::from_fn(|axis| standing.low[axis] - moving.high[axis] + shrink);
    let high: V3 = std::array::from_fn(|axis| standing.high[axis] - moving.low[axis] - shrink);
    Region::of(&Block { low, high }, scale)
}

impl Region {
    /// The whole steps that lie in a block of head places in mm.
    #[must_use]
    pub fn of(block: &Block, scale: Scale) -> Self {
        let step = |place: f64| place.clamp(-2e9, 2e9);
        let mut region = Self { low: [0; 3], high: [0; 3] };
        for (axis, scale) in scale.into_iter().enumerate() {
            let (a, b) = (block.low[axis] * scale, block.high[axis] * scale);
            // A place that is a whole step but for rounding counts as that step.
            region.low[axis] = step((a.min(b) - 1e-6).ceil()) as i32;
            region.high[axis] = step((a.max(b) + 1e-6).floor()) as i32;
        }
        region
    }

    /// Whether the head is in it.
    #[must_use]
    pub fn holds(&self, at: &Steps) -> bool {
        (0..3).all(|axis| self.low[axis] <= at[axis] && at[axis] <= self.high[axis])
    }

    /// When the head enters the region, or leaves it if it is `inside`, after `now` and not after the law's end, where
    /// the axes stand at `end`. Each axis goes one way, so it is within the region's bounds during one interval at the
    /// most, and the head is in the region while all three are.
    #[must_use]
    pub fn changes(
        &self,
        law: &dyn Law,
        at: &Steps,
        end: &Steps,
        now: u64,
        inside: bool,
    ) -> Option<u64> {
        let mut enters = now;
        let mut leaves = None;
        for axis in 0..3 {
            let (from, to) = (at[axis], end[axis]);
            let (least, most) = (self.low[axis], self.high[axis]);
            if from.max(to) < least || from.min(to) > most {
                return None;
            }
            let up = to > from;
            if from < least || from > most {
                enters = enters.max(law.reaches(axis, if up { least } else { most }, now)?);
            }
            if to < least || to > most {
                let out = if up { most.saturating_add(1) } else { least.saturating_sub(1) };
                let when = law.reaches(axis, out, now);
                leaves = [leaves, when].into_iter().flatten().min();
            }
        }
        if inside {
            return leaves.filter(|&when| when > now);
        }
        // It comes in only if it has not gone past in another axis.
        (leaves.is_none_or(|when| when > enters)).then_some(enters).filter(|&when| when > now)
    }
}

/// The largest box around the head, found in one pass, in which no region changes: a law that stays in it costs six
/// comparisons. A region that the head is in bounds it by itself; one that it is not in by the axis that parts them most.
#[must_use]
pub fn quiet<'a>(regions: impl Iterator<Item = (&'a Region, bool)>, at: &Steps) -> Region {
    let mut quiet = Region { low: [i32::MIN; 3], high: [i32::MAX; 3] };
    for (region, inside) in regions {
        if inside {
            for axis in 0..3 {
                quiet.low[axis] = quiet.low[axis].max(region.low[axis]);
                quiet.high[axis] = quiet.high[axis].min(region.high[axis]);
            }
            continue;
        }
        if (0..3).any(|axis| region.low[axis] > region.high[axis]) {
            continue; // nothing can be in it
        }
        let gap = |axis: usize| {
            let below = i64::from(region.low[axis]) - i64::from(at[axis]);
            let above = i64::from(at[axis]) - i64::from(region.high[axis]);
            below.max(above)
        };
        let axis = (0..3).max_by_key(|&axis| gap(axis)).unwrap_or(0);
        if at[axis] < region.low[axis] {
            quiet.high[axis] = quiet.high[axis].min(region.low[axis] - 1);
        } else {
            quiet.low[axis] = quiet.low[axis].max(region.high[axis] + 1);
        }
    }
    quiet
}

#[cfg(test)]
mod tests {
    use super::{Region, meeting, quiet};
    use crate::law::{Law, Straight};
    use crate::scene::Block;
    use proptest::prelude::*;

    fn place() -> impl Strategy<Value = [i32; 4]> {
        [-60..60i32, -60..60i32, -60..60i32, -60..60i32]
    }

    fn region() -> impl Strategy<Value = Region> {
        ([-70..70i32, -70..70i32, -70..70i32], [0..30i32, 0..30i32, 0..30i32]).prop_map(
            |(low, size)| Region { low, high: std::array::from_fn(|axis| low[axis] + size[axis]) },
        )
    }

    /// The first microsecond after `now` at which the answer of `holds` is another one, by looking at each.
    fn sampled(region: &Region, law: &Straight, now: u64) -> Option<u64> {
        let before = region.holds(&law.at(now));
        (now + 1..=law.begins + law.takes).find(|&us| region.holds(&law.at(us)) != before)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100_000))]

        /// The swept test says the same microsecond as a look at each of them, for walls of one step, too.
        #[test]
        fn the_law_tells_what_sampling_tells(
            from in place(), to in place(), takes in 1u64..300, begins in 0u64..50, skip in 0.0..1.0f64, region in region(),
        ) {
            let law = Straight { id: 1, from, to, begins, takes };
            let now = begins + (takes as f64 * skip) as u64;
            let at = law.at(now);
            let told = region.changes(&law, &at, &law.to, now, region.holds(&at));
            prop_assert_eq!(told, sampled(&region, &law, now));
        }

        /// Nothing changes in the quiet box.
        #[test]
        fn the_quiet_box_is_quiet(
            at in place(), regions in proptest::collection::vec(region(), 0..6), u in [0.0..=1.0f64, 0.0..=1.0f64, 0.0..=1.0f64],
        ) {
            let inside: Vec<bool> = regions.iter().map(|region| region.holds(&at)).collect();
            let quiet = quiet(regions.iter().zip(inside.iter().copied()), &at);
            prop_assert!(quiet.holds(&at));
            let there: [i32; 4] = std::array::from_fn(|axis| if axis == 3 { 0 } else {
                let (low, high) = (quiet.low[axis].max(-100), quiet.high[axis].min(100));
                low + (f64::from(high - low) * u[axis]) as i32
            });
            for (region, inside) in regions.iter().zip(inside) {
                prop_assert_eq!(region.holds(&there), inside, "{:?} at {:?}", region, there);
            }
        }

        /// The head is in the meeting region exactly when the blocks overlap by more than the tolerance.
        #[test]
        fn a_meeting_is_an_overlap(
            low in [-20..20i32, -20..20i32, -20..20i32], size in [1..20i32, 1..20i32, 1..20i32],
            body in [-9..9i32, -9..9i32, -9..9i32], wide in [1..12i32, 1..12i32, 1..12i32],
            at in [-40..40i32, -40..40i32, -40..40i32], down in any::<bool>(),
        ) {
            let block = |low: [i32; 3], size: [i32; 3]| Block {
                low: low.map(f64::from), high: std::array::from_fn(|axis| f64::from(low[axis] + size[axis])),
            };
            // Two steps in a mm, and Z counted downward.
            let scale = [2.0, 2.0, if down { -2.0 } else { 2.0 }];
            let (standing, moving) = (block(low, size), block(body, wide));
            let region = meeting(&standing, &moving, 0.001, scale);
            let head: [f64; 3] = std::array::from_fn(|axis| f64::from(at[axis]) / scale[axis]);
            let overlap = moving.moved(head).overlap(&standing);
            prop_assert_eq!(region.holds(&[at[0], at[1], at[2], 0]), overlap > 0.0, "overlap {}", overlap);
        }
    }
}
