//! Planned motion against physics and arithmetic.

use super::physics::{Limits, check, instants};
use super::*;
use lang::record::AxisRecord;
use proptest::prelude::*;

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
fn play(single: &mut Single, axis: &AxisRecord) -> Vec<(bool, Segment)> {
    let mut out = Vec::new();
    let mut s = Segment::default();
    while single.next_segment(axis, &mut s) {
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

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn an_axis_moves_as_its_motor_can(
        distance in -40_000i32..40_000,
        start in 50u16..1500,
        top in 1000u32..60_000,
        accel in 5_000u32..50_000,
        decel in 5_000u32..50_000,
        speed in 1u32..60_000,
    ) {
        prop_assume!(distance.unsigned_abs() < speed * 20);
        let axis = AxisRecord { start_rate: start, top_rate: top, accel, decel, ..mill() };
        let mut single = Single::new(7);
        single.go(&axis, 7 + distance, Pace::of(&axis).with_steps(speed));
        let segments = play(&mut single, &axis);
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
        let mut single = Single::new(0);
        single.go(&axis, first, Pace::of(&axis));
        let mut segments = Vec::new();
        for _ in 0..after {
            let mut s = Segment::default();
            if single.next_segment(&axis, &mut s) {
                segments.push((single.negative(), s));
            }
        }
        if single.is_idle() {
            check_all(&segments, &limits(&axis))?;
            segments.clear();
        }
        single.go(&axis, second, Pace::of(&axis).with_steps(speed));
        segments.extend(play(&mut single, &axis));
        prop_assert_eq!(single.position(), second);
        check_all(&segments, &limits(&axis))?;
    }
}
