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
mod console;
mod control;
mod dap;
mod disasm;
mod engrave;
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
mod level;
mod library;
mod lsp;
mod manual;
mod others;
mod part;
mod paste;
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

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::failure::Failure;
use console::{Console, Format, Options};

/// A small BASIC for machines that step: check, simulate, upload and watch its scripts.
#[derive(Debug, Parser)]
#[command(name = "pasapas", version, long_version = version::LONG, infer_subcommands = false)]
struct Cli {
    #[command(flatten)]
    options: Options,
    #[command(subcommand)]
    command: Command,
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
    /// Make a job of dots of a circuit board's paste layer, or of a list of pads
    Paste(paste::Paste),
    /// Make a laser's job of a picture or of a drawing's paths
    Engrave(engrave::Engrave),
    /// Lay a job of G-code onto a surface that was probed
    Level(level::Level),
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
            Command::Paste(command) => command.run(options, console),
            Command::Engrave(command) => command.run(options, console),
            Command::Level(command) => command.run(options, console),
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
        let console = Console::new(Format::Text);
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
    let console = Console::new(cli.options.format);
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
