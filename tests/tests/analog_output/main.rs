//! The analog output: the same trace on every engine, its voltage at the pin of the emulated board, and what becomes of it when the
//! work is interrupted.

mod board;

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;
use lang::image::Image;
use lang::part::Signals;
use lang::profile::Profile;
use pasapas::sim::Outcome;
use pasapas::sim::trace::{Event, Status, What, to_text};
use tests::on_every_engine;

const HEAD: &str = "SetPos X, 0mm : SetPos Y, 0mm\nF1800\n";

/// The mill with an analog output of these keys, and what else.
fn mill(keys: &str) -> Profile {
    let text = include_str!("../../../examples/profiles/mill.toml");
    Profile::parse(&format!("{text}\n[[aout]]\nn = 1\nname = \"blow\"\n{keys}")).expect("a profile")
}

/// What the check says of a script, warnings too.
fn told(profile: &Profile, script: &str) -> String {
    let source = Source::new("t.bas", script.to_owned());
    let (_, diags) = compile(&source, ProfileChoice::Given(Box::new(profile.clone())));
    diags.render(&source)
}

fn checked(profile: &Profile, script: &str) -> Result<Program, String> {
    let source = Source::new("t.bas", script.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::Given(Box::new(profile.clone())));
    program.ok_or_else(|| diags.render(&source))
}

/// Runs of a script: its engines, each with its name.
fn runs(profile: &Profile, script: &str, world: &str) -> Vec<(&'static str, Outcome, Vec<Event>)> {
    let program = checked(profile, script).unwrap_or_else(|told| panic!("{told}"));
    on_every_engine(&program, world)
}

/// What the trace says of the output: line, mV, share, on the way.
fn values(events: &[Event]) -> Vec<(u32, Option<i32>, Option<i32>, bool)> {
    let value = |event: &Event| match event.what {
        What::Aout { line, n: 1, mv, share, sync, .. } => Some((line, mv, share, sync)),
        _ => None,
    };
    events.iter().filter_map(value).collect()
}

/// Where axis X was, steps, when each action came.
fn places(events: &[Event]) -> Vec<i32> {
    let place = |event: &Event| match &event.what {
        What::Aout { pos: Some(pos), .. } => pos.values()[0],
        _ => None,
    };
    events.iter().filter_map(place).collect()
}

#[test]
fn a_value_is_one_line_of_the_trace_on_every_engine() {
    let script = "CONST FULL = 3300mV\nDIM v AS VOLTAGE = 2V\nSetAout 1, FULL\nSetAout blow, v / 2\nM68 E1 Q0.7\n\
                  M68 E1 Q[v - 1500mV]\nSetAout 1, 0V";
    let mv = [(3, 3300), (4, 1000), (5, 700), (6, 500), (7, 0)];
    let wanted = mv.map(|(line, mv)| (line, Some(mv), None, false));
    let all = runs(&mill(""), script, "");
    for (name, outcome, events) in &all {
        assert_eq!(outcome.end.status, Status::Done, "{name}");
        assert_eq!(values(events), wanted, "{name}");
        assert_eq!(to_text(events), to_text(&all[0].2), "{name}");
    }
    assert!(to_text(&all[0].2).contains(r#"{"ev":"aout","line":4,"n":1,"mv":1000}"#));
    // A share of the range, without units.
    let script = "DIM part = 40\nSetAout blow, part + 2\nM68 E1 Q100\nSYNC SetAout 1, part\nM67 E1 Q7\nG1 X5 F600";
    for (name, _, events) in runs(&mill("range = 100\n"), script, "") {
        let told = values(&events);
        let parts: Vec<_> = told.iter().map(|own| (own.2, own.1)).collect();
        assert_eq!(parts, [42, 100, 40, 7].map(|n| (Some(n), None)), "{name}");
    }
}

#[test]
fn a_value_beyond_the_range_is_a_fault_and_told_where_it_is_known_before() {
    for value in ["v * 2", "v - 4V"] {
        for statement in ["SetAout 1, ", "SYNC SetAout 1, "] {
            let script =
                format!("DIM v AS VOLTAGE = 2V\nSetOut 3, ON\n{statement}{value}\nG1 X5 F600");
            for (name, outcome, events) in runs(&mill(""), &script, "") {
                assert_eq!(outcome.end.status, Status::Fault, "{name}, {script}");
                let Some(What::End { fault: Some(fault), line: 3, .. }) =
                    events.last().map(|event| &event.what)
                else {
                    panic!("{name}: {events:?}")
                };
                assert_eq!((&fault[..], values(&events)), ("F20", vec![]), "{name}");
            }
        }
    }
    let wrong = [
        ("SetAout 1, 3301mV", "0mV to 3300mV"),
        ("SetAout 1, -1mV", "0mV to 3300mV"),
        ("M68 E1 Q3.4", "0mV to 3300mV"),
        ("SetAout 1, 50", "a Voltage"),
        ("SetAout 2, 1V", "no analog output 2"),
        ("M67 E3 Q1", "no analog output 3"),
        ("M67 E1", "without the value"),
        ("M68 Q1", "without the number"),
        ("M67 E1 Q[5mm]", "volts"),
        ("G1 X1 E5 F600", "E has no meaning"),
        ("DIM n = 1\nSetAout n, 1V", "only known at run time"),
        ("SetOut blow, ON", "analog output"),
        ("PRINT AIN(blow)", "analog output"),
        ("blow = 3", "SetAout name"),
        ("SetAout 1", "expected"),
        ("SYNC SetAout 1, 1V, 60ms", "too long"),
    ];
    for (script, text) in wrong {
        let told = told(&mill(""), script);
        assert!(told.contains(text), "{script}: {told}");
    }
    let plain = Profile::built_in("mill").expect("built in");
    let told = checked(&plain, "SetAout 1, 1V").err().unwrap_or_default();
    assert!(told.contains("no analog output 1") && told.contains("[[aout]]"), "{told}");
    // What is a name today stays one.
    assert!(checked(&plain, "DIM setaout\nsetaout = 3\nPRINT setaout").is_ok());
}

#[test]
fn the_small_chip_refuses_program_and_profile_by_name() {
    let profile = mill("");
    for script in ["SetAout 1, 1V", "M67 E1 Q1\nG1 X5 F600"] {
        let program = checked(&profile, script).expect("a program");
        let compiled = lang::back::compile(&program).expect("an image");
        let image = Image::new(&compiled.image).expect("an image");
        let lacks = lang::part::G2553.all_lacks(&image, Signals::from(&profile));
        let told: Vec<String> = lacks.map(|lack| lack.to_string()).collect();
        assert!(told.iter().any(|lack| lack.contains("an analog output")), "{told:?}");
        assert_eq!(lang::part::F5529.lacks(&image, Signals::from(&profile)), None);
    }
    let program = checked(&profile, "Wait 1ms").expect("a program");
    let compiled = lang::back::compile(&program).expect("an image");
    let image = Image::new(&compiled.image).expect("an image");
    let lack = lang::part::G2553.lacks(&image, Signals::from(&profile)).expect("no output");
    assert!(lack.to_string().contains("[[aout]]"), "{lack}");
}

#[test]
fn profiles_that_contradict_themselves_are_refused_and_others_come_back_from_a_board() {
    let text = include_str!("../../../examples/profiles/mill.toml");
    let wrong = [
        ("n = 2\n", "aout.n"),
        ("n = 1\nfull_mv = 0\n", "aout.full_mv"),
        ("n = 1\nrange = 30001\n", "aout.range"),
        ("n = 1\nrange = 10\nfull_mv = 10\n", "full_mv and range"),
        ("n = 1\nsafe = 3301\n", "aout.safe"),
        ("n = 1\nfrequency_hz = 49\n", "aout.frequency_hz"),
        ("n = 1\n[[aout]]\nn = 1\n", "two [[aout]]"),
        ("n = 1\nfrequency_hz = 60\n[pwm]\noutput = 1\nkind = \"spindle\"\n", "one timer"),
    ];
    for (keys, told) in wrong {
        let error = Profile::parse(&format!("{text}\n[[aout]]\n{keys}")).expect_err(keys);
        assert!(error.to_string().contains(told), "{keys}: {error}");
    }
    for keys in
        ["", "range = 30000\nsafe = 30000\n", "full_mv = 10000\nsafe = 1\npause = \"safe\"\n"]
    {
        let profile = mill(keys);
        let record = lang::record::BoardRecord::of(&profile, 1);
        let back = record.into_profile(&profile);
        assert_eq!(back.aouts[0].full(), profile.aouts[0].full(), "{keys}");
        assert_eq!(back.aouts[0].is_share(), profile.aouts[0].is_share(), "{keys}");
        assert_eq!(
            (back.aouts[0].safe, back.aouts[0].pause),
            (profile.aouts[0].safe, profile.aouts[0].pause)
        );
    }
}

#[test]
fn values_on_the_way_keep_their_places_and_take_no_time() {
    let forty = |with: &dyn Fn(i32) -> String| {
        (1..=40).fold(HEAD.to_owned(), |script, n| {
            let before = if n > 1 { with(n) } else { String::new() };
            format!("{script}{before}G1 X{} F{}\n", 2 * n, [1800, 1200, 2400][n as usize / 7 % 3])
        })
    };
    let profile = mill("");
    let plain = runs(&profile, &forty(&|_| String::new()), "");
    let words = |n: i32| match n % 3 {
        0 => format!("M67 E1 Q{}.{}\n", n / 20, n % 10),
        1 => format!("SYNC SetAout 1, {}mV\n", 80 * n),
        _ => "SYNC SetAout blow, 0V\n".to_owned(),
    };
    let synced = runs(&profile, &forty(&words), "");
    for ((name, without, _), (_, with, events)) in plain.iter().zip(&synced) {
        assert_eq!(with.end.status, Status::Done, "{name}");
        let (before, after) = (without.summary.us as f64, with.summary.us as f64);
        assert!(after < 1.02 * before, "{name}: {after} us for {before}");
        assert_eq!(values(events).len(), 39, "{name}");
        assert_eq!(values(events), values(&synced[0].2), "{name}");
        for (at, n) in places(events).into_iter().zip(1..) {
            assert!((at - 200 * n).abs() <= 4, "{name}: value {n} at {at}");
        }
    }
}
