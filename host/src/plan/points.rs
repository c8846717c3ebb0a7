//! From a path to the slow points that its instructions bring.
//!
//! All speeds here are squares, (um/s)^2.

use std::collections::{BTreeMap, VecDeque};

use firmware::motion::path::{Geometry, PLANNING};
use firmware::motion::scaled::Scaled;
use lang::back::SlowPoints;

use super::tour::Stop;

/// A slow point is brought where the square of a corner's speed would be lower than this part of what
/// it may be.
const WORTH: f64 = 0.98;
/// A bound is brought up to so many times the fastest square of its path: above, a later instruction
/// raises it again, and the chip's numbers of 24 bits keep their grain. A loop cannot be raised in its
/// middle: so much is half a metre of it and more.
const HIGHEST: f64 = 4096.0;
/// ... and where it would become at least so many times as much.
const GAIN: f64 = 1.02;
/// What the chip may make too much of, of a square: 0.005 % of a speed.
const EXACT: f64 = 1.0001;
/// Attempts to lower bounds that the chip's arithmetic takes too high.
const ATTEMPTS: usize = 64;

/// What bounds corners beside their shape.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// Corner tolerance, um.
    pub corner: u16,
    /// Time that the chip takes to plan a block, us.
    pub planning: Scaled,
}

/// A block of a path, with what binds behind it.
#[derive(Clone, Debug)]
pub struct Leg {
    /// Statements that begin between the block or rest before it and it: places for a slow point.
    places: Vec<usize>,
    /// What it brakes by.
    pub energy: Scaled,
    /// What the chip brakes to where it knows nothing.
    start2: f64,
    /// At its beginning, by everything ahead.
    bound2: f64,
    /// At its end, by what must be foreseen.
    pass2: f64,
    /// At its end, by its corner, too.
    want2: f64,
    /// The last one of its path.
    last: bool,
    /// Fastest square of the path.
    top2: f64,
}

impl Leg {
    /// At its beginning, by everything ahead, no higher than what is worth saying.
    fn offer(&self) -> f64 {
        self.bound2.min(HIGHEST * self.top2)
    }
}

/// The value of a scaled number.
pub fn real(of: Scaled) -> f64 {
    f64::from(of.0 & 0x00FF_FFFF) * 2f64.powi((of.0 >> 24) as i32 - 128)
}

/// The operand of `slow`: the largest that is not above `value`.
pub fn operand(value: f64) -> [u8; 3] {
    let exponent = value.log2().floor() as i32 + 1;
    let mantissa = (value * 2f64.powi(16 - exponent)).floor().min(65_535.0) as u16;
    let [low, high] = mantissa.to_le_bytes();
    [low, high, (exponent + 104) as u8]
}

/// The bound that an operand says.
pub fn bound(operand: [u8; 3]) -> Scaled {
    Scaled(u32::from_le_bytes([0, operand[0], operand[1], operand[2]]))
}

/// Slow points for everything that was executed; `corner` is the corner tolerance in um.
pub fn find(stops: &[Stop], corner: u16) -> SlowPoints {
    let (legs, empty) = legs(stops, Rule { corner, planning: PLANNING });
    // A place that is come to several times may say what holds each time.
    let mut least: BTreeMap<usize, f64> = BTreeMap::new();
    for leg in &legs {
        let bound2 = leg.offer();
        for place in &leg.places {
            let least = least.entry(*place).or_insert(f64::INFINITY);
            *least = least.min(bound2);
        }
    }
    for place in empty {
        least.remove(&place);
    }
    let mut slow = choose(&legs, &least);
    for _ in 0..ATTEMPTS {
        match broken(&legs, &slow) {
            None => return slow,
            Some((place, excess)) => {
                let lower = least.entry(place).or_default();
                *lower = (*lower - 1.1 * excess).max(1.0) * (1.0 - 1.0 / 32_768.0);
                slow.insert(place, operand(*lower));
            }
        }
    }
    SlowPoints::new()
}

/// The blocks of all paths, and the statements behind which no block follows at least once.
fn legs(stops: &[Stop], rule: Rule) -> (Vec<Leg>, Vec<usize>) {
    let mut legs: Vec<Leg> = Vec::new();
    let mut empty = Vec::new();
    let mut places = Vec::new();
    let mut path = Vec::new();
    for stop in stops {
        match *stop {
            Stop::Statement(number) => places.push(number),
            Stop::Block(geometry, unit) => {
                path.push((geometry, unit, std::mem::take(&mut places)));
            }
            Stop::Rest => {
                empty.append(&mut places);
                plan(&mut path, rule, &mut legs);
            }
        }
    }
    empty.append(&mut places);
    plan(&mut path, rule, &mut legs);
    (legs, empty)
}

/// The legs of one path, which is taken: blocks with their directions at their ends and the places before
/// them.
pub fn plan(path: &mut Vec<(Geometry, [i16; 3], Vec<usize>)>, rule: Rule, legs: &mut Vec<Leg>) {
    let top2 = path.iter().map(|(own, ..)| real(own.feed2())).fold(0.0, f64::max);
    let corners: Vec<f64> = path
        .windows(2)
        .map(|pair| {
            let [(own, unit, _), (next, ..)] = pair else { return 0.0 };
            real(next.corner2(unit, own.length(), own.speed(), rule.corner, rule.planning))
                .max(real(own.start2()))
        })
        .collect();
    let first = legs.len();
    let mut ahead = None;
    while let Some((own, _, places)) = path.pop() {
        let (index, energy, start2) = (path.len(), own.energy(), real(own.start2()));
        let (want2, pass2) = match (corners.get(index), ahead) {
            (Some(&corner2), Some(bound2)) => {
                // A corner that can be braked to from the one before it needs no foresight: the chip
                // sees to it when the block behind it is known.
                let before2 = index.checked_sub(1).map_or(start2, |before| corners[before]);
                let binds = before2 > real(energy) + corner2;
                (corner2.min(bound2), if binds { corner2.min(bound2) } else { bound2 })
            }
            _ => (start2, start2),
        };
        let bound2 = pass2 + real(energy);
        let last = ahead.is_none();
        ahead = Some(bound2);
        legs.push(Leg { places, energy, start2, bound2, pass2, want2, last, top2 });
    }
    legs[first..].reverse();
}

/// The slow points without which a corner would be taken slower than it may be.
fn choose(legs: &[Leg], least: &BTreeMap<usize, f64>) -> SlowPoints {
    let mut slow = SlowPoints::new();
    // What a later pass of a loop needs comes in the earlier ones, too.
    let mut grown = true;
    while grown {
        grown = false;
        let mut rest = Scaled::ZERO;
        for (index, leg) in legs.iter().enumerate() {
            for operand in leg.places.iter().filter_map(|place| slow.get(place)) {
                rest = rest.most(bound(*operand));
            }
            if leg.last {
                rest = Scaled::ZERO;
                continue;
            }
            let next = legs.get(index + 1);
            let offers = leg.places.iter().filter_map(|place| Some((*place, *least.get(place)?)));
            let best = offers.max_by(|left, right| left.1.total_cmp(&right.1));
            if let Some((place, offered)) = best.filter(|(_, offered)| *offered >= 1.0) {
                let raised = rest.most(bound(operand(offered)));
                if is_worth(leg, next, rest, raised) {
                    slow.insert(place, operand(offered));
                    rest = raised;
                    grown = true;
                }
            }
            rest = rest.minus(leg.energy);
        }
    }
    slow
}

/// Whether a corner would be taken much slower than it may be with this bound, and less so with that one.
fn is_worth(leg: &Leg, next: Option<&Leg>, rest: Scaled, raised: Scaled) -> bool {
    let own = next.map_or(0.0, |next| real(next.energy) + next.start2);
    let has = |rest: Scaled| real(rest.minus(leg.energy)).max(own).max(leg.start2);
    has(rest) < WORTH * leg.want2 && has(raised) > GAIN * has(rest)
}

/// The slow point that belongs before the first of these legs of one path, if any: `rest` is what the chip
/// may have there without it.
pub fn before(legs: &VecDeque<Leg>, rest: Scaled) -> Option<[u8; 3]> {
    let leg = legs.front().filter(|leg| !leg.last)?;
    let mut offered = leg.offer();
    for _ in 0..ATTEMPTS {
        let said = Some(offered).filter(|offered| *offered >= 1.0).map(operand)?;
        let raised = rest.most(bound(said));
        if !is_worth(leg, legs.get(1), rest, raised) {
            return None;
        }
        let mut left = raised;
        let excess = legs.iter().find_map(|leg| {
            left = left.minus(leg.energy);
            (real(left) > leg.pass2 * EXACT).then(|| real(left) - leg.pass2)
        });
        let Some(excess) = excess else { return Some(said) };
        offered = (offered - 1.1 * excess) * (1.0 - 1.0 / 32_768.0);
    }
    None
}

/// The place whose bound lets the chip, in its own arithmetic, come faster somewhere than what lies
/// ahead allows, and by how much, (um/s)^2.
fn broken(legs: &[Leg], slow: &SlowPoints) -> Option<(usize, f64)> {
    let mut rest = Scaled::ZERO;
    let mut raised_by = None;
    for leg in legs {
        for place in &leg.places {
            if let Some(own) = slow.get(place).map(|operand| bound(*operand))
                && own > rest
            {
                rest = own;
                raised_by = Some(*place);
            }
        }
        rest = rest.minus(leg.energy);
        if real(rest) > leg.pass2 * EXACT {
            return raised_by.map(|place| (place, real(rest) - leg.pass2));
        }
        if leg.last {
            rest = Scaled::ZERO;
        }
    }
    None
}
