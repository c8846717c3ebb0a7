//! What clients read, by the rules in their sources.

use super::machine::Bench;

/// Universal Gcode Sender: `GrblUtils`, with 1.1's status and version patterns.
#[test]
fn ugs_finds_its_version_its_options_and_its_states() {
    let mut bench = Bench::new();
    assert!(bench.heard.lines().any(|line| line.starts_with("Grbl 1.1h ")));
    let build = bench.ask("$I");
    let version = build.lines().find(|line| line.starts_with("[VER:")).expect("a version");
    assert_eq!(version, "[VER:1.1h.20190830:Pasapas F5529]");
    assert_eq!(build.lines().nth(1), Some("[OPT:VM,15,128]"));
    let state = bench.ask("$G");
    assert!(state.starts_with("[GC:G0 ") && state.ends_with("]\r\nok\r\n"), "{state}");
    // An empty line is answered.
    assert_eq!(bench.ask(""), "ok\r\n");
}

/// LaserGRBL: `GrblCore.cs` counts 34 settings, takes any line with "ok" in it for an answer, reads the
/// version at fixed places.
#[test]
fn lasergrbl_counts_34_settings_and_reads_the_version_by_its_places() {
    let mut bench = Bench::on("laser");
    let welcome = bench.heard.trim();
    let signs: Vec<char> = welcome.chars().collect();
    assert!(welcome.starts_with("Grbl "));
    assert!(signs[5].is_ascii_digit() && signs[7].is_ascii_digit() && signs[8].is_alphabetic());
    let settings = bench.ask("$$");
    let lines: Vec<&str> = settings.lines().collect();
    assert_eq!((lines.len(), lines[34]), (35, "ok"));
    for line in &lines[..34] {
        let (name, value) = line.split_once('=').expect("a setting");
        assert!(name.starts_with('$') && name[1..].parse::<u16>().is_ok(), "{line}");
        assert!(value.parse::<f64>().is_ok(), "{line}");
    }
    // A whole file of settings is written back.
    for line in lines[..34].iter().map(|line| (*line).to_owned()).collect::<Vec<_>>() {
        assert_eq!(bench.ask(&line), "ok\r\n", "{line}");
    }
    let refused = bench.ask("$120=9999");
    let told: Vec<&str> = refused.lines().collect();
    assert_eq!(told.len(), 2);
    assert!(told[0].contains("change accel and decel there"), "{refused}");
    assert!(!told[0].to_lowercase().contains("ok") && !told[0].to_lowercase().contains("error"));
}

/// Candle: `frmmain.cpp` knows exactly these states, wants MPos, and splits by `|`, `:` and `,`.
#[test]
fn candle_knows_every_state_and_finds_mpos() {
    let known = [
        "Idle", "Alarm", "Run", "Home", "Hold:0", "Hold:1", "Check", "Door:0", "Door:1", "Door:2",
        "Door:3", "Jog", "Sleep",
    ];
    let mut bench = Bench::new();
    bench.machine.pace = 3;
    let mut seen = std::collections::BTreeSet::new();
    for bytes in [
        &b"G0X5\n"[..], b"!", b"", b"", b"~", b"$J=G91X1F100\n", b"\x85", b"", b"$C\n", b"$C\n", b"",
        b"$H\n", b"", b"\x84", b"", b"", b"~", b"G0X400\n", b"", b"\x18", b"$X\n", b"$SLP\n", b"",
    ] {
        bench.send(bytes);
        for _ in 0..3 {
            bench.step();
            let report = bench.status();
            let body = report.trim().strip_prefix('<').and_then(|rest| rest.strip_suffix('>'));
            let fields: Vec<&str> = body.expect("a report").split('|').collect();
            assert!(known.contains(&fields[0]), "{report}");
            let place = fields[1].strip_prefix("MPos:").expect("MPos");
            assert!(place.split(',').all(|number| number.parse::<f64>().is_ok()), "{report}");
            seen.insert(fields[0].to_owned());
        }
    }
    for state in ["Idle", "Run", "Hold:0", "Jog", "Check", "Home", "Door:0", "Alarm", "Sleep"] {
        assert!(seen.contains(state), "{state} of {seen:?}");
    }
}

/// OpenPnP: `^ok.*` confirms, `^.*X:(..)\s*Y:(..)` is a place, `^.*FIRMWARE.*` a firmware.
#[test]
fn openpnp_finds_its_firmware_and_its_place() {
    let mut bench = Bench::new();
    assert_eq!(
        bench.ask("M115"),
        "FIRMWARE_NAME:Grbl FIRMWARE_VERSION:1.1h PROTOCOL_VERSION:1.0\r\nok\r\n"
    );
    for line in ["G21 ; Set millimeters mode", "G90 ; Set absolute", "M82", "M204 S100.00", "M84"] {
        assert_eq!(bench.ask(line), "ok\r\n", "{line}");
    }
    assert_eq!(bench.ask("G1 X10.0000 Y5.0000 Z-1.0000 F1000.00 ; move to target"), "ok\r\n");
    assert_eq!(bench.ask("G4 P0 ; Wait for moves to complete"), "ok\r\n");
    let place = bench.ask("M114 ; get position");
    assert_eq!(place, "X:10.000 Y:5.000 Z:-1.000\r\nok\r\n", "the place once");
    assert_eq!(bench.ask("M42 P3 S1"), "ok\r\n");
    bench.machine.view.inputs = 1 << 16;
    assert_eq!(bench.ask("M66 P17 L0"), "[IN:17:1]\r\nok\r\n");
    assert_eq!(bench.ask("G92 X0 Y0 Z0 ; reset coordinates in the controller"), "ok\r\n");
    assert_eq!(bench.ask("M114"), "X:0.000 Y:0.000 Z:0.000\r\nok\r\n");
}

/// cncjs and gSender: a status is `^<(.+)>$`, and what comes between answers must not look like one.
#[test]
fn no_text_looks_like_an_answer() {
    use crate::grbl::session::harmless;
    for text in ["a stroke", "look at the TOKEN", "this is an Error", "okok", "[x] <y>\r\nok"] {
        let told = harmless(text);
        let small = told.to_lowercase();
        assert!(!small.contains("ok") && !small.contains("error"), "{told}");
        assert!(!told.contains(['[', ']', '<', '>', '\r', '\n']), "{told}");
    }
}
