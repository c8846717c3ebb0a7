//! Outlines: what is drawn, in mm.

use std::f64::consts::TAU;

/// A place, mm.
pub(super) type Spot = [f64; 2];

/// Corners of a circle.
const ROUND: usize = 64;
/// How far a chord may lie off its arc, mm.
const CHORD: f64 = 0.002;

/// A closed outline, filled by the even-odd rule, that adds or takes away.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Piece {
    /// Adds; otherwise it takes away from the pieces before it.
    pub add: bool,
    /// Its corners.
    pub ring: Vec<Spot>,
}

/// A flash, a stroke or a region.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Thing {
    /// Draws; otherwise it clears what was drawn before it.
    pub dark: bool,
    /// What it is made of.
    pub pieces: Vec<Piece>,
    /// The part that it belongs to; empty for none.
    pub name: String,
    /// Line of the file.
    pub line: u32,
}

/// Smallest and greatest X and Y.
pub(super) type Bounds = [Spot; 2];

/// What holds some places.
pub(super) fn bounds<'s>(spots: impl Iterator<Item = &'s Spot>) -> Option<Bounds> {
    spots.fold(None, |all: Option<Bounds>, [x, y]| {
        let [low, high] = all.unwrap_or([[*x, *y]; 2]);
        Some([[low[0].min(*x), low[1].min(*y)], [high[0].max(*x), high[1].max(*y)]])
    })
}

impl Thing {
    /// What holds all of it.
    pub fn bounds(&self) -> Option<Bounds> {
        bounds(self.pieces.iter().flat_map(|piece| &piece.ring))
    }

    /// How many corners it has.
    pub fn corners(&self) -> usize {
        self.pieces.iter().map(|piece| piece.ring.len()).sum()
    }

    /// The same elsewhere.
    pub fn mapped(&self, map: impl Fn(Spot) -> Spot) -> Thing {
        let mut out = self.clone();
        for spot in out.pieces.iter_mut().flat_map(|piece| &mut piece.ring) {
            *spot = map(*spot);
        }
        out
    }
}

/// A circle.
pub(super) fn circle(middle: Spot, diameter: f64) -> Vec<Spot> {
    polygon(middle, diameter, ROUND, 0.0)
}

/// A regular polygon with its first corner at `turned` degrees.
pub(super) fn polygon(middle: Spot, diameter: f64, corners: usize, turned: f64) -> Vec<Spot> {
    let corner = |n: usize| {
        let (sin, cos) = (turned.to_radians() + TAU * n as f64 / corners as f64).sin_cos();
        [middle[0] + cos * diameter / 2.0, middle[1] + sin * diameter / 2.0]
    };
    (0..corners).map(corner).collect()
}

/// A rectangle.
pub(super) fn rectangle(middle: Spot, width: f64, height: f64) -> Vec<Spot> {
    let (w, h) = (width / 2.0, height / 2.0);
    let [x, y] = middle;
    vec![[x - w, y - h], [x + w, y - h], [x + w, y + h], [x - w, y + h]]
}

/// A rectangle with its short sides rounded.
pub(super) fn obround(width: f64, height: f64) -> Vec<Spot> {
    let round = width.min(height);
    let (x, y) = ((width - round) / 2.0, (height - round) / 2.0);
    hull([circle([-x, -y], round), circle([x, y], round)].concat())
}

/// A place turned about 0, counter-clockwise.
pub(super) fn turned([x, y]: Spot, degrees: f64) -> Spot {
    let (sin, cos) = degrees.to_radians().sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

/// What a convex outline covers on a straight way.
pub(super) fn swept(ring: &[Spot], from: Spot, to: Spot) -> Vec<Spot> {
    let at = |place: Spot| ring.iter().map(move |s| [s[0] + place[0], s[1] + place[1]]);
    hull(at(from).chain(at(to)).collect())
}

/// The convex hull, counter-clockwise.
pub(super) fn hull(mut spots: Vec<Spot>) -> Vec<Spot> {
    spots.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    spots.dedup();
    if spots.len() < 3 {
        return spots;
    }
    let half = |spots: &mut dyn Iterator<Item = Spot>| {
        let mut out: Vec<Spot> = Vec::new();
        for spot in spots {
            while let [.., a, b] = out[..] {
                let left = (b[0] - a[0]) * (spot[1] - a[1]) - (b[1] - a[1]) * (spot[0] - a[0]);
                if left > 0.0 {
                    break;
                }
                out.pop();
            }
            out.push(spot);
        }
        out.pop();
        out
    };
    let mut out = half(&mut spots.iter().copied());
    out.extend(half(&mut spots.iter().rev().copied()));
    out
}

/// Places on an arc from `from` to `to` about `middle`, without the first; the same place twice is
/// a full circle.
pub(super) fn arc(from: Spot, to: Spot, middle: Spot, clockwise: bool) -> Vec<Spot> {
    let polar = |spot: Spot| {
        let [x, y] = [spot[0] - middle[0], spot[1] - middle[1]];
        (x.hypot(y), y.atan2(x))
    };
    let ((r0, a0), (r1, a1)) = (polar(from), polar(to));
    let mut sweep = if clockwise { a0 - a1 } else { a1 - a0 };
    if sweep <= 1e-9 {
        sweep += TAU;
    }
    let step = 2.0 * (1.0 - (CHORD / r0.max(CHORD)).min(1.0)).clamp(-1.0, 1.0).acos();
    let count = (sweep / step.max(0.01)).ceil().clamp(2.0, 720.0);
    let spot = |n: f64| {
        if n == count {
            return to;
        }
        let part = n / count;
        let angle = if clockwise { a0 - sweep * part } else { a0 + sweep * part };
        let radius = r0 + (r1 - r0) * part;
        [middle[0] + radius * angle.cos(), middle[1] + radius * angle.sin()]
    };
    (1..=count as usize).map(|n| spot(n as f64)).collect()
}
