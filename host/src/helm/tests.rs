//! The owner on a virtual board in real time: what the board did is what counts.

use std::sync::Arc;
use std::sync::mpsc;
use std::time::{Duration, Instant};

use lang::axis::Axis;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::Profile;
use lang::wire;

use super::{Debug, Entry, Helm, Hold, LOOK_AHEAD, Pace, Picture, Port, SLOWEST, User};
use crate::board::F5529;
use crate::board::live::{Live, Touch};
use crate::sim::world::World;

/// Everything of these tests ends long before this, on a loaded machine too.
const PATIENCE: Duration = Duration::from_secs(20);

fn mill() -> Profile {
    Profile::built_in("mill").expect("built in")
}

fn stand() -> (Arc<Live>, Helm) {
    stand_of(&mill())
}

fn stand_of(machine: &Profile) -> (Arc<Live>, Helm) {
    let live = Live::light(&F5529, machine, &World::empty()).expect("a board");
    let live = Arc::new(live);
    let own = live.clone();
    let helm = Helm::start(Box::new(move || own.connect()));
    until(&helm, |picture| picture.port == Port::Up);
    (live, helm)
}

fn until(helm: &Helm, fits: impl Fn(&Picture) -> bool) -> Arc<Picture> {
    let end = Instant::now() + PATIENCE;
    let (mut seen, mut picture) = helm.picture();
    while !fits(&picture) {
        assert!(Instant::now() < end, "it never came: {picture:?}");
        (seen, picture) = helm.wait(seen, Duration::from_millis(200));
    }
    picture
}

fn upload(helm: &Helm, user: User, text: &str) -> (lang::hir::Program, lang::back::Compiled) {
    let (program, diags) = compile(&Source::new("t", text.to_owned()), ProfileChoice::built_in());
    let program = program.unwrap_or_else(|| panic!("{diags:?}"));
    let compiled = lang::back::compile(&program).expect("it fits");
    let image = compiled.image.clone();
    let (to, done) = mpsc::channel();
    helm.ask(user, move |board| {
        let board = board.expect("a board");
        let _ = to.send(board.upload(&image, true, &mut |_| {}).map_err(|error| error.to_string()));
    })
    .expect("room");
    assert_eq!(done.recv_timeout(PATIENCE), Ok(Ok(())));
    (program, compiled)
}

fn hold_x(helm: &Helm, user: User, id: u64) {
    helm.hold(Hold::new((user, id), Axis::X, true, (2_000, 25_000), (0, 30_000))).expect("free");
}

/// An emergency stop that is let go again ends the hold all the same: nothing moves until somebody
/// presses a button anew.
#[test]
fn a_fault_on_the_way_ends_a_hold_that_is_kept() {
    let stop = "\n[[input]]\nn = 4\nrole = \"emergency_stop\"\n";
    let machine = Profile::parse(&(lang::profile::BUILT_IN[0].1.to_owned() + stop));
    let (live, helm) = stand_of(&machine.expect("a profile"));
    let user = User::new();
    hold_x(&helm, user, 1);
    let begun = Instant::now();
    let mut over = None;
    while begun.elapsed() < Duration::from_millis(2000) {
        std::thread::sleep(Duration::from_millis(50));
        let at = begun.elapsed().as_millis();
        if (500..560).contains(&at) {
            live.touch(Touch::Input(4, true));
        } else if at > 600 {
            live.touch(Touch::Input(4, false));
        }
        if helm.keep(user, 1).is_err() {
            over.get_or_insert((begun.elapsed(), live.seen().motors[0]));
        }
    }
    let (when, motors) = over.expect("the hold goes on behind an emergency stop");
    let log = helm.log(0).1;
    assert!(when > Duration::from_millis(450) && motors > 100, "{when:?} {motors} {log:?}");
    assert_eq!(live.seen().motors[0], motors, "it moved on");
    let told = helm.picture().1.status.as_ref().and_then(|status| status.fault.clone());
    assert_eq!(told.as_deref(), Some("F14"));
    // Whoever presses anew moves again.
    hold_x(&helm, user, 2);
    std::thread::sleep(Duration::from_millis(100));
    helm.keep(user, 2).expect("alive");
    std::thread::sleep(Duration::from_millis(600));
    assert!(live.seen().motors[0] > motors);
}

/// Another process at the line stops an axis that a held button moves as slowly as this: it stays so while the button is
/// held, and moves when it is pressed anew.
fn stopped_by_somebody_else(rate: u32) {
    let (live, helm) = stand();
    let user = User::new();
    let press = |id| Hold::new((user, id), Axis::X, true, (rate, 25_000), (0, 30_000));
    helm.hold(press(1)).expect("free");
    let begun = Instant::now();
    let (mut stopped, mut over) = (None, false);
    while begun.elapsed() < Duration::from_millis(2_500) {
        std::thread::sleep(Duration::from_millis(80));
        over |= helm.keep(user, 1).is_err();
        if stopped.is_none() && begun.elapsed() > Duration::from_millis(1_000) {
            assert!(!over && live.seen().motors[0] > 0, "{:?}", helm.log(0).1);
            let (to, done) = mpsc::channel();
            let stop = [wire::command::STOP_AXES, 0b111];
            helm.ask(User::new(), move |board| {
                let _ =
                    to.send(board.is_ok_and(|board| board.write_all(wire::COMMAND, &stop).is_ok()));
            })
            .expect("room");
            assert_eq!(done.recv_timeout(PATIENCE), Ok(true));
            // Its ramp, or the step under way; nobody renews the hold meanwhile.
            std::thread::sleep(Duration::from_millis(100));
            stopped = Some(live.seen().motors[0]);
        }
    }
    let log = helm.log(0).1;
    let on = live.seen().motors[0] - stopped.expect("it was stopped");
    // At the slowest the two steps that the engine has already take as long as that.
    let left = if rate == SLOWEST { 2 } else { 0 };
    assert!(on.unsigned_abs() <= left, "{on} steps after a Stop: {log:?}");
    assert!(over, "the hold goes on: {log:?}");
    let rest = live.seen().motors[0];
    helm.hold(press(2)).expect("free");
    std::thread::sleep(Duration::from_millis(600));
    assert!(live.seen().motors[0] > rest, "a new press does not move it");
}

#[test]
fn a_stop_of_somebody_else_ends_a_slow_hold() {
    stopped_by_somebody_else(60);
}

#[test]
fn a_stop_of_somebody_else_ends_the_slowest_hold() {
    stopped_by_somebody_else(SLOWEST);
}

#[test]
fn a_stop_of_somebody_else_ends_a_fast_hold() {
    stopped_by_somebody_else(2_000);
}

#[test]
fn a_hold_moves_while_it_is_kept_and_rests_soon_after() {
    let (live, helm) = stand();
    let user = User::new();
    hold_x(&helm, user, 1);
    let begun = Instant::now();
    let mut kept = begun;
    while begun.elapsed() < Duration::from_millis(800) {
        std::thread::sleep(Duration::from_millis(80));
        helm.keep(user, 1).unwrap_or_else(|over| panic!("{over:?}: {:?}", helm.log(0).1));
        kept = Instant::now();
    }
    let at_keep = live.seen().motors[0];
    assert!(at_keep > 600, "{at_keep} steps in 0.8 s at 2000 steps/s");
    // Nobody lets go: the board ends by itself. On a loaded machine its time runs late, so its steps
    // are what is judged: those of the look-ahead, and 0.1 s until the keep-alive was on the board.
    std::thread::sleep(LOOK_AHEAD.saturating_sub(kept.elapsed()));
    let rest = loop {
        let before = live.seen().motors;
        std::thread::sleep(Duration::from_millis(300));
        if live.seen().motors == before {
            break before;
        }
        assert!(kept.elapsed() < PATIENCE, "it never rests");
    };
    assert!(rest[0] - at_keep <= 2_000 * 4 / 10, "{} steps too far", rest[0] - at_keep);
    assert!(helm.keep(user, 1).is_err(), "a dead hold came back");
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(live.seen().motors, rest);
    assert_eq!(rest[1..], [0, 0]);
    assert!(helm.log(0).1.iter().any(|entry| matches!(entry, Entry::Hold { id: 1, .. })));
}

#[test]
fn stop_comes_before_everything_that_waits() {
    let (live, helm) = stand();
    let user = User::new();
    upload(&helm, user, "MoveAxe X, 200mm, 5mm/s\n");
    helm.ask(user, |board| {
        board.expect("a board").control(wire::Control::Start).expect("it starts");
    })
    .expect("room");
    until(&helm, |picture| picture.status.as_ref().is_some_and(|s| !s.moving.is_empty()));
    // A user that asks all the while, and one job that goes on for ever.
    let (to, answers) = mpsc::channel();
    for _ in 0..super::MOST_WAITING - 1 {
        let to = to.clone();
        let _ = helm.ask(user, move |board| {
            let words = board.map(|board| {
                (0..200).find_map(|_| board.holding(wire::VERSION, 1).err()).map(|e| e.to_string())
            });
            let _ = to.send(words.map_err(str::to_owned));
        });
    }
    std::thread::sleep(Duration::from_millis(100));
    let pressed = Instant::now();
    helm.stop();
    let state = until(&helm, |picture| {
        picture.status.as_ref().is_some_and(|s| s.moving.is_empty() && s.state == "ready")
    });
    assert!(pressed.elapsed() < Duration::from_secs(2), "{:?}", pressed.elapsed());
    assert_eq!(state.status.as_ref().and_then(|s| s.last_end), Some("stopped"));
    assert!(live.seen().motors[0] < 20_000);
    drop(to);
    let answers: Vec<_> = answers.iter().collect();
    assert!(answers.contains(&Err("Stop came before it".to_owned())), "{answers:?}");
    assert!(answers.contains(&Ok(Some("Stop came before it".to_owned()))), "{answers:?}");
}

#[test]
fn users_take_turns() {
    let (_live, helm) = stand();
    let (many, one) = (User::new(), User::new());
    let (to, order) = mpsc::channel();
    let (go, gate) = mpsc::channel::<()>();
    helm.ask(many, move |_| gate.recv().unwrap_or(())).expect("room");
    for _ in 0..10 {
        let to = to.clone();
        helm.ask(many, move |_| to.send("many").unwrap_or(())).expect("room");
    }
    let own = to.clone();
    helm.ask(one, move |_| own.send("one").unwrap_or(())).expect("room");
    go.send(()).expect("open");
    drop(to);
    let order: Vec<&str> = order.iter().collect();
    assert!(order[..2].contains(&"one"), "{order:?}");
    let full = (0..100).map(|_| helm.ask(many, |_| std::thread::sleep(Duration::from_millis(5))));
    assert!(full.into_iter().any(|asked| asked.is_err()), "a queue without an end");
}

#[test]
fn a_followed_run_halts_at_its_breakpoint_and_steps() {
    let (live, helm) = stand();
    let user = User::new();
    let text = "MoveAxe X, 1mm\nPRINT \"hi\"\nMoveAxe Y, 1mm\nMoveAxe X, 2mm\n";
    let (program, compiled) = upload(&helm, user, text);
    let line_of =
        Arc::new(move |pc: u16| compiled.sidecar.at(pc.into()).map_or(0, |mark| mark.line));
    helm.debug(Debug::Start {
        profile: Box::new(program.profile.clone()),
        line_of,
        breaks: [2].into(),
        pace: Pace::Go,
    });
    let halted = until(&helm, |picture| picture.halted.is_some());
    let places = halted.halted.as_ref().map(|halt| (halt.behind, halt.next));
    assert_eq!(places, Some((1, 2)));
    // The board waits longer than it would for a reader that is gone.
    std::thread::sleep(Duration::from_millis(2_600));
    assert_eq!(live.seen().motors, [100, 0, 0]);
    assert!(!helm.log(0).1.contains(&Entry::Print("hi".to_owned())));
    for next in 3..=4 {
        helm.debug(Debug::Pace(Pace::Step));
        until(&helm, |picture| picture.halted.as_ref().is_some_and(|halt| halt.next == next));
    }
    assert!(helm.log(0).1.contains(&Entry::Print("hi".to_owned())));
    assert_eq!(live.seen().motors, [100, 100, 0]);
    helm.debug(Debug::Pace(Pace::Go));
    until(&helm, |picture| !picture.followed);
    assert_eq!(live.seen().motors, [200, 100, 0]);
    // The next run is not halted: trace mode is off.
    helm.ask(user, |board| {
        board.expect("a board").control(wire::Control::Start).expect("it starts");
    })
    .expect("room");
    until(&helm, |picture| picture.status.as_ref().is_some_and(|s| s.runs == 2));
    until(&helm, |picture| {
        picture.status.as_ref().is_some_and(|s| s.runs == 2 && s.state == "ready")
    });
}

#[test]
fn a_board_that_is_lost_is_told_and_found_again() {
    let (live, helm) = stand();
    let own = live.clone();
    // Another host takes the line away: the owner's end closes.
    let other = own.connect().expect("a board");
    until(&helm, |picture| picture.port == Port::Lost);
    let answer = mpsc::channel();
    let (to, heard) = answer;
    helm.ask(User::new(), move |board| to.send(board.is_err()).unwrap_or(())).expect("room");
    assert!(heard.recv_timeout(PATIENCE).is_ok());
    drop(other);
    until(&helm, |picture| picture.port == Port::Up);
}
