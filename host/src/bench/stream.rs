//! Streaming: a laser's raster fed to the board over its link.

use lang::back::{self, Compiled};
use lang::profile::Profile;

use super::code::program;
use super::stand::Stand;
use super::{Sink, at_least, at_most};
use crate::sim::world::World;
use crate::stream::feed::Feed;
use crate::stream::job::Job;
use crate::stream::late::handler_ms;
use crate::stream::pump::{self, Outcome};

/// Lines of the raster.
const LINES: u32 = 3000;
/// Pixels of a row of it.
const ROW: u32 = 100;

/// A raster as LaserGRBL writes it, ten lines to the millimetre, every pixel of another grey, as a
/// script; rows go to and fro.
pub fn raster(lines: u32, feed: u32) -> String {
    let mut text = format!("PROFILE \"laser\"\nG90\nF{feed}\nG0 X0 Y0\nM3\nS0\n");
    for i in 0..lines {
        let (row, column) = (i / ROW, i % ROW);
        let place = if row % 2 == 0 { column + 1 } else { ROW - column };
        let (x, grey) = (place * 100, (i * 37 + row * 11) % 1000);
        text += &format!("S{grey}\nG1 X{}.{:03}\n", x / 1000, x % 1000);
        if column == ROW - 1 {
            let y = (row + 1) * 100;
            text += &format!("S0\nG1 Y{}.{:03}\n", y / 1000, y % 1000);
        }
    }
    text + "M5\n"
}

/// The same raster with every pixel where the tool stands already.
fn at_rest(raster: &str) -> String {
    let line = |line: &str| match line.starts_with("G1 ") {
        true => "G1 X0.000 Y0.000\n".to_owned(),
        false => format!("{line}\n"),
    };
    raster.lines().map(line).collect()
}

/// Figures `stream_link`: the lines of a raster that go over the link and through the board when
/// nothing moves for them; `stream_rate`: pixels of 0.1 mm at 100 mm/s on a machine with steep ramps,
/// where the planner sets the pace; and `stream_starved`: how often motion stood for want of a piece on
/// the `laser` profile, where one block of look-ahead and ramps of 25 000 st/s2 do; `stream_handler`:
/// from an input's edge to the first output of its handler, at worst, the input's filter of 5 ms in it.
///
/// # Errors
/// The board does not take the job.
pub fn run(sink: Sink<'_>) -> Result<(), String> {
    let laser = Profile::built_in("laser").map_err(|error| error.to_string())?;
    let mut steep = laser.clone();
    for axis in steep.x.iter_mut().chain(&mut steep.y) {
        axis.accel = 2_000_000;
    }
    let (link, _) = stream(&at_rest(&raster(LINES, 6000)), LINES, &laser)?;
    sink(at_least("stream_link", "lines/s", link, 800.0, 1500.0))?;
    let (fast, _) = stream(&raster(LINES, 6000), LINES, &steep)?;
    sink(at_least("stream_rate", "lines/s", fast, 170.0, 500.0))?;
    let (_, starved) = stream(&raster(LINES / 3, 1000), LINES / 3, &laser)?;
    sink(at_most("stream_starved", "times", starved.into(), 0.0, 0.0))?;
    let late = handler()?;
    sink(at_most("stream_handler", "ms", late, handler_ms(115_200).into(), 50.0))
}

/// Edges during a long wait, then while short ones keep the link busy; gives the longest time from
/// one to its handler's output, ms.
fn handler() -> Result<f64, String> {
    const EDGES: u32 = 24;
    let script = "ON IN 3 RISE GOSUB hit\nWait 2s\nREPEAT 250\n  Wait 10ms\nEND REPEAT\nEND\n\
        hit:\nPulse 8, 5ms\nRETURN\n";
    let world: String = (0..EDGES)
        .map(|i| {
            let at = 300 + 157 * i;
            format!("at({at}, || set_in(3, true)); at({}, || set_in(3, false));", at + 60)
        })
        .collect();
    let world = World::parse("bench", &world).map_err(|error| error.to_string())?;
    let (checked, _) = program("handler", script)?;
    let compiled = back::compile(&checked).map_err(|excesses| format!("{excesses:?}"))?;
    let mut stand = Stand::in_world(&checked.profile, &world)?;
    let rig = stand.rig();
    rig.borrow_mut().begin();
    feed(&mut stand, &compiled)?;
    let rising = |edges: Vec<(u64, i32, bool)>, n: i32| -> Vec<u64> {
        edges.into_iter().filter(|edge| edge.1 == n && edge.2).map(|edge| edge.0).collect()
    };
    let mut rig = rig.borrow_mut();
    let edges = rising(rig.take_input_edges(), 3);
    let served = rising(rig.take_output_edges(), 8);
    if (edges.len(), served.len()) != (EDGES as usize, EDGES as usize) {
        return Err(format!("{} edges, {} handlers", edges.len(), served.len()));
    }
    let late = edges.iter().zip(&served).map(|(edge, served)| served - edge).max().unwrap_or(0);
    Ok(late as f64 / rig.ticks(1_000) as f64)
}

/// Streams a raster of so many lines; gives lines a second and how often motion stood.
fn stream(raster: &str, lines: u32, profile: &Profile) -> Result<(f64, u16), String> {
    let (mut checked, _) = program("raster", raster)?;
    checked.profile = profile.clone();
    let compiled = back::compile(&checked).map_err(|excesses| format!("{excesses:?}"))?;
    let mut stand = Stand::new(profile)?;
    let outcome = feed(&mut stand, &compiled)?;
    Ok((f64::from(lines) / outcome.time.as_secs_f64(), outcome.starved))
}

/// Streams a job to its end.
pub(super) fn feed(stand: &mut Stand, compiled: &Compiled) -> Result<Outcome, String> {
    let client = stand.client();
    let slots = client.stream_slots().map_err(|error| error.to_string())?;
    let slots = slots.ok_or("the board cannot stream")?;
    let feed = Feed::new(compiled).map_err(|refused| refused.text)?;
    let mut job = Job::new(feed, slots.bytes.into());
    let outcome = pump::run(client, &mut job, slots, &mut |_| None, &mut |_| ())
        .map_err(|error| error.to_string())?;
    if outcome.end != lang::wire::End::Done {
        return Err(format!("the job ends in line {} with {:?}", outcome.line, outcome.fault));
    }
    Ok(outcome)
}
