//! The pin of the emulated board, and what becomes of the value when the work is interrupted.

use std::time::Duration;

use emulator::{Edge, Signal};
use lang::fault::Fault;
use lang::profile::Profile;
use lang::record::BoardRecord;
use lang::wire::{AOUTS, Control, FAULT, OVERRIDES};
use pasapas::bench::stand::Stand;
use pasapas::client::ClientError;
use pasapas::client::aout::AoutUnit;
use pasapas::client::identity::differences;
use pasapas::link::Link as _;
use pasapas::stream::feed::Feed;
use pasapas::stream::job::Job;
use pasapas::stream::pump;

use super::{checked, mill};

/// Ticks of the board in a microsecond.
const US: u64 = 10_000;

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
    let text = include_str!("../../../examples/profiles/mill.toml")
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

/// Something that happens to the board.
type Order = fn(&mut Stand);

#[test]
fn the_safe_value_holds_after_faults_stops_ends_and_resets() {
    let profile = guarded("safe = 100\n");
    let safe = |stand: &mut Stand, what: &str| {
        assert_eq!(value(stand), 100, "{what}");
        let (part, _) = duty(&edges(stand, 300));
        assert!((part - 0.1).abs() < 2e-3, "{what}: {part}");
    };
    let orders: [(&str, Order); 4] = [
        ("emergency stop at its pin", |stand| press(stand, 4, true)),
        ("by register", |stand| stand.client().control(Control::EmergencyStop).expect("taken")),
        ("Stop", |stand| stand.client().control(Control::Stop).expect("taken")),
        ("RST", |stand| {
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
