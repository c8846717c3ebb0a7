//! The corners that are braked for: a queue in which each takes a word.
//!
//! A corner's *line* is the square of its speed plus what all blocks before it can brake ([`super::ring`]): the square of
//! the speed from which the ramp ends exactly at the corner. The lowest line is the limit for the oldest block. A corner
//! can only become the lowest if no later one is as low, so only such corners are kept, and their lines rise from the first
//! to the last: the queue of a sliding-window minimum. Its first entry is the answer, a new corner removes entries from its
//! end.
//!
//! Of each line only the difference to the one before is kept, in 16 bits. It is rounded down, by no more than
//! 1/2048 of it: a limit may come out lower, never higher.

/// Blocks that may wait, of chords of 0.05 mm what 45 mm/s at 250 mm/s2 want. Thirteen more would reach F3000 less a
/// twentieth; the stack has that memory, so that 512 bytes are never touched at its deepest, and actions on the way.
pub const DEPTH: usize = 81;

/// No square of a speed is more.
pub const HIGHEST: u32 = (1 << 29) - 1;

/// See the module. Values are in the ring's unit.
#[derive(Clone, Copy, Debug)]
pub struct Brakes {
    /// Places in the ring of the blocks behind the corners.
    places: [u8; DEPTH],
    /// How much higher each is than the one before ([`short`]); of the first one nothing.
    gaps: [u16; DEPTH],
    /// The first one.
    first: u8,
    count: u8,
    /// The first one's line at the beginning of the oldest block.
    front2: i32,
    /// The last one's line at the end of the newest block; below 0 where no block stops so fast.
    back2: i32,
}

/// A difference in 16 bits, rounded down: 12 of them, times 2 to the upper four and four more.
fn short(gap: u32) -> u16 {
    let (mut bits, mut up) = (gap >> 4, 0);
    while bits >> 12 != 0 {
        bits >>= 1;
        up += 1 << 12;
    }
    bits as u16 | up
}

/// A difference of its 16 bits.
fn long(short: u16) -> u32 {
    let mut gap = u32::from(short & 0xFFF) << 4;
    let mut up = short >> 12;
    while up != 0 {
        gap <<= 1;
        up -= 1;
    }
    gap
}

/// The place behind or before one.
fn behind(n: u8) -> u8 {
    if usize::from(n) + 1 < DEPTH { n + 1 } else { 0 }
}

impl Brakes {
    /// None.
    pub const NONE: Brakes =
        Brakes { places: [0; DEPTH], gaps: [0; DEPTH], first: 0, count: 0, front2: 0, back2: 0 };

    /// Forgets all.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// The place of the last one.
    fn last(&self) -> usize {
        let n = usize::from(self.first) + usize::from(self.count) - 1;
        if n < DEPTH { n } else { n - DEPTH }
    }

    /// A corner in front of a new block at a place, which may be passed at `corner2`; all blocks before it can take away
    /// `ahead2`.
    ///
    /// `back2` is the last line less the braking of all blocks before the new corner, so it is compared with `corner2`
    /// itself. Entries that are not below it are removed, each with its difference; then the corner is the last one.
    pub fn append(&mut self, place: u8, corner2: u32, ahead2: u32) {
        while self.count != 0 && self.back2 >= corner2 as i32 {
            self.back2 -= long(self.gaps[self.last()]) as i32;
            self.count -= 1;
        }
        self.count += 1;
        let last = self.last();
        self.places[last] = place;
        if self.count == 1 {
            self.front2 = (corner2 + ahead2) as i32;
            self.back2 = corner2 as i32;
            self.gaps[last] = 0;
        } else {
            let gap = short((corner2 as i32 - self.back2) as u32);
            self.gaps[last] = gap;
            self.back2 += long(gap) as i32;
        }
    }

    /// The newest block takes `ramp2` away.
    pub fn go(&mut self, ramp2: u32) {
        self.back2 -= ramp2 as i32;
    }

    /// The oldest block, at a place, which takes `ramp2` away, has been taken: the corner in front of it, if it is the
    /// first one, has been passed, and all lines are lower by `ramp2`. `front2` holds the first of them.
    pub fn take(&mut self, place: u8, ramp2: u32) {
        if self.count == 0 {
            return;
        }
        if self.places[usize::from(self.first)] == place {
            self.first = behind(self.first);
            self.count -= 1;
            self.front2 += long(self.gaps[usize::from(self.first)]) as i32;
        }
        self.front2 -= ramp2 as i32;
    }

    /// Whether a corner's line is no higher than that of the newest block's end, `end2`.
    pub fn hold(&self, end2: u32) -> bool {
        self.count != 0 && self.front2 <= end2 as i32
    }

    /// The square of the speed at which the oldest block may be entered; `end2` is the line of the newest block's end.
    pub fn least(&self, end2: u32) -> u32 {
        if self.hold(end2) { self.front2.max(0) as u32 } else { end2 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::VecDeque;

    proptest! {
        /// What a pass over all blocks finds, less what rounding takes: blocks come and go in any order.
        #[test]
        fn the_queue_brakes_as_a_pass_over_all_blocks_would(
            blocks in prop::collection::vec((0..HIGHEST / 2, 0..HIGHEST / 256, 0..HIGHEST / 256), 1..400),
            goes in prop::collection::vec(any::<bool>(), 800),
        ) {
            let mut brakes = Brakes::NONE;
            // Place, corner, ramp.
            let mut all: VecDeque<(u8, u32, u32)> = VecDeque::new();
            let (mut blocks, mut place) = (blocks.into_iter(), 0);
            for go in goes {
                if go || all.len() == DEPTH {
                    let Some((place, _, ramp2)) = all.pop_front() else { continue };
                    brakes.take(place, ramp2);
                } else {
                    let Some((corner2, ramp2, end2)) = blocks.next() else { continue };
                    // The end that a block may have is no lower than the corner behind it may be.
                    let corner2 = corner2.max(end2);
                    let ahead2 = all.iter().map(|block| block.2).sum();
                    brakes.append(place, corner2, ahead2);
                    brakes.go(ramp2);
                    all.push_back((place, corner2, ramp2));
                    place = behind(place);
                }
                let mut sum = 0;
                let corners = all.iter().map(|(_, corner2, ramp2)| {
                    let line = corner2 + sum;
                    sum += ramp2;
                    line
                });
                let pass = corners.min().unwrap_or(HIGHEST);
                let found = brakes.least(HIGHEST);
                prop_assert!(found <= pass && pass - found <= (HIGHEST >> 11) + 16, "{found} for {pass}");
            }
        }
    }

    #[test]
    fn a_difference_loses_little() {
        for gap in (0..HIGHEST).step_by(9_973) {
            let kept = long(short(gap));
            assert!(kept <= gap && gap - kept <= (gap >> 11) + 15, "{kept} for {gap}");
        }
    }
}
