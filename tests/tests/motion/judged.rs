//! What every test of this suite holds to physics and to its script, whatever else it looks at.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};

use emulator::plant::motor::DriverLimits;
use emulator::{Plant, Wiring};
use lang::hir::Program;
use lang::profile::Profile;
use lang::record::MachineRecord;
use pasapas::bench::stand::image_for;
use pasapas::board::judge::Judge;
use pasapas::board::{Build, F5529, G2553};
use pasapas::sim::record::SegmentKind;
use pasapas::sim::trace::Status;
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};

use crate::lab::{Lab, Step};

/// Longest script, simulated us.
const LONGEST_US: u64 = 300_000_000;
/// Moves and steps that were judged in this process.
static JUDGED: [AtomicUsize; 2] = [AtomicUsize::new(0), AtomicUsize::new(0)];

/// Where a script may lead, steps. Only for one whose end hangs on no switch and on no time.
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
        let options = Options { part: build.part, limit_us, ..Options::default() };
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
        if text.contains("START") {
            // How far an axis is when it gets a new target hangs on time.
            (low, high) = ([i64::MIN; 3], [i64::MAX; 3]);
        }
        let free = ["START", "G2", "G3"].iter().any(|word| text.contains(word));
        Some(Commanded { low, high, end, turns: (!free).then_some(turns) })
    }

    /// Holds the steps of a judge to the script, from power-up to where they are, or to its end.
    ///
    /// # Errors
    /// The first step that is none of the script's.
    pub fn check(&self, judge: &Judge, done: bool) -> Result<(), String> {
        let mut place = [0; 3];
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
        if done && place != self.end {
            return Err(format!("the axes end at {place:?}, not at {:?}", self.end));
        }
        Ok(())
    }
}

/// Judges the steps of a test: profile, drivers, and where the script leads, to its end if it is done.
///
/// # Errors
/// The first violation.
pub fn judge(
    judge: &Judge,
    plant: &Plant,
    commanded: Option<(&Commanded, bool)>,
    abrupt: bool,
) -> Result<(), String> {
    let count = judge.judge(plant, abrupt)?;
    if let Some((commanded, done)) = commanded {
        commanded.check(judge, done)?;
    }
    let moves = JUDGED[0].fetch_add(count.moves, Ordering::Relaxed) + count.moves;
    let steps = JUDGED[1].fetch_add(count.steps, Ordering::Relaxed) + count.steps;
    if count.moves != 0 {
        println!("judged so far: {moves} moves, {steps} steps");
    }
    Ok(())
}

/// Seeded faults: what the bench holds every test to finds each of them.
#[test]
fn the_judges_of_every_test_find_what_is_seeded() {
    let script = "G1 X3 Y1 F1800\nG1 X1 Y0.5\nMoveAxe Z, -2mm";
    for build in [&G2553, &F5529] {
        let mill = Profile::built_in("mill").expect("the mill");
        let (program, _) = image_for(&mill, script).expect("a script");
        let commanded = Commanded::by(build, &mill, &program, script).expect("known places");
        assert_eq!(commanded.end, [100, 50, -200]);
        let run = Lab::new(build, &mill, script).play(|_| {});
        let place = |steps: &[Step]| {
            let mut judge = Judge::new(&mill, &Plant::new(Wiring::Chain));
            judge.add(steps);
            (commanded.check(&judge, true), judge)
        };
        let (found, judge) = place(&run.steps);
        assert_eq!(found, Ok(()));
        assert!(judge.judge(&Plant::new(Wiring::Chain), false).is_ok());
        // A step too many in the middle of a move and before it turns round; one too few.
        let turn = run.steps.iter().position(|step| step.by[0] < 0).expect("it comes back");
        let mut more = run.steps.clone();
        more.insert(turn, Step { at: more[turn].at - 400, by: [1, 0, 0] });
        assert!(place(&more).0.is_err(), "a step outside the range");
        let mut fewer = run.steps.clone();
        fewer.remove(turn - 1);
        assert!(place(&fewer).0.is_err(), "it turns round before its end");
        let mut last = run.steps.clone();
        last.pop();
        assert!(place(&last).0.is_err(), "it ends before its end");
        // Ramps of half the steepness are broken by the same record.
        let mut lazy = mill.clone();
        lazy.x.as_mut().expect("X").accel /= 2;
        let mut judge = Judge::new(&lazy, &Plant::new(Wiring::Chain));
        judge.add(&run.steps);
        assert!(judge.judge(&Plant::new(Wiring::Chain), false).is_err(), "too quick a ramp");
        // Drivers that want longer pulses, and DIR longer before STEP, than the board was told.
        let drivers: [fn(&mut DriverLimits); 2] = [|own| own.pulse *= 15, |own| own.setup *= 6_000];
        for slower in drivers {
            let mut lab = Lab::new(build, &mill, script);
            slower(&mut lab.board.plant_mut().limits);
            lab.start();
            lab.run_ms(900);
            assert!(lab.judged().is_err(), "{:?}", lab.board.plant().limits);
            lab.forgive();
        }
    }
}
