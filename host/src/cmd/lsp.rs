//! `pasapas lsp`: the language server on standard input and output.

use clap::Args;

use super::console::{Console, Options};
use crate::failure::Failure;
use crate::lsp;

/// `pasapas lsp`
#[derive(Debug, Args)]
pub struct Lsp {
    /// What editors add by habit: there is no other way here
    #[arg(long, hide = true)]
    stdio: bool,
}

impl Lsp {
    /// Serves one editor until it says good-bye.
    ///
    /// # Errors
    /// The connection breaks, or the profile is wrong.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let profile = options.profile(console)?;
        let (connection, threads) = lsp::stdio::connect();
        let result = lsp::serve(&connection, profile.as_ref());
        // The writer's thread ends when its channel closes.
        drop(connection);
        let read = threads.ended(result.is_err());
        // What could not be read says more than that there was nothing to be heard.
        read.map_err(|error| Failure::Output(format!("the editor sent no message: {error}")))?;
        result.map_err(|error| Failure::Output(error.to_string()))
    }
}
