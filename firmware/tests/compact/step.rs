//! Motions at the pins: the whole image runs from reset, its main loop, its link and its interrupts,
//! and every step edge is held to what `firmware::motion` plans.

mod late;
mod rig;

use firmware::motion::physics;
use firmware::motion::scaled::Scaled;
use firmware::motion::{Feed, Pace, Segment, Single};
use lang::record::AxisRecord;
use proptest::prelude::*;

use self::rig::{MS, Machine, Plan, STEP, Step};
use crate::chip::CLOCK;
use crate::machine::mill;
use crate::ramp::PAUSE;

/// Ramps of single axes at the most, steps/s2.
const STEEP: u32 = 50_000;

/// Every edge must lie on the tick of the plan, seen from the first one: none was armed late.
fn agree(made: &[Vec<Step>; 3], plan: &Plan) -> Result<(), TestCaseError> {
    let first = |steps: &[Vec<Step>; 3]| steps.iter().flatten().map(|step| step.0).min();
    let (from, begin) = (first(&plan.steps).unwrap_or(0), first(made).unwrap_or(0));
    for (a, (made, planned)) in made.iter().zip(&plan.steps).enumerate() {
        for (n, (m, p)) in made.iter().zip(planned).enumerate() {
            prop_assert_eq!(m.0 - begin, p.0 - from, "axis {}, step {}", a, n);
            prop_assert_eq!(m.1, p.1, "direction of axis {} at step {}", a, n);
        }
        prop_assert_eq!(made.len(), planned.len(), "steps of axis {}", a);
    }
    Ok(())
}

/// What the motor of an axis can follow.
fn bounds(axis: &AxisRecord) -> physics::Limits {
    physics::Limits {
        start: axis.start_rate.into(),
        top: axis.top_rate.into(),
        accel: axis.accel.into(),
        decel: axis.decel.into(),
    }
}

/// An axis of a machine that somebody could build.
fn axis() -> impl Strategy<Value = AxisRecord> {
    (200u16..1_000, 2_000u32..20_000, 20_000u32..200_000, 20_000u32..200_000, 1u16..5).prop_map(
        |(start_rate, top_rate, accel, decel, um)| AxisRecord {
            flags: AxisRecord::PRESENT,
            steps: 100,
            um: um * 250,
            start_rate,
            top_rate,
            accel,
            decel,
            ..mill().axes[0]
        },
    )
}

fn distance() -> impl Strategy<Value = i32> {
    prop_oneof![Just(0), -9..10i32, -500..500i32, -9_000..9_000i32]
}

fn line() -> impl Strategy<Value = ([i32; 3], Feed)> {
    let feed = prop_oneof![
        Just(Feed::Rapid),
        (2_000u32..200_000).prop_map(Feed::Um),
        (300u32..20_000).prop_map(Feed::Steps)
    ];
    ([distance(), distance(), distance()], feed)
}

#[test]
fn every_edge_falls_on_its_tick_while_the_link_is_busy() {
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(5) };
    proptest!(config, |(
        axes in [axis(), axis(), axis()],
        lines in prop::collection::vec(line(), 3),
        n in 0u16..3, by in distance(),
    )| {
        let mut machine = Machine::new(axes, true);
        let mut place = [0; 3];
        for (steps, feed) in lines {
            let plan = machine.line(steps, feed);
            machine.finish(60);
            for (place, by) in place.iter_mut().zip(steps) {
                *place += by;
            }
            prop_assert_eq!(machine.positions(), place);
            agree(&machine.steps(), &plan)?;
        }
        // As steep as the planner's own property of its ramps has them.
        let steep = Scaled::new(STEEP);
        let pace = Pace::of(&axes[usize::from(n)]).with_ramps(steep, steep);
        let plan = machine.axis(n, by, pace);
        machine.finish(60);
        place[usize::from(n)] += by;
        prop_assert_eq!(machine.positions(), place);
        let made = machine.steps();
        agree(&made, &plan)?;
        let times: Vec<u64> = made[usize::from(n)].iter().map(|step| step.0).collect();
        let bounds = bounds(&AxisRecord {
            accel: axes[usize::from(n)].accel.min(STEEP),
            decel: axes[usize::from(n)].decel.min(STEEP),
            ..axes[usize::from(n)]
        });
        prop_assert_eq!(physics::check(&times, &bounds), Ok(()));
        prop_assert!(machine.replies > 0, "the link is silent");
    });
}

#[test]
fn the_link_tells_the_speeds_of_axes_that_move() {
    let axis = AxisRecord {
        flags: AxisRecord::PRESENT,
        start_rate: 400,
        top_rate: 2_000,
        accel: 20_000,
        decel: 20_000,
        ..mill().axes[0]
    };
    let mut machine = Machine::new([axis; 3], false);
    machine.line([4_000, -1_000, 0], Feed::Rapid);
    machine.run(500 * MS);
    for (n, speed) in [(0, 2_000), (1, -500), (2, 0)] {
        machine.call("motion_speed", &[(12, n)]);
        assert_eq!(machine.chip.result() as i32, speed, "axis {n}");
    }
    machine.finish(5);
    machine.call("motion_speed", &[(12, 0)]);
    assert_eq!(machine.chip.result(), 0);
}

/// Three axes at a rate while the link is busy: every edge on its tick; the mean interrupt, cycles.
fn three_axes_at(rate: u32) -> u64 {
    let axis = AxisRecord {
        flags: AxisRecord::PRESENT,
        steps: 400,
        um: 4_000,
        start_rate: 400,
        top_rate: rate,
        accel: 200_000,
        decel: 200_000,
        ..mill().axes[0]
    };
    let axes = [axis; 3];
    let mut machine = Machine::new(axes, true);
    let steps = [40_000, 40_000, -40_000];
    let plan = machine.line(steps, Feed::Rapid);
    machine.finish(5);
    let made = machine.steps();
    agree(&made, &plan).expect("the plan");
    let times: Vec<u64> = made[0].iter().map(|step| step.0).collect();
    assert_eq!(physics::check(&times, &bounds(&axis)), Ok(()));
    assert!(machine.replies > 100, "{} bytes of replies", machine.replies);
    let stats = machine.chip.board.stats().interrupts[&STEP];
    assert!(stats.worst <= 194, "{} cycles", stats.worst);
    stats.total / stats.count
}

#[test]
fn three_axes_make_sixty_thousand_events_a_second_with_the_link_busy() {
    assert!(three_axes_at(40_000) <= 170);
    let mean = three_axes_at(60_000);
    assert!(mean <= 170, "{mean} cycles");
}

#[test]
fn one_axis_makes_sixty_four_thousand_steps_a_second_with_the_link_busy() {
    let axis = AxisRecord {
        flags: AxisRecord::PRESENT,
        start_rate: 1_000,
        top_rate: 64_000,
        accel: 300_000,
        decel: 300_000,
        ..mill().axes[0]
    };
    let mut machine = Machine::new([axis; 3], true);
    let plan = machine.axis(1, -60_000, Pace::of(&axis));
    machine.finish(5);
    let made = machine.steps();
    agree(&made, &plan).expect("the plan");
}

/// What happens to a motion on its way.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Turn {
    /// A pause, and some rest in it, ms.
    Pause(u64),
    Stop,
    Halt,
}

fn turn() -> impl Strategy<Value = Turn> {
    prop_oneof![
        4 => (20u64..60).prop_map(Turn::Pause),
        1 => Just(Turn::Stop),
        1 => Just(Turn::Halt)
    ]
}

/// The instants of steps, run by run: a rest lies between two runs.
fn runs(steps: &[Step], rest: u64) -> Vec<Vec<u64>> {
    let times: Vec<u64> = steps.iter().map(|step| step.0).collect();
    times.chunk_by(|a, b| b - a < rest).map(<[u64]>::to_vec).collect()
}

/// No two steps of a motion lie further apart, ticks: 1/200 s at the start rate.
const REST: u64 = 8 * MS;
#[test]
fn pauses_lose_no_step_and_stops_leave_the_commanded_place_where_the_axes_stand() {
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(8) };
    let turns = prop::collection::vec((1u64..400, turn()), 1..5);
    proptest!(config, |(
        axes in [axis(), axis(), axis()],
        (mut steps, feed) in line(), single: bool, far in 3_000i32..20_000, turns in turns,
    )| {
        let mut machine = Machine::new(axes, true);
        let steep = Scaled::new(STEEP);
        if single {
            steps = [0, -far, 0];
            machine.axis(1, -far, Pace::of(&axes[1]).with_ramps(steep, steep));
        } else {
            steps[2] = far;
            machine.line(steps, feed);
        }
        let mut ended = false;
        for (ms, turn) in turns {
            machine.run(ms * MS);
            match turn {
                Turn::Pause(ms) => {
                    machine.chip.set_byte("MOTION", PAUSE);
                    machine.rest();
                    let there = machine.positions();
                    machine.run(ms * MS);
                    prop_assert_eq!(machine.positions(), there, "it rests in a pause");
                    machine.chip.set_byte("MOTION", 0);
                    continue;
                }
                Turn::Stop => machine.call("motion_stop", &[]),
                Turn::Halt => machine.call("motion_halt", &[]),
            }
            ended = true;
            if turn == Turn::Halt {
                prop_assert!(!machine.moving(), "a halt ends at once");
            }
            break;
        }
        machine.finish(60);
        prop_assert_eq!(machine.chip.byte("MOTION"), 0);
        let place = machine.positions();
        prop_assert_eq!(machine.commanded(), place);
        let made = machine.steps();
        for a in 0..3 {
            let net: i32 = made[a].iter().map(|step| if step.1 { 1 } else { -1 }).sum();
            prop_assert_eq!(place[a], net, "steps of axis {}", a);
            prop_assert!(net.abs() <= steps[a].abs() && net.signum() * steps[a].signum() >= 0);
        }
        if !ended {
            prop_assert_eq!(place, steps);
        }
        if single {
            let bounds = physics::Limits {
                accel: bounds(&axes[1]).accel.min(STEEP.into()),
                decel: bounds(&axes[1]).decel.min(STEEP.into()),
                ..bounds(&axes[1])
            };
            // A halted axis may stand still from any speed: its last run is not looked at.
            let runs = runs(&made[1], REST);
            // A motion halted before its first step has none.
            let braked = runs.len().saturating_sub(usize::from(ended));
            for run in &runs[..braked] {
                prop_assert_eq!(physics::check(run, &bounds), Ok(()));
            }
        }
    });
}

#[test]
fn an_axis_that_meets_a_switch_rests_where_the_twin_does() {
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(10) };
    proptest!(config, |(
        axis in axis(), by in prop_oneof![-20_000..-2_000i32, 2_000..20_000i32],
        speed in 100u32..8_000, ms in 5u64..1_500, slow in 0i8..6,
    )| {
        let mut machine = Machine::new([axis; 3], true);
        let ramp = Scaled::new(60_000).shifted(-slow);
        let pace = Pace::of(&axis).with_steps(speed).with_ramps(ramp, ramp);
        machine.axis(1, by, pace);
        machine.run(ms * MS);
        prop_assume!(machine.moving());
        machine.call("motion_poll", &[]);
        let caught = machine.positions()[1];
        machine.call(
            "motion_hit",
            &[(8, 4), (12, caught as u16), (13, (caught as u32 >> 16) as u16)],
        );
        machine.finish(60);
        let rests = machine.positions()[1];
        prop_assert_eq!(machine.commanded()[1], rests);
        let net: i32 = machine.steps()[1].iter().map(|step| if step.1 { 1 } else { -1 }).sum();
        prop_assert_eq!(rests, net);
        let mut twin = Single::new(0, CLOCK);
        twin.go(&axis, by, pace);
        let mut segment = Segment::NONE;
        while twin.position().abs() < caught.abs() {
            prop_assert!(twin.next_segment(&mut segment));
        }
        if twin.hit(&axis, caught) {
            // At once: the step that was armed is made.
            prop_assert!((rests - caught).abs() <= 1, "{} {}", rests, caught);
        } else {
            while twin.next_segment(&mut segment) {}
            prop_assert_eq!(rests, twin.position());
        }
    });
}
