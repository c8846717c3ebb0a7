//! `--port` and `--address`: the way to a board, for every command that talks to one.

use clap::Args;

use super::console::{Console, Options};
use crate::client::{Client, ClientError};
use crate::failure::Failure;
use crate::link::{self, Link};
use crate::usb;

/// Which board.
#[derive(Clone, Debug, Args)]
pub struct Port {
    /// Serial port, pseudo-terminal, `tcp:[HOST:]PORT` (Modbus TCP) or `rtu:[HOST:]PORT` (RTU frames
    /// over TCP) of the board; without it the LaunchPad's, if one is plugged in
    #[arg(long, value_name = "PORT")]
    port: Option<String>,
    /// Modbus address of the board; without it the profile's, else 1
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=247))]
    address: Option<u8>,
    /// Open the lock of the board's program and profile with its code, until the next reset
    #[arg(long, value_name = "CODE")]
    unlock: Option<String>,
}

/// A master on whatever link the user named.
pub type Board = Client<Box<dyn Link>>;

impl Port {
    /// The port as it was named.
    pub fn name(&self) -> Option<&str> {
        self.port.as_deref()
    }

    /// Whether a gateway may be on the way.
    pub fn is_tcp(&self) -> bool {
        self.port.as_ref().is_some_and(|port| port.starts_with("tcp:"))
    }

    /// Whether the port has bits a second: a pseudo-terminal and a network have none.
    pub fn has_rate(&self) -> bool {
        let Some(port) = &self.port else { return true };
        let path = std::fs::canonicalize(port).unwrap_or_else(|_| port.into());
        !port.starts_with("tcp:") && !port.starts_with("rtu:") && !path.starts_with("/dev/pts")
    }

    /// Opens the port and finds the board's rate and parity.
    ///
    /// # Errors
    /// The port cannot be opened or no board answers.
    pub fn connect(&self, options: &Options, console: &Console) -> Result<Board, Failure> {
        let from_profile = options.profile(console)?.map(|profile| profile.link.address);
        let address = self.address.or(from_profile).unwrap_or(1);
        let port = match &self.port {
            Some(port) => port.clone(),
            None => {
                let port = only_board(&usb::serial_ports())?;
                console.complain(&format!("port {port}"));
                port
            }
        };
        let link = link::open(&port).map_err(Failure::Board)?;
        let mut client = Client::new(link, address);
        client.find().map_err(|error| {
            let hint = match (&error, port.starts_with("tcp:")) {
                (ClientError::Silent, true) => {
                    "; a server that passes on a line's bytes is rtu:HOST:PORT"
                }
                _ => "",
            };
            Failure::Board(format!("board {address} on {port}: {error}{hint}"))
        })?;
        if let Some(code) = &self.unlock {
            client.unlock(code)?;
        }
        Ok(client)
    }
}

/// The port of the one board that is plugged in. Adapters are not taken: anything may hang on them.
fn only_board(ports: &[usb::Port]) -> Result<String, Failure> {
    let boards: Vec<usb::Port> =
        ports.iter().filter(|port| port.board.is_some()).cloned().collect();
    match &boards[..] {
        [board] => Ok(board.name.clone()),
        [] if ports.is_empty() => Err(Failure::Usage(
            "no LaunchPad is plugged in, nor any other serial port: plug it in, or name the board \
             with --port (`tcp:HOST:PORT` over a network)"
                .to_owned(),
        )),
        [] => Err(Failure::Usage(format!(
            "no LaunchPad is plugged in: name the board with --port; there are {}",
            usb::list(ports)
        ))),
        _ => Err(Failure::Usage(format!(
            "more than one LaunchPad is plugged in: choose with --port; there are {}",
            usb::list(&boards)
        ))),
    }
}

impl From<ClientError> for Failure {
    fn from(error: ClientError) -> Failure {
        Failure::Board(error.to_string())
    }
}
