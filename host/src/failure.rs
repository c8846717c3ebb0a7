//! Failures of commands, and their exit codes.

use std::io;

/// Why a command did not do what was asked. The exit codes are a contract with scripts and tools.
#[derive(Debug)]
pub enum Failure {
    /// The script or another input is wrong; its diagnostics were written already. Exit code 1.
    Input,
    /// The command line is wrong. Exit code 2.
    Usage(String),
    /// The run ended in a fault, was stopped, or an expectation failed; that was written already.
    /// Exit code 3.
    Run,
    /// The board or the port failed. Exit code 4.
    Board(String),
    /// A result could not be written. Exit code 4: the input was right and nothing ran wrong.
    Output(String),
    /// The reader of our standard output went away. The exit code is the one that a shell shows for
    /// a process that SIGPIPE ended, as with any other tool in a pipe.
    ClosedPipe,
}

/// 128 and the number of SIGPIPE.
const CLOSED_PIPE: u8 = 128 + 13;

impl Failure {
    /// The process's exit code.
    pub const fn exit_code(&self) -> u8 {
        match self {
            Failure::ClosedPipe => CLOSED_PIPE,
            Failure::Input => 1,
            Failure::Usage(_) => 2,
            Failure::Run => 3,
            Failure::Board(_) | Failure::Output(_) => 4,
        }
    }

    /// What to tell the user, if the command has not told it already.
    pub fn message(&self) -> Option<&str> {
        match self {
            Failure::Input | Failure::Run | Failure::ClosedPipe => None,
            Failure::Usage(text) | Failure::Board(text) | Failure::Output(text) => Some(text),
        }
    }

    /// Writing to `what` (a path or `standard output`) failed.
    pub fn writing(what: &str, error: &io::Error) -> Failure {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Failure::ClosedPipe,
            _ => Failure::Output(format!("{what} cannot be written: {error}")),
        }
    }
}
