//! `pasapas test`: runs scripts with the cell, world and trace of the same name.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use lang::fault::LATE_LINE;
use serde::Serialize;

use super::console::{Console, Options};
use super::others::Others;
use super::part::Choice;
use super::{board_run, cell, script, world};
use crate::failure::Failure;
use crate::input::{self, code};
use crate::interrupt;
use crate::output;
use crate::render::Note;
use crate::scene::{Report, junit};
use crate::sim::trace::{Event, Status, to_text};
use crate::sim::world::World;
use crate::sim::{self, Outcome};

/// `pasapas test`
#[derive(Debug, Args)]
pub struct Test {
    /// Scripts, or folders whose scripts have a cell, a world or a trace beside them; without it this folder
    #[arg(value_name = "FILE")]
    files: Vec<String>,
    /// Who runs them
    #[arg(long, value_enum, default_value_t = Engine::Vm)]
    engine: Engine,
    /// Stop each run after so much simulated time, e.g. 500ms, 10min, 2h; without it after 24h
    #[arg(long, value_name = "TIME", value_parser = super::sim::time)]
    limit: Option<u64>,
    /// Write the results: JSON lines, or JUnit XML for continuous integration
    #[arg(long, value_name = "R.json|R.xml", value_parser = cell::report_file)]
    report: Option<String>,
}

/// Engines of `--engine`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Engine {
    /// Translated to Rhai
    Rhai,
    /// The device's own VM on this computer
    Vm,
    /// The real firmware image in the emulator, cycle by cycle
    Board,
}

/// What stands beside a script.
fn beside(script: &Path) -> [Option<String>; 3] {
    ["cell.toml", "rhai", "trace"].map(|ending| {
        let path = script.with_extension(ending);
        path.is_file().then(|| path.display().to_string())
    })
}

/// What each run of a script has around it. A trace was made in a world: where one stands beside the script, script, world
/// and trace are a run, and the cell is another one. Without a trace the world acts in the cell.
fn runs(script: &Path) -> Vec<[Option<String>; 3]> {
    match beside(script) {
        [Some(cell), world, Some(trace)] if world.is_some() => {
            vec![[None, world, Some(trace)], [Some(cell), None, None]]
        }
        all => vec![all],
    }
}

fn junit_run((file, own): &(String, Tested)) -> junit::Run<'_> {
    junit::Run { file, report: &own.report, differences: &own.differences }
}

/// A script's test.
struct Tested {
    report: Report,
    /// Differences of the trace and of the world's expectations, and a fault, as lines.
    differences: Vec<String>,
}

#[derive(Serialize)]
struct Line<'a> {
    test: &'a str,
    ok: bool,
    us: u64,
    expectations: usize,
    differences: Vec<String>,
}

impl Test {
    /// Tests every script, also after one that fails.
    ///
    /// # Errors
    /// A script or what stands beside it is wrong, or one fails.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let files = self.scripts(console)?;
        interrupt::watch();
        let mut results: Vec<(String, Tested)> = Vec::new();
        let mut wrong = false;
        for file in &files {
            if interrupt::asked() {
                break;
            }
            for beside in runs(Path::new(file)) {
                match self.test(file, beside, options, console) {
                    Ok(tested) => {
                        tell(file, &tested, console)?;
                        results.push((file.clone(), tested));
                    }
                    Err(Failure::Input) => wrong = true,
                    Err(failure) => return Err(failure),
                }
            }
        }
        let failed = results.iter().filter(|(_, own)| !own.holds()).count();
        if let Some(path) = &self.report {
            let text = if path.ends_with(".xml") {
                junit::write(&results.iter().map(junit_run).collect::<Vec<_>>())
            } else {
                results.iter().map(|(file, own)| own.json(file)).collect()
            };
            output::write(path, text)?;
        }
        if !console.json() {
            let all = results.len();
            console.result(&format!("{} of {all} runs are right\n", all - failed))?;
        }
        match (wrong, failed) {
            (true, _) => Err(Failure::Input),
            (false, 0) if interrupt::asked() => Err(Failure::Run),
            (false, 0) => Ok(()),
            (false, _) => Err(Failure::Run),
        }
    }

    /// The scripts that are asked for, in order.
    fn scripts(&self, console: &Console) -> Result<Vec<String>, Failure> {
        let here = vec![".".to_owned()];
        let named = if self.files.is_empty() { &here } else { &self.files };
        let mut scripts = Vec::new();
        for name in named {
            let path = Path::new(name);
            if !path.is_dir() {
                scripts.push(name.clone());
                continue;
            }
            let unreadable = |error: std::io::Error| {
                let text = format!("the folder cannot be read: {error}");
                console.refuse(&Note::error(name, code::UNREADABLE, text))
            };
            let entries = path.read_dir().map_err(unreadable)?;
            let mut own: Vec<PathBuf> =
                entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
            own.retain(|path| {
                path.extension().is_some_and(|extension| extension == "bas")
                    && beside(path).iter().any(Option::is_some)
            });
            own.sort();
            scripts.extend(own.into_iter().map(|path| path.display().to_string()));
        }
        if scripts.is_empty() {
            let text = "there is no script with a cell, a world or a trace beside it".to_owned();
            let hint = "name a script, or write NAME.cell.toml, NAME.rhai or NAME.trace beside it";
            return Err(console.refuse(&Note::error(&named[0], code::ENGINE, text).hint(hint)));
        }
        Ok(scripts)
    }

    fn test(
        &self,
        file: &str,
        [cell, own_world, trace]: [Option<String>; 3],
        options: &Options,
        console: &Console,
    ) -> Result<Tested, Failure> {
        let mut script = script::load(file, options, console)?;
        let others = Others::find(file, &script, options, console)?;
        let choice = cell::CellChoice { no_cell: cell.is_none(), cell };
        let scene = choice.find(file, &script, console)?;
        let world = world::load(own_world.as_deref(), World::unattended(), console)?;
        let world = world.with_scene(scene);
        let events = std::rc::Rc::new(std::cell::RefCell::new(Vec::new()));
        let sink = events.clone();
        let sink = Box::new(move |event: &Event| sink.borrow_mut().push(event.clone()));
        let run = sim::Options {
            interrupted: interrupt::asked,
            times: false,
            limit_us: self.limit.unwrap_or(sim::DEFAULT_LIMIT_US),
            ..sim::Options::default()
        };
        let part = Choice { part: Some(crate::board::DEFAULT) };
        let outcome = match self.engine {
            Engine::Rhai | Engine::Vm => {
                let engine =
                    if self.engine == Engine::Vm { sim::Engine::Vm } else { sim::Engine::Rhai };
                sim::run_chain(&others.chain(&script), engine, &world, &run, sink).map_err(
                    |error| match error {
                        sim::SimError::World(error) => world::wrong(&error, console),
                        sim::SimError::Engine(text) => {
                            console.refuse(&Note::error(file, code::ENGINE, text))
                        }
                    },
                )?
            }
            Engine::Board => {
                let around = (&world, None, false);
                board_run::run(&mut script, &others, part, around, &run, sink, console)?
            }
        };
        let mut differences = ends(&outcome, |line| script.line_of_file(line));
        if let Some(trace) = trace {
            let wanted = input::read_text(&trace).map_err(|note| console.refuse(&note))?;
            differences.extend(difference(&trace, &wanted, &to_text(&events.take())));
        }
        let us = outcome.summary.us;
        let report = outcome.cell.unwrap_or_else(|| Report::without_cell(us));
        Ok(Tested { report, differences })
    }
}

/// What of a run's end is no success, and expectations of a world that do not hold.
fn ends(outcome: &Outcome, line_of: impl Fn(u32) -> u32) -> Vec<String> {
    let mut list = Vec::new();
    let judged = outcome.cell.as_ref().is_some_and(Report::judges_end);
    let line = line_of(outcome.end.line);
    match (outcome.end.status, outcome.end.fault) {
        _ if judged => {}
        (Status::Done, _) => {}
        (Status::Stopped, _) => list.push(format!("stopped in line {line}")),
        (Status::Fault, None) => list.push(format!("fault in line {line}")),
        (Status::Fault, Some(fault)) => {
            let text = if outcome.late_line { LATE_LINE[0] } else { fault.text() };
            list.push(format!("fault {fault} in line {line}: {text}"));
        }
    }
    list.extend(outcome.failures.iter().cloned());
    list
}

/// The first line in which two traces differ.
fn difference(file: &str, wanted: &str, was: &str) -> Option<String> {
    let (mut a, mut b) = (wanted.lines(), was.lines());
    for number in 1.. {
        match (a.next(), b.next()) {
            (None, None) => return None,
            (wanted, was) if wanted == was => {}
            (wanted, was) => {
                let [wanted, was] = [wanted, was].map(|line| line.unwrap_or("the end"));
                return Some(format!("{file}:{number}: wanted {wanted}, was {was}"));
            }
        }
    }
    None
}

impl Tested {
    fn holds(&self) -> bool {
        self.differences.is_empty() && self.report.holds()
    }

    /// What differs, a line each.
    fn all(&self) -> Vec<String> {
        let rows = self.report.rows.iter().filter(|row| !row.holds);
        let rows = rows.map(|row| format!("{}: wanted {}, was {}", row.name, row.wanted, row.was));
        let rows = rows.chain(self.report.stories.iter().cloned());
        rows.chain(self.differences.iter().cloned()).collect()
    }

    fn json(&self, file: &str) -> String {
        let line = Line {
            test: file,
            ok: self.holds(),
            us: self.report.end.us,
            expectations: self.report.rows.len(),
            differences: self.all(),
        };
        serde_json::to_string(&line).unwrap_or_default() + "\n"
    }
}

/// A line for the script, its differences below.
fn tell(file: &str, tested: &Tested, console: &Console) -> Result<(), Failure> {
    if console.json() {
        return console.result(&tested.json(file));
    }
    let word = if tested.holds() { "right" } else { "WRONG" };
    let seconds = tested.report.end.us as f64 / 1e6;
    let mut text = format!("{word} {file} after {seconds:.2} s");
    match tested.report.rows.len() {
        0 => {}
        1 => text += ", 1 expectation",
        n => text += &format!(", {n} expectations"),
    }
    text.push('\n');
    for difference in tested.all() {
        text += &format!("  {difference}\n");
    }
    console.result(&text)
}

#[cfg(test)]
mod tests {
    use super::difference;

    #[test]
    fn the_first_difference_is_told() {
        assert_eq!(difference("a.trace", "a\nb\n", "a\nb\n"), None);
        let told = difference("a.trace", "a\nb\n", "a\nc\n").unwrap();
        assert_eq!(told, "a.trace:2: wanted b, was c");
        assert_eq!(
            difference("a.trace", "a\n", "a\nb\n").unwrap(),
            "a.trace:2: wanted the end, was b"
        );
    }
}
