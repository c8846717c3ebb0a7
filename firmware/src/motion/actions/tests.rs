use super::*;
use proptest::prelude::*;

fn mul_div(a: u32, b: u32, c: u32) -> u32 {
    (u64::from(a) * u64::from(b)).checked_div(c.into()).map_or(u32::MAX, |n| n as u32)
}

/// An engine that plays segments of `(um, units)`, `held` of them ahead, looked at every `pass` units; the times at
/// which outputs are carried out, after the start of the first segment.
fn played(actions: &mut Actions, segments: &[(u32, u16)], held: u16, pass: u16) -> Vec<(u8, i32)> {
    let (mut place, mut next, mut ends, mut now) = (0, 0, Vec::new(), 0_i32);
    let mut done = Vec::new();
    actions.begin(0, 0);
    let total: i32 = segments.iter().map(|own| i32::from(own.1)).sum();
    while now <= total + i32::from(pass) {
        let mut end = ends.last().copied().unwrap_or(0);
        while next < segments.len() && end - now < i32::from(held) {
            let (way, time) = segments[next];
            actions.hand_out(place, place + way, time, mul_div);
            place += way;
            end += i32::from(time);
            ends.push(end);
            next += 1;
        }
        let playing = ends.iter().copied().find(|end| *end > now).unwrap_or(end);
        actions.follow((end - playing) as u16, now < total, now as u16, 1);
        while let Some(action) = actions.take_due(100) {
            done.push((action.output(), now));
        }
        now += i32::from(pass);
    }
    done
}

#[test]
fn one_at_a_boundary_comes_when_the_next_segment_begins() {
    let mut actions = Actions::default();
    actions.begin(0, 0);
    actions.add(Action::new(1, true), 2000, None);
    actions.add(Action::new(2, true), 2500, None);
    actions.add(Action { lead: 5, ..Action::new(3, true) }, 3000, None);
    // The end of all, behind which nothing comes.
    actions.add(Action::new(4, true), 4000, None);
    let done = played(&mut actions, &[(1000, 800); 4], 2400, 10);
    let at = |n: u8| done.iter().find(|own| own.0 == n).map(|own| own.1).expect("carried out");
    assert!((1580..=1610).contains(&at(1)), "{done:?}");
    assert!((1980..=2010).contains(&at(2)), "{done:?}");
    assert!((1880..=1910).contains(&at(3)), "{done:?}");
    assert_eq!(done.len(), 3);
    assert_eq!(actions.flush(None).map(|own| own.output()), Some(4));
    assert!(actions.is_empty());
}

#[test]
fn a_lag_and_a_pulse_are_counted_in_milliseconds() {
    let mut actions = Actions::default();
    actions.begin(0, 0);
    actions.add(Action { lead: -3, pulse: 2, ..Action::new(1, true) }, 0, None);
    assert!(actions.flush(None).is_none());
    let mut seen = Vec::new();
    for ms in 1..=8 {
        actions.tick(0);
        while let Some(action) = actions.take_due(100) {
            seen.push((ms, action.is_on()));
        }
    }
    assert_eq!(seen, [(3, true), (5, false)]);
    assert!(actions.is_empty());
}

#[test]
fn what_is_dropped_tells_which_pulses_last() {
    let mut actions = Actions::default();
    actions.add(Action { pulse: 9, ..Action::new(5, true) }, 0, None);
    actions.add(Action::new(3, true), 7, None);
    assert!(actions.flush(None).is_some_and(|own| own.is_on() && own.output() == 5));
    assert_eq!(actions.drop_all(), 1 << 4);
    assert!(actions.is_empty() && actions.flush(None).is_none());
}

#[test]
fn those_after_the_end_keep_their_places() {
    let mut actions = Actions::default();
    for at in [900, 1000, 1001] {
        actions.add(Action::new(1, at != 1001), at, None);
        assert!(actions.all_lie_beyond(899));
        assert!(!actions.all_lie_beyond(1000));
    }
    assert!(actions.flush(Some(1000)).is_some() && actions.flush(Some(1000)).is_some());
    assert!(actions.flush(Some(1000)).is_none() && actions.all_lie_beyond(1000));
    assert!(actions.take_off().is_some() && actions.take_off().is_none());
}

#[test]
fn the_newest_command_on_an_output_counts() {
    let mut actions = Actions::default();
    let pulse = |n, ms| Action { pulse: ms, ..Action::new(n, true) };
    for (n, ms) in [(3, 5), (4, 5), (3, 9)] {
        actions.add(pulse(n, ms), 0, None);
        assert!(actions.flush(None).is_some_and(|own| own.is_on()));
    }
    let mut ends = Vec::new();
    for ms in 1..=5 {
        actions.tick(0);
        while let Some(own) = actions.take_due(100) {
            ends.push((ms, own.output(), own.is_on()));
        }
    }
    assert_eq!(ends, [(5, 4, false)], "output 3 stays on for 9 ms");
    actions.tick(1 << 2);
    actions.take_over(1 << 3);
    assert!(!actions.is_empty(), "of another output");
    actions.take_over(1 << 2);
    assert!(actions.is_empty());
}

#[test]
fn what_a_pause_keeps_off_has_its_length_after_it() {
    let mut actions = Actions::default();
    actions.add(Action { pulse: 2, ..Action::new(3, true) }, 0, None);
    assert!(actions.flush(None).is_some());
    let mut ends = Vec::new();
    for (ms, held) in [(1, 1 << 2), (2, 1 << 2), (3, 1 << 3), (4, 0)] {
        actions.tick(held);
        ends.extend(actions.take_due(100).map(|_| ms));
    }
    assert_eq!(ends, [4]);
}

#[test]
fn what_switches_off_is_taken_alone() {
    let mut actions = Actions::default();
    actions.add(Action { pulse: 9, ..Action::new(5, true) }, 0, None);
    assert!(actions.flush(None).is_some());
    actions.add(Action::new(3, true), 7, None);
    actions.add(Action { lead: -4, ..Action::new(2, false) }, 7, None);
    let off: Vec<u8> = std::iter::from_fn(|| actions.take_off()).map(|own| own.output()).collect();
    assert_eq!(off, [5, 2]);
    assert_eq!(actions.drop_all(), 0);
}

#[test]
fn a_value_of_an_analog_output_leaves_the_pulse_of_the_same_number_alone() {
    let mut actions = Actions::default();
    actions.add(Action { pulse: 2, ..Action::new(1, true) }, 0, None);
    assert!(actions.flush(None).is_some_and(|own| own.is_on()));
    for (value, on) in [(700, true), (0, false)] {
        actions.add(Action::analog(1, value, on), 0, None);
        let own = actions.flush(None).expect("the value");
        assert_eq!((own.output(), own.is_analog(), own.pulse), (1, true, value));
    }
    actions.take_over(1 << 1);
    actions.tick(0);
    actions.tick(0);
    let end = actions.take_due(100).expect("the pulse's end");
    assert!(!end.is_on() && !end.is_analog() && end.output() == 1);
    assert!(actions.is_empty());
}

#[test]
fn a_safe_value_is_one_that_switches_off() {
    let mut actions = Actions::default();
    actions.add(Action::analog(1, 0, true), 7, None);
    actions.add(Action::analog(1, 500, false), 9, None);
    assert_eq!(actions.take_off().map(|own| own.pulse), Some(500));
    assert!(actions.take_off().is_none());
    assert_eq!(actions.drop_all(), 0, "no output is kept on by a pulse");
}

#[test]
fn no_more_than_there_is_room_for_are_taken() {
    let mut actions = Actions::default();
    for n in 0..ROOM {
        assert!(actions.has_room(), "{n}");
        actions.add(Action::new(1, n % 2 == 0), n as u32, None);
    }
    assert!(!actions.has_room());
    let mut count = 0;
    while actions.flush(None).is_some() {
        count += 1;
    }
    assert_eq!(count, ROOM);
}

proptest! {
    /// Each comes once, in order at its place, no earlier than half a pass before it and no later than a pass behind it.
    #[test]
    fn all_come_at_their_places(
        segments in prop::collection::vec((1..3000_u32, 100..1500_u16), 1..40),
        places in prop::collection::vec(0..1000_u32, 1..ROOM),
        pass in 1..90_u16,
    ) {
        let all: u32 = segments.iter().map(|own| own.0).sum();
        let places: Vec<u32> = places.iter().map(|part| all * part / 1000).filter(|own| *own < all).collect();
        let mut actions = Actions::default();
        actions.begin(0, 0);
        for (n, place) in places.iter().enumerate() {
            actions.add(Action::new(n as u8 + 1, true), *place, None);
        }
        let done = played(&mut actions, &segments, 2400, pass);
        prop_assert_eq!(done.len(), places.len());
        for (n, at) in done {
            let place = places[usize::from(n) - 1];
            let (mut way, mut time) = (0, 0.0);
            for (um, units) in &segments {
                let part = (f64::from(place - way) / f64::from(*um)).min(1.0);
                time += part * f64::from(*units);
                if part < 1.0 {
                    break;
                }
                way += um;
            }
            let off = f64::from(at) - time;
            let late = 2.0 * f64::from(pass) + 2.0;
            prop_assert!((-f64::from(EARLY) - 2.0..=late).contains(&off), "{} off", off);
        }
    }
}
