//! Analog inputs and thresholds: what a script sees of them is the same on the model, on the firmware's machine and on the
//! emulated board with its converter.

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;
use lang::profile::Profile;
use pasapas::board::engine::run_native_traced;
use pasapas::board::{DEFAULT, engine};
use pasapas::sim::trace::{Event, What, to_text};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};

fn program(profile: &Profile, script: &str) -> Program {
    let source = Source::new("t.bas", script.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::Given(Box::new(profile.clone())));
    program.unwrap_or_else(|| panic!("{}", diags.render(&source)))
}

/// The traces of a script by its engines, each with its name.
fn traces(profile: &Profile, script: &str, world: &str) -> Vec<(String, Vec<Event>)> {
    let (program, world) =
        (program(profile, script), World::parse("w.rhai", world).expect("a world"));
    let mut all = Vec::new();
    let options = Options { part: DEFAULT.part, ..Options::default() };
    for engine in [Engine::Rhai, Engine::Vm] {
        let (_, events) = run_traced(&program, engine, &world, &options).expect("a run");
        all.push((format!("{engine:?}"), events));
    }
    let compiled = lang::back::compile(&program).expect("an image");
    let native = run_native_traced(DEFAULT, &program, &compiled, &world, &options);
    all.push(("the machine without an emulator".to_owned(), native.expect("a run").1));
    let run =
        engine::run_traced(DEFAULT, &program, &compiled.image, &compiled.sidecar, &world, &options);
    all.push(("the board".to_owned(), run.expect("a run").1));
    all
}

/// The one trace that all engines give.
fn trace(profile: &Profile, script: &str, world: &str) -> Vec<Event> {
    let mut all = traces(profile, script, world).into_iter();
    let (_, first) = all.next().expect("an engine");
    for (name, events) in all {
        assert_eq!(to_text(&events), to_text(&first), "{name}\n{script}");
    }
    first
}

fn printed(events: &[Event]) -> Vec<String> {
    let text = |event: &Event| match &event.what {
        What::Print { text, .. } => Some(text.clone()),
        _ => None,
    };
    events.iter().filter_map(text).collect()
}

fn picker() -> Profile {
    Profile::built_in("picker").expect("built in")
}

/// Four analog inputs with filters, and four thresholds of both directions, one of them with a role.
fn bench() -> Profile {
    Profile::parse(&bench_text()).expect("a profile")
}

fn bench_text() -> String {
    let mut text = include_str!("../../examples/profiles/mill.toml").to_owned();
    for (n, filter) in [(1, 1), (2, 2), (3, 16), (4, 32)] {
        text += &format!("[[analog]]\nn = {n}\nfilter_ms = {filter}\n");
    }
    for (input, analog, on, off) in
        [(18, 1, 2000, 1000), (19, 2, 500, 900), (20, 3, 3300, 0), (21, 4, 0, 1)]
    {
        text += &format!(
            "[[threshold]]\ninput = {input}\nanalog = {analog}\non_mv = {on}\noff_mv = {off}\n"
        );
    }
    text
}

#[test]
fn a_voltage_is_read_to_the_millivolt_by_every_engine() {
    let script = "PRINT AIN(1); \" \"; AIN(2); \" \"; AIN(3); \" \"; AIN(4)\n";
    for volts in
        [[0, 1, 2, 3], [799, 800, 801, 1650], [3300, 3299, 3298, 0], [1234, 2345, 17, 3000]]
    {
        let world: String =
            (1..).zip(volts).map(|(n, mv): (i32, i32)| format!("set_ain({n}, {mv});")).collect();
        let [a, b, c, d] = volts;
        let expected = format!("{a}mV {b}mV {c}mV {d}mV");
        assert_eq!(printed(&trace(&bench(), script, &world)), [expected]);
    }
}

#[test]
fn a_threshold_is_an_input_like_any_other() {
    let script = "DIM n, up, down\n\
                  ON IN 18 RISE GOSUB rises\n\
                  ON IN 18 FALL GOSUB falls\n\
                  PRINT IN(18); IN(19); IN(20); IN(21); \" \"; INPORT() / 65536\n\
                  WaitIn 18, ON, 2s\n\
                  PRINT IN(18); IN(19); \" \"; INPORT() / 65536\n\
                  WaitIn 18, FALL\n\
                  WaitIn? 18, RISE, 300ms\n\
                  n = 18\n\
                  PRINT TIMEDOUT; IN(n); up; down\n\
                  WaitIn n, RISE, 1s\n\
                  Wait 20ms\n\
                  PRINT up; down\n\
                  END\n\
                  rises: up = up + 1\n RETURN\n\
                  falls: down = down + 1\n RETURN\n";
    // 18 is on from 2000 mV on and off at 1000; 1001 in between leaves it as it is.
    let world = "set_ain(2, 400); at(100, || set_ain(1, 1999)); at(300, || set_ain(1, 2000)); at(400, || set_ain(1, 1001));
                 at(500, || ramp_ain(1, 0, 200)); at(1400, || ramp_ain(1, 3300, 100));";
    let events = trace(&bench(), script, world);
    assert_eq!(printed(&events), ["0101 20", "11 22", "1011", "21"]);
}

#[test]
fn a_probe_and_a_hold_work_by_a_voltage() {
    let script =
        "Probe X, 20mm, 10mm/s, 18, ON\nPRINT PROBEOK(X)\nMoveAxe X, 0mm\nPRINT \"home\"\n";
    let mut profile = bench();
    let world = "at(900, || set_ain(1, 2500)); at(2000, || set_ain(1, 0));";
    for (name, events) in traces(&profile, script, world) {
        assert_eq!(printed(&events), ["1", "home"], "{name}");
        let caught = events.iter().find_map(|event| match &event.what {
            What::Probe { pos, ok: true, .. } => Some(*pos),
            _ => None,
        });
        // 10 mm/s for 0.9 s, 100 steps a millimetre, looked at each millisecond; the ramp costs some.
        let caught = caught.unwrap_or_else(|| panic!("{name}: it answers"));
        assert!((850..=905).contains(&caught), "{name}: {caught}");
    }
    let text = bench_text() + "\n[[input]]\nn = 18\nrole = \"hold\"\n";
    profile = Profile::parse(&text).expect("with a role");
    let script = "MoveAxe X, 10mm, 10mm/s\nPRINT \"there\"\n";
    let world = "at(300, || set_ain(1, 2500)); at(2300, || { set_ain(1, 0); after(50, || press_start()); });";
    for (name, events) in traces(&profile, script, world) {
        let us = events.iter().find_map(|event| match &event.what {
            What::Print { .. } => event.us,
            _ => None,
        });
        let us = us.unwrap_or_else(|| panic!("{name}: it arrives"));
        assert!(
            (3_000_000..3_200_000).contains(&us),
            "{name}: held for two seconds, there after {us} us"
        );
    }
}

#[test]
fn an_input_that_no_threshold_makes_is_f20_everywhere() {
    let script = "DIM n\nn = 19\nON ERROR GOTO bad\nWaitIn n, ON, 10ms\nPRINT IN(n)\nn = 17\nPRINT IN(n)\nEND\n\
                  bad: PRINT \"F\"; ERR; \" line \"; ERL\nRESUME NEXT\n";
    let events = trace(&picker(), script, "");
    assert_eq!(printed(&events), ["F20 line 4", "F20 line 5", "0"]);
}

/// A filter is the board's: on the desktop the same rule gives the same input within two milliseconds.
#[test]
fn a_filtered_threshold_comes_at_the_same_time_on_every_engine() {
    let script = "WaitIn 20, ON\nPRINT \"up\"\nWaitIn 21, ON\nPRINT \"down\"\n";
    let world = "set_ain(4, 3300); at(50, || set_ain(3, 3300)); at(1000, || set_ain(4, 0));";
    let times = |events: &[Event]| -> Vec<u64> {
        let print = |event: &Event| matches!(event.what, What::Print { .. }).then_some(event.us);
        events.iter().filter_map(print).flatten().collect()
    };
    let all = traces(&bench(), script, world);
    let board = times(&all.last().expect("the board").1);
    for (name, events) in &all {
        let own = times(events);
        assert_eq!(own.len(), 2, "{name}");
        for (own, board) in own.iter().zip(&board) {
            assert!(own.abs_diff(*board) <= 2_000, "{name}: {own} us, the board {board} us");
        }
    }
}

#[test]
fn what_a_part_or_a_profile_lacks_is_named() {
    let told = |profile: &str, script: &str| {
        let source = Source::new("t.bas", script.to_owned());
        let profile = Profile::built_in(profile).expect("built in");
        compile(&source, ProfileChoice::Given(Box::new(profile))).1.render(&source)
    };
    assert!(told("mill", "PRINT AIN(1)\n").contains("the machine `mill` has no analog input 1"));
    assert!(told("picker", "PRINT AIN(2)\n").contains("its analog inputs are 1"));
    assert!(told("picker", "DIM n\nPRINT AIN(n)\n").contains("only known at run time"));
    assert!(told("picker", "PRINT IN(pressure)\n").contains("is an analog input"));
    assert!(told("picker", "PRINT AIN(held)\n").contains("`held` is an input"));
    assert!(told("picker", "WaitIn 19, ON\n").contains("its inputs are 1 to 17, 18"));
    assert!(told("picker", "IF AIN(1) > 5 THEN PRINT 1\n").contains("1.2V"));
    let compiled =
        lang::back::compile(&program(&picker(), "PRINT AIN(pressure)\n")).expect("an image");
    let image = lang::image::Image::new(&compiled.image).expect("sound");
    let signals = lang::part::Signals::from(&picker());
    let lack = lang::part::G2553.lacks(&image, signals).expect("no converter");
    assert_eq!(lack.to_string(), "analog inputs ([[analog]] in the profile)");
    assert_eq!(lang::part::F5529.lacks(&image, signals), None);
}
