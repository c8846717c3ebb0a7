//! The analog output at the pin of the emulated board: its part of the time, what interrupts the work, and values on the way.

mod rig;

use emulator::{Board, Edge, Format, Link, Parity, Signal, Silicon};
use lang::fault::Fault;
use lang::profile::{Aout, Profile, Wiring};
use lang::wire::{self, Control, RunState};
use rig::company::{Company, fast, start};
use rig::{BOOT_US, give, off, on, read, wired, write};

/// Input of the emergency stop, of the hold, of the door, of X's reference switch.
const ESTOP: u8 = 4;
const HOLD: u8 = 3;
const DOOR: u8 = 2;
const LIMIT: u8 = 1;

/// Three axes with switches at the pins, both lines open, and an analog output of these keys. 50 Hz: what waits for a period shows.
fn machine(hz: u16, keys: &str) -> Profile {
    wired(
        "direct",
        &format!(
            "[[input]]\nn = {ESTOP}\nrole = \"emergency_stop\"\n[[input]]\nn = {HOLD}\nrole = \"hold\"\n\
             [[input]]\nn = {DOOR}\nrole = \"door\"\n[rs485]\naddress = 5\n\
             [[aout]]\nn = 1\nname = \"blow\"\nfrequency_hz = {hz}\nfull_mv = 1000\n{keys}"
        ),
    )
}

fn started(profile: &Profile, script: &str) -> Board {
    let mut board = on(Silicon::default(), profile, script);
    write(&mut board, wire::RUN_CONTROL, Control::Start as u16);
    board.record(true);
    board
}

fn value(board: &mut Board) -> u16 {
    read(board, wire::AOUTS).expect("an answer")
}

/// Edges of the pin in so many ms.
fn edges(board: &mut Board, ms: u64) -> Vec<Edge> {
    board.take_edges();
    board.run_us(ms * 1000);
    let own = |edge: &Edge| edge.signal == Signal::Aout;
    board.take_edges().into_iter().filter(own).collect()
}

/// Part of the time for which the pin is high.
fn duty(edges: &[Edge]) -> f64 {
    let falls: Vec<u64> = edges.iter().filter(|edge| !edge.level).map(|edge| edge.cycle).collect();
    let [first, .., last] = falls[..] else { return 0.0 };
    let pulses = edges.windows(2).filter(|pair| pair[0].level && pair[0].cycle > first);
    let high: u64 = pulses.map(|pair| pair[1].cycle - pair[0].cycle).sum();
    high as f64 / (last - first) as f64
}

/// Where the pulses became wider or narrower: tenths of a period of 50 us, and X's steps until then.
fn changes(board: &mut Board) -> Vec<(u64, i32)> {
    let second = board.ticks_per_second();
    let (mut steps, mut rise, mut seen) = (0, 0, Vec::new());
    for edge in board.take_edges() {
        match edge.signal {
            Signal::Step(0) if edge.level => steps += 1,
            Signal::Aout if edge.level => rise = edge.cycle,
            Signal::Aout => {
                let part = ((edge.cycle - rise) * 200_000 + second / 2) / second;
                if seen.last().is_none_or(|(last, _)| *last != part) {
                    seen.push((part, steps));
                }
            }
            _ => {}
        }
    }
    seen
}

fn holds(board: &mut Board, mv: u16, what: &str) {
    assert_eq!(value(board), mv, "{what}");
    let part = duty(&edges(board, 200));
    assert!((part - f64::from(mv) / 1000.0).abs() < 3e-3, "{what}: {part} for {mv}");
}

/// A long path with values on the way, the last of which is far.
const LONG: &str = "SetPos X, 0mm\nF1200\nSetAout blow, 300mV\nG1 X4\nSYNC SetAout 1, 600mV\nG1 X60\n\
                    M67 E1 Q0.9\nG1 X120\nWait 10s";

/// A board on its way, with 600 mV.
fn under_way(keys: &str) -> Board {
    let mut board = started(&machine(50, keys), LONG);
    board.run_us(600_000);
    assert_eq!(value(&mut board), 600);
    board
}

#[test]
fn the_pin_is_high_for_the_part_of_the_time_that_the_value_says() {
    for hz in [50, 1000, 20_000] {
        for mv in [0, 10, 500, 990, 1000] {
            let mut board = started(&machine(hz, ""), &format!("SetAout 1, {mv}mV\nWait 5s"));
            board.run_us(50_000);
            holds(&mut board, mv, &format!("{hz} Hz"));
        }
    }
    // By its register, at any time, in its range only.
    let mut board = on(Silicon::default(), &machine(1000, "safe = 100\n"), "Wait 1s");
    board.record(true);
    holds(&mut board, 100, "after a reset");
    write(&mut board, wire::AOUTS, 700);
    holds(&mut board, 700, "by register");
    let body = rig::write_body(wire::AOUTS, 1001);
    assert_eq!(rig::ask(&mut board, &body, 20_000).get(1..3), Some(&[0x86, 3][..]));
    holds(&mut board, 700, "a value beyond");
}

/// A request of function 16.
fn several(register: u16, values: &[u16]) -> Vec<u8> {
    let [high, low] = register.to_be_bytes();
    let count = values.len() as u8;
    let values = values.iter().flat_map(|value| value.to_be_bytes());
    [1, 16, high, low, 0, count, 2 * count].into_iter().chain(values).collect()
}

#[test]
fn a_request_that_cannot_be_done_whole_changes_nothing() {
    let mut board = on(Silicon::default(), &machine(1000, "safe = 100\n"), "Wait 1s");
    let places =
        [wire::AOUTS, wire::OVERRIDES, wire::UPLOAD_LENGTH, wire::OUTPUTS, wire::POSITIONS];
    let before = places.map(|register| read(&mut board, register));
    for (body, exception) in [
        // Registers that stay 0, behind one that takes values.
        (several(wire::AOUTS, &[700, 0, 0, 0, 0, 0, 0, 0]), 2),
        (several(wire::AOUTS, &[700, 0]), 2),
        (several(wire::OVERRIDES, &[50, 5]), 3),
        // The second one is only read.
        (several(wire::UPLOAD_LENGTH, &[9, 9]), 2),
        // A fourth axis.
        (several(wire::POSITIONS, &[5, 0, 5, 0, 5, 0, 5, 0]), 3),
        // Outputs 1 to 3 of two.
        (vec![1, 15, 0, 0, 0, 3, 1, 7], 2),
    ] {
        let reply = rig::ask(&mut board, &body, 20_000);
        assert_eq!(reply.get(1..3), Some(&[body[1] | 0x80, exception][..]), "{body:?}");
        assert_eq!(places.map(|register| read(&mut board, register)), before, "{body:?}");
    }
    let whole = several(wire::OVERRIDES, &[50, 20]);
    assert_eq!(rig::ask(&mut board, &whole, 20_000).get(..6), Some(&whole[..6]));
    assert_eq!(read(&mut board, wire::OVERRIDES), Some(50));
    assert_eq!(read(&mut board, wire::OVERRIDES + 1), Some(20));
}

#[test]
fn an_emergency_stop_in_the_middle_of_a_path_puts_the_pin_low_at_once_and_for_good() {
    let mut board = under_way("");
    // Where a period is high.
    while board.bus_read8(0x0220) >> 6 & 1 == 0 {
        board.run_us(100);
    }
    board.take_edges();
    let at = board.cycles();
    board.plant_mut().set_input(ESTOP, true);
    let after = edges(&mut board, 500);
    let [fall] = after[..] else { panic!("{after:?}") };
    let us = (fall.cycle - at) * 1_000_000 / board.ticks_per_second();
    assert!(!fall.level && us < 10, "{us} us");
    assert_eq!(read(&mut board, wire::FAULT), Some(14));
    holds(&mut board, 0, "pressed");
    board.plant_mut().set_input(ESTOP, false);
    board.run_us(50_000);
    write(&mut board, wire::RUN_CONTROL, Control::Acknowledge as u16);
    assert_eq!(edges(&mut board, 3_000), []);
    holds(&mut board, 0, "released");
}

#[test]
fn the_safe_value_holds_after_faults_stops_ends_and_resets() {
    type Order = fn(&mut Board);
    let orders: [(&str, Order); 4] = [
        ("emergency stop at its pin", |board| board.plant_mut().set_input(ESTOP, true)),
        ("by register", |board| write(board, wire::RUN_CONTROL, Control::EmergencyStop as u16)),
        ("Stop", |board| write(board, wire::RUN_CONTROL, Control::Stop as u16)),
        ("RST", |board| board.reset_pin()),
    ];
    for (what, order) in orders {
        let mut board = under_way("safe = 100\n");
        order(&mut board);
        board.run_us(700_000);
        holds(&mut board, 100, what);
        board.run_us(4_000_000);
        assert_eq!(value(&mut board), 100, "{what}, later");
    }
    let ends = [
        ("the end", "", 0),
        ("a fault", "DIM n\nn = 1 / n\n", 2),
        ("a value beyond", "DIM v AS VOLTAGE = 900mV\nSetAout 1, v * 2\n", 20),
        ("one beyond on the way", "DIM v AS VOLTAGE = 900mV\nSYNC SetAout 1, v - 1V\nG1 X5\n", 20),
    ];
    for (what, end, fault) in ends {
        let mut board = started(
            &machine(50, "safe = 100\n"),
            &format!("F1200\nSetAout 1, 600mV\nWait 200ms\n{end}"),
        );
        board.run_us(100_000);
        assert_eq!(value(&mut board), 600, "{what}");
        board.run_us(1_000_000);
        assert_eq!(read(&mut board, wire::FAULT), Some(fault), "{what}");
        holds(&mut board, 100, what);
    }
}

#[test]
fn a_pause_keeps_it_or_gives_it_its_safe_value_as_the_profile_says() {
    let cases = [("", 600), ("pause = \"safe\"\n", 0), ("safe = 50\npause = \"safe\"\n", 50)];
    for ((keys, paused), input) in cases.into_iter().flat_map(|case| [(case, HOLD), (case, DOOR)]) {
        let what = format!("input {input}: {keys}");
        let mut board = under_way(keys);
        board.plant_mut().set_input(input, true);
        board.run_us(700_000);
        holds(&mut board, paused, &what);
        // Nobody goes on while it is on.
        write(&mut board, wire::RUN_CONTROL, Control::Resume as u16);
        board.run_us(100_000);
        assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Paused as u16), "{what}");
        holds(&mut board, paused, &what);
        board.plant_mut().set_input(input, false);
        board.run_us(50_000);
        holds(&mut board, paused, &what);
        write(&mut board, wire::RUN_CONTROL, Control::Resume as u16);
        board.run_us(100_000);
        holds(&mut board, 600, &what);
        write(&mut board, wire::OVERRIDES, 200);
        board.run_us(4_000_000);
        holds(&mut board, 900, &what);
    }
}

#[test]
fn a_value_whose_time_comes_in_a_pause_waits_for_its_end_but_the_safe_one() {
    // The lag ends in the pause.
    let cases = [
        ("pause = \"safe\"\n", 900, 0, 900),
        ("safe = 50\npause = \"safe\"\n", 900, 50, 900),
        ("safe = 50\npause = \"safe\"\n", 0, 50, 0),
        ("safe = 50\npause = \"safe\"\n", 50, 50, 50),
        ("", 900, 900, 900),
        ("", 0, 0, 0),
    ];
    for (keys, mv, paused, after) in cases {
        let what = format!("{mv} mV, {keys}");
        let script = format!(
            "SetPos X, 0mm\nF1200\nSetAout blow, 600mV\nG1 X4\nSYNC SetAout 1, {mv}mV, -1s\nG1 X120"
        );
        let mut board = started(&machine(50, keys), &script);
        board.run_us(500_000);
        assert_eq!(value(&mut board), 600, "{what}");
        board.plant_mut().set_input(DOOR, true);
        board.run_us(2_000_000);
        holds(&mut board, paused, &what);
        // A host's own value goes with the pause.
        write(&mut board, wire::AOUTS, 333);
        holds(&mut board, 333, &what);
        board.plant_mut().set_input(DOOR, false);
        board.run_us(50_000);
        write(&mut board, wire::RUN_CONTROL, Control::Resume as u16);
        board.run_us(100_000);
        holds(&mut board, after, &what);
    }
}

#[test]
fn a_fault_that_a_handler_takes_lets_the_safe_value_come_and_nothing_else() {
    // The safe value, the one that waits for a block behind the path's end, and what holds in the handler.
    for (safe, last, held) in [(0, 0, 0), (100, 100, 100), (100, 0, 900), (0, 300, 900)] {
        let what = format!("safe {safe}, {last} mV last");
        let script = format!(
            "DIM none\nON ERROR GOTO away\nSetPos X, 0mm\nF1200\nSetAout 1, 600mV\nG1 X4\n\
             SYNC SetAout 1, 900mV\nG1 X8\nSYNC SetAout 1, {last}mV\nPRINT 1 / none\nEND\n\
             away:\nWait 3s\nEND"
        );
        let mut board = started(&machine(50, &format!("safe = {safe}\n")), &script);
        board.run_us(600_000);
        holds(&mut board, held, &what);
        board.run_us(1_000_000);
        holds(&mut board, held, &what);
        board.run_us(2_000_000);
        assert_eq!(read(&mut board, wire::RUN_STATE), Some(RunState::Ready as u16), "{what}");
        holds(&mut board, safe, &format!("{what}, at the end"));
    }
}

#[test]
fn a_value_leaves_the_pulse_of_the_output_with_its_number_alone() {
    let script =
        "SetPos X, 0mm\nF1200\nG1 X4\nSYNC Pulse 1, 200ms\nG1 X5\nSYNC SetAout 1, 600mV\nG1 X20";
    let mut board = started(&machine(1000, ""), script);
    let pin = |board: &mut Board| read(board, wire::OUTPUTS).expect("an answer") & 1;
    board.run_us(240_000);
    assert_eq!(pin(&mut board), 1);
    board.run_us(40_000);
    assert_eq!((value(&mut board), pin(&mut board)), (600, 1));
    board.run_us(200_000);
    assert_eq!((value(&mut board), pin(&mut board)), (600, 0));
}

#[test]
fn a_limit_switch_puts_the_pin_low_at_once_and_the_safe_value_follows() {
    for safe in [0, 100] {
        let script =
            "SetPos X, 0mm\nF1200\nSetAout 1, 600mV\nG1 X-60\nSYNC SetAout 1, 900mV\nG1 X-80";
        let mut board = started(&machine(20_000, &format!("safe = {safe}\n")), script);
        board.run_us(300_000);
        holds(&mut board, 600, "before");
        board.take_edges();
        let at = board.cycles();
        board.plant_mut().set_input(LIMIT, true);
        board.run_us(300_000);
        let second = board.ticks_per_second();
        let own: Vec<Edge> =
            board.take_edges().into_iter().filter(|edge| edge.signal == Signal::Aout).collect();
        // Pulses of 600 mV are 30 us wide.
        let wide = own.windows(2).filter(|pair| {
            let width = pair[1].cycle - pair[0].cycle;
            pair[0].level && pair[0].cycle > at + second / 20_000 && width * 100_000 > second
        });
        assert_eq!(wide.count(), 0, "safe {safe}: it comes again");
        assert_eq!(read(&mut board, wire::FAULT), Some(Fault::LimitSwitch.number().into()));
        holds(&mut board, safe, "after");
    }
}

#[test]
fn with_both_lines_busy_values_keep_their_places_and_an_emergency_stop_its_time() {
    let mut profile = fast(20_000);
    profile.wiring = Wiring::Direct;
    profile.inputs[0].n = ESTOP.into();
    profile.aouts =
        vec![Aout { n: 1, frequency_hz: Some(20_000), full_mv: Some(1000), ..Aout::default() }];
    let script = "SetPos X, 0mm\nF3000\nG1 X10\nSYNC SetAout 1, 600mV\nG1 X20\nSYNC SetAout 1, 300mV\nG1 X30\n\
                  M67 E1 Q0.8\nG1 X40\nSYNC SetAout 1, 500mV\nG1 X400";
    let mut board = off(Silicon::default(), &profile, script);
    board.power_up();
    board.set_uart_format_on(Link::Rs485, Format { baud: 115_200, parity: Parity::None });
    board.run_us(BOOT_US);
    board.record(true);
    start(&mut board);
    let mut company = Company::new([true; 2]);
    let mut run = |board: &mut Board, ms: u64| {
        for _ in 0..2 * ms {
            company.ask(board);
            board.run_us(500);
        }
    };
    run(&mut board, 1_500);
    let seen = changes(&mut board);
    // 50 mm/s at 100 steps/mm: 5 steps in a millisecond.
    // A period between two values may have a width between theirs.
    let wanted = [(6, 1_000_i32), (3, 2_000), (8, 3_000), (5, 4_000)];
    let near = |(_, place): &(u64, i32), at: &i32| (at - place).abs() <= 6;
    for own in &wanted {
        assert!(seen.iter().any(|(part, at)| *part == own.0 && near(own, at)), "{own:?}: {seen:?}");
    }
    assert!(seen.iter().all(|(_, at)| wanted.iter().any(|own| near(own, at))), "{seen:?}");
    assert_eq!(seen.last().map(|own| own.0), Some(5), "{seen:?}");
    // Where a period is high.
    while board.bus_read8(0x0220) >> 6 & 1 == 0 {
        board.run_for(100);
    }
    board.take_edges();
    let at = board.cycles();
    board.plant_mut().set_input(ESTOP, true);
    run(&mut board, 300);
    let mut own = board.take_edges().into_iter().filter(|edge| edge.signal == Signal::Aout);
    let last = own.next_back().expect("it was high");
    let us = last.cycle.saturating_sub(at) * 1_000_000 / board.ticks_per_second();
    assert!(!last.level && us < 60, "{us} us");
    board.run_us(50_000);
    assert_eq!(read(&mut board, wire::FAULT), Some(Fault::EmergencyStop.number().into()));
    assert_eq!(value(&mut board), 0);
}

#[test]
fn a_board_whose_profile_has_no_output_takes_no_value_and_leaves_the_pin_alone() {
    for statement in
        ["SetAout 1, 600mV", "SYNC SetAout 1, 600mV\nG1 X5", "SYNC SetAout 1, 0mV\nG1 X5"]
    {
        let script = format!("F1200\nWait 50ms\n{statement}\nWait 1s");
        let mut board = off(Silicon::default(), &machine(1000, ""), &script);
        give(&mut board, &wired("direct", ""));
        board.power_up();
        board.run_us(BOOT_US);
        board.record(true);
        let body = rig::write_body(wire::AOUTS, 0);
        assert_eq!(rig::ask(&mut board, &body, 20_000).get(1..3), Some(&[0x86, 3][..]));
        assert_eq!(value(&mut board), 0);
        write(&mut board, wire::RUN_CONTROL, Control::Start as u16);
        assert_eq!(edges(&mut board, 300), [], "{statement}");
        assert_eq!(
            read(&mut board, wire::FAULT),
            Some(Fault::ValueRange.number().into()),
            "{statement}"
        );
        // P3DIR
        assert_eq!(board.bus_read8(0x0224) >> 6 & 1, 0, "{statement}: the pin is driven");
    }
}

#[test]
fn a_value_on_the_way_comes_at_its_place_whatever_the_override_is() {
    let script = "SetPos X, 0mm\nF1200\nG1 X4\nSYNC SetAout 1, 600mV\nG1 X8\nSYNC SetAout 1, 300mV, 1mm\nG1 X12\n\
                  M67 E1 Q0\nG1 X16";
    for percent in [100, 30, 200] {
        let mut board = on(Silicon::default(), &machine(20_000, ""), script);
        write(&mut board, wire::OVERRIDES, percent);
        board.record(true);
        write(&mut board, wire::RUN_CONTROL, Control::Start as u16);
        board.run_us(4_000_000);
        let seen = changes(&mut board);
        let at: Vec<i32> = seen.iter().map(|(_, at)| *at).collect();
        let parts: Vec<u64> = seen.iter().map(|(part, _)| *part).collect();
        assert_eq!(parts.last(), Some(&3), "{percent} %: {seen:?}");
        // 40 mm/s at most and 80 steps/mm: 3 steps in a millisecond.
        assert!((at[0] - 320).abs() <= 4, "{percent} %: {seen:?}");
        assert!((at[at.len() - 1] - 560).abs() <= 8, "{percent} %: {seen:?}");
    }
}

#[test]
fn no_period_is_dark_or_full_while_the_value_changes() {
    let script = "DIM i, v AS VOLTAGE\nWait 20ms\nFOR i = 1 TO 400\nv = 200mV + 10mV * (i * 37 MOD 61)\nSetAout 1, v\nNEXT\n\
                  Wait 5s";
    for hz in [1000, 5000, 20_000] {
        let mut board = started(&machine(hz, ""), script);
        let own = edges(&mut board, 400);
        let period = board.ticks_per_second() as f64 / f64::from(hz);
        let parts = |level: bool| {
            let own = own.windows(2).filter(move |pair| pair[0].level == level);
            own.map(|pair| (pair[1].cycle - pair[0].cycle) as f64 / period).collect::<Vec<_>>()
        };
        let (high, low) = (parts(true), parts(false));
        assert!(high.len() > 100, "{hz} Hz");
        let widest = high.iter().copied().fold(0.0, f64::max);
        let least = high.iter().copied().fold(1.0, f64::min);
        assert!(least > 0.19 && widest < 0.82, "{hz} Hz: {least} to {widest}");
        let dark = low.iter().copied().fold(0.0, f64::max);
        assert!(dark < 0.82, "{hz} Hz: low for {dark} of a period");
    }
}
