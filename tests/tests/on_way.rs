//! Actions on the way: outputs act at their places, on every engine and at the pins of the shipped image, and the path
//! takes no longer for them.

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;
use lang::profile::Profile;
use lang::wire::{Control, OVERRIDES, RunState};
use pasapas::board::engine::{self, run_native_traced};
use pasapas::board::{DEFAULT, F5529, G2553};
use pasapas::sim::record::Record;
use pasapas::sim::trace::{Event, Status, What};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, Outcome, run_traced};
use pasapas::torture::stand::Stand;
use pasapas::torture::table::Table;

fn program(script: &str) -> Program {
    let source = Source::new("t.bas", script.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::built_in());
    program.unwrap_or_else(|| panic!("{script}: {}", diags.render(&source)))
}

/// Runs of a script: its engines, each with its name.
fn runs(script: &str, world: &str) -> Vec<(&'static str, Outcome, Vec<Event>)> {
    runs_of(program(script), world)
}

/// Runs on a mill whose output 3 is off in a pause.
fn paused(script: &str, world: &str) -> Vec<(&'static str, Outcome, Vec<Event>)> {
    let mill = include_str!("../../examples/profiles/mill.toml");
    let own = "\n[[output]]\nn = 3\npause = \"off\"\n";
    let profile = Profile::parse(&(mill.to_owned() + own)).expect("a mill");
    let source = Source::new("t.bas", script.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::Given(Box::new(profile)));
    runs_of(program.unwrap_or_else(|| panic!("{script}: {}", diags.render(&source))), world)
}

fn runs_of(program: Program, world: &str) -> Vec<(&'static str, Outcome, Vec<Event>)> {
    let world = World::parse("w.rhai", world).expect("a world");
    let options = Options { limit_us: 30_000_000, ..Options::default() };
    let compiled = lang::back::compile(&program).expect("an image");
    let mut all = Vec::new();
    for (name, engine) in [("rhai", Engine::Rhai), ("vm", Engine::Vm)] {
        let (outcome, events) = run_traced(&program, engine, &world, &options).expect("a run");
        all.push((name, outcome, events));
    }
    let (run, events) =
        run_native_traced(DEFAULT, &program, &compiled, &world, &options).expect("a run");
    all.push(("native", run.outcome, events));
    let (image, sidecar) = (&compiled.image, &compiled.sidecar);
    let (run, events) =
        engine::run_traced(&F5529, &program, image, sidecar, &world, &options).expect("a run");
    all.push(("board", run.outcome, events));
    all
}

/// What SYNC has done, in the order in which it happened: line, output, level.
fn acts(events: &[Event]) -> Vec<(u32, i32, u8)> {
    let act = |event: &Event| match event.what {
        What::Out { line, n, v, sync: true, .. } => Some((line, n, v)),
        _ => None,
    };
    events.iter().filter_map(act).collect()
}

/// When an output changed at its pin, us.
fn edges(record: &Record, n: i32) -> Vec<(u64, bool)> {
    let own = record.outputs.iter().filter(|edge| edge.n == n);
    own.map(|edge| (edge.us, edge.on)).collect()
}

/// Where axis X was, steps, when each action came.
fn places(events: &[Event]) -> Vec<i32> {
    let place = |event: &Event| match &event.what {
        What::Out { pos: Some(pos), .. } => pos.values()[0],
        _ => None,
    };
    events.iter().filter_map(place).collect()
}

const HEAD: &str = "SetPos X, 0mm : SetPos Y, 0mm\nF1800\n";

/// Forty blocks along X at changing feeds, of 2 mm each; `with` comes before each but the first.
fn forty(with: impl Fn(i32) -> String) -> String {
    let mut script = HEAD.to_owned();
    for n in 1..=40 {
        if n > 1 {
            script += &with(n);
        }
        let feed = [1800, 1200, 2400][n as usize / 7 % 3];
        script += &format!("G1 X{} F{feed}\n", 2 * n);
    }
    script
}

fn toggled(n: i32) -> String {
    format!("SYNC SetOut 3, {}\n", if n % 2 == 0 { "ON" } else { "OFF" })
}

#[test]
fn forty_actions_come_within_a_millisecond_and_take_no_time() {
    let plain = runs(&forty(|_| String::new()), "");
    let synced = runs(&forty(toggled), "");
    for ((name, without, _), (_, with, events)) in plain.iter().zip(&synced) {
        let (before, after) = (without.summary.us as f64, with.summary.us as f64);
        assert!(after < 1.02 * before, "{name}: {after} us for {before}");
        assert_eq!(with.end.status, Status::Done, "{name}");
        assert_eq!(acts(events).len(), 39, "{name}");
        let levels: Vec<bool> = edges(&with.record, 3).iter().map(|(_, on)| *on).collect();
        // The end of the run switches off what is on.
        assert_eq!(levels, (2..=41).map(|n| n % 2 == 0).collect::<Vec<_>>(), "{name}");
        let off = places(events).into_iter().zip(1..).map(|(at, n)| (at - 200 * n).abs());
        let worst = off.max().unwrap_or_default();
        println!("{name}: {before} us, {after} us, {worst} steps off at worst");
        // 20 to 40 mm/s, 100 steps to the mm.
        assert!(worst <= 4, "{name}: {worst} steps off");
    }
}

#[test]
fn leads_and_lags_are_times_or_ways() {
    // Before the place of output 4, which has no lead: us, steps.
    let cases = [
        ("15ms", Some(-15_000), 0),
        ("40ms", Some(-40_000), 0),
        ("-30ms", Some(30_000), 0),
        ("3mm", None, -300),
        ("-2.5mm", None, 250),
    ];
    for (lead, us, steps) in cases {
        let script = format!(
            "{HEAD}G1 X20\nSYNC SetOut 4, ON\nSYNC SetOut 3, ON, {lead}\nG1 X40\nG1 X50\nSetOut 3, OFF"
        );
        for (name, outcome, events) in runs(&script, "") {
            let first = |n| edges(&outcome.record, n)[0].0 as i64;
            let apart = first(3) - first(4);
            let acted = acts(&events);
            let own = acted.iter().position(|act| act.1 == 3).expect("it acted");
            let at = places(&events)[own] - 2000 - steps;
            println!("{name}, {lead}: {apart} us apart, {at} steps off");
            match us {
                Some(us) => assert!((apart - us).abs() <= 1100, "{name}, {lead}: {apart} us"),
                None => assert!(at.abs() <= 4, "{name}, {lead}: {at} steps off"),
            }
        }
    }
}

#[test]
fn several_at_one_place_come_in_order_each_at_the_pins() {
    let script = format!(
        "{HEAD}G1 X5\nSYNC SetOut 3, ON\nM62 P4\nSYNC SetOut 3, OFF\nSYNC SetOut 3, ON\nSYNC Pulse 5, 30ms\n\
         G1 X10\nM63 P4\nG1 X12\nSetOut 3, OFF"
    );
    let lines = [(4, 3, 1), (5, 4, 1), (6, 3, 0), (7, 3, 1), (8, 5, 1), (8, 5, 0), (10, 4, 0)];
    for (name, outcome, events) in runs(&script, "") {
        assert_eq!(acts(&events), lines, "{name}");
        let levels: Vec<bool> = edges(&outcome.record, 3).iter().map(|(_, on)| *on).collect();
        assert_eq!(levels, [true, false, true, false], "{name}");
        let [(on, true), (off, false)] = edges(&outcome.record, 5)[..] else { panic!("{name}") };
        assert!((off - on).abs_diff(30_000) <= 1_100, "{name}: {} us", off - on);
    }
}

#[test]
fn without_a_next_block_it_comes_before_what_waits_for_the_path() {
    let script = format!(
        "{HEAD}G1 X5\nSYNC SetOut 3, ON\nPRINT OUT(3)\nSYNC SetOut 3, OFF\nG0 X0\nPRINT OUT(3)\n"
    );
    for (name, _, events) in runs(&script, "") {
        let printed = events.iter().filter_map(|event| match &event.what {
            What::Print { text, .. } => Some(text.as_str()),
            _ => None,
        });
        assert_eq!(printed.collect::<Vec<_>>(), ["1", "0"], "{name}");
        assert_eq!(acts(&events), [(4, 3, 1), (6, 3, 0)], "{name}");
    }
}

#[test]
fn more_than_are_known_at_a_time_make_the_path_slow_and_none_is_lost() {
    let mut script = HEAD.to_owned();
    for n in 1..=120 {
        script += &format!("{}G1 X{}\n", toggled(n), f64::from(n) / 20.0);
    }
    script += "SYNC Pulse 4, 300ms\nSYNC Pulse 5, 200ms, -100ms\nG1 X7";
    for (name, outcome, events) in runs(&script, "") {
        assert_eq!(outcome.end.status, Status::Done, "{name}");
        assert_eq!(acts(&events).len(), 124, "{name}");
        let levels: Vec<bool> = edges(&outcome.record, 3).iter().map(|(_, on)| *on).collect();
        assert_eq!(levels.len(), 120, "{name}");
        // The run ends behind its pulses.
        let [(on, true), (off, false)] = edges(&outcome.record, 5)[..] else { panic!("{name}") };
        assert!((off - on).abs_diff(200_000) <= 1_100, "{name}: {} us", off - on);
    }
}

#[test]
fn stops_and_faults_drop_what_has_not_come() {
    // Output 5 pulses when the emergency stop comes, output 3 would come later.
    let script = format!("{HEAD}G1 X1\nSYNC Pulse 5, 10s\nG1 X20\nSYNC SetOut 3, ON\nG1 X40");
    for (name, outcome, _) in runs(&script, "at(300, || press_estop());") {
        assert_eq!(outcome.end.status, Status::Fault, "{name}");
        assert_eq!(edges(&outcome.record, 3), [], "{name}");
        let [(_, true), (off, false)] = edges(&outcome.record, 5)[..] else { panic!("{name}") };
        assert!((299_000..306_000).contains(&off), "{name}: {off} us");
    }
    // A fault of a statement that is handled: the path ends, what waits behind it does not come.
    let script = format!(
        "DIM none\nON ERROR GOTO away\n{HEAD}G1 X5\nSYNC SetOut 3, ON\nPRINT 1 / none\nEND\naway:\nWait 50ms\nEND"
    );
    for (name, outcome, _) in runs(&script, "") {
        assert_eq!(edges(&outcome.record, 3), [], "{name}");
    }
}

#[test]
fn the_small_chip_refuses_it_by_name() {
    let program = program("SYNC SetOut 1, ON\nF600\nG1 X1");
    let compiled = lang::back::compile(&program).expect("an image");
    let image = lang::image::Image::new(&compiled.image).expect("an image");
    let lack = G2553.part.lacks(&image, 0).expect("it lacks that");
    assert!(lack.to_string().contains("SYNC"), "{lack}");
    assert!(F5529.part.lacks(&image, 0).is_none());
}

/// A press of Stop at `ms`, and of Start long enough behind it for the axes to rest.
fn pause_at(ms: u32, start: u32) -> String {
    format!("at({ms}, || press_stop()); at({start}, || press_start());\n")
}

#[test]
fn a_pause_loses_none_of_those_that_wait_for_their_places() {
    let script = forty(toggled);
    let plain = runs(&script, "");
    let world =
        [(300, 1_000), (1_400, 2_100), (2_471, 3_200)].map(|(at, on)| pause_at(at, on)).concat();
    for ((name, _, without), (_, outcome, with)) in plain.iter().zip(runs(&script, &world)) {
        assert_eq!(outcome.end.status, Status::Done, "{name}");
        assert_eq!(acts(&with), acts(without), "{name}");
        let levels: Vec<bool> = edges(&outcome.record, 3).iter().map(|(_, on)| *on).collect();
        assert_eq!(levels, (2..=41).map(|n| n % 2 == 0).collect::<Vec<_>>(), "{name}");
        for (at, n) in places(&with).into_iter().zip(1..) {
            assert!((at - 200 * n).abs() <= 4, "{name}: action {n} at {at}");
        }
    }
}

#[test]
fn what_is_off_in_a_pause_goes_off_and_comes_back_once() {
    let script = format!(
        "{HEAD}G1 X5\nSYNC SetOut 3, ON\nSYNC SetOut 4, ON\nG1 X30\nSYNC SetOut 3, OFF\nG1 X40\nWait 20ms"
    );
    for (name, outcome, events) in paused(&script, &pause_at(500, 1_500)) {
        assert_eq!(acts(&events), [(4, 3, 1), (5, 4, 1), (7, 3, 0)], "{name}");
        let own = edges(&outcome.record, 3);
        let [(on, true), (away, false), (back, true), (off, false)] = own[..] else {
            panic!("{name}: {own:?}")
        };
        // The axes brake for up to a quarter of a second.
        assert!(on < away && (500_000..760_000).contains(&away), "{name}: {own:?}");
        assert!((1_500_000..1_520_000).contains(&back) && back < off, "{name}: {own:?}");
        let [(_, true), (end, false)] = edges(&outcome.record, 4)[..] else { panic!("{name}") };
        assert!(end > off, "{name}: output 4 stays on in the pause");
        assert!((places(&events)[2] - 3000).abs() <= 4, "{name}");
    }
}

#[test]
fn lags_that_end_in_a_pause_switch_off_at_once_and_on_behind_it() {
    // Output 3 is off in the pause, output 4 stays: their lags end at some 770 ms, when the axes rest.
    let head = format!("{HEAD}SYNC SetOut 4, ON\nG1 X5\n");
    let tail = "G1 X40\nWait 20ms";
    let world = pause_at(300, 1_500);
    let first = |record: &Record, n| edges(record, n).first().map(|(us, _)| *us).unwrap_or(0);
    let script = format!("{head}SYNC SetOut 3, ON, -600ms\nSYNC SetOut 4, OFF, -600ms\n{tail}");
    for (name, outcome, events) in paused(&script, &world) {
        assert_eq!(acts(&events).len(), 3, "{name}");
        let on = first(&outcome.record, 3);
        assert!((1_500_000..1_520_000).contains(&on), "{name}: {on} us");
        let [(_, true), (off, false)] = edges(&outcome.record, 4)[..] else { panic!("{name}") };
        assert!((600_000..1_000_000).contains(&off), "{name}: {off} us");
    }
    // An older one that goes on and a later one that goes off, both in the pause, leave it off.
    let script = format!("{head}SYNC SetOut 3, ON, -600ms\nSYNC SetOut 3, OFF, -700ms\n{tail}");
    for (name, outcome, _) in paused(&script, &world) {
        assert_eq!(edges(&outcome.record, 3), [], "{name}");
    }
}

#[test]
fn a_pulse_that_a_pause_keeps_off_comes_once_after_it() {
    // Output 3 is off in the pause, output 4 is not: on both the lag ends when the axes rest.
    let head = format!("{HEAD}SYNC SetOut 5, ON\nG1 X5\n");
    let script =
        format!("{head}SYNC Pulse 3, 30ms, -600ms\nSYNC Pulse 4, 30ms, -600ms\nG1 X40\nWait 20ms");
    for (name, outcome, _) in paused(&script, &pause_at(300, 1_500)) {
        for n in [3, 4] {
            let [(on, true), (off, false)] = edges(&outcome.record, n)[..] else {
                panic!("{name}, output {n}: {:?}", edges(&outcome.record, n))
            };
            assert!((1_500_000..1_520_000).contains(&on), "{name}, output {n}: {on} us");
            // Its milliseconds are counted whole, and the pass that switches it on may come late in the first one.
            assert!((28_000..=31_000).contains(&(off - on)), "{name}, output {n}: {} us", off - on);
        }
    }
    // One that the pause interrupts has the rest of its time after it.
    let script = format!("{HEAD}SYNC Pulse 3, 900ms\nG1 X40\nWait 20ms");
    for (name, outcome, _) in paused(&script, &pause_at(300, 1_500)) {
        let own = edges(&outcome.record, 3);
        let [(on, true), (away, false), (back, true), (off, false)] = own[..] else {
            panic!("{name}: {own:?}")
        };
        let long = away - on + off - back;
        assert!((898_000..=902_000).contains(&long), "{name}: {long} us, {own:?}");
    }
}

#[test]
fn the_newest_command_on_an_output_counts() {
    let lengths = |script: &str| {
        runs(script, "")
            .into_iter()
            .map(|(name, outcome, _)| {
                assert_eq!(outcome.end.status, Status::Done, "{name}");
                (name, edges(&outcome.record, 3))
            })
            .collect::<Vec<_>>()
    };
    // A pulse within a pulse, 10 mm at 30 mm/s later.
    let two = format!("{HEAD}SYNC Pulse 3, 400ms\nG1 X10\nSYNC Pulse 3, 400ms\nG1 X50\n");
    for (name, own) in lengths(&two) {
        let [(on, true), (off, false)] = own[..] else { panic!("{name}: {own:?}") };
        assert!((700_000..780_000).contains(&(off - on)), "{name}: {own:?}");
    }
    // SYNC SetOut, and a SetOut that waits for the path's end, within a pulse.
    for later in
        ["SYNC SetOut 3, ON\nG1 X50\n", "SetOut 3, ON\nG1 X50\n", "Pulse 3, 500ms\nG1 X50\n"]
    {
        let script = format!("{HEAD}SYNC Pulse 3, 600ms\nG1 X10\n{later}");
        for (name, own) in lengths(&script) {
            let [(on, true), (off, false)] = own[..] else { panic!("{name}, {later}: {own:?}") };
            assert!(off - on > 900_000, "{name}, {later}: {own:?}");
        }
    }
}

#[test]
fn outputs_of_the_controller_are_not_the_programs() {
    let mill = include_str!("../../examples/profiles/mill.toml");
    let own = "\n[[output]]\nn = 6\nrole = \"enable\"\n[[output]]\nn = 7\nrole = \"lamp\"\n";
    let profile = Profile::parse(&(mill.to_owned() + own)).expect("a mill");
    for n in [6, 7] {
        for statement in [
            "SetOut n, OFF",
            "SetOut n, ON",
            "Pulse n, 5ms",
            "SYNC SetOut n, OFF",
            "SYNC Pulse n, 5ms",
        ] {
            let script = format!("{HEAD}DIM n\nn = {n}\nG1 X5\n{statement}\nG1 X10\nWait 20ms");
            let source = Source::new("t.bas", script.clone());
            let (program, diags) =
                compile(&source, ProfileChoice::Given(Box::new(profile.clone())));
            let program = program.unwrap_or_else(|| panic!("{script}: {}", diags.render(&source)));
            for (name, outcome, _) in runs_of(program, "") {
                assert_eq!(
                    outcome.end.fault,
                    Some(lang::fault::Fault::ValueRange),
                    "{name}, {statement}, {n}"
                );
            }
        }
    }
}

#[test]
fn a_stop_drops_them_on_the_way_and_in_a_pause() {
    let script = format!(
        "{HEAD}SYNC Pulse 5, 10s\nG1 X5\nSYNC SetOut 3, ON, -3s\nG1 X30\nSYNC SetOut 4, ON\nG1 X60\nWait 5s"
    );
    // Stop for two seconds ends the run, from its pause.
    for (name, outcome, events) in paused(&script, "hold_stop(300, 2300);") {
        assert_eq!(outcome.end.status, Status::Stopped, "{name}");
        assert_eq!(acts(&events), [(3, 5, 1)], "{name}");
        assert_eq!(edges(&outcome.record, 3), [], "{name}");
        assert_eq!(edges(&outcome.record, 4), [], "{name}");
        let [(_, true), (off, false)] = edges(&outcome.record, 5)[..] else { panic!("{name}") };
        assert!((2_300_000..2_320_000).contains(&off), "{name}: {off} us");
    }
    for (name, outcome, _) in
        paused(&script, "at(300, || press_stop()); at(900, || press_estop());")
    {
        assert_eq!(outcome.end.status, Status::Fault, "{name}");
        assert_eq!(edges(&outcome.record, 3), [], "{name}");
        let [(_, true), (off, false)] = edges(&outcome.record, 5)[..] else { panic!("{name}") };
        assert!((899_000..906_000).contains(&off), "{name}: {off} us");
    }
}

/// The override goes up and down in the middle of the path, and in a pause: each action keeps its place and comes once.
#[test]
fn an_override_moves_no_action_from_its_place() {
    let script = forty(toggled);
    let compiled = lang::back::compile(&program(&script)).expect("an image");
    let mut stand = Stand::native();
    stand.upload(&compiled.image, false).expect("it is taken");
    stand.control(Control::Start);
    let (mut was, mut seen) = (false, Vec::new());
    for ms in 0..20_000_u32 {
        stand.board.run_us(1_000);
        let (on, at) = (stand.board.plant().output(3), stand.board.plant().motors[0].position);
        if on != was {
            (was, seen) = (on, [seen, vec![at]].concat());
        }
        match ms {
            400 => _ = stand.write(OVERRIDES, &[200]),
            900 => _ = stand.write(OVERRIDES, &[30]),
            1_500 => {
                stand.control(Control::Pause);
                stand.board.run_us(700_000);
                assert_eq!(stand.state(), Some(RunState::Paused as u16));
                // It starts nothing that is stopped.
                let rests = stand.board.plant().motors[0].position;
                stand.write(OVERRIDES, &[150]);
                stand.board.run_us(300_000);
                assert_eq!(stand.board.plant().motors[0].position, rests);
                stand.control(Control::Resume);
            }
            _ => {}
        }
    }
    assert_eq!(stand.state(), Some(RunState::Ready as u16));
    assert_eq!(seen.len(), 40, "{seen:?}");
    for (at, n) in seen.into_iter().take(39).zip(1..) {
        // Looked at each millisecond, and during a write later.
        assert!((at - 200 * n).abs() <= 30, "action {n} at {at}");
    }
}

/// A handler goes on with the run, so no output comes into its fault state: what was to go off goes off.
#[test]
fn a_fault_that_is_handled_leaves_on_nothing_that_was_to_go_off() {
    let script = "DIM far AS LENGTH = 500mm\nON ERROR GOTO again\nHome\nF1800\nG1 X5\nSYNC SetOut 3, ON\nSYNC Pulse 5, 10s\nG1 X10\n\
         SYNC SetOut 3, OFF\nSYNC SetOut 4, ON\nG1 X[far]\nG1 X40\nWait 1s\nEND\nagain:\nfar = 30mm\nRESUME";
    for (name, outcome, _) in runs(script, "") {
        assert_eq!(outcome.end.status, Status::Done, "{name}");
        let [(on, true), (off, false)] = edges(&outcome.record, 3)[..] else {
            panic!("{name}: {:?}", edges(&outcome.record, 3))
        };
        assert!(off - on < 400_000, "{name}: {on} to {off} us");
        assert_eq!(edges(&outcome.record, 4), [], "{name}");
        let [(_, true), (end, false)] = edges(&outcome.record, 5)[..] else { panic!("{name}") };
        assert!(end.abs_diff(off) < 5_000, "{name}: {end} us");
    }
}

/// Six lags that reach beyond the path leave no room for a seventh, and no motion comes before it that would make some.
#[test]
fn too_many_that_lie_beyond_the_path_are_a_fault_and_none_acts_early() {
    let mut script = HEAD.to_owned();
    for n in 1..=8 {
        let on = if n % 2 == 1 { "ON" } else { "OFF" };
        script += &format!("G1 X{}\nSYNC SetOut 3, {on}, -5mm\n", f64::from(n) / 2.0);
    }
    script += "G1 X20";
    for (name, outcome, events) in runs(&script, "") {
        assert_eq!(outcome.end.status, Status::Fault, "{name}");
        assert_eq!(edges(&outcome.record, 3), [], "{name}");
        assert!(acts(&events).iter().all(|(_, _, on)| *on == 0), "{name}");
    }
}
