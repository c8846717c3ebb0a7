//! Beads: a long, narrow pad gets a line of paste on the way instead of dots.
//!
//! The valve gives a constant flow, so what a pad gets is set by the speed: a bead of length L at speed v
//! takes L / v, and the flow times that is the pad's area times the stencil's thickness.

use super::dots::axis;
use super::needle::{Bead as Asked, Needle};
use super::outline::Spot;
use super::pads::Pad;

/// Length over width from which a pad is narrow.
const NARROW: f64 = 2.0;
/// Places along a line that must lie on the pad.
const LOOKS: usize = 40;

/// A line of paste.
#[derive(Clone, Debug, PartialEq)]
pub struct Bead {
    /// Where it begins and where it ends, mm.
    pub ends: [Spot; 2],
    /// Speed of the needle, mm/s.
    pub speed: f64,
    /// Number of its pad.
    pub pad: usize,
}

/// The middle line of a pad that is long and narrow enough for a bead, half a width short of both
/// ends; none for any other pad.
pub fn line(pad: &Pad, asked: &Asked) -> Option<[Spot; 2]> {
    let area = pad.area?;
    let (along, ratio) = axis(pad);
    if ratio < NARROW {
        return None;
    }
    let far = |cell: &Spot| (cell[0] - pad.at[0]) * along[0] + (cell[1] - pad.at[1]) * along[1];
    let low = pad.cells.iter().map(far).fold(f64::INFINITY, f64::min);
    let high = pad.cells.iter().map(far).fold(f64::NEG_INFINITY, f64::max);
    let (length, width) = (high - low, area / (high - low));
    if length < asked.from {
        return None;
    }
    let place = |at: f64| [pad.at[0] + along[0] * at, pad.at[1] + along[1] * at];
    let (first, last) = (low + width / 2.0, high - width / 2.0);
    // A bent pad, or one with a hole, has its middle line beside itself.
    let on_pad = |n: usize| {
        let [x, y] = place(first + (last - first) * n as f64 / LOOKS as f64);
        pad.cells.iter().any(|cell| (cell[0] - x).hypot(cell[1] - y) < width / 4.0)
    };
    (0..=LOOKS).all(on_pad).then(|| [place(first), place(last)])
}

/// The speed at which a line gives what a pad's stencil would, mm/s, within the asked range.
pub fn speed(pad: &Pad, ends: [Spot; 2], needle: &Needle, asked: &Asked) -> f64 {
    let length = (ends[1][0] - ends[0][0]).hypot(ends[1][1] - ends[0][1]);
    // Of one dot in `ms`, as mm2 of stencil a second.
    let flow = needle.area() / (f64::from(needle.ms) / 1000.0);
    (flow * length / pad.area.unwrap_or(1.0)).clamp(asked.slowest, asked.fastest)
}

/// What a bead gives of what the pad's stencil would: 1 is all of it.
pub fn given(bead: &Bead, pad: &Pad, needle: &Needle) -> f64 {
    let [a, b] = bead.ends;
    let seconds = (b[0] - a[0]).hypot(b[1] - a[1]) / bead.speed;
    let flow = needle.area() / (f64::from(needle.ms) / 1000.0);
    flow * seconds / pad.area.unwrap_or(1.0)
}

/// Brings beads into an order with a short way: from the end of each to the nearest end of another.
pub fn order(mut beads: Vec<Bead>, mut at: Spot) -> Vec<Bead> {
    let far = |a: Spot, b: Spot| (a[0] - b[0]).hypot(a[1] - b[1]);
    for n in 0..beads.len() {
        let near = |bead: &Bead| far(at, bead.ends[0]).min(far(at, bead.ends[1]));
        let nearest = (n..beads.len()).min_by(|a, b| near(&beads[*a]).total_cmp(&near(&beads[*b])));
        beads.swap(n, nearest.unwrap_or(n));
        if far(at, beads[n].ends[1]) < far(at, beads[n].ends[0]) {
            beads[n].ends.reverse();
        }
        at = beads[n].ends[1];
    }
    beads
}

/// The way along beads and between them, mm.
pub fn way(beads: &[Bead]) -> f64 {
    let far = |a: Spot, b: Spot| (a[0] - b[0]).hypot(a[1] - b[1]);
    let along: f64 = beads.iter().map(|bead| far(bead.ends[0], bead.ends[1])).sum();
    let between = beads.windows(2).map(|pair| far(pair[0].ends[1], pair[1].ends[0]));
    along + between.sum::<f64>()
}
