//! Generated jobs: scenes in which an event comes at a time that leaves no doubt, and faults of every
//! kind, in loops, subs and handlers.

use std::fmt::Write as _;

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};

use crate::lab::{Case, compare};

/// Input 3 follows output 1 and input 4 output 2, later than a traced statement takes. No switch is in
/// the way.
const WORLD: &str = r#"after_out(1, true, 150, || set_in(3, true));
                     after_out(1, false, 20, || set_in(3, false));
                     after_out(2, true, 250, || set_in(4, true));
                     after_out(2, false, 20, || set_in(4, false));
                     at(0, || set_in(6, true)); switch_at("X", -90000);
                     switch_at("Y", -90000); switch_at("Z", 90000);"#;

/// Faults of the program's own and of the machine; `n` is 1 or more.
const FAULTS: [&str; 16] = [
    "k = 1 / (n - n)",
    "k = list(n + 7)",
    "PRINT \"never \"; SQR(0 - n)",
    "k = 1 << (31 + n)",
    "k = 2147483647 + n",
    "IF 7 MOD (n - n) = 0 THEN PRINT \"never\"",
    "boxes(n + 5) = 1",
    "Wait (0 - n) * 1ms",
    "SetOut 99 + n, ON",
    "WaitIn 7, ON, 40ms",
    "MoveRel Y, 1mm, (n - n) * 1mm/s",
    "Probe Z, POS(Z) - 1mm, 20mm/s",
    "Probe Y, POS(Y) + 1mm, 20mm/s, 6, ON",
    "WaitChar 66, 30ms",
    "Send 20 - n",
    "G1 X[(n - n) * 1mm] F[n - n]",
];

struct Tape<'t> {
    data: &'t [u16],
    at: usize,
    /// The handler of input 3 fails: what moves meanwhile rests somewhere.
    failing: bool,
    /// Scenes with ticks: a script has four ON lines, of which two are taken.
    ticks: usize,
}

impl Tape<'_> {
    fn pick(&mut self, n: usize) -> usize {
        let value = self.data.get(self.at).copied().unwrap_or(0);
        self.at += 1;
        usize::from(value) % n
    }
}

fn scene(tape: &mut Tape<'_>, out: &mut String, depth: usize) {
    let fault = FAULTS[tape.pick(FAULTS.len())];
    let text = match tape.pick(16) {
        // In a wait.
        0 | 1 => "SetOut 1, ON\nWait 500ms\nSetOut 1, OFF\nWait 60ms\n".to_owned(),
        // In a move.
        2 => "SetOut 1, ON\nMoveRel X, 5mm, 10mm/s\nn = n + 1\nPRINT \"moved \"; n\nSetOut 1, OFF\nWait 60ms\n"
            .to_owned(),
        // Two in one move.
        3 => "SetOut 2, ON\nSetOut 1, ON\nMoveRel X, -6mm, 10mm/s\nPRINT \"both\"\nSetOut 1, OFF\nSetOut 2, OFF\nWait 60ms\n"
            .to_owned(),
        // While an axis goes on by itself.
        4 if !tape.failing => "START MoveRel Y, 6mm, 10mm/s\nSetOut 1, ON\nWaitMove Y\nSetOut 1, OFF\nWait 60ms\n".to_owned(),
        5 if tape.ticks < 2 => {
            tape.ticks += 1;
            "ON EVERY 250ms GOSUB tick\nWait 850ms\nON EVERY OFF\nPRINT \"ticks \"; ticks\n".to_owned()
        }
        // The last look of a wait for an input.
        6 => "SetOut 1, ON\nWaitIn? 4, ON, 600ms\nPRINT TIMEDOUT\nSetOut 1, OFF\nWait 60ms\n".to_owned(),
        7 | 8 => format!("{fault}\nPRINT \"behind\"\n"),
        9 => format!("work n\nPRINT half(n)\n{fault}\n"),
        10 => "F900\nG1 X[n * 1mm] Y2\nG1 Y3\nG2 X[n * 1mm] Y3 I1 J0\nG1 Z-1\n".to_owned(),
        11 => "FOR i = 1 TO 2000\nm = (m * 7 + i) MOD 10007\nNEXT\nPRINT m\n".to_owned(),
        12 => "IF IN(3) ORELSE IN(6) THEN\nPRINT \"in \"; POSST(X)\nELSE\nPRINT \"never\"\nEND IF\n".to_owned(),
        13 => "SELECT CASE n MOD 3\nCASE 0: Pulse 6, 20ms\nCASE 1: SetPort 64\nCASE ELSE: PRINT n\nEND SELECT\n".to_owned(),
        _ if depth > 0 => {
            let mut inner = String::new();
            scene(tape, &mut inner, depth - 1);
            format!("REPEAT 2\n{inner}n = n + 1\nEND REPEAT\n")
        }
        _ => "SetOut 2, ON\nWait 700ms\nSetOut 2, OFF\nWait 60ms\n".to_owned(),
    };
    out.push_str(&text);
}

/// What a handler does.
fn handled(tape: &mut Tape<'_>) -> &'static str {
    [
        "n = n + 1",
        "MoveRel Y, 0.5mm",
        "Wait 30ms",
        "SetOut 5, ON\nSetOut 5, OFF",
        "WaitIn? 8, ON, 20ms",
        "m = m + IN(3) + 2 * IN(4)",
        "G90 G21 G61 G1 Z[n * -0.01mm] F300",
    ][tape.pick(7)]
}

fn generate(data: &[u16]) -> Case {
    let mut tape = Tape { data, at: 0, failing: false, ticks: 0 };
    tape.failing = tape.pick(4) == 0;
    let mut text = "DIM n, m, k, i, ticks, boxes(3)\nTABLE list = 3, 1, 4\nn = 1\n".to_owned();
    let guarded = tape.pick(8) != 0;
    if guarded {
        text += "ON ERROR GOTO oops\n";
    }
    let edge = ["RISE", "FALL"][tape.pick(2)];
    text += "ON IN 3 RISE GOSUB hit\n";
    let _ = writeln!(text, "ON IN 4 {edge} GOSUB other\nF600\nWait 100ms");
    for _ in 0..2 + tape.pick(5) {
        scene(&mut tape, &mut text, 1);
    }
    if tape.pick(4) == 0 {
        text += "ON ERROR STOP\n";
        scene(&mut tape, &mut text, 1);
    }
    if tape.pick(4) == 0 {
        text += "ON IN 3 OFF\n";
        scene(&mut tape, &mut text, 1);
    }
    text += "fin:\nPRINT n; \" \"; m; \" \"; k; \" \"; ticks; \" \"; ERR; \" \"; ERL\n";
    text += ["END\n", "Wait 200ms\nEND\n", "SetOut 7, ON\nEND\n"][tape.pick(3)];
    let _ = write!(text, "hit:\nPRINT \"hit \"; n\n{}\n", handled(&mut tape));
    if tape.failing {
        let _ = writeln!(text, "k = m / (n - n)\nPRINT \"hit goes on\"");
    }
    let _ = write!(text, "RETURN\nSUB other\nPRINT \"other\"\n{}\nEND SUB\n", handled(&mut tape));
    text += "SUB tick\nticks = ticks + 1\nEND SUB\n";
    text += "SUB work(a)\nPRINT \"work \"; 7 / (a - 2)\nPRINT \"worked\"\nEND SUB\n";
    text += "FUNCTION half(a)\nSetOut 8, ON\nPRINT \"half \"; 6 / (a - 3)\nSetOut 8, OFF\nRETURN a / 2\nEND FUNCTION\n";
    if guarded {
        let _ = write!(text, "oops:\nPRINT \"F\"; ERR; \" \"; ERL\n{}\n", handled(&mut tape));
        text += ["RESUME NEXT\n", "RESUME NEXT\n", "RESUME NEXT\n", "END\n"][tape.pick(4)];
        if tape.pick(6) == 0 {
            text =
                text.replace("RESUME NEXT\n", "n = n + 1\nIF n < 12 THEN GOTO fin\nRESUME NEXT\n");
        }
    }
    Case { script: text, world: WORLD.to_owned() }
}

fn run(seed: u8, cases: u32) {
    let config =
        Config { cases, failure_persistence: None, max_shrink_iters: 60, ..Config::default() };
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]);
    let mut runner = TestRunner::new_with_rng(config, rng);
    let tapes = prop::collection::vec(any::<u16>(), 4..40);
    let result = runner.run(&tapes, |tape| compare(&generate(&tape)).map_err(TestCaseError::fail));
    if let Err(error) = result {
        panic!("{error}");
    }
}

#[test]
fn streamed_jobs_leave_the_traces_of_the_simulation() {
    run(1, 14);
}

#[test]
#[ignore = "ten minutes: the long form of the test above"]
fn many_streamed_jobs_leave_the_traces_of_the_simulation() {
    run(2, 1500);
}
