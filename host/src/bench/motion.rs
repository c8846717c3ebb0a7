//! Step rates and the accuracy of step edges, at the emulated pins.

use std::time::Duration;

use emulator::{Edge, Signal, TICKS_PER_SECOND};
use lang::profile::Profile;

use super::stand::{Stand, fast_mill, image_for, rises};
use super::{Sink, at_least, at_most, jitter, path};
use crate::board::{Build, F5529, G2553};

/// Rates that are asked for, highest first, until one is done without a lost step.
const RATES: [u32; 12] = [
    100_000, 91_000, 90_000, 80_000, 60_000, 50_000, 45_000, 40_000, 30_000, 20_000, 15_000, 10_000,
];
/// Rate at which the edges are compared with the ideal ones: no divisor of the clock.
const STEADY_RATE: u32 = 17_777;
/// How far an edge may be from its place, us.
const EDGE_US: f64 = 1.0;
/// Steps over which a rate is taken.
const WINDOW: usize = 200;

/// Moves of 1 s at the top rate, away from the reference switches.
const THREE: &str = "G1 X{a} Y{b} Z-{c} F6000000\n";
const ONE: &str = "MoveAxe X, {a}st\n";
const STARTED: &str =
    "START MoveAxe X, {a}st\nSTART MoveAxe Y, {a}st\nSTART MoveAxe Z, -{a}st\nWaitMove\n";

/// Figures of the G2553: `steps_3axis`, `steps_1axis`, `cpu_left` (with three axes at 40 000
/// events/s, ramps on, before planner and link), `step_interrupt`, `step_edge`, `ram_unused`; with
/// `_f5529` those of the F5529, which alone has `steps_started`. Of both: `step_jitter_...` and
/// `move_time_...` over random moves while a client asks all the while, `moves_checked_...`; then
/// those of [`path`].
///
/// # Errors
/// The board does not run the moves.
pub fn run(sink: Sink<'_>) -> Result<(), String> {
    let three = best(&G2553, THREE, &[0])?;
    sink(at_least("steps_3axis", "events/s", three.rate, 40_000.0, 60_000.0))?;
    let one = best(&G2553, ONE, &[0])?;
    sink(at_least("steps_1axis", "steps/s", one.rate, 60_000.0, 100_000.0))?;
    let must = at_rate(&G2553, THREE, &[0], 40_000)?;
    sink(at_least("cpu_left", "%", must.cpu_left, 30.0, 55.0))?;
    sink(at_most("step_interrupt", "cycles", must.interrupt as f64, 300.0, 200.0))?;
    let steady = at_rate(&G2553, ONE, &[0], STEADY_RATE)?;
    sink(at_most("step_edge", "us", steady.edge_us, EDGE_US, 0.1))?;
    let unused = three.unused.min(one.unused).min(must.unused).min(steady.unused);
    sink(at_least("ram_unused", "bytes", unused, 24.0, 64.0))?;

    let three = best(&F5529, THREE, &[0])?;
    sink(at_least("steps_3axis_f5529", "events/s", three.rate, 90_000.0, 120_000.0))?;
    let one = best(&F5529, ONE, &[0])?;
    sink(at_least("steps_1axis_f5529", "steps/s", one.rate, 100_000.0, 150_000.0))?;
    let started = best(&F5529, STARTED, &[0, 1, 2])?;
    sink(at_least("steps_started", "steps/s", started.rate, 45_000.0, 55_000.0))?;
    let must = at_rate(&F5529, THREE, &[0], 62_500)?;
    sink(at_least("cpu_left_f5529", "%", must.cpu_left, 30.0, 55.0))?;
    sink(at_most("step_interrupt_f5529", "cycles", must.interrupt as f64, 300.0, 200.0))?;

    let mill = Profile::built_in("mill").map_err(|error| error.to_string())?;
    let all = jitter::MOVES as f64;
    let found = jitter::measure(&G2553, &mill)?;
    sink(at_most("step_jitter_g2553", "us", found.jitter_us, EDGE_US, 0.1))?;
    sink(at_most("move_time_g2553", "%", found.time_off, 0.1, 0.02))?;
    sink(at_least("moves_checked_g2553", "moves", found.in_limits as f64, all, all))?;
    let found = jitter::measure(&F5529, &mill)?;
    sink(at_most("step_jitter_f5529", "us", found.jitter_us, 0.2, 0.04))?;
    sink(at_most("move_time_f5529", "%", found.time_off, 0.1, 0.02))?;
    sink(at_least("moves_checked_f5529", "moves", found.in_limits as f64, all, all))?;
    path::run(sink)
}

/// What a run at one rate gave.
struct Measured {
    /// The slowest axis's best rate over [`WINDOW`] steps.
    rate: f64,
    /// Farthest edge from a straight line through the steady part, us.
    edge_us: f64,
    /// Longest step interrupt, cycles.
    interrupt: u64,
    /// Part of the processor that step interrupts leave between the first and the last step, %.
    cpu_left: f64,
    /// Bytes of RAM that the stack never reached.
    unused: f64,
}

/// The highest rate that a build is asked for: the G2553's one event stream takes 185 cycles at a
/// segment change, and above 70 000 events/s nothing is left for the link.
fn top(build: &Build) -> u32 {
    if build.part == G2553.part { 60_000 } else { RATES[0] }
}

/// The highest rate that the board reaches with every step made and every edge in its place: an
/// engine that is asked for more postpones events, which its mean rate would not show.
fn best(build: &Build, script: &str, axes: &[u8]) -> Result<Measured, String> {
    let mut why = String::new();
    for rate in RATES.into_iter().filter(|rate| *rate <= top(build)) {
        match at_rate(build, script, axes, rate) {
            Ok(measured) if measured.edge_us <= EDGE_US => return Ok(measured),
            Ok(measured) => {
                why = format!("at {rate} st/s: an edge is {:.2} us off", measured.edge_us);
            }
            Err(text) => why = format!("at {rate} st/s: {text}"),
        }
    }
    Err(why)
}

fn at_rate(build: &Build, script: &str, axes: &[u8], rate: u32) -> Result<Measured, String> {
    with_profile(build, script, axes, &fast_mill(rate, 400_000)?)
}

/// Moves of 1 s at the profile's top rate, the same for each axis.
fn with_profile(
    build: &Build,
    script: &str,
    axes: &[u8],
    profile: &Profile,
) -> Result<Measured, String> {
    let rate = profile.axes().next().map_or(0, |(_, axis)| axis.top_rate);
    let steps = i64::from(rate);
    let mm = |steps: i64| format!("{}.{:02}", steps / 100, steps % 100);
    let text = script
        .replace("{a}st", &format!("{steps}st"))
        .replace("{a}", &mm(steps))
        .replace("{b}", &mm(steps * 2 / 3))
        .replace("{c}", &mm(steps / 3));
    let (_, image) = image_for(profile, &text)?;
    let mut stand = Stand::on(build, profile)?;
    stand.upload(&image)?;
    let edges = stand.run(Duration::from_secs(20))?;
    for &axis in axes {
        let there = stand.motors()[usize::from(axis)].abs();
        if there != steps {
            return Err(format!("axis {axis} stands at {there}, not at {steps}"));
        }
    }
    let identity = stand.identity()?;
    let (interrupt, busy) = stand.step_interrupts();
    let own = edges.iter().filter(|edge| matches!(edge.signal, Signal::Step(_)));
    let (first, last) = own.fold((u64::MAX, 0), |(a, b), e| (a.min(e.cycle), b.max(e.cycle)));
    let span = last.saturating_sub(first);
    let rates = axes.iter().map(|axis| top_rate(&edges, *axis));
    Ok(Measured {
        rate: rates.fold(f64::INFINITY, f64::min),
        edge_us: axes.iter().map(|axis| edge_error(&edges, *axis)).fold(0.0, f64::max),
        interrupt,
        cpu_left: 100.0 - 100.0 * busy as f64 / span.max(1) as f64,
        unused: f64::from(identity.stack_free),
    })
}

/// Best rate over [`WINDOW`] steps.
fn top_rate(edges: &[Edge], axis: u8) -> f64 {
    let times = rises(edges, Signal::Step(axis));
    let shortest = times.windows(WINDOW + 1).map(|w| w[WINDOW] - w[0]).min();
    shortest.map_or(0.0, |ticks| (WINDOW as u64 * TICKS_PER_SECOND) as f64 / ticks as f64)
}

/// Farthest edge from the straight line through the middle of a move.
fn edge_error(edges: &[Edge], axis: u8) -> f64 {
    let times = rises(edges, Signal::Step(axis));
    let steady = &times[times.len() * 2 / 5..times.len() * 3 / 5];
    let (Some(first), Some(last)) = (steady.first(), steady.last()) else { return f64::INFINITY };
    let step = (last - first) as f64 / (steady.len().max(2) - 1) as f64;
    let off = |(i, time): (usize, &u64)| ((time - first) as f64 - i as f64 * step).abs();
    let ticks = steady.iter().enumerate().map(off).fold(0.0, f64::max);
    ticks * 1e6 / TICKS_PER_SECOND as f64
}

#[cfg(test)]
mod tests {
    use lang::record::feature;

    use super::{EDGE_US, ONE, STARTED, THREE, at_rate, with_profile};
    use crate::bench::stand::fast_mill;
    use crate::board::BUILDS;
    use crate::board::size::budget;

    #[test]
    fn the_step_interrupt_keeps_its_ceiling() {
        for build in BUILDS {
            let most = budget(build).expect("a budget").interrupt;
            for script in [THREE, ONE] {
                let measured = at_rate(build, script, &[0], 40_000).expect("it moves");
                let (name, cycles) = (build.part.name, measured.interrupt);
                assert!(cycles <= most, "{name}, {script}: {cycles} of {most} cycles");
            }
        }
    }

    /// A pulse that ends while the link's interrupt runs must not cost the timer's next turn, 4 ms.
    #[test]
    fn every_rate_that_a_profile_may_have_is_kept_while_the_link_is_busy() {
        for build in BUILDS {
            for pulse in [2, 3, 4, 6, 10, 30] {
                let mut scripts = vec![(ONE, &[0][..], false), (THREE, &[0], false)];
                if build.part.features & feature::START != 0 {
                    scripts.push((STARTED, &[0, 1, 2], true));
                }
                for (script, axes, on_their_own) in scripts {
                    let rate = build.part.top_rate(pulse, on_their_own);
                    let mut profile = fast_mill(rate, 400_000).expect("a profile");
                    profile.pulse_us = pulse;
                    let what = format!("{}, {pulse} us, {rate} st/s, {script}", build.part.name);
                    let measured = with_profile(build, script, axes, &profile);
                    let measured = measured.unwrap_or_else(|error| panic!("{what}: {error}"));
                    assert!(measured.edge_us <= EDGE_US, "{what}: {} us off", measured.edge_us);
                }
            }
        }
    }
}
