//! Outputs that are to act along a job's path (SYNC) and have not acted yet.

use std::f64::consts::TAU;

use lang::axis::Axis;
use lang::effect::{Action, Center, Dist, Effect, Lead, Plane};

/// An action, and how far the path is beyond its place.
#[derive(Clone, Copy, Debug)]
struct Pending {
    action: Action,
    /// The block at whose beginning its place is has been followed.
    begun: bool,
    /// um along the path.
    um: f64,
    /// ms, no more than there were.
    ms: f64,
}

impl Pending {
    /// Whether it has acted.
    fn is_over(&self) -> bool {
        match self.action.lead {
            Lead::Way(lead) => self.begun && self.um >= -f64::from(lead),
            Lead::Time(lead) => self.begun && self.ms >= -f64::from(lead),
        }
    }

    /// What it is from here on.
    fn rest(&self) -> Action {
        let less =
            |lead: i32, gone: f64| if self.begun { lead + gone.round() as i32 } else { lead };
        let lead = match self.action.lead {
            Lead::Way(lead) => Lead::Way(less(lead, self.um)),
            Lead::Time(lead) => Lead::Time(less(lead, self.ms)),
        };
        Action { lead, ..self.action }
    }
}

/// See the module.
#[derive(Debug, Default)]
pub struct Along {
    list: Vec<Pending>,
}

impl Along {
    /// A SYNC has been followed.
    pub fn add(&mut self, action: Action) {
        self.list.push(Pending { action, begun: false, um: 0.0, ms: 0.0 });
    }

    /// A block of the path has been followed: um, and the least ms that it takes. Gives what has acted by its end.
    pub fn block(&mut self, um: f64, ms: f64) -> Vec<Action> {
        for own in &mut self.list {
            (own.begun, own.um, own.ms) = (true, own.um + um, own.ms + ms);
        }
        self.take_over()
    }

    /// A statement has waited for the path's end. It took `ms`; without that it took longer than any lag. Gives what has
    /// acted by its end.
    pub fn end(&mut self, ms: Option<f64>) -> Vec<Action> {
        let Some(ms) = ms else {
            return self.list.drain(..).map(|own| own.action).collect();
        };
        for own in &mut self.list {
            (own.begun, own.um, own.ms) = (true, f64::INFINITY, own.ms + ms);
        }
        self.take_over()
    }

    fn take_over(&mut self) -> Vec<Action> {
        let over = self.list.extract_if(.., |own| own.is_over());
        over.map(|own| own.action).collect()
    }

    /// Something else has switched these outputs: what is still to come for them does not.
    pub fn forget(&mut self, which: impl Fn(&Action) -> bool) {
        self.list.retain(|own| !which(&own.action));
    }

    /// What has not acted yet, as statements before the path's next block.
    pub fn effects(&self) -> impl Iterator<Item = Effect> + '_ {
        self.list.iter().map(|own| Effect::Sync(own.rest()))
    }
}

/// The length of a block whose axes go `by`, um.
pub fn straight(by: [f64; 3]) -> f64 {
    by[0].hypot(by[1]).hypot(by[2])
}

/// The length of an arc whose axes go `by`, um; `um_per_step` of each axis. A full circle ends where it begins.
pub fn arc(
    by: [f64; 3],
    clockwise: bool,
    plane: Plane,
    center: &Center,
    um_per_step: [f64; 3],
) -> f64 {
    let axes = plane.axes().map(Axis::index);
    let um = |dist: Dist, axis: usize| match dist {
        Dist::Um(um) => f64::from(um),
        Dist::Steps(steps) => f64::from(steps) * um_per_step[axis],
    };
    let to = axes.map(|axis| by[axis]);
    let chord = to[0].hypot(to[1]);
    let (radius, angle) = match center {
        Center::Radius(radius) => {
            let radius = um(*radius, axes[0]);
            let size = radius.abs();
            let angle = 2.0 * (chord / (2.0 * size.max(chord / 2.0)).max(1e-9)).min(1.0).asin();
            (size.max(chord / 2.0), if radius < 0.0 { TAU - angle } else { angle })
        }
        Center::Offsets(offsets) => {
            let offset = axes.map(|axis| um(offsets[axis], axis));
            let from = offset.map(|value| -value);
            let end = [to[0] - offset[0], to[1] - offset[1]];
            let cross = from[0] * end[1] - from[1] * end[0];
            let dot = from[0] * end[0] + from[1] * end[1];
            let turn = cross.atan2(dot) * if clockwise { -1.0 } else { 1.0 };
            let angle = if chord < 1.0 || turn <= 0.0 { turn + TAU } else { turn };
            (offset[0].hypot(offset[1]), angle.min(TAU))
        }
    };
    let along = straight(by).powi(2) - chord.powi(2);
    (radius * angle).hypot(along.max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn arcs_are_as_long_as_they_are() {
        let offset = |x, y| Center::Offsets([Dist::Um(x), Dist::Um(y), Dist::Um(0)]);
        let near = |length: f64, wanted: f64| assert!((length - wanted).abs() < 1.0, "{length}");
        let one = [10.0; 3];
        let xy = |by, clockwise, center: Center| arc(by, clockwise, Plane::Xy, &center, one);
        near(xy([1e4, 1e4, 0.0], false, offset(0, 10_000)), PI * 5e3);
        near(xy([1e4, 1e4, 0.0], true, offset(0, 10_000)), PI * 15e3);
        near(xy([0.0; 3], true, offset(0, 10_000)), PI * 20e3);
        near(xy([1e4, 1e4, 0.0], true, Center::Radius(Dist::Um(10_000))), PI * 5e3);
        near(xy([1e4, 1e4, 0.0], true, Center::Radius(Dist::Steps(-1_000))), PI * 15e3);
        near(xy([0.0, 0.0, 3e4], true, offset(0, 10_000)), (PI * 20e3).hypot(3e4));
        let zx = Center::Offsets([Dist::Um(10_000), Dist::Um(0), Dist::Um(0)]);
        near(arc([1e4, 0.0, 1e4], false, Plane::Zx, &zx, one), PI * 5e3);
    }
}
