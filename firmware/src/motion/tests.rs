//! Planned motion against physics and arithmetic.

mod ahead;

use super::physics::{Limits, TICKS_PER_SECOND, check, instants};
use super::scaled::Scaled;
use super::*;
use lang::record::AxisRecord;
use proptest::prelude::*;

/// The step timer's rate.
const CLOCK: Scaled = Scaled::constant(physics::TICKS_PER_SECOND);

fn mill() -> AxisRecord {
    AxisRecord {
        steps: 400,
        um: 4000,
        start_rate: 400,
        top_rate: 8_000,
        accel: 25_000,
        decel: 25_000,
        ..AxisRecord::default()
    }
}

fn limits(axis: &AxisRecord) -> Limits {
    Limits {
        start: axis.start_rate.into(),
        top: axis.top_rate.into(),
        accel: axis.accel.into(),
        decel: axis.decel.into(),
    }
}

/// Plays an axis to rest: its segments, each with its direction.
fn play(single: &mut Single) -> Vec<(bool, Segment)> {
    let mut out = Vec::new();
    let mut s = Segment::default();
    while single.next_segment(&mut s) {
        out.push((single.negative(), s));
    }
    out
}

/// Checks stretches of one direction each.
fn check_all(segments: &[(bool, Segment)], limits: &Limits) -> Result<(), TestCaseError> {
    for run in segments.chunk_by(|a, b| a.0 == b.0) {
        let times = instants(run.iter().map(|s| &s.1), 0);
        check(&times, limits).map_err(|v| TestCaseError::fail(format!("{v:?}")))?;
    }
    Ok(())
}

/// Numbers whose magnitudes, not values, are equally likely: what a profile may hold.
fn magnitudes(least: u32, most: u32) -> impl Strategy<Value = u32> {
    let (least, most) = (f64::from(least), f64::from(most));
    (0.0..=1.0f64).prop_map(move |part| (least * (most / least).powf(part)).round() as u32)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// Ramps steeper than are promised still lead to the target, in intervals that the timer has.
    #[test]
    fn every_profile_leads_to_the_target(
        distance in -40_000i32..40_000,
        start in magnitudes(1, 60_000),
        top in magnitudes(1, 60_000),
        accel in magnitudes(100, 10_000_000),
        decel in magnitudes(100, 10_000_000),
        speed in magnitudes(1, 60_000),
    ) {
        // No longer than 20 s.
        let distance = distance % (20 * speed.min(top) as i32);
        let start = start.min(top) as u16;
        let axis = AxisRecord { start_rate: start, top_rate: top, accel, decel, ..mill() };
        let mut single = Single::new(0, CLOCK);
        single.go(&axis, distance, Pace::of(&axis).with_steps(speed));
        let mut steps = 0;
        for (_, segment) in play(&mut single) {
            let last = i64::from(segment.interval)
                + i64::from(segment.dif) * (i64::from(segment.events) - 1);
            prop_assert!((1 << 16..1 << 31).contains(&last.min(segment.interval.into())));
            prop_assert!(last.max(segment.interval.into()) < 1 << 31);
            prop_assert_eq!(segment.events & segment.mask, 0);
            steps += u32::from(segment.steps());
        }
        prop_assert_eq!((single.position(), steps), (distance, distance.unsigned_abs()));
    }

    #[test]
    fn an_axis_moves_as_its_motor_can(
        distance in -40_000i32..40_000,
        start in magnitudes(1, 60_000),
        top in magnitudes(1, 60_000),
        accel in magnitudes(100, 100_000),
        decel in magnitudes(100, 100_000),
        speed in magnitudes(1, 60_000),
    ) {
        // No longer than 20 s.
        let distance = distance % (20 * speed.min(top) as i32);
        let start = start.min(top) as u16;
        let axis = AxisRecord { start_rate: start, top_rate: top, accel, decel, ..mill() };
        let mut single = Single::new(7, CLOCK);
        single.go(&axis, 7 + distance, Pace::of(&axis).with_steps(speed));
        let segments = play(&mut single);
        prop_assert_eq!(single.position(), 7 + distance);
        check_all(&segments, &limits(&axis))?;
    }

    #[test]
    fn a_new_target_on_the_fly_is_reached_within_the_ramps(
        first in -20_000i32..20_000,
        second in -20_000i32..20_000,
        after in 0usize..60,
        speed in 100u32..8_000,
    ) {
        let axis = mill();
        let mut single = Single::new(0, CLOCK);
        single.go(&axis, first, Pace::of(&axis));
        let mut segments = Vec::new();
        for _ in 0..after {
            let mut s = Segment::default();
            if single.next_segment(&mut s) {
                segments.push((single.negative(), s));
            }
        }
        if single.is_idle() {
            check_all(&segments, &limits(&axis))?;
            segments.clear();
        }
        single.go(&axis, second, Pace::of(&axis).with_steps(speed));
        segments.extend(play(&mut single));
        prop_assert_eq!(single.position(), second);
        check_all(&segments, &limits(&axis))?;
    }
}

/// A path's steps: instants of the events, ticks, and the positions after them.
fn play_path(path: &mut Path, axes: &[AxisRecord; 3], from: [i32; 3]) -> Vec<(u64, [i32; 3])> {
    let mut segment = PathSegment::default();
    let (mut acc, mut position, mut time) = ([0; 3], from, 0);
    let mut out = vec![(0, from)];
    while path.next_segment(axes, &mut segment) {
        let s = segment.ramp;
        for instant in instants([&s], 0) {
            segment.played(1, &mut acc, &mut position);
            segment.begin = false;
            out.push((time + (instant << 16), position));
        }
        time += s.duration();
    }
    for p in &mut out {
        p.0 >>= 16;
    }
    out
}

fn arcs() -> impl Strategy<Value = (Ends, [i32; 2])> {
    let radius = prop_oneof![50i32..2_000, 2_000i32..60_000];
    (radius, 0.0f64..6.25, 0.02f64..6.25, any::<bool>(), 0u8..3, -3_000i32..3_000, any::<bool>())
        .prop_map(|(r, from, sweep, clockwise, first, rise, full)| {
            let point =
                |a: f64| [(f64::from(r) * a.cos()).round(), (f64::from(r) * a.sin()).round()];
            let to = if clockwise { from - sweep } else { from + sweep };
            let (p, mut q) = (point(from), point(to));
            if full {
                q = p;
            }
            let (a, b) = (usize::from(first), (usize::from(first) + 1) % 3);
            let c = 3 - a - b;
            let mut to_um = [20_000, -7_000, 3_000];
            let from_um = to_um;
            to_um[a] += (q[0] - p[0]) as i32;
            to_um[b] += (q[1] - p[1]) as i32;
            to_um[c] += rise;
            let steps = |um: [i32; 3]| um.map(|um| (f64::from(um) / 10.0).round() as i32);
            let ends =
                Ends { first, clockwise, from_um, to_um, start: steps(from_um), end: steps(to_um) };
            (ends, [-p[0] as i32, -p[1] as i32])
        })
}

/// Plays blocks as fast as they are taken: the segments, and where they end.
fn play_blocks(axes: &[AxisRecord; 3], blocks: &[Block]) -> (Vec<(bool, Segment)>, [i32; 3]) {
    let mut path = Path::new(20, CLOCK);
    let (mut acc, mut position) = ([0; 3], [0; 3]);
    let (mut out, mut segment) = (Vec::new(), PathSegment::default());
    let mut blocks = blocks.iter();
    loop {
        while path.has_room() {
            let Some(block) = blocks.next() else { break };
            assert!(path.push(axes, block));
        }
        if !path.next_segment(axes, &mut segment) {
            return (out, position);
        }
        segment.played(segment.ramp.steps(), &mut acc, &mut position);
        out.push((segment.negative & 1 != 0, segment.ramp));
    }
}

fn way() -> impl Strategy<Value = i32> {
    prop_oneof![4 => -9..9i32, 4 => -400..400i32, 1 => -70_000..70_000i32]
}

proptest! {
    /// However long they are and however many wait: every step is made.
    #[test]
    fn blocks_in_a_row_end_where_they_shall(
        ways in prop::collection::vec([way(), way(), way()], 1..150),
        accel in magnitudes(1_000, 1_000_000),
        feed in magnitudes(1_000, 100_000),
    ) {
        let axis = AxisRecord { accel, decel: accel / 2, ..mill() };
        let axes = [axis, AxisRecord { start_rate: 100, ..axis }, AxisRecord { um: 1_000, ..axis }];
        let manner = Manner::new(Feed::Um(feed), false);
        let blocks: Vec<_> =
            ways.iter().map(|steps| Block { steps: *steps, um: [0; 3], manner }).collect();
        let (_, position) = play_blocks(&axes, &blocks);
        for axis in 0..3 {
            prop_assert_eq!(position[axis], ways.iter().map(|way| way[axis]).sum::<i32>());
        }
    }

    /// A row of blocks in one direction is one long move with changing speeds, within the ramps from its first step to
    /// its last. Feeds are above the start rate, below which an axis jumps.
    #[test]
    fn blocks_in_one_direction_keep_the_ramps(
        ways in prop::collection::vec((way(), magnitudes(20_000, 100_000)), 1..150),
        start in magnitudes(100, 2_000),
        accel in magnitudes(1_000, 100_000),
        decel in magnitudes(1_000, 100_000),
    ) {
        let axis = AxisRecord { start_rate: start as u16, accel, decel, ..mill() };
        let block = |(way, feed): &(i32, u32)| {
            let manner = Manner::new(Feed::Um(*feed), false);
            Block { steps: [way.abs(), 0, 0], um: [0; 3], manner }
        };
        let blocks: Vec<_> = ways.iter().map(block).collect();
        let (segments, _) = play_blocks(&[axis; 3], &blocks);
        check_all(&segments, &limits(&axis))?;
    }

    /// At a right angle of one axis and another, with no tolerance, each begins as it may from rest, however fast the
    /// other one is there: X a hundred times as fast as Y, or Y as X, is a machine.
    #[test]
    fn a_line_begins_no_faster_than_its_own_axis_may(
        ways in prop::collection::vec(prop_oneof![-9..9i32, -400..400i32], 2..100),
        machine in prop::array::uniform2((
            magnitudes(1, 3_000), magnitudes(1, 3_000), magnitudes(1, 600), magnitudes(1_000, 100_000),
        )),
        feed in magnitudes(1_000, 100_000),
    ) {
        let axes = [0, 1, 0].map(|n: usize| {
            let (steps, um, start, accel) = machine[n];
            AxisRecord {
                steps: steps as u16, um: um as u16, start_rate: start as u16, top_rate: 10 * start,
                accel, decel: accel, ..mill()
            }
        });
        let manner = Manner::new(Feed::Um(feed), false);
        let mut path = Path::new(0, CLOCK);
        let mut blocks = ways.iter().enumerate().map(|(n, way)| {
            let mut steps = [0; 3];
            steps[n % 2] = *way;
            Block { steps, um: [0; 3], manner }
        });
        let mut segment = PathSegment::default();
        let mut waits = blocks.next();
        let mut before = None;
        loop {
            while let (true, Some(block)) = (path.has_room(), &waits) {
                prop_assert!(path.push(&axes, block));
                waits = blocks.next();
            }
            if !path.next_segment(&axes, &mut segment) {
                break;
            }
            let moved = usize::from(segment.way[0] == 0);
            if segment.begin && before.replace(moved) != Some(moved) {
                let start = f64::from(axes[moved].start_rate);
                let most = (start * start + 2.0 * f64::from(axes[moved].accel)).sqrt();
                let interval = f64::from(segment.ramp.interval) * f64::from(segment.ramp.mask + 1);
                let rate = 65_536.0 * f64::from(TICKS_PER_SECOND) / interval;
                prop_assert!(rate < most * 1.05, "{} begins with {} steps/s of {}", moved, rate, start);
            }
            segment.begin = false;
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn an_arc_stays_within_a_step_of_its_circle((ends, offset) in arcs(), feed in 500u32..60_000) {
        let axes = [mill(); 3];
        let arc = ends.around(offset).unwrap();
        let mut path = Path::new(20, CLOCK);
        prop_assert!(path.push_arc(&axes, &arc, &Manner::new(Feed::Um(feed), true)));
        let made = play_path(&mut path, &axes, ends.start);
        prop_assert_eq!(made.last().unwrap().1, ends.end);
        let [a, b, _] = arc.axes();
        let radius = f64::from(arc.from[0]).hypot(f64::from(arc.from[1])) / 10.0;
        let mut worst = 0.0f64;
        for (_, p) in &made {
            let x = f64::from(p[a]) - f64::from(arc.center[0]) / 10.0;
            let y = f64::from(p[b]) - f64::from(arc.center[1]) / 10.0;
            worst = worst.max((x.hypot(y) - radius).abs());
        }
        prop_assert!(worst < 1.0, "{} steps off a circle of {}", worst, radius);
    }
}

#[test]
fn an_arc_keeps_its_feed() {
    let axes = [mill(); 3];
    for (radius, feed) in [(5_000, 20_000u32), (10_000, 45_000), (50_000, 70_000), (1_000, 2_000)] {
        let ends = Ends {
            first: 0,
            clockwise: false,
            from_um: [radius, 0, 0],
            to_um: [radius, 0, 0],
            start: [radius / 10, 0, 0],
            end: [radius / 10, 0, 0],
        };
        let arc = ends.around([-radius, 0]).unwrap();
        let mut path = Path::new(20, CLOCK);
        assert!(path.push_arc(&axes, &arc, &Manner::new(Feed::Um(feed), true)));
        let made = play_path(&mut path, &axes, ends.start);
        let mut cruise = 0;
        // Speed between points 60 steps apart, by the angle between them: a position is known to
        // 0.7 steps at either end.
        let angle = |p: &[i32; 3]| f64::from(p[1]).atan2(f64::from(p[0]));
        let ramp = 2.0 * f64::from(feed) / 250_000.0 * 16e6;
        let end = made.last().unwrap().0 as f64;
        for pair in made.windows(101) {
            let ((t0, p0), (t1, p1)) = (&pair[0], &pair[100]);
            if (*t0 as f64) < ramp || (*t1 as f64) > end - ramp {
                continue;
            }
            let turn = (angle(p1) - angle(p0)).rem_euclid(std::f64::consts::TAU);
            let speed = turn * f64::from(radius) / (t1 - t0) as f64 * 16e6;
            let share = speed / f64::from(feed);
            assert!((share - 1.0).abs() < 0.02 + 0.01, "{share} of {feed} at radius {radius}");
            cruise += 1;
        }
        assert!(cruise > 100, "{cruise}");
        // Whole turn in the time that its length and ramps take.
        let length = std::f64::consts::TAU * f64::from(radius);
        let (v, v0, a) = (f64::from(feed), 4_000.0f64.min(f64::from(feed)), 250_000.0);
        let want = 2.0 * (v - v0) / a + (length - (v * v - v0 * v0) / a) / v;
        assert!((end / 16e6 / want - 1.0).abs() < 0.01, "{} s for {want} s", end / 16e6);
    }
}

#[test]
fn a_polygon_of_half_millimetres_runs_at_its_feed() {
    let axes = [mill(); 3];
    let mut path = Path::new(20, CLOCK);
    let corner = |k: i32| {
        let a = f64::from(k) * 0.05;
        [(1000.0 * a.cos()).round() as i32, (1000.0 * a.sin()).round() as i32, 0]
    };
    let (mut k, mut segment, mut slow, mut time) = (0, PathSegment::default(), 0, 0);
    for _ in 0..10_000 {
        while k < 126 && path.has_room() {
            let (a, b) = (corner(k), corner(k + 1));
            let steps = [b[0] - a[0], b[1] - a[1], 0];
            let manner = Manner::new(Feed::Um(15_000), false);
            assert!(path.push(&axes, &Block { steps, um: [0; 3], manner }));
            k += 1;
        }
        if !path.next_segment(&axes, &mut segment) {
            break;
        }
        // The ramp up takes 44 ms.
        time += segment.ramp.duration() >> 16;
        let cruises = time > u64::from(TICKS_PER_SECOND / 20) && k < 124;
        slow += u32::from(cruises && path.velocity() < 14_600);
    }
    assert_eq!((k, slow), (126, 0));
}

#[test]
fn a_radius_finds_its_centre_and_a_bad_arc_is_refused() {
    let ends = |to: [i32; 2], clockwise| Ends {
        first: 0,
        clockwise,
        from_um: [0; 3],
        to_um: [to[0], to[1], 0],
        start: [0; 3],
        end: [to[0] / 10, to[1] / 10, 0],
    };
    let centre = |to, clockwise, r| ends(to, clockwise).with_radius(r).map(|arc| arc.center);
    assert_eq!(centre([10_000, 10_000], false, 10_000), Ok([0, 10_000]));
    assert_eq!(centre([10_000, 10_000], true, 10_000), Ok([10_000, 0]));
    assert_eq!(centre([10_000, 10_000], false, -10_000), Ok([10_000, 0]));
    assert_eq!(centre([10_000, 0], false, 5_000), Ok([5_000, 0]));
    assert_eq!(centre([10_000, 0], false, 4_998), Ok([5_000, 0]));
    assert!(centre([10_000, 0], false, 4_900).is_err());
    assert!(centre([0, 0], false, 5_000).is_err());
    assert!(ends([10_000, 0], false).around([5_000, 0]).is_ok());
    assert!(ends([10_000, 0], false).around([5_006, 0]).is_err());
    assert!(ends([10_000, 0], false).around([0, 0]).is_err());
    let arc = ends([10_000, 10_000], false).around([0, 10_000]).unwrap();
    assert_eq!(arc.extremes(), [[0, 10_000], [0, 10_000]]);
    let arc = ends([10_000, 10_000], true).around([0, 10_000]).unwrap();
    assert_eq!(arc.extremes(), [[-10_000, 10_000], [0, 20_000]]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// No axis record, feed or distance may hang the planner, divide by zero or miss the target.
    #[test]
    fn any_axis_and_any_block_come_to_their_end(
        start in 0u16..,
        top in prop_oneof![0u32..2, 1u32..200_000],
        accel in prop_oneof![0u32..2, 0u32..1_000_000],
        scale in (1u16.., 1u16..),
        steps in prop::array::uniform3(-300i32..300),
        feed in prop_oneof![0u32..3, 0u32..3_000_000],
        in_steps: bool,
        percent: u8,
    ) {
        let axis = AxisRecord {
            start_rate: start, top_rate: top, accel, decel: accel, steps: scale.0, um: scale.1,
            ..AxisRecord::default()
        };
        let axes = [axis; 3];
        let mut path = Path::new(20, CLOCK);
        path.set_override(percent, percent / 2);
        let feed = if in_steps { Feed::Steps(feed) } else { Feed::Um(feed) };
        let manner = Manner::new(feed, false);
        let taken = path.push(&axes, &Block { steps, um: [0; 3], manner });
        prop_assert!(taken);
        let (mut segment, mut acc, mut position) = (PathSegment::default(), [0; 3], [0; 3]);
        for _ in 0..4_000 {
            if !path.next_segment(&axes, &mut segment) {
                break;
            }
            prop_assert!(segment.ramp.interval < 1 << 31 && segment.ramp.events > 0);
            segment.played(segment.ramp.steps(), &mut acc, &mut position);
        }
        prop_assert!(path.is_idle());
        prop_assert_eq!(position, steps);
        let mut single = Single::new(0, CLOCK);
        single.go(&axis, steps[0], Pace::of(&axis).with_um(&axis, 77));
        play(&mut single);
        prop_assert_eq!(single.position(), steps[0]);
        single.go(&axis, 0, Pace::of(&axis));
        let mut s = Segment::default();
        single.next_segment(&mut s);
        single.hit(&axis, single.position());
        play(&mut single);
        prop_assert!(single.is_idle());
    }
}
