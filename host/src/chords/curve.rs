//! One arc as chords, in micrometres from its start.

use std::f64::consts::TAU;

use firmware::motion::{Arc, Ends};
use lang::axis::Axis;
use lang::effect::Plane;
use lang::fault::Fault;
use lang::profile::Profile;

/// Largest angle of a chord: the smallest circle is an octagon.
const WIDEST: f64 = TAU / 8.0;
/// How far the rounding of a chord's ends to whole micrometres takes it from the arc, um.
const ROUNDING_UM: f64 = 1.0;

/// An arc as its words say it, in micrometres from its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// G2.
    pub clockwise: bool,
    /// The plane.
    pub plane: Plane,
    /// The end.
    pub end: [i32; 3],
    /// The centre.
    pub center: Center,
}

/// A centre as words give it, um.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Center {
    /// From the start, in the plane's first and second axis.
    Offset([i32; 2]),
    /// R.
    Radius(i32),
}

impl Shape {
    /// The arc, its centre found: what a part that draws arcs finds from the same words.
    ///
    /// # Errors
    /// F09, as there.
    pub fn arc(&self) -> Result<Arc, Fault> {
        let ends = Ends {
            first: self.plane.axes()[0].index() as u8,
            clockwise: self.clockwise,
            from_um: [0; 3],
            to_um: self.end,
            start: [0; 3],
            end: [0; 3],
        };
        match self.center {
            Center::Offset(offset) => ends.around(offset),
            Center::Radius(radius) => ends.with_radius(radius),
        }
    }

    /// Ends of the chords from the start, um; the last one is the arc's. Of chords that are no longer
    /// than this `tolerance_um` allows ([`tolerance_um`]) the fewest.
    ///
    /// # Errors
    /// F09.
    pub fn chords(&self, tolerance_um: f64) -> Result<Vec<[i32; 3]>, Fault> {
        let arc = self.arc()?;
        let [a, b, c] = arc.axes();
        let from = arc.from.map(f64::from);
        let to = arc.to.map(f64::from);
        let radius = from[0].hypot(from[1]);
        // RS274/NGC lets an end miss the circle by a little: the radius changes evenly on the way.
        let growth = to[0].hypot(to[1]) - radius;
        let sweep = match arc.sweep {
            u32::MAX => TAU,
            part => f64::from(part) / 4_294_967_296.0 * TAU,
        };
        let count = (sweep / widest(radius + growth.max(0.0), tolerance_um)).ceil().max(1.0);
        let begin = from[1].atan2(from[0]);
        let sweep = if self.clockwise { -sweep } else { sweep };
        let mut ends = Vec::with_capacity(count as usize);
        for n in 1..count as u32 {
            let part = f64::from(n) / count;
            let (sine, cosine) = (begin + sweep * part).sin_cos();
            let out = radius + growth * part;
            let mut end = [0; 3];
            end[a] = (out * cosine - from[0]).round() as i32;
            end[b] = (out * sine - from[1]).round() as i32;
            end[c] = (f64::from(self.end[c]) * part).round() as i32;
            ends.push(end);
        }
        ends.push(self.end);
        Ok(ends)
    }
}

/// The angle whose chord leaves a circle by the tolerance, radians.
fn widest(radius: f64, tolerance_um: f64) -> f64 {
    let off = (tolerance_um - ROUNDING_UM).max(ROUNDING_UM);
    // Where the circle is smaller than what it may be off by, any chord will do.
    let half = (1.0 - (off / radius).min(1.0)).acos();
    (2.0 * half).min(WIDEST)
}

/// How far chords may leave an arc in this plane, um: what the profile lets a path round its corners
/// by, and no less than half a step, which no axis can show.
pub fn tolerance_um(profile: &Profile, plane: Plane) -> f64 {
    let half_step = |axis: Axis| {
        profile
            .axis(axis)
            .map_or(0.0, |own| f64::from(own.scale.um) / f64::from(own.scale.steps.max(1)) / 2.0)
    };
    let [a, b] = plane.axes().map(half_step);
    f64::from(profile.corner_um).max(a).max(b).max(2.0 * ROUNDING_UM)
}
