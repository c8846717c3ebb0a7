//! Length of a pass of the main loop, and its parts: requests of a host, and the rules of a statement.
//!
//! Both chips clear their watchdog once a pass. On the G2553 the rules of `firmware/src/rules` are micro-code, on the
//! F5529 compiled code.

use std::time::Duration;

use emulator::Kicks;
use lang::profile::Profile;

use super::stand::{Stand, gate, image_on};
use super::{Sink, at_most};
use crate::board::{Build, F5529, G2553};
use crate::link::Link;

/// Lines that go nowhere.
const LINES: u32 = 2_000;
/// Requests of a status.
const REQUESTS: u32 = 200;
/// From one to the next, as a screen asks.
const REST: Duration = Duration::from_millis(20);
/// A path of short lines that never rests.
const PATH: &str = "F1500\nG91\nREPEAT 100\nG1 X0.5 Y0.1\nG1 X-0.1 Y0.5\nG1 X-0.5 Y-0.1\nG1 X0.1 Y-0.5\nEND REPEAT\n";

/// What a host that asks 50 times a second may take of a chip, and what is aimed at.
const ASKING: [f64; 2] = [0.05, 0.025];

/// Figures of the G2553 and, with `_f5529`, of the F5529: `pass_worst`, the longest pass of the main loop while a path of
/// short lines plays and a host asks for the status every 20 ms, at most what planning a line may take (3.4 ms) and what
/// the VM may keep the loop (2 ms); `status_asked`, what such a request costs the main loop and the link's interrupts;
/// `line_rules`, what the rules of a line that goes nowhere take.
///
/// # Errors
/// The board does not answer or does not run.
pub fn run(sink: Sink<'_>) -> Result<(), String> {
    let mill = Profile::built_in("mill").map_err(|error| error.to_string())?;
    let asked = |clock: u32| ASKING.map(|part| part * f64::from(clock) * REST.as_secs_f64());
    let passes = Passes::of(&G2553, &mill)?;
    sink(at_most("pass_worst", "us", passes.worst_us, 3_400.0, 2_000.0))?;
    let [must, aim] = asked(G2553.part.clock);
    sink(at_most("status_asked", "cycles", passes.status, must, aim))?;
    sink(at_most("line_rules", "cycles", passes.line, 10_000.0, 8_000.0))?;
    let passes = Passes::of(&F5529, &mill)?;
    sink(at_most("pass_worst_f5529", "us", passes.worst_us, 2_000.0, 1_500.0))?;
    let [must, aim] = asked(F5529.part.clock);
    sink(at_most("status_asked_f5529", "cycles", passes.status, must, aim))?;
    sink(at_most("line_rules_f5529", "cycles", passes.line, 6_000.0, 4_000.0))
}

/// What is measured of a chip.
struct Passes {
    /// The longest pass, us.
    worst_us: f64,
    /// Cycles of a request.
    status: f64,
    /// Cycles of a line's rules.
    line: f64,
}

impl Passes {
    fn of(build: &Build, mill: &Profile) -> Result<Passes, String> {
        let mut stand = Stand::on(build, mill)?;
        let (_, image) = image_on(&build.part, mill, PATH)?;
        stand.upload(&image)?;
        stand.rig().borrow_mut().board().clear_stats();
        stand.run_asking(Duration::from_secs(60), REST)?;
        let ticks = stand.rig().borrow_mut().board().ticks_per_second() as f64;
        let worst_us = kicks(&stand).longest as f64 / ticks * 1e6;
        let clock = f64::from(build.part.clock);
        Ok(Passes {
            worst_us,
            status: status(&mut stand, clock)?,
            line: line(&mut stand, build, mill)?,
        })
    }
}

fn kicks(stand: &Stand) -> Kicks {
    stand.rig().borrow_mut().board().kicks()
}

/// Passes of the main loop while so many requests are made, or none, and the time that takes, s.
fn passes(stand: &mut Stand, requests: u32) -> Result<(f64, f64), String> {
    stand.rig().borrow_mut().board().clear_stats();
    let from = stand.seconds();
    for _ in 0..requests {
        stand.client().status().map_err(|error| error.to_string())?;
        stand.client().link().pause(REST);
    }
    if requests == 0 {
        stand.client().link().pause(Duration::from_secs(1));
    }
    Ok((kicks(stand).count as f64, stand.seconds() - from))
}

/// Cycles of a request: the time that passes of a loop without one leave.
fn status(stand: &mut Stand, clock: f64) -> Result<f64, String> {
    let (idle, seconds) = passes(stand, 0)?;
    let (busy, during) = passes(stand, REQUESTS)?;
    Ok((during - busy * seconds / idle) * clock / f64::from(REQUESTS))
}

/// Cycles of a line that goes nowhere, less those of a loop around nothing.
fn line(stand: &mut Stand, build: &Build, mill: &Profile) -> Result<f64, String> {
    let mut seconds = |body: &str| -> Result<f64, String> {
        let text = format!(
            "F1500\nG0 X0 Y0 Z0\nSetOut 1, ON\nREPEAT {LINES}\n{body}END REPEAT\nSetOut 1, OFF\n"
        );
        let (_, image) = image_on(&build.part, mill, &text)?;
        stand.upload(&image)?;
        let edges = stand.run(Duration::from_secs(60))?;
        Ok(gate(&edges)? as f64 / emulator::TICKS_PER_SECOND as f64)
    };
    let (with, without) = (seconds("G1 X0 Y0\n")?, seconds("")?);
    Ok((with - without) / f64::from(LINES) * f64::from(build.part.clock))
}
