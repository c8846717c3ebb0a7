//! Long random moves while a client polls without a pause: every edge at the pins against the instant
//! that the planner gives it, and every move against the ramps of the profile.

use std::time::Duration;

use emulator::{Edge, Rng, Signal};
use firmware::motion::scaled::Scaled;
use firmware::motion::{
    Arc, Block, Ends, Feed, Manner, Pace, Path, PathSegment, Segment, Single, physics,
};
use lang::part::Part;
use lang::profile::Profile;
use lang::record::{AxisRecord, MachineRecord};

use super::stand::{Stand, image_for};
use crate::board::Build;

/// Moves that are made.
pub const MOVES: usize = 32;
/// Rest between two moves; a longer one separates them.
const REST_MS: u64 = 30;
/// Rest of the client between two requests.
const ASK_EVERY: Duration = Duration::from_millis(3);

/// What was found.
pub struct Found {
    /// Farthest edge from its planned instant, counted from the move's first step, us.
    pub jitter_us: f64,
    /// Farthest duration of a move from the planned one, %.
    pub time_off: f64,
    /// Moves whose steps keep the start rate, the top rate and the ramps.
    pub in_limits: usize,
}

/// A move from rest to rest.
enum Move {
    Axis(usize, i32, u32),
    Line([i32; 3], u32),
    Arc(Box<Arc>, u32),
}

/// Instants of the steps of each axis, ticks of the step timer.
type Instants = [Vec<u64>; 3];

/// A script of random moves, and the moves.
fn script(rng: &mut Rng, arcs: bool) -> Result<(String, Vec<Move>), String> {
    // To the middle of the machine, away from the reference switches.
    let mut text = format!("G91\nG1 X150 Y100 Z-40 F3000\nG4 P{:.3}\n", REST_MS as f64 / 1e3);
    let mut at = [15_000, 10_000, -4_000];
    let mut moves = vec![Move::Line(at, 50_000)];
    for n in 1..MOVES {
        // Away and back in turns, so that travel stays within some hundred mm.
        let way = if n % 2 == 0 { 1 } else { -1 };
        let mut steps = || way * (200 + rng.below(6_000) as i32);
        let by = [steps(), steps() / 2, steps() / 5];
        match rng.below(if arcs { 3 } else { 2 }) {
            0 => {
                let speed = 900 + rng.below(7_000) as u32;
                text += &format!("MoveRel X, {}st, {speed}st/s\n", by[0]);
                at[0] += by[0];
                moves.push(Move::Axis(0, by[0], speed));
            }
            1 => {
                let feed = 10 + rng.below(60) as u32;
                let [x, y, z] = by.map(|steps| f64::from(steps) / 100.0);
                text += &format!("G1 X{x:.2} Y{y:.2} Z{z:.2} F{}\n", feed * 60);
                at = [0, 1, 2].map(|i| at[i] + by[i]);
                moves.push(Move::Line(by, feed * 1_000));
            }
            _ => {
                let (r, feed) = (way * (300 + rng.below(2_000) as i32), 10 + rng.below(30) as u32);
                let to = [at[0] + r, at[1] + r, at[2]];
                let um = |steps: [i32; 3]| steps.map(|steps| steps * 10);
                let ends = Ends {
                    first: 0,
                    clockwise: false,
                    from_um: um(at),
                    to_um: um(to),
                    start: at,
                    end: to,
                };
                let arc = ends.around([0, r * 10]).map_err(|fault| fault.to_string())?;
                let r = f64::from(r) / 100.0;
                text += &format!("G3 X{r:.2} Y{r:.2} J{r:.2} F{}\n", feed * 60);
                at = to;
                moves.push(Move::Arc(Box::new(arc), feed * 1_000));
            }
        }
        text += &format!("G4 P{:.3}\n", REST_MS as f64 / 1e3);
    }
    Ok((text, moves))
}

/// What the planner of a part makes of a move.
fn plan(one: &Move, record: &MachineRecord, part: &Part) -> Instants {
    let axes: &[AxisRecord; 3] = &record.axes;
    let mut out: Instants = Default::default();
    let rate = Scaled::constant(part.clock);
    let mut path = Path::new(record.corner, rate);
    let taken = match one {
        Move::Axis(axis, steps, speed) => {
            let mut single = Single::new(0, rate);
            single.go(&axes[*axis], *steps, Pace::of(&axes[*axis]).with_steps(*speed));
            let mut segments = Vec::new();
            let mut segment = Segment::default();
            while single.next_segment(&mut segment) {
                segments.push(segment);
            }
            out[*axis] = physics::instants(&segments, 0);
            return out;
        }
        Move::Line(steps, feed) => {
            let manner = Manner::new(Feed::Um(*feed), true);
            let block = Block { steps: *steps, um: [0; 3], manner };
            if part.look_ahead {
                path.push(axes, &block)
            } else {
                // No ring takes bits from its feed.
                path.push_ending(axes, &block, Scaled::ZERO);
                true
            }
        }
        Move::Arc(arc, feed) => path.push_arc(axes, arc, &Manner::new(Feed::Um(*feed), true)),
    };
    let (mut segments, mut segment) = (Vec::new(), PathSegment::default());
    while taken && path.next_segment(axes, &mut segment) {
        segments.push(segment);
    }
    let mut instants = physics::instants(segments.iter().map(|own| &own.ramp), 0).into_iter();
    let mut acc = [0; 3];
    for segment in &mut segments {
        for at in instants.by_ref().take(segment.ramp.steps().into()) {
            let mut by = [0; 3];
            segment.played(1, &mut acc, &mut by);
            segment.begin = false;
            (0..3).filter(|axis| by[*axis] != 0).for_each(|axis| out[axis].push(at));
        }
    }
    out
}

/// The steps at the pins, one move after the other.
fn made(edges: &[Edge], clock: u32) -> Vec<Instants> {
    let mut out: Vec<Instants> = Vec::new();
    let mut last = None;
    for edge in edges {
        let (Signal::Step(axis), true) = (edge.signal, edge.level) else { continue };
        let rest = REST_MS * u64::from(clock) / 1_000 * 2 / 3;
        if last.is_none_or(|last| edge.cycle > last + rest) {
            out.push(Default::default());
        }
        last = Some(edge.cycle);
        if let Some(instants) = out.last_mut() {
            instants[usize::from(axis)].push(edge.cycle);
        }
    }
    out
}

fn first(instants: &Instants) -> u64 {
    instants.iter().filter_map(|own| own.first()).min().copied().unwrap_or(0)
}

fn last(instants: &Instants) -> u64 {
    instants.iter().filter_map(|own| own.last()).max().copied().unwrap_or(0)
}

/// Moves a build's board about.
///
/// # Errors
/// It does not run the moves, or makes other steps than planned.
pub fn measure(build: &Build, profile: &Profile) -> Result<Found, String> {
    let arcs = build.part.features & lang::record::feature::ARC != 0;
    let (text, moves) = script(&mut Rng::new(4), arcs)?;
    let (_, image) = image_for(profile, &text)?;
    let clock = build.part.clock;
    let mut stand = Stand::on(build, profile)?.in_ticks();
    stand.upload(&image)?;
    let edges = stand.run_asking(Duration::from_secs(120), ASK_EVERY)?;
    let made = made(&edges, clock);
    if made.len() != moves.len() {
        return Err(format!("{} moves were made, not {}", made.len(), moves.len()));
    }
    let record = MachineRecord::of(profile);
    let mut found = Found { jitter_us: 0.0, time_off: 0.0, in_limits: 0 };
    for (n, (one, made)) in moves.iter().zip(&made).enumerate() {
        let planned = plan(one, &record, &build.part);
        let (here, there) = (first(made), first(&planned));
        for axis in 0..3 {
            if made[axis].len() != planned[axis].len() {
                let (made, planned) = (made[axis].len(), planned[axis].len());
                return Err(format!("move {n}, axis {axis}: {made} steps, {planned} planned"));
            }
            for (made, planned) in made[axis].iter().zip(&planned[axis]) {
                let off = (made - here).abs_diff(planned - there);
                found.jitter_us = found.jitter_us.max(off as f64 * 1e6 / f64::from(clock));
            }
        }
        let (took, wanted) = (last(made) - here, last(&planned) - there);
        found.time_off = found.time_off.max(took.abs_diff(wanted) as f64 / wanted as f64 * 100.0);
        // The axis with most steps has all events of a line; on an arc that changes.
        let axis = (0..3).max_by_key(|axis| made[*axis].len()).unwrap_or(0);
        let own = &record.axes[axis];
        let limits = physics::Limits {
            start: own.start_rate.into(),
            top: own.top_rate.into(),
            accel: own.accel.into(),
            decel: own.decel.into(),
        };
        if !matches!(one, Move::Arc(..)) {
            let times: Vec<u64> = made[axis].iter().map(|at| physics::ticks(*at, clock)).collect();
            physics::check(&times, &limits).map_err(|v| format!("move {n}: {v:?}"))?;
        }
        found.in_limits += 1;
    }
    Ok(found)
}
