//! What every test of this suite holds to physics and to its script, whatever else it looks at.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};

use emulator::Plant;
use lang::hir::Program;
use lang::profile::Profile;
use lang::record::MachineRecord;
use pasapas::board::Build;
use pasapas::board::judge::Judge;
use pasapas::sim::record::SegmentKind;
use pasapas::sim::trace::Status;
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};

/// Longest script, simulated us.
const LONGEST_US: u64 = 300_000_000;
/// Moves and steps that were judged in this process.
static JUDGED: [AtomicUsize; 2] = [AtomicUsize::new(0), AtomicUsize::new(0)];

/// Where a script may lead, steps. Only for one whose places hang on no switch and on no time.
#[derive(Clone, Debug)]
pub struct Commanded {
    low: [i64; 3],
    high: [i64; 3],
    /// Where it ends.
    pub end: [i64; 3],
    /// Places at which an axis may turn round; arcs turn anywhere, and so does a new target on the way.
    turns: Option<[BTreeSet<i64>; 3]>,
}

impl Commanded {
    /// What the simulator says of a script that nothing around the machine disturbs.
    pub fn by(
        build: &Build,
        profile: &Profile,
        program: &Program,
        text: &str,
    ) -> Option<Commanded> {
        // Places that hang on a switch or on time.
        if ["Home", "Probe", "MoveSpeed"].iter().any(|word| text.contains(word)) {
            return None;
        }
        let limit_us = LONGEST_US;
        let options = Options { look_ahead: build.part.look_ahead, limit_us, ..Options::default() };
        let (outcome, _) = run_traced(program, Engine::Vm, &World::empty(), &options).ok()?;
        // It waits for ever behind its end.
        if outcome.end.status == Status::Fault {
            return None;
        }
        let record = MachineRecord::of(profile);
        let mut turns: [BTreeSet<i64>; 3] = Default::default();
        let (mut low, mut high, mut end) = ([0; 3], [0; 3], [0; 3]);
        let mut include = |axis: usize, place: i64| {
            low[axis] = place.min(low[axis]);
            high[axis] = place.max(high[axis]);
        };
        for segment in &outcome.record.path {
            if !matches!(segment.kind, SegmentKind::Move(_)) {
                return None;
            }
            for axis in 0..3 {
                for place in [segment.from[axis], segment.to[axis]] {
                    include(axis, place.into());
                    turns[axis].insert(place.into());
                }
                if segment.axes[axis] {
                    end[axis] = segment.to[axis].into();
                }
            }
            if let Some(arc) = segment.arc {
                let at = |axis: usize, steps: i32| {
                    let own = &record.axes[axis];
                    f64::from(steps) * f64::from(own.um) / f64::from(own.steps) - arc.center[axis]
                };
                let [a, b] = arc.plane.map(|axis| axis.index());
                let radius = at(a, segment.from[a]).hypot(at(b, segment.from[b]));
                for axis in [a, b] {
                    let own = &record.axes[axis];
                    let scale = f64::from(own.steps) / f64::from(own.um);
                    for um in [arc.center[axis] - radius, arc.center[axis] + radius] {
                        let steps = um * scale;
                        include(
                            axis,
                            if um < arc.center[axis] { steps.floor() } else { steps.ceil() } as i64,
                        );
                    }
                }
            }
        }
        let free = ["START", "G2", "G3"].iter().any(|word| text.contains(word));
        Some(Commanded { low, high, end, turns: (!free).then_some(turns) })
    }

    /// Holds the steps of a judge to the script; `from` is where the machine stood.
    pub fn check(&self, judge: &Judge, from: [i64; 3]) -> Result<(), String> {
        let mut place = from;
        let mut way = [0; 3];
        for step in judge.steps() {
            for axis in (0..3).filter(|axis| step.by[*axis] != 0) {
                let by = step.by[axis];
                let turns = way[axis] == -by;
                if turns && self.turns.as_ref().is_some_and(|t| !t[axis].contains(&place[axis])) {
                    let at = place[axis];
                    return Err(format!("axis {axis} turns round at {at}, where no move ends"));
                }
                way[axis] = by;
                place[axis] += i64::from(by);
                if !(self.low[axis]..=self.high[axis]).contains(&place[axis]) {
                    let range = [self.low[axis], self.high[axis]];
                    return Err(format!("axis {axis} steps to {}, outside {range:?}", place[axis]));
                }
            }
        }
        Ok(())
    }
}

/// Judges the steps of a test: profile, drivers, and where the script leads.
pub fn judge(judge: &Judge, plant: &Plant, commanded: Option<&Commanded>, abrupt: bool) {
    let count = judge.judge(plant, abrupt).unwrap_or_else(|text| panic!("{text}"));
    if let Some(Err(text)) = commanded.map(|own| own.check(judge, [0; 3])) {
        panic!("{text}");
    }
    let moves = JUDGED[0].fetch_add(count.moves, Ordering::Relaxed) + count.moves;
    let steps = JUDGED[1].fetch_add(count.steps, Ordering::Relaxed) + count.steps;
    if count.moves != 0 {
        println!("judged so far: {moves} moves, {steps} steps");
    }
}
