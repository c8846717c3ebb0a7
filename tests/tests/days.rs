//! What goes on for days: clocks that come round, belts and feeds that never end.

use emulator::Config;
use lang::fault::Fault;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;
use lang::part::G2553;
use lang::profile::{BUILT_IN, Profile};
use lang::wire::{Control, FAULT, RUN_STATE, RunState};
use pasapas::board::{BUILDS, F5529};
use pasapas::sim::record::StopReason;
use pasapas::sim::trace::{Event, What};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, Outcome, run_traced};
use pasapas::torture::stand::Stand;

const HOUR_US: u64 = 3_600_000_000;

fn on(script: &str, profile: &Profile) -> Program {
    let source = Source::new("days.bas", script.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::Given(Box::new(profile.clone())));
    program.unwrap_or_else(|| panic!("{script}: {}", diags.render(&source)))
}

fn mill() -> Profile {
    Profile::built_in("mill").expect("built in")
}

/// What a run prints, and its outcome.
fn prints(
    program: &Program,
    engine: Engine,
    hours: u64,
    part: lang::part::Part,
) -> (String, Outcome) {
    let options = Options {
        limit_us: hours * HOUR_US,
        times: false,
        record: false,
        part,
        ..Options::default()
    };
    let (outcome, events) =
        run_traced(program, engine, &World::empty(), &options).expect("it runs");
    let text = |event: &Event| match &event.what {
        What::Print { text, .. } => Some(format!("{text}\n")),
        _ => None,
    };
    (events.iter().filter_map(text).collect(), outcome)
}

/// A loop that only computes, prints or moves ends soon after its user wants that, whatever time it simulates.
#[test]
fn a_loop_without_an_end_is_ended_by_its_user() {
    for body in [
        "n = n + 1",
        "PRINT n",
        "Wait 10min",
        "MoveAxe X, 200mm\n MoveAxe X, 0mm",
        "G1 X9 F600\n G1 X0",
    ] {
        let program = on(&format!("DIM n\nDO\n {body}\nLOOP\n"), &mill());
        for engine in [Engine::Rhai, Engine::Vm] {
            for build in &BUILDS {
                let options = Options {
                    limit_us: 60 * 24 * HOUR_US,
                    part: build.part,
                    interrupted: || true,
                    ..Options::default()
                };
                let (outcome, _) =
                    run_traced(&program, engine, &World::empty(), &options).expect("it runs");
                let summary = &outcome.summary;
                let (part, count) = (build.part.name, summary.statements);
                let at = format!("{body}, {engine:?}, {part}: {count} statements");
                assert_eq!(summary.stopped, Some(StopReason::Interrupted), "{at}");
                assert!(summary.statements < 20_000, "{at}");
                assert!((2..=4).contains(&outcome.end.line), "{at}: line {}", outcome.end.line);
            }
        }
    }
}

/// Sixty days, hour by hour: TIMER comes round after 12.4 days and each 24.8 days from there; what is counted from it
/// stays right.
#[test]
fn differences_of_times_are_right_for_sixty_days() {
    let script = "\
DIM hour, since, deadline, now, before, wrong, rounds
deadline = TIMER() + 90min
FOR hour = 1 TO 1440
  since = TIMER()
  deadline = since + 90min
  before = TIMER() - 30min
  Wait 60min
  now = TIMER()
  IF TIMER() - since < 60min OR TIMER() - since > 61min THEN wrong = wrong + 1
  IF now - since < 60min OR now - since > 61min THEN wrong = wrong + 1
  IF deadline - TIMER() < 29min OR deadline - now > 31min THEN wrong = wrong + 1
  IF elapsed(now, before) < 90min OR elapsed(now, before) > 91min THEN wrong = wrong + 1
  IF TIMER() - deadline >= 0ms THEN wrong = wrong + 1
  IF now < since THEN rounds = rounds + 1
NEXT
PRINT wrong; \" \"; rounds
FUNCTION elapsed(a, b)
  now = a
  RETURN now - b
END FUNCTION
";
    let program = on(script, &mill());
    for engine in [Engine::Rhai, Engine::Vm] {
        let (text, outcome) = prints(&program, engine, 1_500, lang::part::F5529);
        assert_eq!(text, "0 2\n", "{engine:?}: {:?}", outcome.end);
    }
}

/// A sum of times that are no readings still faults where 32 bits end: it would be wrong without a word otherwise.
#[test]
fn a_total_of_times_is_no_reading() {
    let script = "DIM total, since\nDO\nsince = TIMER()\nWait 4s\ntotal = total + (TIMER() - since) + 20000min\nLOOP\n";
    let program = on(script, &mill());
    for engine in [Engine::Rhai, Engine::Vm] {
        let (_, outcome) = prints(&program, engine, 1, lang::part::F5529);
        assert_eq!(outcome.end.fault, Some(Fault::Overflow), "{engine:?}");
    }
}

/// The boards' own counters, brought near each place where one of their bits turns over.
#[test]
fn a_boards_clock_comes_round_without_a_word() {
    let script = "\
DIM t AT 3000, wrong AT 3002, rounds AT 3004
DIM since, deadline
DO
  t = TIMER()
LOOP UNTIL IN(3)
DO
  since = TIMER()
  deadline = since + 1s
  Wait 50ms
  t = TIMER()
  IF t - since < 50ms OR t - since > 70ms THEN wrong = wrong + 1
  IF deadline - t < 900ms OR deadline - TIMER() > 960ms THEN wrong = wrong + 1
  rounds = rounds + 1
LOOP
";
    for build in BUILDS {
        let name = build.part.name;
        for turn in [1u64 << 30, 1 << 31, 3 << 30, 1 << 32] {
            let mut stand = Stand::new(build, &Config::default()).expect("the shipped image");
            let image = lang::back::compile(&on(script, &mill())).expect("it fits").image;
            stand.upload(&image, false).expect("it is taken");
            stand.control(Control::Start);
            stand.board.run_us(1_234_567);
            let shown = stand.read_long(3000).expect("t").cast_unsigned();
            assert!((900..1_400).contains(&shown), "{name}: {shown}");
            // The counter is somewhere near in RAM; so is the program's reading of it, which follows.
            let ram = if build.part.look_ahead { 0x1C00..0x4400 } else { 0x200..0x400 };
            let long = |stand: &Stand, at: u16| {
                u32::from(stand.board.peek16(at + 2)) << 16 | u32::from(stand.board.peek16(at))
            };
            let near = |value: u32| (shown.saturating_sub(200)..shown + 300).contains(&value);
            let found: Vec<u16> =
                ram.step_by(2).filter(|at| *at < 0x43FE && near(long(&stand, *at))).collect();
            let shift = (turn - 3_000) as u32;
            let poke = |stand: &mut Stand, at: u16| {
                let value = long(stand, at).wrapping_add(shift);
                stand.board.poke16(at, value as u16);
                stand.board.poke16(at + 2, (value >> 16) as u16);
            };
            // It is the one that the readings follow, on a copy of the board.
            let counts = |at: &&u16| {
                let mut copy = stand.clone();
                poke(&mut copy, **at);
                copy.board.run_us(20_000);
                let follows = ((turn - 3_000 + u64::from(shown)) << 33) as i64 >> 33;
                let shown = copy.read_long(3000).map(i64::from);
                shown.is_some_and(|shown| (shown - follows).abs() < 400)
            };
            let counter = *found.iter().find(counts).expect("a counter");
            poke(&mut stand, counter);
            stand.board.run_us(100_000);
            stand.board.plant_mut().set_input(3, true);
            stand.board.run_us(6_000_000);
            assert_eq!(stand.read(RUN_STATE), Some(RunState::Running as u16), "{name} {turn:x}");
            assert_eq!(stand.read_long(3002), Some(0), "{name} {turn:x}");
            assert!(stand.read_long(3004).expect("rounds") > 90, "{name} {turn:x}");
            // 31 bits with their sign.
            let shown = stand.read_long(3000).expect("t");
            let wanted = ((turn + 4_500) << 33) as i64 >> 33;
            assert!((i64::from(shown) - wanted).abs() < 1_500, "{name} {turn:x}: {shown}");
        }
    }
}

/// A mill whose X is driven fast.
fn fast() -> Profile {
    let text = BUILT_IN[0].1.replacen("top_rate = 8000", "top_rate = 60000", 1);
    Profile::parse(&text.replace("pulse_us = 3", "pulse_us = 2")).expect("sound")
}

/// A belt goes on beyond 2^29 steps, beyond what um hold, and where it rests its place begins anew.
#[test]
fn a_belt_runs_on_and_what_follows_goes_from_there() {
    let script = "MoveSpeed X, 600mm/s\nWait 180min\nStopAxe X\nMoveRel X, 10mm\nPRINT POS(X)\nSetPos X, 0mm\nMoveAxe X, -5mm\nPRINT POS(X)\n";
    let program = on(script, &fast());
    for engine in [Engine::Rhai, Engine::Vm] {
        let (text, outcome) = prints(&program, engine, 4, lang::part::F5529);
        assert_eq!(text, "10000um\n-5000um\n", "{engine:?}: {:?}", outcome.end);
    }
}

/// A mill whose X moves 65 mm a step: 2147 m are soon behind it.
fn coarse() -> Profile {
    let mut profile = mill();
    let x = profile.x.as_mut().expect("an X");
    x.scale = lang::profile::Scale { steps: 1, um: 65_000 };
    profile
}

const FEED: &str =
    "DIM i\nFOR i = 1 TO 60\n  MoveRel X, 65000mm\n  SetPos X, 0mm\nNEXT\nPRINT POS(X)\n";

#[test]
fn a_feed_goes_on_beyond_what_32_bits_of_a_place_hold() {
    let program = on(FEED, &coarse());
    for engine in [Engine::Rhai, Engine::Vm] {
        let (text, outcome) = prints(&program, engine, 4, lang::part::F5529);
        assert_eq!(text, "0um\n", "{engine:?}: {:?}", outcome.end);
        // Without it, and on the part that has no room for it, F01 says what to write.
        let plain = on(&FEED.replace("SetPos X, 0mm", "Wait 1ms"), &coarse());
        for (program, part) in [(&plain, lang::part::F5529), (&program, G2553)] {
            let (_, outcome) = prints(program, engine, 4, part);
            let fault = outcome.end.fault.expect("a fault");
            assert_eq!(fault, Fault::Overflow, "{engine:?} {}", part.name);
            assert!(
                fault.cause().contains("place of an axis") && fault.remedy().contains("SetPos")
            );
        }
    }
    // The same on the board, twice: places stay from run to run.
    let mut stand = Stand::new(&F5529, &Config::default()).expect("the shipped image");
    let image = lang::back::compile(&program).expect("it fits").image;
    stand.upload(&image, false).expect("it is taken");
    for run in 1..=2 {
        stand.control(Control::Start);
        for _ in 0..80 {
            stand.board.run_us(1_000_000);
            if stand.read(RUN_STATE) == Some(RunState::Ready as u16) {
                break;
            }
        }
        assert_eq!(stand.read(RUN_STATE), Some(RunState::Ready as u16), "run {run}");
        assert_eq!(stand.read(FAULT), Some(0), "run {run}");
        assert_eq!(stand.board.plant().motors[0].pulses, run * 60 * 1_000, "run {run}");
    }
}
