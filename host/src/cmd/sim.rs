//! `pasapas sim`: runs a script on a simulated machine.

use std::cell::RefCell;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::rc::Rc;

use ::cell::vary::Deviation;
use clap::{Args, ValueEnum};
use lang::fault::{Fault, LATE_LINE};
use lang::profile::Profile;

use super::console::{Console, Options};
use super::others::Others;
use super::part::Choice;
use super::script::{self, Script};
use super::{board_run, cell, summary, world};
use crate::failure::Failure;
use crate::input::{self, code};
use crate::interrupt;
use crate::output::{self, OutputFile};
use crate::plot::{Form, Plot};
use crate::render::Note;
use crate::scene::replay::replay;
use crate::scene::{Report, Scene};
use crate::sim::trace::{Event, PerAxis, Status, What, write_line};
use crate::sim::world::World;
use crate::sim::{self, DEFAULT_LIMIT_US, Outcome, SimError};

/// `pasapas sim`
#[derive(Debug, Args)]
pub struct Sim {
    /// A script, or a program of another system that `import` reads
    file: String,
    /// Who runs it
    #[arg(long, value_enum, default_value_t = Engine::Rhai)]
    engine: Engine,
    /// Scenario: switches, sensors and people around the machine
    #[arg(long, value_name = "W.rhai")]
    world: Option<String>,
    /// Write one JSON line for each effect; `-` is standard output
    #[arg(long, value_name = "T")]
    trace: Option<String>,
    /// Draw the path, inputs and outputs
    #[arg(long, value_name = "P.svg|P.html", value_parser = plot_file)]
    plot: Option<String>,
    #[command(flatten)]
    cell: cell::CellChoice,
    #[command(flatten)]
    cell_output: cell::CellOutput,
    /// Run with this deviation, as `prove` prints it: "stuck tray.11 813ms"; several times for several
    #[arg(long, value_name = "DEVIATION", value_parser = Deviation::parse)]
    deviate: Vec<Deviation>,
    /// Play this trace of a board into the cell instead of running the script
    #[arg(long, value_name = "T", conflicts_with_all = ["engine", "world", "trace", "plot", "vcd", "limit"])]
    replay: Option<String>,
    #[command(flatten)]
    part: Choice,
    /// Write every edge at the board's pins as a Value Change Dump (engine board)
    #[arg(long, value_name = "P.vcd")]
    vcd: Option<String>,
    /// End after this simulated time: 90s, 500ms, 10min, 24h
    #[arg(long, value_name = "TIME", value_parser = time)]
    limit: Option<u64>,
}

/// Engines of `--engine`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Engine {
    /// Translated to Rhai: fast
    Rhai,
    /// The device's own VM on this computer
    Vm,
    /// The real firmware image in the emulator, cycle by cycle
    Board,
    /// The firmware's machine on a simulated MSP430F5529: what `board` does, without an emulator
    #[value(hide = true)]
    Machine,
}

impl Engine {
    const fn name(self) -> &'static str {
        match self {
            Engine::Rhai => "rhai",
            Engine::Vm => "vm",
            Engine::Board => "board",
            Engine::Machine => "machine",
        }
    }
}

fn plot_file(name: &str) -> Result<String, String> {
    match Form::of(name) {
        Some(_) => Ok(name.to_owned()),
        None => Err("a plot's name ends in .svg or .html".to_owned()),
    }
}

/// A time in us; a plain number is seconds.
pub(super) fn time(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match &text[digits.len()..] {
        "us" => 1.0,
        "ms" => 1e3,
        "s" | "" => 1e6,
        "min" => 6e7,
        "h" => 3.6e9,
        _ => return Err("a time is a number with ms, s, min or h".to_owned()),
    };
    let value: f64 = digits.parse().map_err(|_| format!("`{digits}` is no number"))?;
    let us = value * unit;
    if us.is_finite() && (1.0..1e15).contains(&us) {
        Ok(us as u64)
    } else {
        Err("a limit lies between 1us and 30 years".to_owned())
    }
}

impl Sim {
    /// Runs the script and writes what was asked for.
    ///
    /// # Errors
    /// The script or the world is wrong, the run ends in a fault, is stopped, or an expectation
    /// does not hold.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        if self.vcd.is_some() && !matches!(self.engine, Engine::Board | Engine::Machine) {
            return Err(Failure::Usage(
                "--vcd needs --engine board: only that has pins".to_owned(),
            ));
        }
        let mut script = script::load(&self.file, options, console)?;
        let outputs = [
            ("--trace", self.trace.as_ref()),
            ("--plot", self.plot.as_ref()),
            ("--vcd", self.vcd.as_ref()),
            ("--cell-log", self.cell_output.cell_log.as_ref().filter(|name| *name != "-")),
            ("--report", self.cell_output.report.as_ref()),
        ];
        script.keep_inputs(&self.file, options, self.world.as_deref(), &outputs)?;
        let others = Others::find(&self.file, &script, options, console)?;
        let beside: Vec<_> = others.list.iter().map(|other| Some(Path::new(&other.file))).collect();
        output::keep_inputs(&outputs, &beside)?;
        let scene = self.cell.find(&self.file, &script, console)?;
        output::keep_inputs(&outputs, &[scene.as_ref().map(|scene| Path::new(&scene.file))])?;
        if scene.is_none() {
            self.without_cell()?;
        }
        if let Some(scene) = &scene {
            scene
                .strikes(&script.program.profile, &self.deviate)
                .map_err(|text| Failure::Usage(format!("--deviate: {text}")))?;
        }
        let scene = scene.map(|scene| scene.deviating(self.deviate.clone()));
        if let (Some(trace), Some(scene)) = (&self.replay, &scene) {
            return self.play(trace, scene, &script.program.profile, console);
        }
        let world = world::load(self.world.as_deref(), World::unattended(), console)?;
        let world = world.with_scene(scene);
        interrupt::watch();
        let prints = !console.json() && self.trace.as_deref() != Some("-");
        let listener = Listener::open(self.trace.as_deref(), prints.then_some(*console))?;
        let listener = Rc::new(RefCell::new(listener));
        let sink = Rc::clone(&listener);
        let sink = Box::new(move |event: &Event| sink.borrow_mut().hear(event));
        let mut outcome = self.simulate(&mut script, &others, &world, console, sink)?;
        listener.borrow_mut().finish()?;
        self.plot(&script, &outcome, console)?;
        // Of another system's program the user sees its own lines, not those of the script.
        if outcome.program == 0 {
            outcome.summary.line = script.line_of_file(outcome.summary.line);
            outcome.end.line = script.line_of_file(outcome.end.line);
        }
        let notes = outcome.unattended.notes(&script.program, |line| script.line_of_file(line));
        let to_stderr = self.trace.as_deref() == Some("-");
        let whose = (self.engine.name(), &self.part.or_default().part);
        summary::write(&self.file, whose, &script.program, &outcome, &notes, to_stderr, console)?;
        if let Some(report) = &outcome.cell {
            self.cell_output.write(&self.file, report, to_stderr, console)?;
        }
        let rests = listener.borrow().rests;
        let file = others.file(outcome.program).unwrap_or(&self.file);
        verdict(file, &outcome, &script.program.profile, &rests, console)
    }

    /// Options that ask for something that only a cell gives.
    fn without_cell(&self) -> Result<(), Failure> {
        let asked = [
            ("--cell-log", self.cell_output.cell_log.is_some()),
            ("--report", self.cell_output.report.is_some()),
            ("--deviate", !self.deviate.is_empty()),
            ("--replay", self.replay.is_some()),
        ];
        match asked.iter().find(|(_, given)| *given) {
            Some((option, _)) => Err(Failure::Usage(format!(
                "{option} needs a cell: write NAME.cell.toml beside the script, or give --cell FILE"
            ))),
            None => Ok(()),
        }
    }

    /// Plays a trace into the cell.
    fn play(
        &self,
        trace: &str,
        scene: &Scene,
        profile: &Profile,
        console: &Console,
    ) -> Result<(), Failure> {
        let text = input::read_text(trace).map_err(|note| console.refuse(&note))?;
        let events = crate::sim::trace::read(text.as_bytes()).map_err(|error| {
            console.refuse(&Note::error(trace, code::ENGINE, error.to_string()))
        })?;
        let played = replay(scene, profile, &events);
        for remark in &played.remarks {
            console.complain(remark);
        }
        for difference in &played.differences {
            console.complain(&format!("board and cell disagree: {difference}"));
        }
        self.cell_output.write(&self.file, &played.report, false, console)?;
        if played.report.holds() && played.differences.is_empty() {
            Ok(())
        } else {
            Err(Failure::Run)
        }
    }

    fn simulate(
        &self,
        script: &mut Script,
        others: &Others,
        world: &World,
        console: &Console,
        sink: sim::Sink,
    ) -> Result<Outcome, Failure> {
        let mut options = sim::Options {
            limit_us: self.limit.unwrap_or(DEFAULT_LIMIT_US),
            record: self.plot.is_some(),
            interrupted: interrupt::asked,
            ..sim::Options::default()
        };
        let part = Choice { part: Some(self.part.or_default()) };
        let engine = match self.engine {
            // The model of the small chip has no pins for a cell to hang on.
            Engine::Rhai | Engine::Vm
                if world.scene().is_some() && !self.part.or_default().part.look_ahead =>
            {
                let text = "without an emulator a cell stands around the f5529: `--engine board` has other parts";
                return Err(Failure::Usage(text.to_owned()));
            }
            Engine::Rhai => sim::Engine::Rhai,
            Engine::Vm => sim::Engine::Vm,
            Engine::Board | Engine::Machine => {
                let vcd = self.vcd.as_deref();
                let scene = (world, vcd, self.engine == Engine::Machine);
                return board_run::run(script, others, part, scene, &options, sink, console);
            }
        };
        options.part = part.to_simulate(script, console)?;
        let chain = others.chain(script);
        sim::run_chain(&chain, engine, world, &options, sink).map_err(|error| match error {
            SimError::World(error) => world::wrong(&error, console),
            SimError::Engine(text) => console.refuse(&Note::error(&self.file, code::ENGINE, text)),
        })
    }

    fn plot(&self, script: &Script, outcome: &Outcome, console: &Console) -> Result<(), Failure> {
        let Some(path) = &self.plot else { return Ok(()) };
        let Some(form) = Form::of(path) else { return Ok(()) };
        let title = std::path::Path::new(&self.file).file_name();
        let title = title.map_or_else(|| self.file.clone(), |name| name.display().to_string());
        let plot =
            Plot { title: &title, source: script.source.text(), program: &script.program, outcome };
        output::write(path, plot.render(form))?;
        if outcome.record.truncated {
            let last = outcome.record.path.last().map_or(0, |piece| piece.end_us);
            console.complain(&format!(
                "{path}: the picture ends after {}: of a longer run no more is kept; the summary is of all of it",
                crate::plot::time(last)
            ));
        }
        Ok(())
    }
}

/// Exit code 3 for everything but a run that was done and met its expectations.
fn verdict(
    file: &str,
    outcome: &Outcome,
    profile: &Profile,
    rests: &PerAxis,
    console: &Console,
) -> Result<(), Failure> {
    let end = &outcome.end;
    let line = end.line;
    match (end.status, end.fault) {
        (Status::Done, _) => {}
        (Status::Stopped, _) => console.complain(&format!("{file}:{line}:1: stopped here")),
        (Status::Fault, None) => console.complain(&format!("{file}:{line}:1: fault")),
        (Status::Fault, Some(fault)) => {
            let own = [fault.text(), fault.cause(), fault.remedy()];
            let [text, cause, remedy] = if outcome.late_line { LATE_LINE } else { own };
            console.complain(&format!("{file}:{line}:1: fault {fault}: {text}"));
            console.complain(&format!("  {cause}"));
            if matches!(fault, Fault::SoftLimit | Fault::LimitSwitch) {
                console.complain(&format!("  machine positions: {}", places(profile, rests)));
            }
            console.complain(&format!("  hint: {remedy}"));
        }
    }
    for failure in &outcome.failures {
        console.complain(&format!("expectation failed: {failure}"));
    }
    let as_expected = outcome.cell.as_ref().is_none_or(Report::holds);
    // A cell may expect another end than `done`: it judges the end itself then.
    let ended = outcome.cell.as_ref().is_some_and(Report::judges_end) || end.status == Status::Done;
    let good = ended && as_expected && outcome.failures.is_empty();
    if good { Ok(()) } else { Err(Failure::Run) }
}

/// Where each axis rests in the travel of its machine.
fn places(profile: &Profile, rests: &PerAxis) -> String {
    let axes = profile.axes().filter_map(|(axis, own)| {
        let um = i64::from(rests.get(axis)?) * i64::from(own.scale.um) / i64::from(own.scale.steps);
        let [at, least, most] =
            [um, own.min_um.into(), own.max_um.into()].map(|um: i64| um as f64 / 1000.0);
        Some(format!("{} {at:.3} mm (travel {least:.3} to {most:.3})", axis.letter()))
    });
    axes.collect::<Vec<_>>().join(", ")
}

/// Where the trace goes.
enum TraceTo {
    StandardOutput(BufWriter<io::Stdout>),
    File(OutputFile),
}

/// Hears the trace: writes it where `--trace` says and shows what PRINT prints.
struct Listener {
    name: String,
    to: Option<TraceTo>,
    prints: Option<Console>,
    failed: Option<Failure>,
    /// Where the axes rest at the end, steps.
    rests: PerAxis,
}

impl Listener {
    fn open(name: Option<&str>, prints: Option<Console>) -> Result<Listener, Failure> {
        let to = match name {
            None => None,
            Some("-") => Some(TraceTo::StandardOutput(BufWriter::new(io::stdout()))),
            Some(path) => {
                let file = OutputFile::create(path.as_ref());
                Some(TraceTo::File(file.map_err(|error| Failure::writing(path, &error))?))
            }
        };
        let name = name.unwrap_or_default().to_owned();
        Ok(Listener { name, to, prints, failed: None, rests: PerAxis::default() })
    }

    fn hear(&mut self, event: &Event) {
        if let Err(failure) = self.try_hear(event) {
            self.failed.get_or_insert(failure);
            // A run that nobody hears goes on for hours of simulated time.
            interrupt::ask();
        }
    }

    fn try_hear(&mut self, event: &Event) -> Result<(), Failure> {
        if let What::End { pos, .. } = &event.what {
            self.rests = *pos;
        }
        if let (Some(console), What::Print { text, .. }) = (&self.prints, &event.what) {
            console.result(&format!("{text}\n"))?;
        }
        let written = match &mut self.to {
            None => Ok(()),
            Some(TraceTo::StandardOutput(to)) => write_line(to, event),
            Some(TraceTo::File(to)) => write_line(to, event),
        };
        written.map_err(|error| Failure::writing(&self.name, &error))
    }

    fn finish(&mut self) -> Result<(), Failure> {
        if let Some(failure) = self.failed.take() {
            return Err(failure);
        }
        let finished = match self.to.take() {
            None => Ok(()),
            Some(TraceTo::StandardOutput(mut to)) => to.flush(),
            Some(TraceTo::File(to)) => to.finish(),
        };
        finished.map_err(|error| Failure::writing(&self.name, &error))
    }
}

#[cfg(test)]
mod tests {
    use super::time;

    #[test]
    fn times_have_units_and_bounds() {
        assert_eq!(time("90s"), Ok(90_000_000));
        assert_eq!(time("1.5"), Ok(1_500_000));
        assert_eq!(time("24h"), Ok(86_400_000_000));
        assert_eq!(time("250ms"), Ok(250_000));
        for wrong in ["", "s", "5 m", "-1s", "1e99h", "0s", "NaNs"] {
            assert!(time(wrong).is_err(), "{wrong}");
        }
    }
}
