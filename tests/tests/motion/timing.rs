//! Times of the board, without trace mode, against those of the simulator.

use std::cell::RefCell;
use std::rc::Rc;

use emulator::{Signal, TICKS_PER_SECOND};
use lang::profile::Profile;
use pasapas::bench::stand::image_for;
use pasapas::board::{Build, F5529, G2553};
use pasapas::sim::trace::{Event, What};
use pasapas::sim::world::World;
use pasapas::sim::{self, Engine, Options};

use crate::lab::{DONE, Lab};

/// The board writes its shift registers each millisecond, before or after.
const OUTPUT_MS: f64 = 1.0;
/// How much longer a statement that moves takes than its motion, ms: its words, its plan, and the
/// main loop's look at the end.
const STATEMENT_MS: f64 = 2.5;
/// Where a stop or a new target finds the step engine within a segment, ms.
const SEGMENT_MS: f64 = 4.0;

/// What lies between two outputs: milliseconds, and statements with effects.
type Stretch = (f64, usize);

/// The stretches between outputs in the simulator.
fn simulated(build: &Build, script: &str) -> Vec<Stretch> {
    let mill = Profile::built_in("mill").expect("the mill");
    let text = format!("{script}\nSetOut {DONE}, ON\n");
    let (program, _) = image_for(&mill, &text).expect("a script");
    let events = Rc::new(RefCell::new(Vec::new()));
    let heard = Rc::clone(&events);
    let sink = Box::new(move |event: &Event| {
        let out = matches!(event.what, What::Out { .. });
        heard.borrow_mut().push((event.us.unwrap_or_default() as f64 / 1e3, out));
    });
    let options = Options { record: false, part: build.part, ..Options::default() };
    sim::run(&program, Engine::Vm, &World::empty(), &options, sink).expect("a run");
    let events = events.borrow();
    let outs: Vec<usize> = (0..events.len()).filter(|&n| events[n].1).collect();
    outs.windows(2).map(|w| (events[w[1]].0 - events[w[0]].0, w[1] - w[0])).collect()
}

/// The same at the pins, ms.
fn measured(build: &Build, script: &str) -> Vec<f64> {
    let mill = Profile::built_in("mill").expect("the mill");
    let run = Lab::new(build, &mill, script).play(|_| {});
    let edges = run.edges.iter().filter(|edge| matches!(edge.signal, Signal::Out(_)));
    let times: Vec<u64> = edges.map(|edge| edge.cycle).collect();
    times.windows(2).map(|w| (w[1] - w[0]) as f64 * 1e3 / TICKS_PER_SECOND as f64).collect()
}

/// Every stretch between two outputs takes what the simulator says; `meet`: orders find axes on
/// their way.
fn agrees(build: &Build, script: &str, meet: bool) {
    let (there, here) = (measured(build, script), simulated(build, script));
    assert_eq!(there.len(), here.len(), "{script}");
    for (n, (t, (s, statements))) in there.iter().zip(&here).enumerate() {
        let mut bound = OUTPUT_MS + STATEMENT_MS * *statements as f64 + s * 0.001;
        bound += if meet { SEGMENT_MS } else { 0.0 };
        let name = build.part.name;
        assert!((t - s).abs() <= bound, "{name}, stretch {n}: {t} ms for {s} ms in\n{script}");
    }
}

#[test]
fn starts_stops_and_new_targets_take_what_the_simulator_says() {
    // START returns at once, StopAxe when the axis rests, a new target counts from what the step
    // engine holds already.
    let script = "SetOut 1, ON\nSTART MoveAxe X, 30mm\nSTART MoveAxe Y, 20mm\nSetOut 1, OFF\n\
        Wait 100ms\nSTART MoveAxe X, 2mm\nWaitMove X\nSetOut 2, ON\nWaitMove\nSetOut 2, OFF\n\
        MoveSpeed X, 4000st/s\nMoveSpeed Y, -700st/s\nWait 220ms\nSetOut 3, ON\nStopAxe X\n\
        SetOut 3, OFF\nWait 10ms\nSetOut 4, ON\nStopAll\nSetOut 4, OFF\nMoveSpeed Z, -8000st/s\n\
        Wait 313ms\nSetOut 5, ON\nStopAxe Z\nSetOut 5, OFF";
    agrees(&F5529, script, true);
}

#[test]
fn moves_take_what_the_simulator_says() {
    let common = "SetOut 1, ON\nMoveAxe X, 31mm\nSetOut 1, OFF\nMoveRel Y, 1mm, 20mm/s, 90mm/s2\n\
        SetOut 2, ON\nG0 X4 Y9 Z-3\nSetOut 2, OFF\nF900\nG1 X5\nG1 X7 Y9.5\nG1 X7 Y12 Z-4\n\
        SetOut 3, ON\nG4 P0.1\nSetOut 3, OFF\nG99 G81 X3 Y3 Z-5 R-3.5\nG82 X2 Z-6 R-3.5 P0.05\n\
        G80\nSetOut 4, ON";
    agrees(&G2553, common, false);
    agrees(&F5529, common, false);
    let large = "SetOut 1, ON\nF1800\nG1 X9\nG3 X12 Y3 J3\nG1 Y9\nG2 X15 Y12 Z-2 I3\n\
        SetOut 1, OFF\nG61 G1 X4\nG1 X4.5\nG1 X5 Y3\nG64 G1 X4 Y2\nSetOut 2, ON";
    agrees(&F5529, large, false);
}
