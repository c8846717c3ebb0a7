//! `pasapas trace`: a program on a board, effect by effect.
//!
//! In trace mode the board waits with its next effect until the host has taken the last event. A
//! host that does not take it halts the program: this makes steps and breakpoints without a byte of
//! the board's memory.

use std::io::BufRead;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use clap::Args;
use lang::back::Compiled;
use lang::called;
use lang::hir::Var;
use lang::image::crc_in;
use lang::wire::{self, Control, Exception, RunState};

use super::arcs;
use super::console::{Console, Options};
use super::others::Others;
use super::port::{Board, Port};
use super::script::{self, Script};
use crate::client::identity::Identity;
use crate::client::status::{holds, long};
use crate::client::trace::{LineOf, Tracer};
use crate::failure::Failure;
use crate::sim::trace::{Event, Status, What};

/// `pasapas trace`
#[derive(Debug, Args)]
pub struct Trace {
    /// The script that is on the board
    file: String,
    #[command(flatten)]
    port: Port,
    /// Halt behind each effect and ask what to do
    #[arg(long)]
    step: bool,
    /// Halt behind each effect of this line and ask what to do
    #[arg(long = "break", value_name = "LINE")]
    breakpoints: Vec<u32>,
}

/// Between two looks for an event, so that a pty or a TCP board is not asked all the time.
const LOOK: Duration = Duration::from_millis(1);
/// Without an event for so long the board's state is asked for.
const QUIET: Duration = Duration::from_millis(250);
/// Longest time from Start to the run's begin: the image check of 3 KB.
const START_PATIENCE: Duration = Duration::from_secs(2);

/// What one may say where the program is halted.
const HELP: &str = "Enter or s: to the next effect   c: go on   b LINE, d LINE: set, delete a \
    breakpoint\np [NAME[(INDEX)]]: show variables   set NAME[(INDEX)] [=] VALUE   q: end the run\n";

impl Trace {
    /// Starts the program and writes its trace, as `sim --trace -` does, to its end.
    ///
    /// # Errors
    /// The script is wrong, the board holds another program, does not start or does not answer; the
    /// run ends in a fault or is stopped.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let mut script = script::load(&self.file, options, console)?;
        let mut compiled = script::compile_for_device(&script, console)?;
        let mut board = self.port.connect(options, console)?;
        let mut identity = board.identity()?;
        identity.check().map_err(Failure::Board)?;
        if arcs::are_missing(&compiled, identity.features) {
            compiled = arcs::without(&mut script, &compiled, "this board", console)?;
        }
        let wanted = (compiled.image.len(), crc_in(&compiled.image));
        let held = |own: &Identity| (usize::from(own.program_bytes), own.program_crc);
        if held(&identity) != wanted {
            // What ran last may have begun another one: Start begins the selected one.
            if let Some(library) = board.library()?.filter(|library| library.selected != 0) {
                board.select(library.selected)?;
                identity = board.identity()?;
            }
        }
        if held(&identity) != wanted {
            return Err(Failure::Board(format!(
                "the board's program is not {file}: `pasapas upload {file}` brings it",
                file = self.file
            )));
        }
        let others = Others::find(&self.file, &script, options, console)?;
        let first = (others.name(), &script, &compiled);
        let beside = others.list.iter().map(|own| (own.name.as_str(), &own.script, &own.compiled));
        let mut session = Session {
            programs: std::iter::once(first).chain(beside).collect(),
            runs: Some(0),
            board: &mut board,
            console,
            steps: self.step,
            breakpoints: self.breakpoints.clone(),
            alone: false,
            said: listen(),
        };
        if session.steps && session.ask("the program is not started yet", None)? == Answer::Quit {
            return Ok(());
        }
        let before = session.board.late_events()?;
        let result = session.follow();
        // Nobody takes events any more: the program must not wait for that.
        let quiet = board.write(wire::TRACE_MODE, 0);
        let status = result?;
        quiet?;
        if let Some(late) = board.late_since(before)? {
            console.complain(&format!("{}: {late}", self.file));
        }
        // The trace has the fault's number alone.
        if status == Status::Fault
            && let state = board.status()?
            && let (Some(fault), Some(text)) = (state.fault, state.text)
        {
            let [cause, remedy] = state.advice.unwrap_or_default();
            console.complain(&format!(
                "{}: fault {fault}: {text}\n  {cause}\n  hint: {remedy}",
                self.file
            ));
        }
        if status == Status::Done { Ok(()) } else { Err(Failure::Run) }
    }
}

/// A run that is being looked at.
struct Session<'a> {
    /// The script and those that it runs: name, text, image.
    programs: Vec<(&'a str, &'a Script, &'a Compiled)>,
    /// Which of them runs; none that is known.
    runs: Option<usize>,
    board: &'a mut Board,
    console: &'a Console,
    steps: bool,
    breakpoints: Vec<u32>,
    /// Nobody answers any more: nothing halts it.
    alone: bool,
    /// What is typed, line by line.
    said: Receiver<String>,
}

/// Reads standard input in a thread of its own, as the board must hear of its host all the while.
fn listen() -> Receiver<String> {
    let (tell, said) = mpsc::channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            if tell.send(line).is_err() {
                return;
            }
        }
    });
    said
}

/// What to do with a halted program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Answer {
    GoOn,
    Quit,
}

impl<'a> Session<'a> {
    /// The lines of the program that runs, 0 where they are not known.
    fn lines(&self) -> LineOf<'a> {
        let compiled = self.program().map(|(_, _, compiled)| compiled);
        Box::new(move |pc: u16| {
            let mark = compiled.and_then(|compiled| compiled.sidecar.at(usize::from(pc)));
            mark.map_or(0, |mark| mark.line)
        })
    }

    fn program(&self) -> Option<(&'a str, &'a Script, &'a Compiled)> {
        self.programs.get(self.runs?).copied()
    }

    /// RUN has begun the program of this name: its lines are told if its script stands beside this one.
    fn turn(&mut self, tracer: &mut Tracer<'a>, name: &str) -> Result<(), Failure> {
        let identity = self.board.identity()?;
        let held = (usize::from(identity.program_bytes), identity.program_crc);
        let is_it = |(own, _, compiled): &(&str, &Script, &Compiled)| {
            called::same(own, name) && (compiled.image.len(), crc_in(&compiled.image)) == held
        };
        self.runs = self.programs.iter().position(is_it);
        if self.runs.is_none() {
            self.console.complain(&format!(
                "the board's program \"{name}\" is none of the scripts beside this one: its lines are \
                 told as 0"
            ));
        }
        tracer.turn(self.lines());
        Ok(())
    }

    /// From Start to the last event.
    fn follow(&mut self) -> Result<Status, Failure> {
        let Some((_, script, _)) = self.program() else { return Ok(Status::Done) };
        let mut tracer = Tracer::new(script.program.profile.clone(), self.lines());
        self.board.drop_print()?;
        tracer = tracer.queued(self.start()?);
        let mut heard = Instant::now();
        let mut over = false;
        loop {
            let Some(what) = tracer.poll(self.board)? else {
                if over {
                    return Err(Failure::Board(
                        "the run is over, and its end was not told: another host may have taken it"
                            .to_owned(),
                    ));
                }
                if heard.elapsed() > QUIET {
                    // The last event may have come since that look: it is asked for once more.
                    over = self.is_over()?;
                    heard = Instant::now();
                }
                self.board.link().pause(LOOK);
                continue;
            };
            let line = what.line();
            let text = self.text(line).to_owned();
            let end = match &what {
                What::End { status, .. } => Some(*status),
                What::Run { program, .. } => {
                    self.turn(&mut tracer, program)?;
                    None
                }
                _ => None,
            };
            self.console.json_line(&Event { what, us: None })?;
            if let Some(status) = end {
                return Ok(status);
            }
            // Breakpoints are lines of the script that was named.
            let wanted = self.steps || self.runs == Some(0) && self.breakpoints.contains(&line);
            if wanted && !self.alone {
                let mut place = format!("line {line} is done: {text}");
                if let Some(next) = self.next_line(line)? {
                    place += &format!("\nline {next} is next: {}", self.text(next));
                }
                if self.ask(&place, Some(&tracer))? == Answer::Quit {
                    self.board.control(Control::Stop)?;
                    self.alone = true;
                }
            }
            heard = Instant::now();
        }
    }

    /// Where the program waits with its next effect, if it comes to another line within [`QUIET`].
    fn next_line(&mut self, line: u32) -> Result<Option<u32>, Failure> {
        let line_of = self.lines();
        let begun = Instant::now();
        while begun.elapsed() < QUIET {
            let next = line_of(self.board.status()?.program_counter);
            if next != line && next != 0 {
                return Ok(Some(next));
            }
        }
        Ok(None)
    }

    /// The line as it is written.
    fn text(&self, line: u32) -> &str {
        self.program().map_or("", |(_, script, _)| script.source.line_text(line).trim())
    }

    /// Starts the program; tells whether the board queues its events.
    fn start(&mut self) -> Result<bool, Failure> {
        let (_, runs) = self.board.run_state()?;
        let halts = self.steps || !self.breakpoints.is_empty();
        let queued = self.board.begin_trace(halts)?;
        self.board.control(Control::Start)?;
        let begun = Instant::now();
        while self.board.run_state()?.1 == runs {
            if begun.elapsed() > START_PATIENCE {
                let status = self.board.status()?;
                let held = status.blocked_by.map(|input| format!(", {}", holds(input)));
                let fault = status.fault.map(|fault| format!(", {fault}; Start acknowledges it"));
                return Err(Failure::Board(format!(
                    "the program did not start; the board is {}{}{}",
                    status.state,
                    held.unwrap_or_default(),
                    fault.unwrap_or_default()
                )));
            }
        }
        Ok(queued)
    }

    /// Whether nothing runs; the last event comes before that shows.
    fn is_over(&mut self) -> Result<bool, Failure> {
        let (state, _) = self.board.run_state()?;
        Ok(matches!(state, Some(RunState::Empty | RunState::Ready | RunState::Fault)))
    }

    /// Does what is asked for until the program shall go on. Without anybody to ask it does.
    fn ask(&mut self, place: &str, tracer: Option<&Tracer<'_>>) -> Result<Answer, Failure> {
        self.console.complain(&format!("{place}\n(s, c, b, d, p, set, q; ? explains)"));
        loop {
            let said = match self.said.recv_timeout(QUIET) {
                Ok(said) => said,
                Err(RecvTimeoutError::Timeout) => {
                    // Trace mode ends 2 s after its reader.
                    if let Some(tracer) = tracer {
                        tracer.hold(self.board)?;
                    }
                    continue;
                }
                Err(RecvTimeoutError::Disconnected) => {
                    self.alone = true;
                    return Ok(Answer::GoOn);
                }
            };
            // `set row=2` is `set row 2`.
            let said = said.replacen('=', " ", 1);
            let words: Vec<&str> = said.split_whitespace().collect();
            let answer = match words[..] {
                [] | ["s"] => {
                    self.steps = true;
                    return Ok(Answer::GoOn);
                }
                ["c"] => {
                    self.steps = false;
                    return Ok(Answer::GoOn);
                }
                ["q"] => return Ok(Answer::Quit),
                ["b", line] => self.mark(line, true),
                ["d", line] => self.mark(line, false),
                ["p"] => self.show_all()?,
                ["p", name] => self.show(name)?,
                ["set", name, value] => self.set(name, value)?,
                _ => HELP.to_owned(),
            };
            self.console.complain(answer.trim_end());
        }
    }

    fn mark(&mut self, line: &str, on: bool) -> String {
        let Ok(line) = line.parse::<u32>() else {
            return format!("`{line}` is no line's number");
        };
        self.breakpoints.retain(|own| *own != line);
        if on {
            self.breakpoints.push(line);
            self.breakpoints.sort_unstable();
        }
        let lines: Vec<String> = self.breakpoints.iter().map(u32::to_string).collect();
        format!("halts behind the effects of lines: {}", lines.join(", "))
    }

    fn show_all(&mut self) -> Result<String, Failure> {
        let mut text = String::new();
        let Some((_, script, compiled)) = self.program() else { return Ok(String::new()) };
        for place in &compiled.vars {
            let var = script.program.var(place.var);
            for index in 0..place.len {
                text += &self.value(var, place.cell, index)?;
            }
        }
        Ok(if text.is_empty() { "the program has no variables".to_owned() } else { text })
    }

    /// One line: the variable's name and value.
    fn value(&mut self, var: &Var, cell: u32, index: u32) -> Result<String, Failure> {
        let words = self.board.holding(register(cell + index), 2)?;
        let &[low, high] = &words[..] else { return Ok(String::new()) };
        let name = if var.array { format!("{}({index})", var.name) } else { var.name.clone() };
        Ok(format!("{name} = {}{}\n", long(low, high), var.kind.unit().suffix()))
    }

    /// Variable and cell of a name as the user wrote it, `name` or `name(index)`.
    fn find(&self, written: &str) -> Result<(&Var, u32, u32), String> {
        let (name, index) = match written.trim_end_matches(')').split_once('(') {
            None => (written, 0),
            Some((name, index)) => match index.parse() {
                Ok(index) => (name, index),
                Err(_) => return Err(format!("`{index}` is no index")),
            },
        };
        let Some((_, script, compiled)) = self.program() else {
            return Err("the script of the program that runs is not known".to_owned());
        };
        let program = &script.program;
        let found = compiled
            .vars
            .iter()
            .map(|place| (program.var(place.var), place))
            .find(|(var, _)| var.name.eq_ignore_ascii_case(name));
        let Some((var, place)) = found else {
            return Err(format!("the program has no variable `{name}` on the board; p shows all"));
        };
        if index >= place.len {
            return Err(format!("{} goes from 0 to {}", var.name, place.len - 1));
        }
        Ok((var, place.cell, index))
    }

    fn show(&mut self, name: &str) -> Result<String, Failure> {
        match self.find(name) {
            Ok((var, cell, index)) => {
                let var = var.clone();
                self.value(&var, cell, index)
            }
            Err(text) => Ok(text),
        }
    }

    fn set(&mut self, name: &str, value: &str) -> Result<String, Failure> {
        let (cell, index) = match self.find(name) {
            Ok((_, cell, index)) => (cell, index),
            Err(text) => return Ok(text),
        };
        let Ok(value) = value.parse::<i32>() else {
            return Ok(format!("`{value}` is no whole number of 32 bits"));
        };
        let (low, high) = (value as u16, (value >> 16) as u16);
        match self.board.write_all(register(cell + index), &[low, high]) {
            Err(error) if error.is_exception(Exception::IllegalValue) => {
                Ok(format!("{value} is outside of MIN and MAX of `{name}`"))
            }
            written => {
                written?;
                self.show(name)
            }
        }
    }
}

/// The first of a cell's two registers.
fn register(cell: u32) -> u16 {
    wire::CELLS.saturating_add(u16::try_from(2 * cell).unwrap_or(u16::MAX))
}
