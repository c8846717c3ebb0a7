//! `pasapas dap`: the debug adapter on standard input and output, or on a TCP port.

use std::io::{self, BufReader};
use std::net::{Ipv4Addr, TcpListener};

use clap::Args;

use super::console::{Console, Options};
use crate::dap::{self, Setup};
use crate::failure::Failure;

/// `pasapas dap`
#[derive(Debug, Args)]
pub struct Dap {
    /// Serve one editor after the other on this local TCP port instead; 0 takes a free one
    #[arg(long, value_name = "PORT")]
    port: Option<u16>,
    /// What editors add by habit: it is so anyway
    #[arg(long, hide = true, conflicts_with = "port")]
    stdio: bool,
}

impl Dap {
    /// Serves one editor until it goes, or many at a port.
    ///
    /// # Errors
    /// The connection breaks, the port is taken, or the profile is wrong.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let setup = Setup { profile: options.profile(console)? };
        let broken = |error: io::Error| Failure::Output(error.to_string());
        let Some(port) = self.port else {
            return dap::serve(BufReader::new(io::stdin()), io::stdout(), setup).map_err(broken);
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))
            .map_err(|error| Failure::Output(format!("port {port}: {error}")))?;
        let own = listener.local_addr().map_err(broken)?;
        console.result(&format!("listening on {own}\n"))?;
        for editor in listener.incoming() {
            let editor = editor.map_err(broken)?;
            let from = BufReader::new(editor.try_clone().map_err(broken)?);
            // An editor that breaks off does not end the service.
            if let Err(error) = dap::serve(from, editor, setup.clone()) {
                console.complain(&format!("an editor's session broke: {error}"));
            }
        }
        Ok(())
    }
}
