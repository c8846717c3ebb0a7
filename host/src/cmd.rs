//! The command line: what is common to all commands; each command has a file of its own.
//!
//! Names, exit codes and formats are a contract with other tools (see [`Failure`]).

mod arcs;
mod axes;
mod bench;
mod board;
mod board_run;
mod build;
mod cell;
mod check;
mod control;
mod dap;
mod disasm;
mod flash;
mod fleet;
mod fmt;
#[cfg(feature = "gateway")]
mod gateway;
#[cfg(not(feature = "gateway"))]
#[path = "cmd/no_gateway.rs"]
mod gateway;
mod grbl;
mod import;
mod library;
mod lsp;
mod manual;
mod others;
mod part;
mod place;
mod port;
mod profile;
mod prove;
mod script;
mod selftest;
mod sim;
mod size;
mod status;
mod stream;
mod summary;
mod test;
mod torture;
mod trace;
mod upload;
mod version;
mod workbench;
mod world;

use std::io::{IsTerminal, Write};
use std::process::ExitCode;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};
use lang::front::diag::Diag;
use lang::front::source::Source;
use lang::profile::Profile;

use crate::failure::Failure;
use crate::input;
use crate::render::{self, Note};

/// A small BASIC for machines that step: check, simulate, upload and watch its scripts.
#[derive(Debug, Parser)]
#[command(name = "pasapas", version, long_version = version::LONG, infer_subcommands = false)]
struct Cli {
    #[command(flatten)]
    options: Options,
    #[command(subcommand)]
    command: Command,
}

/// Options that every command takes.
#[derive(Debug, Args)]
pub struct Options {
    /// How to write diagnostics, status and summaries
    #[arg(long, global = true, value_enum, default_value_t = Format::Text)]
    pub format: Format,
    /// The machine: a file, or one of the built-in mill, charly, thesis, laser. Without it the
    /// script's PROFILE line decides, else mill
    #[arg(long, global = true, value_name = "P.toml|NAME")]
    pub profile: Option<String>,
}

/// Form of what is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For people
    Text,
    /// One JSON object a line
    Json,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Show what is wrong with scripts
    Check(check::Check),
    /// Compile scripts and show what they use of the device
    Build(build::Build),
    /// Run a script on a simulated machine
    Sim(sim::Sim),
    /// Run scripts with what stands beside them, and say which are right
    Test(test::Test),
    /// Run a script in its cell again and again, each time with other deviations
    Prove(prove::Prove),
    /// Show the instructions of a script or of an image
    Disasm(disasm::Disasm),
    /// Make a script of a program of another system
    Import(import::Import),
    /// Make a job that picks and places parts of a circuit board's placement file
    Place(place::Place),
    /// Put scripts into one style
    Fmt(fmt::Fmt),
    /// Keep a virtual board up: the real firmware behind a serial device or a TCP port
    Board(board::Board),
    /// Bring a program to a board
    Upload(upload::Upload),
    /// Show the programs that a board holds
    List(library::List),
    /// Erase a program of a board
    Erase(library::Erase),
    /// Run a job larger than the board's memory, piece by piece
    Stream(stream::Stream),
    /// Run a board's stored program, release its WaitStart, or acknowledge its fault
    Start(control::Start),
    /// End a board's run on a ramp
    Stop(control::Control),
    /// Pause a board's run on a ramp
    Pause(control::Control),
    /// Go on with a board's paused run
    Resume(control::Control),
    /// Show what a board does
    Status(status::Status),
    /// Show what a board prints and does, as it changes
    Watch(status::Watch),
    /// Run a board's program effect by effect, with its trace, steps, breakpoints and variables
    Trace(trace::Trace),
    /// Reference a board's axes
    Home(axes::Home),
    /// Move one axis of a board by a bounded distance
    Jog(axes::Jog),
    /// Show a board's inputs and outputs, set outputs
    Io(axes::Io),
    /// Script, simulation and board on one page of the browser
    Workbench(workbench::Workbench),
    /// Boards on several lines for programs on several protocols: Modbus TCP
    Gateway(gateway::Gateway),
    /// A Grbl controller for the programs that drive one: a board, or a virtual one, at a TCP port or a
    /// pseudo-terminal
    Grbl(grbl::Grbl),
    /// All boards behind gateways, by tags: what differs, a program for each, start, stop
    Fleet(fleet::Fleet),
    /// Serve an editor: the language server on standard input and output
    Lsp(lsp::Lsp),
    /// Serve an editor's debugger: the debug adapter on standard input and output
    Dap(dap::Dap),
    /// Show what the firmware uses of flash and RAM, by module
    Size(size::Size),
    /// Measure step rates, cycles, bytes and times, one line each
    Bench(bench::Bench),
    /// Inject faults of every kind and count what survives
    Torture(torture::Torture),
    /// Write the firmware to a LaunchPad
    Flash(flash::Flash),
    /// Measure on a board what the emulator promises: clock, link, flash, inputs, outputs, motion
    Selftest(selftest::Selftest),
    /// Show the machine descriptions that the tool knows, or those of a board
    Profile(profile::Profile),
}

impl Command {
    fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        use control::Action;
        match self {
            Command::Check(command) => command.run(options, console),
            Command::Build(command) => command.run(options, console),
            Command::Disasm(command) => command.run(options, console),
            Command::Sim(command) => command.run(options, console),
            Command::Test(command) => command.run(options, console),
            Command::Prove(command) => command.run(options, console),
            Command::Import(command) => command.run(options, console),
            Command::Place(command) => command.run(options, console),
            Command::Fmt(command) => command.run(options, console),
            Command::Workbench(command) => command.run(options, console),
            Command::Gateway(command) => command.run(options, console),
            Command::Grbl(command) => command.run(options, console),
            Command::Fleet(command) => command.run(options, console),
            Command::Lsp(command) => command.run(options, console),
            Command::Dap(command) => command.run(options, console),
            Command::Board(command) => command.run(options, console),
            Command::Upload(command) => command.run(options, console),
            Command::Stream(command) => command.run(options, console),
            Command::Home(command) => command.run(options, console),
            Command::Jog(command) => command.run(options, console),
            Command::Io(command) => command.run(options, console),
            Command::List(command) => command.run(options, console),
            Command::Erase(command) => command.run(options, console),
            Command::Start(command) => command.run(options, console),
            Command::Stop(command) => command.run(Action::Stop, options, console),
            Command::Pause(command) => command.run(Action::Pause, options, console),
            Command::Resume(command) => command.run(Action::Resume, options, console),
            Command::Status(command) => command.run(options, console),
            Command::Watch(command) => command.run(options, console),
            Command::Trace(command) => command.run(options, console),
            Command::Size(command) => command.run(options, console),
            Command::Bench(command) => command.run(options, console),
            Command::Torture(command) => command.run(options, console),
            Command::Flash(command) => command.run(options, console),
            Command::Selftest(command) => command.run(options, console),
            Command::Profile(command) => command.run(options, console),
        }
    }
}

/// The command line as clap knows it: man pages and completions are made from it.
pub fn command_line() -> clap::Command {
    Cli::command().after_help(manual::list())
}

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    let arguments: Vec<String> =
        std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    if let Some(text) = manual::asked(&arguments) {
        let console = Console { format: Format::Text, quiet: false };
        return match console.result(text) {
            Ok(()) => ExitCode::SUCCESS,
            Err(failure) => ExitCode::from(failure.exit_code()),
        };
    }
    let parsed = command_line().try_get_matches();
    let cli = match parsed.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(cli) => cli,
        Err(error) => {
            // clap writes help to standard output (0) and mistakes to standard error (2).
            let code = error.exit_code();
            let _ = error.print();
            return ExitCode::from(u8::try_from(code).unwrap_or(2));
        }
    };
    let console = Console { format: cli.options.format, quiet: false };
    match cli.command.run(&cli.options, &console) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if let Some(message) = failure.message() {
                console.complain(&format!("pasapas: {message}"));
            }
            ExitCode::from(failure.exit_code())
        }
    }
}

/// Where results, diagnostics and remarks go.
#[derive(Clone, Copy, Debug)]
pub struct Console {
    format: Format,
    /// Diagnostics are not shown.
    quiet: bool,
}

impl Console {
    /// The same for what is looked at beside: its diagnostics are not shown.
    pub fn quiet(self) -> Console {
        Console { quiet: true, ..self }
    }

    /// Whether results are JSON lines.
    pub fn json(&self) -> bool {
        self.format == Format::Json
    }

    /// Whether a progress bar would be seen.
    pub fn shows_progress(&self) -> bool {
        !self.json() && std::io::stderr().is_terminal()
    }

    /// Writes a result to standard output, as it is.
    ///
    /// # Errors
    /// Standard output is full or gone.
    pub fn result(&self, text: &str) -> Result<(), Failure> {
        self.bytes(text.as_bytes())
    }

    /// Writes bytes to standard output.
    ///
    /// # Errors
    /// Standard output is full or gone.
    pub fn bytes(&self, bytes: &[u8]) -> Result<(), Failure> {
        let mut out = std::io::stdout().lock();
        out.write_all(bytes)
            .and_then(|()| out.flush())
            .map_err(|error| Failure::writing("standard output", &error))
    }

    /// Writes one JSON line to standard output.
    ///
    /// # Errors
    /// Standard output is full or gone.
    pub fn json_line(&self, value: &impl serde::Serialize) -> Result<(), Failure> {
        let mut line = serde_json::to_string(value)
            .map_err(|error| Failure::Output(format!("no JSON can be made of it: {error}")))?;
        line.push('\n');
        self.result(&line)
    }

    /// Writes a line to standard error. There is nobody to tell when that fails.
    pub fn complain(&self, text: &str) {
        let _ = writeln!(std::io::stderr().lock(), "{text}");
    }

    /// Writes a diagnostic: a JSON line on standard output or text on standard error.
    ///
    /// # Errors
    /// Standard output is full or gone.
    pub fn note(&self, note: &Note) -> Result<(), Failure> {
        if self.quiet {
            return Ok(());
        }
        if self.json() {
            return self.result(&format!("{}\n", note.json()));
        }
        let _ = std::io::stderr().lock().write_all(note.plain().as_bytes());
        Ok(())
    }

    /// Writes a diagnostic of a script, with its source line.
    ///
    /// # Errors
    /// Standard output is full or gone.
    pub fn note_in(&self, note: &Note, source: &Source) -> Result<(), Failure> {
        if self.quiet || self.json() {
            return self.note(note);
        }
        let shown = match render::stderr_is_rich() {
            true => render::excerpt(note, source),
            false => note.quoted(source),
        };
        let _ = std::io::stderr().lock().write_all(shown.as_bytes());
        Ok(())
    }

    /// Writes a diagnostic of the language.
    ///
    /// # Errors
    /// Standard output is full or gone.
    pub fn diag(&self, diag: &Diag, source: &Source) -> Result<(), Failure> {
        self.note_in(&Note::of(diag, source), source)
    }

    /// Writes a note that ends the command.
    pub fn refuse(&self, note: &Note) -> Failure {
        match self.note(note) {
            Ok(()) => Failure::Input,
            Err(failure) => failure,
        }
    }
}

impl Options {
    /// The profile that `--profile` names, if it is there.
    ///
    /// # Errors
    /// It does not exist or is wrong; that was written.
    pub fn profile(&self, console: &Console) -> Result<Option<Profile>, Failure> {
        match &self.profile {
            None => Ok(None),
            Some(name) => input::profile(name).map(Some).map_err(|note| match note.file.as_str() {
                "--profile" => Failure::Usage(note.text),
                _ => console.refuse(&note),
            }),
        }
    }
}
