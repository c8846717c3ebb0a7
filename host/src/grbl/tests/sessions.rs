//! Thousands of generated sessions, each held against a small model of Grbl's states.

use lang::fault::Fault;
use proptest::prelude::*;

use super::machine::Bench;

/// Something that happens.
#[derive(Clone, Debug)]
enum Happens {
    Line(&'static str),
    /// A byte at once.
    Live(u8),
    Garbage(Vec<u8>),
    Steps(u8),
    Fault(Fault),
    Gone,
}

const LINES: &[&str] = &[
    "G0X5",
    "G1X7F600",
    "G91",
    "G90",
    "G1X2",
    "G2X9I1",
    "M3S100",
    "M5",
    "M8",
    "M9",
    "G4P0.1",
    "G4P0",
    "M0",
    "M2",
    "$H",
    "$X",
    "$C",
    "$$",
    "$#",
    "$G",
    "$I",
    "$J=G91X1F600",
    "$J=G53X9F600",
    "G0X999",
    "G38.2Z-3F60",
    "G38.3Z-3F60",
    "G10L20P1X0",
    "G92X1",
    "$SLP",
    "G28",
    "M30",
    "",
    "nonsense",
    "G1X",
    "$10=0",
    "$110=1",
    "M42P5S1",
    "M114",
    "M115",
    "(ok)",
    "G54",
    "$RST=#",
];

fn happens() -> impl Strategy<Value = Happens> {
    prop_oneof![
        8 => proptest::sample::select(LINES).prop_map(Happens::Line),
        3 => proptest::sample::select(&b"!~\x18\x84\x85\x90\x91\x95\x97\x9A\x9E\xA0\xA1\xC2\xFF"[..])
            .prop_map(Happens::Live),
        1 => proptest::collection::vec(any::<u8>(), 0..40).prop_map(Happens::Garbage),
        6 => (1u8..12).prop_map(Happens::Steps),
        1 => proptest::sample::select(&[Fault::LimitSwitch, Fault::EmergencyStop, Fault::InputActive,
            Fault::HomeNotFound][..]).prop_map(Happens::Fault),
        1 => Just(Happens::Gone),
    ]
}

/// What a client that counts knows, and what Grbl's state must be when all is quiet.
#[derive(Default)]
struct Model {
    /// Lines that have no answer yet.
    owed: usize,
    /// Where the text begins that has not been looked at.
    read: usize,
    /// Bytes of a line whose end has not been sent.
    open: bool,
    critical: bool,
    alarm: bool,
}

impl Model {
    /// Reads what came since.
    fn read(&mut self, bench: &mut Bench) {
        let text = bench.heard.split_off(0);
        for line in text[self.read..].split("\r\n").filter(|line| !line.is_empty()) {
            if line == "ok" || line.strip_prefix("error:").is_some_and(|n| n.parse::<u8>().is_ok())
            {
                assert!(self.owed > 0, "an answer to nothing");
                self.owed -= 1;
            } else if let Some(number) = line.strip_prefix("ALARM:") {
                self.alarm = true;
                if matches!(number, "1" | "2" | "3") {
                    (self.critical, self.owed) = (true, 0);
                }
            } else if line.starts_with("Grbl 1.1h") {
                (self.critical, self.alarm) = (false, false);
            } else if line == "[MSG:'$H'|'$X' to unlock]" {
                self.alarm = true;
            } else if line.starts_with('<') {
                report(line);
            } else {
                let small = line.to_lowercase();
                assert!(!small.contains("ok") && !small.contains("error"), "{line}");
            }
        }
        self.read = 0;
    }
}

/// The grammar of a report; its state.
fn report(line: &str) -> &str {
    let body = line.strip_prefix('<').and_then(|rest| rest.strip_suffix('>')).expect("brackets");
    let mut fields = body.split('|');
    let state = fields.next().expect("a state");
    let known = [
        "Idle", "Run", "Hold:0", "Hold:1", "Jog", "Alarm", "Door:0", "Door:1", "Door:2", "Check",
        "Home", "Sleep",
    ];
    assert!(known.contains(&state), "{line}");
    for field in fields {
        let (name, values) = field.split_once(':').expect("a value");
        let numbers = |n: usize| {
            let all: Vec<&str> = values.split(',').collect();
            assert!(all.len() == n && all.iter().all(|v| v.parse::<f64>().is_ok()), "{line}");
        };
        match name {
            "MPos" | "WPos" | "WCO" | "Ov" => numbers(3),
            "FS" | "Bf" => numbers(2),
            "Pn" | "A" => assert!(values.bytes().all(|c| c.is_ascii_uppercase()), "{line}"),
            _ => panic!("{line}"),
        }
    }
    state
}

/// Whether bytes end a line or leave one open; how many lines they end.
fn ends(bytes: &[u8], open: &mut bool, returned: &mut bool) -> usize {
    let mut count = 0;
    for byte in bytes {
        if matches!(byte, b'?' | b'!' | b'~' | 0x80.. | 0x18) {
            continue;
        }
        let after = std::mem::replace(returned, *byte == b'\r');
        match byte {
            b'\n' if after => {}
            b'\r' | b'\n' => {
                count += 1;
                *open = false;
            }
            _ => *open = true,
        }
    }
    count
}

fn session(events: &[Happens], pace: u32) {
    let mut bench = Bench::new();
    bench.machine.pace = pace;
    let (mut model, mut returned) = (Model::default(), false);
    for event in events {
        let bytes = match event {
            Happens::Line(text) => format!("{text}\n").into_bytes(),
            Happens::Live(byte) => vec![*byte],
            Happens::Garbage(bytes) => bytes.clone(),
            Happens::Steps(count) => {
                for _ in 0..*count {
                    bench.step();
                }
                Vec::new()
            }
            Happens::Fault(fault) => {
                bench.machine.fail(*fault);
                bench.step();
                Vec::new()
            }
            Happens::Gone => {
                let view = bench.machine.view.clone();
                bench.session.gone(&view);
                for _ in 0..6 {
                    bench.step();
                }
                assert!(bench.machine.rests(), "it goes on with nobody there");
                assert!(!bench.machine.stays(), "something stays on with nobody there");
                model = Model::default();
                bench.heard.clear();
                returned = false;
                let view = bench.machine.view.clone();
                bench.session.open(&view);
                bench.step();
                Vec::new()
            }
        };
        // One byte after the other, as a line brings them.
        for byte in bytes {
            let ended = ends(&[byte], &mut model.open, &mut returned);
            if byte == 0x18 {
                // Lines behind it wait for the welcome, also of a machine that still ramps down.
                (model.owed, model.open, returned) = (0, false, false);
                model.critical = false;
            }
            if !model.critical {
                model.owed += ended;
            }
            bench.send(&[byte]);
            model.read(&mut bench);
        }
        model.read(&mut bench);
        bench.send(b"?");
        if bench.heard.starts_with("<Idle") {
            assert!(bench.machine.rests(), "Idle, and it moves");
        }
        let alarm = bench.heard.starts_with("<Alarm");
        assert!(!alarm || bench.machine.rests(), "an alarm, and it moves");
        model.read(&mut bench);
        assert!(bench.machine.queue.len() <= 2_001);
    }
    quiet(&mut bench, &mut model);
}

/// What holds is let go, what waits is done: then nothing is owed, and the state is that of the model.
fn quiet(bench: &mut Bench, model: &mut Model) {
    for _ in 0..600 {
        bench.send(b"~");
        for _ in 0..3 {
            bench.step();
        }
        model.read(bench);
    }
    assert!(bench.machine.rests(), "it moves for ever");
    if model.critical {
        return;
    }
    assert_eq!(model.owed, 0, "lines without an answer");
    let state = bench.state();
    match state.as_str() {
        "Alarm" => assert!(model.alarm, "an alarm that nobody told"),
        "Idle" | "Check" | "Sleep" => {}
        other => panic!("{other} at rest"),
    }
    // From every state a reset, and `$X` where it says so, lead to Idle.
    bench.heard.clear();
    bench.send(b"\x18");
    bench.wait();
    assert!(bench.heard.contains("Grbl 1.1h"), "{}", bench.heard);
    if bench.state() == "Alarm" {
        bench.ask("$X");
    }
    assert_eq!(bench.state(), "Idle");
    assert_eq!(bench.ask("G4P0.01"), "ok\r\n");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 10_000, max_shrink_iters: 2_000, ..ProptestConfig::default() })]

    #[test]
    fn ten_thousand_sessions_are_as_grbls_states_say(
        events in proptest::collection::vec(happens(), 1..40), pace in 1u32..6
    ) {
        session(&events, pace);
    }
}
