//! The `pasapas` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    pasapas::cmd::main()
}
