//! The analog output: the same trace on every engine, its voltage at the pin of the emulated board, and what becomes of it when the
//! work is interrupted.

use std::time::Duration;

use emulator::{Edge, Signal};
use lang::fault::Fault;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;
use lang::image::Image;
use lang::part::Signals;
use lang::profile::Profile;
use lang::record::BoardRecord;
use lang::wire::{AOUTS, Control, FAULT, OVERRIDES};
use pasapas::bench::stand::Stand;
use pasapas::board::{DEFAULT, engine};
use pasapas::client::ClientError;
use pasapas::client::aout::AoutUnit;
use pasapas::client::identity::differences;
use pasapas::link::Link as _;
use pasapas::sim::trace::{Event, Status, What, to_text};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, Outcome, run_traced};
use pasapas::stream::feed::Feed;
use pasapas::stream::job::Job;
use pasapas::stream::pump;

/// Ticks of the board in a microsecond.
const US: u64 = 10_000;

const HEAD: &str = "SetPos X, 0mm : SetPos Y, 0mm\nF1800\n";

/// The mill with an analog output of these keys, and what else.
fn mill(keys: &str) -> Profile {
    let text = include_str!("../../examples/profiles/mill.toml");
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
fn runs(profile: &Profile, script: &str, world: &str) -> Vec<(String, Outcome, Vec<Event>)> {
    let program = checked(profile, script).unwrap_or_else(|told| panic!("{told}"));
    let world = World::parse("w.rhai", world).expect("a world");
    let options = Options { part: DEFAULT.part, limit_us: 30_000_000, ..Options::default() };
    let mut all = Vec::new();
    for engine in [Engine::Rhai, Engine::Vm] {
        let (outcome, events) = run_traced(&program, engine, &world, &options).expect("a run");
        all.push((format!("{engine:?}"), outcome, events));
    }
    let compiled = lang::back::compile(&program).expect("an image");
    let (run, events) =
        engine::run_native_traced(DEFAULT, &program, &compiled, &world, &options).expect("a run");
    all.push(("native".to_owned(), run.outcome, events));
    let (image, sidecar) = (&compiled.image, &compiled.sidecar);
    let (run, events) =
        engine::run_traced(DEFAULT, &program, image, sidecar, &world, &options).expect("a run");
    all.push(("board".to_owned(), run.outcome, events));
    all
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
    let text = include_str!("../../examples/profiles/mill.toml");
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

/// A board that runs a script.
fn board(profile: &Profile, script: &str) -> Stand {
    let mut stand = Stand::new(profile).expect("a board");
    let program = checked(profile, script).unwrap_or_else(|told| panic!("{told}"));
    let compiled = lang::back::compile(&program).expect("it fits");
    stand.upload(&compiled.image).expect("stored");
    stand.rig().borrow_mut().board().record(true);
    stand.client().control(Control::Start).expect("started");
    stand
}

fn pause(stand: &mut Stand, ms: u64) {
    stand.client().link().pause(Duration::from_millis(ms));
}

/// The value that the register shows.
fn value(stand: &mut Stand) -> u16 {
    stand.client().holding(AOUTS, 1).expect("an answer")[0]
}

/// Edges of the output's pin from now on, for so long.
fn edges(stand: &mut Stand, ms: u64) -> Vec<Edge> {
    stand.rig().borrow_mut().board().take_edges();
    pause(stand, ms);
    let all = stand.rig().borrow_mut().board().take_edges();
    all.into_iter().filter(|edge| edge.signal == Signal::Aout).collect()
}

/// Part of the time for which the pin is high, and the periods in a second.
fn duty(edges: &[Edge]) -> (f64, f64) {
    let falls: Vec<u64> = edges.iter().filter(|edge| !edge.level).map(|edge| edge.cycle).collect();
    let [first, .., last] = falls[..] else { return (0.0, 0.0) };
    let pulses = edges.windows(2).filter(|pair| pair[0].level && pair[0].cycle > first);
    let high: u64 = pulses.map(|pair| pair[1].cycle - pair[0].cycle).sum();
    let periods = (falls.len() - 1) as f64;
    (high as f64 / (last - first) as f64, periods * 1e6 * US as f64 / (last - first) as f64)
}

#[test]
fn the_pin_is_high_for_the_part_of_the_time_that_the_value_says() {
    for hz in [50, 1000, 20_000] {
        let profile = mill(&format!("frequency_hz = {hz}\nfull_mv = 10000\n"));
        for mv in [1, 100, 5_000, 9_900, 10_000] {
            let mut stand = board(&profile, &format!("SetAout 1, {mv}mV\nWait 5s"));
            pause(&mut stand, 50);
            assert_eq!(value(&mut stand), mv);
            let (part, rate) = duty(&edges(&mut stand, 200));
            // Whole ticks of the timer, of which 20 000 Hz have 1 250.
            assert!((part - f64::from(mv) / 10_000.0).abs() < 2e-3, "{hz} Hz, {mv} mV: {part}");
            if part > 0.0 {
                assert!((rate / f64::from(hz) - 1.0).abs() < 3e-3, "{hz} Hz: {rate}");
            }
        }
    }
}

#[test]
fn no_period_is_dark_or_full_while_the_value_changes() {
    let profile = mill("frequency_hz = 5000\nrange = 100\n");
    let script = "DIM i, v\nFOR i = 1 TO 400\nv = 20 + (i * 37 MOD 61)\nSetAout 1, v\nNEXT\n";
    let mut stand = board(&profile, script);
    pause(&mut stand, 5);
    let own = edges(&mut stand, 300);
    let widths: Vec<f64> = own
        .windows(2)
        .filter(|pair| pair[0].level)
        .map(|pair| (pair[1].cycle - pair[0].cycle) as f64 / (200 * US) as f64)
        .collect();
    let still = widths.iter().position(|part| (part - widths[widths.len() - 1]).abs() > 1e-9);
    assert!(still.is_some(), "it changes: {widths:?}");
    assert!(widths.iter().all(|part| (0.19..0.82).contains(part)), "{widths:?}");
    let periods = own.iter().filter(|edge| edge.level).map(|edge| edge.cycle / (200 * US));
    let gaps = own.windows(2).filter(|pair| !pair[0].level);
    assert!(
        gaps.clone().all(|pair| pair[1].cycle - pair[0].cycle < 170 * US),
        "{}",
        periods.count()
    );
}

/// The mill with switches at the chip's pins, an emergency stop at input 4, a hold at input 3, both lines busy.
fn guarded(keys: &str) -> Profile {
    let text = include_str!("../../examples/profiles/mill.toml")
        .replace("wiring = \"chain\"", "wiring = \"direct\"");
    let text = format!(
        "{text}\n[[input]]\nn = 4\nrole = \"emergency_stop\"\n[[input]]\nn = 3\nrole = \"hold\"\n[rs485]\naddress = 5\n\n\
         [[aout]]\nn = 1\nfrequency_hz = 50\nfull_mv = 1000\n{keys}"
    );
    Profile::parse(&text).expect("a profile")
}

/// A long path with values on the way, of which the last never comes before a stop.
const LONG: &str = "SetPos X, 0mm\nF1200\nSetAout 1, 300mV\nSetOut 2, ON\nG1 X2\nSYNC SetAout 1, 600mV\nG1 X60\n\
                    SYNC SetAout 1, 900mV\nG1 X120\nWait 10s";

/// When the pin was high last, of these edges; 0 for never.
fn last_high(edges: &[Edge]) -> u64 {
    assert!(edges.last().is_none_or(|edge| !edge.level), "it stays high");
    edges.last().map_or(0, |edge| edge.cycle)
}

fn now(stand: &Stand) -> u64 {
    stand.rig().borrow_mut().board().cycles()
}

fn press(stand: &Stand, input: u8, down: bool) {
    stand.rig().borrow_mut().board().plant_mut().set_input(input, down);
}

#[test]
fn an_emergency_stop_in_the_middle_of_a_path_puts_the_pin_low_at_once() {
    // 50 Hz: what waits for a period shows.
    let mut stand = board(&guarded(""), LONG);
    pause(&mut stand, 600);
    assert_eq!(value(&mut stand), 600);
    // Until the pin is high.
    stand.rig().borrow_mut().board().take_edges();
    pause(&mut stand, 1);
    let at = now(&stand);
    press(&stand, 4, true);
    let after = edges(&mut stand, 600);
    assert!(last_high(&after) < at + 10 * US, "{} us", last_high(&after).saturating_sub(at) / US);
    assert_eq!(value(&mut stand), 0);
    // It stays off when the contact closes again and the fault is acknowledged.
    press(&stand, 4, false);
    pause(&mut stand, 50);
    stand.client().control(Control::Acknowledge).expect("taken");
    assert_eq!(edges(&mut stand, 200), []);
    assert_eq!(value(&mut stand), 0);
}

#[test]
fn the_safe_value_holds_after_faults_stops_ends_and_resets() {
    let profile = guarded("safe = 100\n");
    let safe = |stand: &mut Stand, what: &str| {
        assert_eq!(value(stand), 100, "{what}");
        let (part, _) = duty(&edges(stand, 300));
        assert!((part - 0.1).abs() < 2e-3, "{what}: {part}");
    };
    let orders: [(&str, &dyn Fn(&mut Stand)); 4] = [
        ("emergency stop at its pin", &|stand| press(stand, 4, true)),
        ("by register", &|stand| stand.client().control(Control::EmergencyStop).expect("taken")),
        ("Stop", &|stand| stand.client().control(Control::Stop).expect("taken")),
        ("RST", &|stand| {
            stand.rig().borrow_mut().board().reset_pin();
            stand.client().link().pause(Duration::from_millis(300));
            stand.client().find().expect("an answer");
        }),
    ];
    for (what, order) in orders {
        let mut stand = board(&profile, LONG);
        pause(&mut stand, 600);
        assert_eq!(value(&mut stand), 600, "{what}");
        order(&mut stand);
        pause(&mut stand, 700);
        safe(&mut stand, what);
        // Nothing that was still to come does.
        pause(&mut stand, 3_000);
        assert_eq!(value(&mut stand), 100, "{what}");
    }
    for (what, end) in [
        ("the end", ""),
        ("a fault", "DIM n\nn = 1 / n\n"),
        ("one on the way", "G1 X5\nSYNC SetAout 1, 900mV, -5s\n"),
    ] {
        let mut stand = board(&profile, &format!("F1200\nSetAout 1, 600mV\nWait 100ms\n{end}"));
        pause(&mut stand, 60);
        assert_eq!(value(&mut stand), 600, "{what}");
        pause(&mut stand, 8_000);
        safe(&mut stand, what);
    }
}

#[test]
fn a_pause_keeps_it_or_gives_it_its_safe_value_as_the_profile_says() {
    for (keys, in_pause) in
        [("", 600), ("pause = \"safe\"\n", 0), ("safe = 50\npause = \"safe\"\n", 50)]
    {
        let mut stand = board(&guarded(keys), LONG);
        pause(&mut stand, 600);
        assert_eq!(value(&mut stand), 600);
        press(&stand, 3, true);
        pause(&mut stand, 700);
        assert_eq!(value(&mut stand), in_pause, "{keys}");
        press(&stand, 3, false);
        pause(&mut stand, 50);
        stand.client().control(Control::Resume).expect("taken");
        pause(&mut stand, 100);
        assert_eq!(value(&mut stand), 600, "{keys}");
        stand.client().write(OVERRIDES, 200).expect("taken");
        pause(&mut stand, 4_000);
        assert_eq!(value(&mut stand), 900, "{keys}");
    }
}

#[test]
fn a_stop_in_a_pause_leaves_the_safe_value_and_no_resume_brings_the_old_one() {
    for keys in ["safe = 100\n", "safe = 100\npause = \"safe\"\n"] {
        let mut stand = board(&guarded(keys), LONG);
        pause(&mut stand, 600);
        press(&stand, 3, true);
        pause(&mut stand, 700);
        stand.client().control(Control::Stop).expect("taken");
        pause(&mut stand, 300);
        assert_eq!(value(&mut stand), 100, "{keys}");
        press(&stand, 3, false);
        pause(&mut stand, 50);
        stand.client().control(Control::Resume).expect("taken");
        pause(&mut stand, 300);
        assert_eq!(value(&mut stand), 100, "{keys}");
        let (part, _) = duty(&edges(&mut stand, 300));
        assert!((part - 0.1).abs() < 2e-3, "{keys}: {part}");
    }
}

#[test]
fn a_streamed_job_without_its_host_ends_with_the_safe_value() {
    for safe in [0, 100] {
        let profile = guarded(&format!("safe = {safe}\n"));
        let program = checked(&profile, LONG).unwrap_or_else(|told| panic!("{told}"));
        let compiled = lang::back::compile(&program).expect("an image");
        let mut stand = Stand::new(&profile).expect("a board");
        stand.rig().borrow_mut().board().record(true);
        let client = stand.client();
        let slots = client.stream_slots().expect("an answer").expect("it can stream");
        let mut job = Job::new(Feed::new(&compiled).expect("an image"), slots.bytes.into());
        let gone = pump::run_observed(
            client,
            &mut job,
            slots,
            &mut |_| None,
            None,
            &mut |client, _, _| match client.holding(AOUTS, 1)?[0] {
                600 => Err(ClientError::Interrupted),
                _ => Ok(()),
            },
        );
        assert!(gone.is_err(), "it went on");
        // Nobody feeds it for two seconds, then it comes to rest.
        pause(&mut stand, 4_000);
        let fault = stand.client().holding(FAULT, 1).expect("an answer")[0];
        assert_eq!(fault, u16::from(Fault::LinkLost.number()));
        assert_eq!(value(&mut stand), safe);
        let (part, _) = duty(&edges(&mut stand, 300));
        assert!((part - f64::from(safe) / 1000.0).abs() < 2e-3, "{safe}: {part}");
    }
}

/// A program does not come to a board that was told of another output, or of none.
#[test]
fn a_board_without_the_output_is_another_machine() {
    let record = |profile: &Profile| BoardRecord::of(profile, 1);
    let plain = Profile::built_in("mill").expect("built in");
    for (held, wanted) in
        [(&plain, &mill("")), (&mill(""), &plain), (&mill("safe = 3\n"), &mill(""))]
    {
        let found = differences(&record(held), &record(wanted));
        assert_eq!(found, ["analog output"]);
    }
}

#[test]
fn a_client_finds_the_output_with_its_unit() {
    let kinds = [("", Some(AoutUnit::Voltage)), ("range = 100\n", Some(AoutUnit::Share))];
    for (keys, unit) in kinds {
        let mut stand = board(&mill(keys), "Wait 5s");
        assert_eq!(stand.client().aout_unit().expect("an answer"), unit, "{keys}");
        stand.client().write(AOUTS, 42).expect("taken");
        let own = stand.client().aouts(unit).expect("an answer")[0];
        let value = Some(42);
        assert_eq!(
            (own.n, own.mv.or(own.share), own.share.is_some()),
            (1, value, !keys.is_empty())
        );
    }
    let plain = Profile::built_in("mill").expect("built in");
    let mut stand = Stand::new(&plain).expect("a board");
    assert_eq!(stand.client().aout_unit().expect("an answer"), None);
    assert_eq!(stand.client().aouts(None).expect("nothing to ask"), []);
}
