//! `pasapas gateway` in a tool that was built without it.

use clap::Args;

use super::console::{Console, Options};
use crate::failure::Failure;

/// `pasapas gateway`: this tool was built without it (see the page of the gateway)
#[derive(Debug, Args)]
pub struct Gateway {
    /// What the gateway would be asked
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    rest: Vec<String>,
}

impl Gateway {
    /// Says how to get it.
    ///
    /// # Errors
    /// Always: it is not there.
    pub fn run(&self, _options: &Options, _console: &Console) -> Result<(), Failure> {
        Err(Failure::Usage(
            "this tool was built without the gateway: `cargo install --path host --features gateway`, \
             or take a release's package"
                .to_owned(),
        ))
    }
}
