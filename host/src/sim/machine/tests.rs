use std::cell::RefCell;
use std::rc::Rc;

use lang::axis::Axis;
use lang::effect::{Coord, Dist, Effect, Frame, Rate, Read, Sensor, Want};
use lang::fault::Fault;
use lang::part::G2553;
use lang::plain::Plain;
use lang::profile::{BUILT_IN, Profile};

use super::Machine;
use crate::sim::step::Step;
use crate::sim::trace::{Event, Status, to_text};
use crate::sim::world::{Registers, World};
use crate::sim::{End, Options};

fn work(um: i32) -> Coord {
    Coord { value: Dist::Um(um), frame: Frame::Work }
}

fn go(axis: Axis, um: i32) -> Effect {
    Effect::MoveAxe { axis, to: work(um), speed: None, accel: None, decel: None, wait: true }
}

fn line(x: i32, y: i32, exact: bool) -> Effect {
    Effect::Linear { rapid: false, to: [Some(work(x)), Some(work(y)), None], exact }
}

const HOME_X: Effect = Effect::Home { axis: Axis::X, query: false };

/// Runs one effect a line; gives trace, end, time in us.
fn run_on(profile: &str, world: &str, effects: &[Effect]) -> (String, End, u64) {
    run_with(&Profile::built_in(profile).unwrap(), world, effects)
}

fn run_with(profile: &Profile, world: &str, effects: &[Effect]) -> (String, End, u64) {
    let world = World::parse("w.rhai", world).unwrap();
    let events = Rc::new(RefCell::new(Vec::new()));
    let log = events.clone();
    let sink = Box::new(move |event: &Event| log.borrow_mut().push(event.clone()));
    let options = Options { times: false, part: G2553, ..Options::default() };
    let mut machine =
        Machine::new(profile, &world, &options, Vec::new(), &Registers::default(), sink).unwrap();
    let mut fault = None;
    let mut last = 0;
    for (index, effect) in effects.iter().enumerate() {
        last = index as u32 + 1;
        if machine.statement(last) == Step::Stop {
            break;
        }
        match machine.begin(effect) {
            Step::Done(_) => {}
            Step::Fault(found) => {
                fault = Some(machine.ramp_down(found));
                break;
            }
            Step::Stop => break,
            other => panic!("{other:?}"),
        }
    }
    if fault.is_none() {
        machine.end();
    }
    let end = machine.finish(fault, last).unwrap();
    let (summary, record, failures) = machine.results(&end);
    assert_eq!(failures, Vec::<String>::new());
    for segment in &record.path {
        assert!(segment.end_us >= segment.start_us, "{segment:?}");
    }
    (to_text(&events.borrow()), end, summary.us)
}

fn run(world: &str, effects: &[Effect]) -> (String, End, u64) {
    run_on("mill", world, effects)
}

fn status(result: &(String, End, u64)) -> (Status, Option<Fault>) {
    (result.1.status, result.1.fault)
}

#[test]
fn a_move_takes_the_time_of_its_ramps() {
    // 2000 steps, 400 to 8000 st/s at 25 000 st/s2: each ramp 0.304 s and 1276.8 steps, more than
    // there are, so a triangle with a peak of sqrt(400^2 + 2000 * 25000) = 7082 st/s.
    let (trace, _, us) = run("", &[go(Axis::X, 20_000)]);
    assert_eq!(
        trace,
        "{\"ev\":\"move\",\"line\":1,\"kind\":\"axe\",\"to\":{\"X\":2000,\"Y\":0,\"Z\":0}}\n\
         {\"ev\":\"end\",\"status\":\"done\",\"line\":1,\"pos\":{\"X\":2000,\"Y\":0,\"Z\":0}}\n"
    );
    let ideal = 2.0 * (7_082.4 - 400.0) / 25_000.0 * 1e6;
    // The planner's segments keep below the ramp by up to 2 %.
    assert!((us as f64 - ideal).abs() < ideal * 0.02, "{us} for {ideal}");
}

#[test]
fn a_path_arrives_where_it_was_sent() {
    let feed = Effect::SetFeed(Rate::Um(20_000));
    let moves = [feed, line(10_000, -2_500, true), line(20_000, 0, false), line(0, 0, false)];
    for n in 2..=moves.len() {
        let (trace, _, _) = run("", &moves[..n]);
        let commanded = trace.lines().rev().nth(1).and_then(|l| l.split("\"to\":").nth(1));
        let reached = trace.lines().next_back().and_then(|l| l.split("\"pos\":").nth(1));
        assert_eq!(commanded, reached, "{trace}");
    }
}

#[test]
fn homing_sets_the_zero_where_the_switch_opens() {
    let result = run("switch_at(\"X\", -500);", &[HOME_X, go(Axis::X, 1_000)]);
    assert!(
        result.0.starts_with("{\"ev\":\"home\",\"line\":1,\"axis\":\"X\",\"ok\":true,\"pos\":0}"),
        "{}",
        result.0
    );
    assert_eq!(status(&result), (Status::Done, None));
    let result = run("switch_at(\"X\", -90000);", &[HOME_X]);
    assert_eq!(status(&result), (Status::Fault, Some(Fault::HomeNotFound)));
    let query = Effect::Home { axis: Axis::X, query: true };
    assert_eq!(status(&run("switch_at(\"X\", -90000);", &[query])), (Status::Done, None));
    // Already closed: slow off it at once.
    let result = run("switch_at(\"X\", 300);", &[HOME_X]);
    assert_eq!(status(&result), (Status::Done, None));
}

#[test]
fn a_probe_is_caught_at_its_step() {
    let probe = |query| Effect::Probe {
        axis: Axis::Z,
        limit: work(-30_000),
        speed: Some(Rate::Um(5_000)),
        sensor: Sensor::Default,
        query,
    };
    let result = run("probe_at(\"Z\", -1840);", &[probe(false)]);
    let line = "{\"ev\":\"probe\",\"line\":1,\"axis\":\"Z\",\"ok\":true,\"pos\":-1840}";
    assert!(result.0.starts_with(line), "{}", result.0);
    assert_eq!(status(&run("", &[probe(false)])), (Status::Fault, Some(Fault::ProbeMissed)));
    assert_eq!(status(&run("", &[probe(true)])), (Status::Done, None));
    let result = run("set_in(17, true);", &[probe(true)]);
    assert_eq!(status(&result), (Status::Fault, Some(Fault::InputActive)));
    // A motor that lost 40 steps downward touches 40 steps later.
    let lost = "fault_at(100, \"stall\", \"Z\", 40); probe_at(\"Z\", -1840);";
    assert!(run(lost, &[probe(false)]).0.contains("\"pos\":-1880"));
}

#[test]
fn soft_limits_hold_for_homed_axes_and_switches_for_all() {
    let result = run("", &[HOME_X, go(Axis::X, 300_001)]);
    assert_eq!(status(&result), (Status::Fault, Some(Fault::SoftLimit)));
    assert_eq!(result.0.lines().count(), 2, "{}", result.0);
    let result = run("", &[go(Axis::X, -25_000)]);
    assert_eq!(status(&result), (Status::Fault, Some(Fault::LimitSwitch)));
    assert!(result.0.contains("\"pos\":{\"X\":-2000,"), "{}", result.0);
}

#[test]
fn a_pause_changes_neither_trace_nor_end() {
    let effects = [
        HOME_X,
        Effect::SetFeed(Rate::Um(20_000)),
        line(30_000, 10_000, false),
        line(30_000, 40_000, false),
        line(0, 0, true),
        Effect::Plain(Plain::Wait, [500, 0]),
        go(Axis::Y, 5_000),
    ];
    let plain = run("", &effects);
    assert_eq!(plain.1.status, Status::Done);
    for at in [500, 1_500, 2_500, 3_700, 6_100, 7_950] {
        let world = format!("at({at}, || press_stop()); at({}, || press_start());", at + 1_000);
        let paused = run(&world, &effects);
        assert_eq!(paused.0, plain.0, "paused at {at}");
        assert!(paused.2 > plain.2 + 800_000, "{} {}", paused.2, plain.2);
    }
}

#[test]
fn stop_held_nothing_left_and_the_emergency_stop_end_a_run() {
    let wait = [Effect::WaitIn { n: 3, want: Want::On, timeout: None, query: false }];
    assert_eq!(status(&run("", &wait)), (Status::Stopped, None));
    let held = run("hold_stop(100, 2500);", &[go(Axis::X, 200_000)]);
    assert_eq!(status(&held), (Status::Stopped, None));
    let result = run("at(300, || press_estop());", &[go(Axis::X, 200_000)]);
    assert_eq!(status(&result), (Status::Fault, Some(Fault::EmergencyStop)));
    // 5 ms of filter: shorter pulses do not count.
    let glitch = "at(10, || set_in(3, true)); at(12, || set_in(3, false));";
    assert_eq!(status(&run(glitch, &wait)), (Status::Stopped, None));
    let (_, end, us) = run("at(10, || set_in(3, true));", &wait);
    assert_eq!((end.status, us), (Status::Done, 15_000));
    // The buttons have the same: the pause begins 5 ms late, a bounce is none.
    let (_, end, us) = run("hold_stop(10, 3);", &[Effect::Plain(Plain::Wait, [500, 0])]);
    assert_eq!((end.status, us), (Status::Done, 500_000));
    let paused = "hold_stop(10, 50); at(110, || press_start());";
    let (_, end, us) = run(paused, &[Effect::Plain(Plain::Wait, [500, 0])]);
    assert_eq!((end.status, us), (Status::Done, 600_000));
}

#[test]
fn an_emergency_stop_waits_for_no_filter() {
    let text = BUILT_IN[0].1.to_owned()
        + "\n[[input]]\nn = 5\nrole = \"emergency_stop\"\ninvert = true\nfilter_ms = 50\n";
    let profile = Profile::parse(&text).unwrap();
    // A disturbance that `IN(5)` would never show.
    let world = "at(300, || set_in(5, true)); at(301, || set_in(5, false));";
    let result = run_with(&profile, world, &[go(Axis::X, 200_000)]);
    assert_eq!((status(&result), result.2), ((Status::Fault, Some(Fault::EmergencyStop)), 300_000));
}

#[test]
fn a_speed_move_rests_at_its_soft_limit() {
    let effects = [
        Effect::Home { axis: Axis::Y, query: false },
        Effect::MoveSpeed { axis: Axis::Y, speed: Rate::Steps(4_000) },
        Effect::Plain(Plain::Wait, [10_000, 0]),
    ];
    let profile = Profile::built_in("mill").unwrap();
    let sink = Box::new(|_: &Event| {});
    let options = Options { part: G2553, ..Options::default() };
    let world = World::empty();
    let mut machine =
        Machine::new(&profile, &world, &options, Vec::new(), &Registers::default(), sink).unwrap();
    assert_eq!(machine.begin(&effects[0]), Step::Done(0));
    assert_eq!(machine.begin(&effects[1]), Step::Done(0));
    assert_eq!(machine.begin(&effects[2]), Step::Late(Fault::SoftLimit));
    let at = machine.begin(&Effect::Read(Read::PosSteps(Axis::Y)));
    assert_eq!(at, Step::Done(20_000));
}

#[test]
fn independent_axes_run_at_once_and_the_last_target_holds() {
    let start = |axis, um| Effect::MoveAxe {
        axis,
        to: work(um),
        speed: Some(Rate::Steps(2_000)),
        accel: None,
        decel: None,
        wait: false,
    };
    let both = run("", &[start(Axis::X, 20_000), start(Axis::Y, 20_000), Effect::WaitMove(None)]);
    let one = run("", &[start(Axis::X, 20_000), Effect::WaitMove(Some(Axis::X))]);
    assert!(both.2 < one.2 + 1_000, "{} {}", both.2, one.2);
    let turned = run(
        "",
        &[start(Axis::X, 50_000), Effect::Plain(Plain::Wait, [1_000, 0]), go(Axis::X, -1_000)],
    );
    assert!(turned.0.contains("\"pos\":{\"X\":-100,"), "{}", turned.0);
}

#[test]
fn outputs_take_their_end_states_and_pulses_write_two_lines() {
    let (trace, end, us) = run(
        "after_out(1, true, 20, || set_in(2, true)); expect_out(1, false); expect_out(3, false);",
        &[
            Effect::Plain(Plain::SetOut, [1, 1]),
            Effect::WaitIn { n: 2, want: Want::Rise, timeout: Some(1_000), query: false },
            Effect::Plain(Plain::Pulse, [3, 40]),
            Effect::Plain(Plain::SetPort, [0b101, 0]),
        ],
    );
    assert_eq!(end.status, Status::Done);
    assert_eq!(us, 20 + 25_000 + 20 + 40_000 + 20 - 20);
    assert_eq!(trace.matches("\"ev\":\"out\"").count(), 1 + 2 + 8);
}
