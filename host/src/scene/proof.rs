//! Proof by variation: a script runs in its cell again and again, each time with other deviations, and every run has an
//! outcome. A run depends on script, cell and deviations alone, so its seed repeats it anywhere.

mod class;
mod reached;
pub mod table;

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use cell::vary::{self, Deviation};
use lang::back::Compiled;
use lang::hir::Program;

pub use self::class::Class;
use self::class::classify;
use super::{Report, Scene};
use crate::board::engine::BoardError;
use crate::sim::trace::Event;
use crate::sim::world::World;
use crate::sim::{End, Options, SimError, vm_engine};

/// A script in its cell, ready to run many times.
pub struct Case<'a> {
    /// The script.
    pub program: &'a Program,
    /// Its image.
    pub compiled: &'a Compiled,
    /// What is around the machine beside the cell.
    pub world: &'a World,
    /// The cell.
    pub scene: &'a Scene,
    /// Limits of a run.
    pub options: &'a Options,
}

/// A run.
#[derive(Clone, Debug)]
pub struct Ran {
    /// Its outcome.
    pub class: Class,
    /// How it ended.
    pub end: End,
    /// What the cell gave.
    pub report: Report,
    /// Lines of statements that had an effect.
    pub lines: BTreeSet<u32>,
}

impl Case<'_> {
    /// Runs with these deviations.
    ///
    /// # Errors
    /// The machine or the world fails, or the user interrupts before it begins.
    pub fn run(&self, deviations: &[Deviation]) -> Result<Ran, BoardError> {
        if (self.options.interrupted)() {
            let text = "interrupted before the program started";
            return Err(BoardError::Board(text.to_owned()));
        }
        let scene = self.scene.deviating(deviations.to_vec());
        let world = self.world.clone().with_scene(Some(scene));
        let lines = Rc::new(RefCell::new(BTreeSet::new()));
        let told = Rc::clone(&lines);
        let sink = Box::new(move |event: &Event| {
            told.borrow_mut().insert(event.what.line());
        });
        let outcome = vm_engine::run(self.program, self.compiled, &world, self.options, sink)
            .map_err(|error| match error {
                SimError::World(error) => BoardError::World(error),
                SimError::Engine(text) => BoardError::Board(text),
            })?;
        let (end, stopped) = (outcome.end, outcome.summary.stopped);
        let report =
            outcome.cell.ok_or_else(|| BoardError::Board("the run had no cell".to_owned()))?;
        let class = classify(&report, &end, stopped, deviations, &self.scene.cell);
        Ok(Ran { class, end, report, lines: lines.take() })
    }
}

/// How much is to be proved.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Runs in all.
    pub runs: u64,
    /// Seed of the first run; the others count up from it.
    pub seed: u64,
    /// Threads.
    pub jobs: usize,
    /// Of every `shard.1` runs only the one with the number `shard.0`, from 0.
    pub shard: (u64, u64),
    /// No run begins after this time.
    pub within: Option<Duration>,
    /// No run begins after one that is neither passed nor handled.
    pub until_fails: bool,
}

/// An outcome with its runs.
#[derive(Clone, Debug)]
pub struct Tally {
    /// The outcome.
    pub class: Class,
    /// Runs.
    pub runs: u64,
    /// The first run's seed.
    pub seed: u64,
    /// The first run's deviations.
    pub deviations: Vec<Deviation>,
    /// The fewest and smallest deviations that still have this outcome, of one that is neither passed nor handled.
    pub shrunk: Option<Shrunk>,
}

/// What is left of a failing run's deviations.
#[derive(Clone, Debug)]
pub struct Shrunk {
    /// The deviations.
    pub deviations: Vec<Deviation>,
    /// A run with them.
    pub ran: Ran,
    /// Runs that it took.
    pub runs: usize,
}

/// What was found.
#[derive(Clone, Debug)]
pub struct Proof {
    /// Runs that were made.
    pub runs: u64,
    /// Runs that were asked for.
    pub wanted: u64,
    /// Outcomes in the order of [`Class::ALL`], those that occurred.
    pub tallies: Vec<Tally>,
    /// Lines of statements with an effect that no run reached; those of handlers of errors first.
    pub unreached: Vec<u32>,
    /// How long it took.
    pub took: Duration,
}

/// Runs that shrinking a case may take.
const SHRINKING: usize = 120;

/// The runs of a thread: outcome of each, and of each line the first run that reached it.
#[derive(Default)]
struct Found {
    classes: BTreeMap<u64, Class>,
    lines: BTreeMap<u32, u64>,
}

impl Found {
    fn reached(&mut self, lines: impl IntoIterator<Item = u32>, index: u64) {
        for line in lines {
            self.lines.entry(line).and_modify(|first| *first = index.min(*first)).or_insert(index);
        }
    }
}

/// Runs a case under variation. `progress` hears how many runs were made; what `interrupted` ends is given as far as it
/// is known. The same whatever the number of threads.
///
/// # Errors
/// A run fails for a reason that is not the script's.
pub fn prove(
    case: &Case<'_>,
    plan: &Plan,
    interrupted: &(dyn Fn() -> bool + Sync),
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Proof, BoardError> {
    let began = Instant::now();
    let (part, parts) = (plan.shard.0, plan.shard.1.max(1));
    let wanted = plan.runs.saturating_sub(part).div_ceil(parts);
    let next = AtomicU64::new(0);
    // Runs from this one on are not begun.
    let end = AtomicU64::new(wanted);
    let made = AtomicU64::new(0);
    let all = Mutex::new(Ok(Found::default()));
    let work = || {
        let mut found = Found::default();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let late = plan.within.is_some_and(|within| began.elapsed() >= within);
            if late || interrupted() || index >= end.load(Ordering::Relaxed) {
                break;
            }
            let seed = plan.seed.wrapping_add(part + index * parts);
            let ran = case.run(&vary::draw(&case.scene.cell, seed));
            // A run that was cut short has no outcome.
            if interrupted() {
                break;
            }
            match ran {
                Ok(ran) => {
                    if plan.until_fails && ran.class.fails() {
                        end.fetch_min(index + 1, Ordering::Relaxed);
                    }
                    found.classes.insert(index, ran.class);
                    found.reached(ran.lines, index);
                }
                Err(error) => {
                    end.store(0, Ordering::Relaxed);
                    if let Ok(mut all) = all.lock() {
                        *all = Err(error);
                    }
                    return;
                }
            }
            progress(made.fetch_add(1, Ordering::Relaxed) + 1);
        }
        if let Ok(mut all) = all.lock()
            && let Ok(all) = &mut *all
        {
            all.classes.extend(found.classes);
            for (line, index) in found.lines {
                all.reached([line], index);
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..plan.jobs.max(1) {
            scope.spawn(work);
        }
    });
    let mut found = all.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)?;
    // Another thread may have gone beyond the run that ends the search.
    let end = end.load(Ordering::Relaxed);
    found.classes.retain(|index, _| *index < end);
    found.lines.retain(|_, first| *first < end);
    let seed_of = |index: u64| plan.seed.wrapping_add(part + index * parts);
    let mut tallies = Vec::new();
    for class in Class::ALL {
        let mut own = found.classes.iter().filter(|(_, other)| **other == class);
        let Some((&first, _)) = own.next() else { continue };
        let seed = seed_of(first);
        let deviations = vary::draw(&case.scene.cell, seed);
        let shrunk = match class.fails() {
            true => Some(shrink(case, class, &deviations, interrupted)?),
            false => None,
        };
        tallies.push(Tally { class, runs: own.count() as u64 + 1, seed, deviations, shrunk });
    }
    let lines = found.lines.into_keys().collect();
    let unreached = reached::never(case.program, &lines);
    let runs = found.classes.len() as u64;
    Ok(Proof { runs, wanted, tallies, unreached, took: began.elapsed() })
}

/// The fewest and smallest deviations with the same outcome.
fn shrink(
    case: &Case<'_>,
    class: Class,
    deviations: &[Deviation],
    interrupted: &(dyn Fn() -> bool + Sync),
) -> Result<Shrunk, BoardError> {
    let mut runs = 0;
    let keeps = |list: &[Deviation]| {
        runs += 1;
        !interrupted() && case.run(list).is_ok_and(|ran| ran.class == class)
    };
    let deviations = vary::shrink(deviations, SHRINKING, keeps);
    let ran = case.run(&deviations)?;
    Ok(Shrunk { deviations, ran, runs: runs + 1 })
}
