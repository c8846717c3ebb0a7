//! Boxes and forms: what stands in a cell, mm.

/// Three numbers: a place or a size, mm.
pub type V3 = [f64; 3];

/// A box by its least and greatest corner, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Least X, Y, Z.
    pub low: V3,
    /// Greatest X, Y, Z.
    pub high: V3,
}

impl Block {
    /// The box of this size whose bottom's middle is at `at`.
    #[must_use]
    pub fn standing(at: V3, size: V3) -> Self {
        Self {
            low: [at[0] - size[0] / 2.0, at[1] - size[1] / 2.0, at[2]],
            high: [at[0] + size[0] / 2.0, at[1] + size[1] / 2.0, at[2] + size[2]],
        }
    }

    /// How deep two boxes are in one another, in mm, along the axis where that is least; 0 or less where they are apart.
    #[must_use]
    pub fn overlap(&self, other: &Self) -> f64 {
        (0..3)
            .map(|axis| self.high[axis].min(other.high[axis]) - self.low[axis].max(other.low[axis]))
            .fold(f64::INFINITY, f64::min)
    }

    /// Moved by `by`.
    #[must_use]
    pub fn moved(&self, by: V3) -> Self {
        let sum = |corner: V3| [corner[0] + by[0], corner[1] + by[1], corner[2] + by[2]];
        Self { low: sum(self.low), high: sum(self.high) }
    }

    /// Whether a place lies in it, its faces included.
    #[must_use]
    pub fn holds(&self, at: V3) -> bool {
        (0..3).all(|axis| (self.low[axis]..=self.high[axis]).contains(&at[axis]))
    }
}

/// A form that stands on its bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Form {
    /// Full width, depth and height before it is turned, mm; a cylinder's width is its diameter.
    pub size: V3,
    /// Whether it is an upright cylinder.
    pub round: bool,
    /// Turned counter-clockwise about its middle, degrees.
    pub turn_deg: f64,
}

impl Form {
    /// Boxes along the axes that together cover it when it stands at `at`; `slices` of them along X where it is turned
    /// or round. They cover it, so that a test against them misses no contact.
    #[must_use]
    pub fn blocks(&self, at: V3, slices: u32) -> Vec<Block> {
        let [width, depth, height] = self.size;
        let turn = self.turn_deg.rem_euclid(360.0);
        if !self.round && turn.rem_euclid(180.0) == 0.0 {
            return vec![Block::standing(at, self.size)];
        }
        if !self.round && turn.rem_euclid(90.0) == 0.0 {
            return vec![Block::standing(at, [depth, width, height])];
        }
        let outline = self.outline();
        let left = outline.iter().map(|corner| corner[0]).fold(f64::INFINITY, f64::min);
        let right = -left;
        let step = (right - left) / f64::from(slices.max(1));
        (0..slices.max(1))
            .map(|slice| {
                let from = left + step * f64::from(slice);
                let (low, high) = span_of_slice(&outline, from, from + step);
                Block {
                    low: [at[0] + from, at[1] + low, at[2]],
                    high: [at[0] + from + step, at[1] + high, at[2] + height],
                }
            })
            .collect()
    }

    /// The corners of its outline from above, from its middle; a circle as a polygon around it.
    #[must_use]
    pub fn outline(&self) -> Vec<[f64; 2]> {
        if self.round {
            const CORNERS: u32 = 32;
            let around = self.size[0] / 2.0 / (std::f64::consts::PI / f64::from(CORNERS)).cos();
            return (0..CORNERS)
                .map(|corner| {
                    let (sin, cos) =
                        (std::f64::consts::TAU * f64::from(corner) / f64::from(CORNERS)).sin_cos();
                    [around * cos, around * sin]
                })
                .collect();
        }
        let (sin, cos) = self.turn_deg.to_radians().sin_cos();
        let (x, y) = (self.size[0] / 2.0, self.size[1] / 2.0);
        [[x, y], [-x, y], [-x, -y], [x, -y]]
            .map(|[x, y]| [x * cos - y * sin, x * sin + y * cos])
            .to_vec()
    }
}

/// Least and greatest Y of a convex outline between two X.
fn span_of_slice(outline: &[[f64; 2]], from: f64, to: f64) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut take = |y: f64| {
        low = low.min(y);
        high = high.max(y);
    };
    for (index, &[x, y]) in outline.iter().enumerate() {
        if (from..=to).contains(&x) {
            take(y);
        }
        let [next_x, next_y] = outline[(index + 1) % outline.len()];
        for edge in [from, to] {
            if (x < edge) != (next_x < edge) {
                take(y + (next_y - y) * (edge - x) / (next_x - x));
            }
        }
    }
    if low > high { (0.0, 0.0) } else { (low, high) }
}

#[cfg(test)]
mod tests {
    use super::{Block, Form};

    #[test]
    fn a_quarter_turn_is_one_exact_box() {
        let form = Form { size: [30.0, 10.0, 5.0], round: false, turn_deg: 90.0 };
        assert_eq!(
            form.blocks([0.0; 3], 8),
            [Block { low: [-5.0, -15.0, 0.0], high: [5.0, 15.0, 5.0] }]
        );
    }

    proptest::proptest! {
        /// Whatever its turn, the slices hold every point of the form, and little more than it.
        #[test]
        fn slices_cover_a_turned_form(
            width in 0.1..100.0f64, depth in 0.1..100.0f64, turn in -360.0..360.0f64, round in proptest::bool::ANY,
            slices in 1u32..20, u in -1.0..1.0f64, v in -1.0..1.0f64,
        ) {
            let depth = if round { width } else { depth };
            let form = Form { size: [width, depth, 1.0], round, turn_deg: turn };
            let at = if round {
                let (sin, cos) = (u * std::f64::consts::PI).sin_cos();
                [width / 2.0 * v * cos, width / 2.0 * v * sin]
            } else {
                let (sin, cos) = turn.to_radians().sin_cos();
                let (x, y) = (u * width / 2.0, v * depth / 2.0);
                [x * cos - y * sin, x * sin + y * cos]
            };
            let blocks = form.blocks([0.0; 3], slices);
            let held = blocks.iter().any(|block| {
                let wider = Block { low: block.low.map(|low| low - 1e-6), high: block.high.map(|high| high + 1e-6) };
                wider.holds([at[0], at[1], 0.5])
            });
            proptest::prop_assert!(held, "{at:?} is in none of {blocks:?}");
        }
    }
}
