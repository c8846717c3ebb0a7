//! What a client says and hears, one thing at a time.

use lang::fault::Fault;
use lang::wire::RunState;

use super::machine::Bench;
use crate::grbl::order::Order;

const OK: &str = "ok\r\n";

#[test]
fn the_welcome_comes_by_itself_and_each_line_has_one_answer() {
    let mut bench = Bench::new();
    assert_eq!(bench.heard, "\r\nGrbl 1.1h ['$' for help]\r\n");
    bench.heard.clear();
    bench.send(b"\n\n\r\n\rG21\n\r(word)\n");
    assert_eq!(bench.heard, OK.repeat(7));
    assert_eq!(bench.state(), "Idle");
    for (line, answer) in [
        ("G1X1", "error:22\r\n"),
        ("$Q", "error:3\r\n"),
        ("$$=1", "error:3\r\n"),
        ("G1X", "error:2\r\n"),
        ("$10=x", "error:2\r\n"),
        ("$N1=G0", "[MSG:no start-up lines here: let a program of the board do it]\r\nerror:3\r\n"),
    ] {
        assert_eq!(bench.ask(line), answer, "{line}");
    }
    bench.heard.clear();
    bench.send(b"G4P0\r");
    bench.send(b"?");
    bench.send(b"\n");
    assert_eq!(bench.heard.matches(OK).count(), 1, "a report between CR and LF: {}", bench.heard);
    bench.heard.clear();
    bench.send("G0X1\u{e9}\n".as_bytes());
    bench.send(&[b'X'; 300]);
    bench.send(b"\n");
    // The letter's first byte acts at once, and is none of Grbl's; what is left is a good line.
    assert_eq!(bench.heard, "ok\r\nerror:11\r\n");
}

#[test]
fn reports_tell_offsets_and_overrides_now_and_then() {
    let mut bench = Bench::new();
    let first = bench.status();
    assert_eq!(first, "<Idle|MPos:0.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000>\r\n");
    assert!(bench.status().contains("|Ov:100,100,100>"));
    assert!(!bench.status().contains("WCO"));
    bench.ask("G10L20P1X5");
    assert!(bench.status().contains("|WCO:-5.000,0.000,0.000>"));
    bench.send(b"\x91\xC2\x91\x95\x96\x9A");
    assert!(bench.status().contains("|Ov:120,50,110>"), "C2 is nothing");
    bench.ask("$10=2");
    assert!(bench.status().starts_with("<Idle|WPos:5.000,0.000,0.000|Bf:15,128|FS:0,0"));
    bench.ask("$13=1");
    assert!(bench.status().starts_with("<Idle|WPos:0.1969,0.0000,0.0000|"));
}

#[test]
fn a_line_is_answered_when_there_is_room_ahead_of_the_machine() {
    let mut bench = Bench::new();
    bench.machine.pace = 10;
    bench.heard.clear();
    for n in 0..200 {
        bench.send(format!("G1X{}F60\n", n % 100 + 1).as_bytes());
    }
    let taken = bench.heard.matches("ok").count();
    assert!((100..=110).contains(&taken), "{taken}");
    assert_eq!(bench.state(), "Run");
    for _ in 0..2100 {
        bench.step();
    }
    assert_eq!(bench.heard.matches("ok").count(), 200);
    assert_eq!(bench.state(), "Idle");
}

#[test]
fn short_lines_of_a_picture_may_be_more() {
    let mut bench = Bench::on("laser");
    bench.machine.pace = 100_000;
    bench.send(b"G91M4S0\n");
    for n in 0..200 {
        bench.send(format!("G1X0.1F6000S{n}\n").as_bytes());
    }
    assert_eq!(bench.heard.matches("ok").count(), 201);
}

#[test]
fn sync_lines_wait_for_rest() {
    let mut bench = Bench::new();
    bench.machine.pace = 5;
    for line in ["G4P0", "G4P0.1", "G10L20P1X0", "G28.1", "M400", "M114", "M2"] {
        bench.heard.clear();
        bench.send(b"G0X5\n");
        bench.send(b"G0X0\n");
        bench.send(format!("{line}\n").as_bytes());
        assert_eq!(bench.heard, OK.repeat(2), "{line}");
        bench.wait();
        assert!(bench.heard.ends_with(OK) && bench.heard.len() > 2 * OK.len(), "{line}");
        bench.ask("G10L2P1X0");
    }
    bench.ask("G10L20P1X-10");
    assert_eq!(bench.ask("M114"), "X:-10.000 Y:0.000 Z:0.000\r\nok\r\n");
    assert_eq!(bench.ask("M30"), "[MSG:Pgm End]\r\nok\r\n");
}

#[test]
fn a_hold_before_the_first_piece_is_remembered() {
    let mut bench = Bench::new();
    bench.send(b"!");
    assert_eq!(bench.state(), "Hold:0");
    assert_eq!(bench.ask("G0X5"), OK);
    assert_eq!((bench.state(), bench.machine.view.steps[0]), ("Hold:0".to_owned(), 0));
    bench.send(b"~");
    bench.step();
    assert_eq!(bench.state(), "Run");
    bench.send(b"!");
    bench.step();
    assert_eq!(bench.state(), "Hold:1");
    bench.step();
    assert_eq!(bench.state(), "Hold:0");
    bench.send(b"~");
    bench.wait();
    assert_eq!((bench.state(), bench.machine.view.steps[0]), ("Idle".to_owned(), 500));
}

#[test]
fn a_jog_is_cancelled_by_a_byte_and_leaves_modal_words_alone() {
    let mut bench = Bench::new();
    bench.machine.pace = 50;
    assert_eq!(bench.ask("$J=G91 X5 F600").lines().count(), 1);
    bench.heard.clear();
    bench.send(b"$J=G91X5F100000\n$J=G91X5F1000\n");
    bench.step();
    assert_eq!((bench.state(), bench.heard.as_str()), ("Jog".to_owned(), "ok\r\nok\r\n"));
    assert_eq!(bench.ask("G0X1").lines().next(), Some("error:9"));
    bench.send(b"$J=G91X5F1000\n");
    bench.send("\u{85}".as_bytes());
    bench.wait();
    assert_eq!(bench.state(), "Idle");
    assert!(bench.machine.rests());
    assert!(bench.ask("$G").contains("G90"), "as before");
    for (line, answer) in [
        ("$J=X1", 22),
        ("$J=F100", 26),
        ("$J=G2X1F1", 16),
        ("$J=X1X2F1", 25),
        ("$J=G53X301F1", 15),
        ("$J=X-1F1", 15),
        ("$J=X1F-1", 4),
        ("$J=", 22),
    ] {
        assert_eq!(bench.ask(line), format!("error:{answer}\r\n"), "{line}");
    }
    assert_eq!(bench.state(), "Idle", "no alarm");
    // A held jog ends, too.
    bench.send(b"$J=G53X100F1000\n");
    bench.step();
    bench.send(b"!");
    bench.wait();
    assert_eq!(bench.state(), "Idle");
}

#[test]
fn a_reset_in_motion_ramps_down_and_keeps_the_place() {
    let mut bench = Bench::new();
    bench.machine.pace = 5;
    bench.send(b"G91G20G1X1F600\nX1\nX1\n");
    for _ in 0..7 {
        bench.step();
    }
    bench.heard.clear();
    bench.send(b"\x18?");
    assert_eq!(bench.heard, "", "it still ramps down");
    bench.wait();
    let welcome = "\r\nGrbl 1.1h ['$' for help]\r\n";
    let report = bench.heard.strip_prefix(welcome).expect("no alarm");
    assert!(report.starts_with("<Idle|MPos:25.400,"), "what was asked meanwhile: {report}");
    assert_eq!(bench.machine.view.steps[0], 2540);
    assert!(bench.ask("$G").contains("G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0"));
    bench.ask("G1X26F600");
    assert_eq!(bench.machine.view.steps[0], 2600);
}

#[test]
fn a_soft_limit_is_an_alarm_before_anything_moves() {
    let mut bench = Bench::new();
    let heard = bench.ask("G0X301");
    assert_eq!(heard, "ALARM:2\r\n[MSG:Reset to continue]\r\n");
    assert_eq!((bench.state(), bench.machine.done.len()), ("Alarm".to_owned(), 0));
    assert_eq!(bench.ask("G0X1"), "", "only a reset is heard");
    assert!(bench.ask("\x18").contains("[MSG:'$H'|'$X' to unlock]"));
    assert_eq!(bench.ask("G0X1"), "error:9\r\n");
    assert_eq!(bench.ask("$X"), "[MSG:Caution: Unlocked]\r\nok\r\n");
    assert_eq!(bench.ask("G0X1"), OK);
}

#[test]
fn faults_are_alarms_by_their_meaning() {
    for (fault, alarm, critical) in [
        (Fault::LimitSwitch, 1, true),
        (Fault::EmergencyStop, 3, true),
        (Fault::LinkLost, 3, true),
        (Fault::InputActive, 4, false),
        (Fault::HomeStaysClosed, 8, false),
        (Fault::HomeNotFound, 9, false),
    ] {
        let mut bench = Bench::new();
        bench.machine.pace = 50;
        bench.send(b"G0X5\nG0X6\n");
        bench.step();
        bench.heard.clear();
        bench.machine.fail(fault);
        bench.step();
        assert!(bench.heard.starts_with(&format!("ALARM:{alarm}\r\n")), "{}", bench.heard);
        assert_eq!(bench.heard.contains("Reset to continue"), critical, "{fault}");
        assert_eq!(bench.state(), "Alarm");
        if critical {
            bench.send(b"\x18");
            bench.wait();
        }
        assert_eq!(bench.ask("G0X1"), "error:9\r\n");
        bench.ask("$X");
        assert_eq!(bench.machine.view.state, Some(RunState::Ready), "acknowledged");
        assert_eq!(bench.ask("G0X1"), OK);
        assert_eq!(bench.machine.view.steps[0], 100);
    }
}

#[test]
fn probes_tell_where_and_a_miss_is_an_alarm() {
    let mut bench = Bench::new();
    bench.machine.contact = Some([0, 0, -700]);
    assert_eq!(bench.ask("G38.2Z-20F100"), "[PRB:0.000,0.000,-7.000:1]\r\nok\r\n");
    assert!(bench.ask("$#").contains("[PRB:0.000,0.000,-7.000:1]"));
    bench.machine.contact = None;
    assert_eq!(bench.ask("G38.3Z-9F100"), "[PRB:0.000,0.000,-9.000:0]\r\nok\r\n");
    let heard = bench.ask("G38.2Z-11F100");
    assert_eq!(heard, "[PRB:0.000,0.000,-11.000:0]\r\nALARM:5\r\nok\r\n");
    assert_eq!(bench.ask("$X"), "[MSG:Caution: Unlocked]\r\nok\r\n");
}

#[test]
fn homing_sleep_check_and_halts() {
    let mut bench = Bench::new();
    bench.ask("G0X5");
    assert_eq!(bench.ask("$H"), OK);
    assert_eq!(bench.machine.view.steps, [0; 3]);
    // Check mode: nothing moves, its end is a reset.
    assert_eq!(bench.ask("$C"), "[MSG:Enabled]\r\nok\r\n");
    assert_eq!((bench.state(), bench.ask("G0X5")), ("Check".to_owned(), OK.to_owned()));
    assert_eq!(bench.ask("M114"), "X:0.000 Y:0.000 Z:0.000\r\nok\r\n");
    assert!(bench.ask("$C").starts_with("[MSG:Disabled]\r\nok\r\n\r\nGrbl 1.1h"));
    assert_eq!(bench.machine.view.steps, [0; 3]);
    // M0 holds until a resume.
    bench.heard.clear();
    bench.send(b"M0\nG0X3\n");
    bench.wait();
    assert_eq!((bench.state(), bench.heard.as_str()), ("Hold:0".to_owned(), ""));
    bench.send(b"~");
    bench.wait();
    assert_eq!((bench.state(), bench.machine.view.steps[0]), ("Idle".to_owned(), 300));
    assert_eq!(bench.ask("$SLP"), "ok\r\n[MSG:Sleeping]\r\n");
    assert_eq!((bench.state(), bench.ask("G0X1")), ("Sleep".to_owned(), "error:9\r\n".to_owned()));
    assert!(bench.ask("\x18").contains("to unlock"));
    bench.ask("$X");
    assert_eq!(bench.ask("G0X1"), OK);
    assert!(bench.machine.done.contains(&Order::Motors(true)));
}

#[test]
fn who_leaves_leaves_nothing_that_moves_or_is_on() {
    let mut bench = Bench::new();
    bench.machine.pace = 50;
    bench.send(b"M3S1000\nM8\nM42P5S1\nG1X50F600\nX60\n");
    for _ in 0..4 {
        bench.step();
    }
    assert!(bench.machine.stays());
    let view = bench.machine.view.clone();
    bench.session.gone(&view);
    for _ in 0..5 {
        bench.step();
    }
    assert!(bench.machine.rests() && !bench.machine.stays());
    // The next one begins anew.
    bench.heard.clear();
    let view = bench.machine.view.clone();
    bench.session.open(&view);
    bench.wait();
    assert!(bench.heard.starts_with("\r\nGrbl 1.1h"));
    assert!(bench.ask("$G").contains("M5 M9"));
}

/// Without a run no end of one switches off what a byte has switched on.
#[test]
fn coolant_that_is_switched_on_at_rest_is_off_after_a_reset_and_without_a_client() {
    let coolant = Bench::new().session.machine.coolant.expect("mill has coolant");
    let ends: [fn(&mut Bench); 4] = [
        |bench| bench.send(b"\x18"),
        |bench| {
            let view = bench.machine.view.clone();
            bench.session.gone(&view);
        },
        |bench| bench.machine.fail(Fault::EmergencyStop),
        |bench| bench.machine.view.trouble = Some("the port is gone".to_owned()),
    ];
    for (n, end) in ends.into_iter().enumerate() {
        for bytes in [&b"\xA0"[..], b"\xA1", b"\xA0\xA1"] {
            let mut bench = Bench::new();
            bench.send(bytes);
            bench.step();
            assert_eq!(bench.machine.on, [coolant], "{n} {bytes:x?}");
            end(&mut bench);
            bench.wait();
            assert!(bench.machine.on.is_empty(), "{n} {bytes:x?}");
            // What waits to be switched on when the end comes is not switched on after it.
            let mut bench = Bench::new();
            bench.send(bytes);
            end(&mut bench);
            bench.wait();
            assert!(bench.machine.on.is_empty(), "{n} {bytes:x?} at once");
        }
    }
    let mut bench = Bench::new();
    bench.send(b"\xA0\xA0");
    bench.wait();
    assert!(bench.machine.on.is_empty(), "switched off by its own byte");
}

#[test]
fn somebody_elses_run_is_shown_and_not_disturbed_by_lines() {
    let mut bench = Bench::new();
    bench.machine.view.state = Some(RunState::Running);
    let view = bench.machine.view.clone();
    bench.session.take(b"G0X5\n", &view);
    let out = String::from_utf8(bench.session.outgoing()).expect("text");
    assert!(out.contains("[MSG:a program of the board runs]\r\nerror:8"), "{out}");
    assert_eq!(bench.state(), "Run");
}

#[test]
fn a_flood_of_lines_loses_none_in_silence() {
    let mut bench = Bench::new();
    bench.machine.pace = 1;
    bench.heard.clear();
    // Dwells are sync lines: nothing is taken meanwhile.
    bench.send(&b"G4P0.01\n".repeat(5_000));
    bench.send(&b"?".repeat(100_000));
    assert!(bench.heard.len() < 20_000, "{}", bench.heard.len());
    bench.heard.clear();
    for _ in 0..2_000 {
        bench.step();
    }
    let good = bench.heard.matches("ok\r\n").count();
    let lost = bench.heard.matches("error:11\r\n").count();
    assert_eq!(good + lost, 5_000);
    assert!(lost > 4_000 && good >= 256, "{good} {lost}");
    assert_eq!(bench.ask("G0X1"), OK);
}

#[test]
fn a_door_that_opens_in_a_jog_holds_nothing_after_a_reset() {
    let mut bench = Bench::new();
    bench.machine.pace = 20;
    bench.send(b"$J=G91X9F600\n");
    bench.step();
    // The jog still ramps down when the reset comes.
    bench.send(b"\x84\x18");
    bench.wait();
    assert_eq!((bench.state(), bench.ask("G0X7")), ("Idle".to_owned(), OK.to_owned()));
    assert_eq!(bench.machine.view.steps[0], 700, "it moves without a resume");
}

#[test]
fn a_reference_run_is_none_while_a_jog_moves() {
    let mut bench = Bench::new();
    bench.machine.pace = 20;
    bench.send(b"$J=G91X9F600\n");
    bench.step();
    bench.heard.clear();
    bench.send(b"$H\n");
    bench.send(b"\x85");
    bench.wait();
    assert_eq!((bench.state(), bench.heard.as_str()), ("Idle".to_owned(), "error:8\r\n"));
    assert_eq!(bench.ask("$H"), OK);
}

#[test]
fn a_run_that_somebody_else_ends_is_an_alarm_and_costs_no_answer() {
    let mut bench = Bench::new();
    bench.machine.pace = 20;
    bench.send(b"G1X9F600\nM400\n");
    bench.step();
    bench.machine.fail(Fault::LimitSwitch);
    // As the drive shows a stop at the machine: it ended, and the board has no fault.
    (bench.machine.view.fault, bench.machine.view.state) = (None, Some(RunState::Ready));
    bench.heard.clear();
    bench.step();
    assert!(bench.heard.starts_with("ALARM:3\r\n[MSG:"), "{}", bench.heard);
    assert!(bench.ask("\x18").contains("to unlock"));
    bench.ask("$X");
    assert_eq!(bench.ask("M400"), OK);
}
