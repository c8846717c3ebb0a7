//! `pasapas prove`: a script in its cell under variation.

use std::thread::available_parallelism;
use std::time::Duration;

use ::cell::scene::{Scene, Vary};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::console::{Console, Options};
use super::part::Choice;
use super::{cell, script, world};
use crate::board::engine::BoardError;
use crate::failure::Failure;
use crate::input::code;
use crate::interrupt;
use crate::output;
use crate::render::Note;
use crate::scene::proof::{self, Case, Plan};
use crate::sim::world::World;
use crate::sim::{self, chain};

/// `pasapas prove`
#[derive(Debug, Args)]
pub struct Prove {
    /// A script with a cell that has a [[vary]]
    file: String,
    #[command(flatten)]
    cell: cell::CellChoice,
    /// Scenario beside the cell: people, switches, a host
    #[arg(long, value_name = "W.rhai")]
    world: Option<String>,
    /// Runs, each with other deviations
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    runs: u64,
    /// Seed of the first run; the others count up from it
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Runs at the same time; without it one for each core
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=512))]
    jobs: Option<u16>,
    /// Begin no run after this time: 60s, 10min, 2h
    #[arg(long = "for", value_name = "TIME", value_parser = super::sim::time)]
    within: Option<u64>,
    /// Make one part of the runs: 3/8 is the third of eight machines
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(u64, u64)>,
    /// End with the first run that is neither passed nor handled
    #[arg(long)]
    until_fails: bool,
    /// Write the outcomes as JSON lines
    #[arg(long, value_name = "R.json", value_parser = json_file)]
    report: Option<String>,
}

/// `3/8` as its number from 0, and how many there are.
fn shard(text: &str) -> Result<(u64, u64), String> {
    let numbers = text
        .split_once('/')
        .and_then(|(own, all)| Some((own.parse::<u64>().ok()?, all.parse::<u64>().ok()?)));
    match numbers {
        Some((own, all)) if (1..=all).contains(&own) => Ok((own - 1, all)),
        _ => Err("a part is written 3/8: the third of eight".to_owned()),
    }
}

fn json_file(name: &str) -> Result<String, String> {
    let is_json = [".json", ".jsonl"].iter().any(|end| name.ends_with(end));
    if is_json {
        Ok(name.to_owned())
    } else {
        Err("the report of a proof ends in .json".to_owned())
    }
}

impl Prove {
    /// Proves the script.
    ///
    /// # Errors
    /// Script or cell is wrong, or a run is neither passed nor handled.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let mut script = script::load(&self.file, options, console)?;
        let outputs = [("--report", self.report.as_ref())];
        script.keep_inputs(&self.file, options, self.world.as_deref(), &outputs)?;
        let refuse = |text: String, hint: &str| {
            console.refuse(&Note::error(&self.file, code::ENGINE, text).hint(hint))
        };
        let Some(scene) = self.cell.find(&self.file, &script, console)? else {
            return Err(refuse(
                "there is no cell to vary".to_owned(),
                "write NAME.cell.toml beside the script, or give --cell FILE",
            ));
        };
        if scene.cell.varies.is_empty() {
            return Err(refuse(
                format!("{} varies nothing: all runs would be the same", scene.file),
                "add what may differ to it: `[[vary]]` with `key = \"THING.KEY\"` and `sigma = 0.2`, or with `fault = \
                 \"pause\"`, `chance = 0.1` and `within_s = 5`; without, `pasapas sim` makes the one run that there is",
            ));
        }
        if scene.cell.expects.is_empty() {
            let text = format!("{} expects nothing: what does not fault passes", scene.file);
            let note = Note::error(&scene.file, code::ENGINE, text).warning();
            console.note(&note.hint(
                "add `[[expect]]` with `what = \"no_collision\"`, or what the work is for",
            ))?;
        }
        if !chain::calls(&script.program).is_empty() {
            return Err(refuse(
                "the script begins other programs with RUN; one is proved at a time".to_owned(),
                "prove each of them with a cell of its own",
            ));
        }
        let world = world::load(self.world.as_deref(), World::unattended(), console)?;
        let compiled = script::compile_for_device(&script, console)?;
        let part = Choice { part: Some(&crate::board::F5529) };
        let (compiled, _) = part.fit(&mut script, compiled, console)?;
        interrupt::watch();
        let options = sim::Options {
            record: false,
            judged: false,
            interrupted: interrupt::asked,
            ..sim::Options::default()
        };
        let case = Case {
            program: &script.program,
            compiled: &compiled,
            world: &world,
            scene: &scene,
            options: &options,
        };
        let nominal = case.run(&[]).map_err(|error| failed(error, console))?;
        if nominal.class.fails() && !interrupt::asked() {
            // What is wrong without any deviation is no matter of variation.
            console.complain(&format!(
                "{}: {} without any deviation",
                self.file,
                nominal.class.word()
            ));
            console.complain(nominal.report.table().trim_end());
            return Err(Failure::Run);
        }
        // What has hung is not run for a day, a thousand times.
        let limit_us = limit_us(nominal.report.end.us, &scene.cell);
        let options = sim::Options { limit_us, ..options };
        let case = Case { options: &options, ..case };
        let cores = available_parallelism().map_or(1, usize::from);
        let plan = Plan {
            runs: self.runs,
            seed: self.seed,
            jobs: self.jobs.map_or(cores, usize::from),
            shard: self.shard.unwrap_or((0, 1)),
            within: self.within.map(Duration::from_micros),
            until_fails: self.until_fails,
        };
        let bar = bar(plan.runs / plan.shard.1, console);
        let progress = |made: u64| bar.set_position(made);
        let proof = proof::prove(&case, &plan, &interrupt::asked, &progress);
        bar.finish_and_clear();
        let proof = proof.map_err(|error| failed(error, console))?;
        let line_of = |line: u32| script.line_of_file(line);
        let json: String = proof.json(&line_of).into_iter().map(|line| line + "\n").collect();
        if let Some(path) = &self.report {
            output::write(path, &json)?;
        }
        if console.json() {
            console.result(&json)?;
        } else if proof.wanted == 0 {
            let (own, all) = plan.shard;
            console.result(&format!(
                "part {} of {all} has no run: there are {} in all\n",
                own + 1,
                plan.runs
            ))?;
        } else {
            let nominal = |key: &str| {
                let value = ::cell::vary::value(&scene.cell, key);
                (value != 0.0).then_some(value)
            };
            console.result(&proof.table(&self.file, &line_of, &nominal))?;
        }
        if proof.holds() { Ok(()) } else { Err(Failure::Run) }
    }
}

/// Time after which a run has hung, us: an hour and ten times what it takes without a deviation, and all that deviations
/// may make it wait. The same for every run, whatever its deviations are.
fn limit_us(nominal: u64, cell: &Scene) -> u64 {
    let waits = cell.varies.iter().map(|vary| match vary {
        Vary::Fault { up_to_us, within_us, .. } => {
            up_to_us.unwrap_or(0).saturating_add(within_us.unwrap_or(0))
        }
        Vary::Number { .. } => 0,
    });
    let waits = waits.fold(0, u64::saturating_add).saturating_mul(100);
    let own = nominal.saturating_mul(10).saturating_add(3_600_000_000);
    own.saturating_add(waits).min(sim::DEFAULT_LIMIT_US)
}

fn failed(error: BoardError, console: &Console) -> Failure {
    match error {
        BoardError::World(error) => world::wrong(&error, console),
        error => Failure::Board(error.to_string()),
    }
}

/// Shown on a terminal only.
fn bar(runs: u64, console: &Console) -> ProgressBar {
    if !console.shows_progress() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(runs);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos} of {len} runs, {eta} left") {
        bar.set_style(style);
    }
    bar
}

#[cfg(test)]
mod tests {
    use super::shard;

    #[test]
    fn parts_are_numbered_from_one() {
        assert_eq!(shard("1/1"), Ok((0, 1)));
        assert_eq!(shard("3/8"), Ok((2, 8)));
        for wrong in ["", "3", "0/8", "9/8", "a/b", "1/0"] {
            assert!(shard(wrong).is_err(), "{wrong}");
        }
    }
}
