//! Times of the board, without trace mode, against those of the simulator.

use std::cell::RefCell;
use std::rc::Rc;

use emulator::{Signal, TICKS_PER_SECOND};
use lang::profile::Profile;
use pasapas::bench::stand::image_for;
use pasapas::board::{Build, G2553, G2955};
use pasapas::sim::trace::{Event, What};
use pasapas::sim::world::World;
use pasapas::sim::{self, Engine, Options};

use crate::lab::{DONE, Lab};

/// The board writes its shift registers each millisecond.
const OUTPUT_MS: f64 = 1.0;
/// How much longer a pass of the main loop with a statement takes than the simulator's 20 us, ms.
const PASS_MS: f64 = 0.5;

/// Milliseconds at which outputs 1 to 7 change in the simulator, from the first change on.
fn simulated(build: &Build, script: &str) -> Vec<f64> {
    let mill = Profile::built_in("mill").expect("the mill");
    let text = format!("{script}\nSetOut {DONE}, ON\n");
    let (program, _) = image_for(&mill, &text).expect("a script");
    let times = Rc::new(RefCell::new(Vec::new()));
    let heard = Rc::clone(&times);
    let sink = Box::new(move |event: &Event| {
        if let (What::Out { .. }, Some(us)) = (&event.what, event.us) {
            heard.borrow_mut().push(us as f64 / 1e3);
        }
    });
    let look_ahead = build.part.look_ahead;
    let options = Options { record: false, look_ahead, ..Options::default() };
    sim::run(&program, Engine::Vm, &World::empty(), &options, sink).expect("a run");
    let times = times.borrow();
    times.iter().map(|ms| ms - times[0]).collect()
}

/// The same at the pins.
fn measured(build: &Build, script: &str) -> Vec<f64> {
    let mill = Profile::built_in("mill").expect("the mill");
    let run = Lab::new(build, &mill, script).play(|_| {});
    let edges = run.edges.iter().filter(|edge| matches!(edge.signal, Signal::Out(_)));
    let times: Vec<u64> = edges.map(|edge| edge.cycle).collect();
    times.iter().map(|at| (at - times[0]) as f64 * 1e3 / TICKS_PER_SECOND as f64).collect()
}

/// Every stretch between two outputs takes what the simulator says.
fn agrees(build: &Build, script: &str) {
    let (there, here) = (measured(build, script), simulated(build, script));
    assert_eq!(there.len(), here.len(), "{script}");
    for (n, (t, s)) in there.windows(2).zip(here.windows(2)).enumerate() {
        let (t, s) = (t[1] - t[0], s[1] - s[0]);
        let bound = OUTPUT_MS + PASS_MS + s * 0.001;
        let name = build.part.name;
        println!("{name} {n}: {t:.3} {s:.3} {:.3}", t - s);
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
    agrees(&G2955, script);
}

#[test]
fn moves_take_what_the_simulator_says() {
    let common = "SetOut 1, ON\nMoveAxe X, 31mm\nSetOut 1, OFF\nMoveRel Y, 1mm, 20mm/s, 90mm/s2\n\
        SetOut 2, ON\nG0 X4 Y9 Z-3\nSetOut 2, OFF\nF900\nG1 X5\nG1 X7 Y9.5\nG1 X7 Y12 Z-4\nSetOut 3, ON\n\
        G4 P0.1\nSetOut 3, OFF\nG99 G81 X3 Y3 Z-5 R-3.5\nG82 X2 Z-6 R-3.5 P0.05\nG80\nSetOut 4, ON";
    agrees(&G2553, common);
    agrees(&G2955, common);
    let large = "SetOut 1, ON\nF1800\nG1 X9\nG3 X12 Y3 J3\nG1 Y9\nG2 X15 Y12 Z-2 I3\nSetOut 1, OFF\n\
        G61 G1 X4\nG1 X4.5\nG1 X5 Y3\nG64 G1 X4 Y2\nSetOut 2, ON";
    agrees(&G2955, large);
}

#[test]
fn dump() {
    let mill = Profile::built_in("mill").expect("the mill");
    for script in ["SetOut 1, ON\nF1800\nG1 X9\nG3 X12 Y3 J3\nG1 Y9\nG2 X15 Y12 Z-2 I3\nSetOut 1, OFF\nSetOut 2,ON", "SetOut 1, ON\nG0 X4 Y9 Z-3\nSetOut 1, OFF\nSetOut 2,ON"] {
        let run = Lab::new(&G2955, &mill, script).play(|_| {});
        let on = run.edges.iter().find(|e| e.signal == Signal::Out(1)).unwrap().cycle;
        let off = run.edges.iter().find(|e| e.signal == Signal::Out(1) && !e.level).unwrap().cycle;
        let (a, b) = (run.steps[0].at, run.steps.last().unwrap().at);
        let ms = |t: u64| t as f64 / 16e3;
        println!("before {} move {} after {}; sim {:?}", ms(a - on), ms(b - a), ms(off - b), simulated(&G2955, script));
        for w in run.steps.windows(3) {
            let (i, j) = (w[1].at - w[0].at, w[2].at - w[1].at);
            if j > i + i / 4 || i > j + j / 4 { println!("{} at {}: {i} {j} {:?}", 0, ms(w[1].at - a), w[2].by); }
        }
    }
}

