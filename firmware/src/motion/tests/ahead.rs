//! What holds on every path of short blocks: feeds under an override, a power that follows the speed, exact stops.

use super::{CLOCK, magnitudes, mill};
use crate::motion::path::geometry::{Geometry, Shape, Tail};
use crate::motion::path::{Block, FOLLOWS, FULL, Feed, Manner, Path, PathSegment};
use crate::motion::scaled::Scaled;
use lang::record::AxisRecord;
use proptest::prelude::*;
use std::f64::consts::TAU;

/// um/s
const FEED: u32 = 20_000;
/// Of a laser at its feed, thousandths.
const POWER: u16 = 400;
/// The start rate, um/s.
const START: u32 = 4_000;

/// A polygon of chords on a circle, a wave, and a row of chords with a right angle in its middle; chords in um.
fn courses() -> [Vec<[i32; 2]>; 3] {
    let at = |n: u32, count: u32| f64::from(n) / f64::from(count) * TAU;
    let round = |radius: f64, count: u32| {
        let place = move |n: u32| [at(n, count).cos() * radius, at(n, count).sin() * radius];
        (0..=count).map(place).collect::<Vec<_>>()
    };
    let wave = (0..=600).map(|n| [f64::from(n) * 100.0, 400.0 * at(n, 150).sin()]).collect();
    let corner = (0..=400).map(|n| [f64::from(n.min(200)) * 150.0, f64::from(n.max(200)) * 150.0]);
    [round(12_000.0, 500), wave, corner.collect()].map(|places: Vec<[f64; 2]>| {
        let places: Vec<_> = places.iter().map(|place| place.map(|um| um.round() as i32)).collect();
        places.windows(2).map(|pair| [0, 1].map(|n| pair[1][n] - pair[0][n])).collect()
    })
}

/// A segment that was played: speed at its end, um/s, its mean speed and its power, and whether a block ends with it.
struct Played {
    exit: u32,
    mean: f64,
    power: u16,
    ends: bool,
}

fn play(course: &[[i32; 2]], percent: u8, manner: Manner) -> Vec<Played> {
    let axes = [mill(); 3];
    let mut path = Path::new(20, CLOCK);
    path.set_override(percent, 100);
    let (mut at, mut steps) = ([0; 2], [0; 2]);
    let (mut blocks, mut begun) = (course.iter(), course.iter());
    let (mut out, mut segment, mut length) = (Vec::<Played>::new(), PathSegment::default(), 0.0);
    loop {
        while path.has_room() {
            let Some(way) = blocks.next() else { break };
            let before = steps;
            at = [at[0] + way[0], at[1] + way[1]];
            steps = at.map(|um: i32| (f64::from(um) / 10.0).round() as i32);
            let by = [steps[0] - before[0], steps[1] - before[1], 0];
            assert!(path.push(&axes, &Block { steps: by, um: [way[0], way[1], 0], manner }));
        }
        if !path.next_segment(&axes, &mut segment) {
            return out;
        }
        if segment.begin {
            if let Some(last) = out.last_mut() {
                last.ends = true;
            }
            let way = segment.way.map(f64::from);
            let events = way[0].abs().max(way[1].abs());
            // What the feed holds along: the axis with most steps by its steps, the other one as commanded.
            let mut um = begun.next().expect("a block begins that was pushed").map(f64::from);
            for (um, steps) in um.iter_mut().zip(way) {
                if steps.abs() == events {
                    *um = steps * 10.0;
                }
            }
            length = um[0].hypot(um[1]) / events;
        }
        let seconds = segment.ramp.duration() as f64 / 65_536.0 / 16e6;
        out.push(Played {
            exit: path.velocity(),
            mean: f64::from(segment.ramp.steps()) * length / seconds,
            power: segment.power,
            ends: false,
        });
    }
}

#[test]
fn an_override_makes_every_path_as_fast_as_it_says() {
    for course in courses() {
        for percent in [50, 100, 200] {
            let wanted = f64::from(FEED) * f64::from(percent) / 100.0;
            let run = play(&course, percent, Manner::new(Feed::Um(FEED), false));
            let fastest = run.iter().map(|one| one.mean).fold(0.0, f64::max);
            assert!((0.99..1.005).contains(&(fastest / wanted)), "{fastest} for {wanted} um/s");
        }
    }
}

#[test]
fn an_override_that_comes_down_holds_at_once() {
    let manner = Manner::new(Feed::Um(FEED), false);
    let axes = [mill(); 3];
    let mut path = Path::new(20, CLOCK);
    path.set_override(200, 100);
    let mut segment = PathSegment::default();
    for n in 0..800 {
        while path.has_room() {
            let block = Block { steps: [10, 0, 0], um: [100, 0, 0], manner };
            assert!(path.push(&axes, &block));
        }
        assert!(path.next_segment(&axes, &mut segment));
        if n == 400 {
            assert!(path.velocity() > 39_000, "{}", path.velocity());
            path.set_override(50, 100);
        }
        // 3 mm of the ramp down, a block of which is one or two segments.
        assert!(n < 480 || path.velocity() <= FEED / 2, "{} at {n}", path.velocity());
    }
}

#[test]
fn a_power_that_follows_is_the_part_of_the_feed_that_the_speed_is() {
    for course in courses() {
        for percent in [50, 100, 200] {
            let manner = Manner { power: POWER | FOLLOWS, ..Manner::new(Feed::Um(FEED), false) };
            for one in play(&course, percent, manner) {
                let wanted = f64::from(POWER) * one.mean / f64::from(FEED);
                // On a ramp the mean of both ends' speeds is not quite the mean speed.
                let off = (f64::from(one.power) - wanted).abs();
                assert!(
                    one.power <= FULL && off <= 0.01 * wanted + 1.0,
                    "{} for {wanted}",
                    one.power
                );
            }
            let manner = Manner { power: POWER, ..Manner::new(Feed::Um(FEED), false) };
            assert!(play(&course, percent, manner).iter().all(|one| one.power == POWER));
        }
    }
}

#[test]
fn an_exact_stop_is_one_at_every_corner() {
    for course in courses() {
        let run = play(&course, 100, Manner::new(Feed::Um(FEED), true));
        let ends = run.iter().filter(|one| one.ends);
        // Along a diagonal both axes start at their rate.
        assert!(ends.clone().all(|one| one.exit <= START * 1415 / 1000), "{START} um/s");
        assert_eq!(ends.count(), course.len() - 1);
        // Without it the same path is as fast as its feed somewhere.
        assert!(run.iter().all(|one| one.mean < f64::from(FEED) * 0.9));
    }
}

/// An axis of any scale up to a thousand steps in a um or um in a step, of any start rate and ramps.
fn axis() -> impl Strategy<Value = AxisRecord> {
    let scale = (magnitudes(1, 1_000), magnitudes(1, 1_000));
    let ramps = (magnitudes(100, 1_000_000), magnitudes(100, 1_000_000));
    (scale, ramps, magnitudes(1, 2_000)).prop_map(|((steps, um), (accel, decel), start_rate)| {
        AxisRecord {
            steps: steps as u16,
            um: um as u16,
            start_rate: start_rate as u16,
            top_rate: 100_000,
            accel,
            decel,
            ..AxisRecord::default()
        }
    })
}

proptest! {
    #[test]
    fn a_corner_asks_no_axis_for_more_than_its_start_rate_or_its_ramp(
        axes in prop::array::uniform3(axis()),
        lines in prop::array::uniform2(prop::array::uniform3(-500..500i32)),
    ) {
        prop_assume!(lines.iter().all(|line| *line != [0; 3]));
        let shapes = lines.each_ref().map(|line| Geometry::of(&axes, &Shape::Line(line, &[0; 3]), Feed::Rapid));
        let [own, next] = shapes;
        let tail = Tail { length: own.length, fast: own.feed, unit: own.unit };
        // Without a tolerance what an axis may jump by is its start rate.
        let speed2 = next.corner2(&axes, &tail, own.ramp().least(next.ramp()), next.feed, 0);
        let real = |of: Scaled| f64::from(of.0 & 0xFF_FFFF) * (f64::from(of.0 >> 24) - 128.0).exp2();
        let (speed, length) = (real(speed2).sqrt(), real(own.length.least(next.length)));
        for (n, axis) in axes.iter().enumerate() {
            let along = |line: &[i32; 3], g: &Geometry| f64::from(line[n]) / real(g.length);
            // In as much time as the shorter line takes.
            let change = speed * (along(&lines[0], &own) - along(&lines[1], &next)).abs();
            prop_assert!(change <= f64::from(axis.start_rate) * 1.001 + 0.1, "{n} jumps by {change}");
            let ramp = change * speed / length;
            prop_assert!(ramp <= f64::from(axis.accel.min(axis.decel)) * 1.001 + 1.0, "{n} needs {ramp}");
        }
    }
}
