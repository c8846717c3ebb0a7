//! `pasapas grbl`: a Grbl server in front of a board.

use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use clap::Args;
use serde_json::json;

use super::console::{Console, Options};
use super::part::Choice;
use super::port::Port;
use super::world;
use crate::board::live::{Live, LiveError};
use crate::client::Client;
use crate::failure::Failure;
use crate::grbl::port::Ports;
use crate::grbl::{Server, Setting};
use crate::interrupt;
use crate::link::{self, Link};
use crate::sim::world::World;

/// `pasapas grbl`
#[derive(Debug, Args)]
pub struct Grbl {
    #[command(flatten)]
    port: Port,
    /// Serve at this TCP port of this computer; 0 takes a free one
    #[arg(long, value_name = "PORT")]
    tcp: Option<u16>,
    /// Serve at this TCP address, for other computers too. Grbl knows no login
    #[arg(long, value_name = "ADDR:PORT", conflicts_with = "tcp")]
    listen: Option<SocketAddr>,
    /// Serve at a pseudo-terminal, with a link to it of this name
    #[arg(long, value_name = "LINK")]
    pty: Option<PathBuf>,
    /// Keep G54 to G59, G28, G30, $10 and $13 in this file; without it they end with the server
    #[arg(long, value_name = "FILE")]
    offsets: Option<PathBuf>,
    #[command(flatten)]
    part: Choice,
    /// Scenario around the virtual board
    #[arg(long, value_name = "W.rhai")]
    world: Option<String>,
}

impl Grbl {
    /// Serves until Ctrl-C or SIGTERM ends it; what a client moves then comes to rest.
    ///
    /// # Errors
    /// No board answers, it cannot be fed, a place for clients is taken, or the file of offsets is none.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let profile = options.machine(console)?;
        let mut ports = Ports::default();
        let mut ways = Vec::new();
        let local = |port| SocketAddr::from((Ipv4Addr::LOCALHOST, port));
        // Without a way in there is one that any client can find.
        let usual = (self.pty.is_none()).then(|| local(0));
        if let Some(address) = self.listen.or(self.tcp.map(local)).or(usual) {
            let address = ports.listen(address).map_err(Failure::Board)?;
            ways.push(match address.ip().is_loopback() {
                true => format!("tcp:{}", address.port()),
                false => format!("tcp:{address}"),
            });
            if !address.ip().is_loopback() {
                console.complain("the network can drive the machine: Grbl knows no login");
            }
        }
        if let Some(link) = &self.pty {
            ports.pty(link).map_err(Failure::Board)?;
            ways.push(link.display().to_string());
        }
        let (name, open) = self.board(&profile, options, console)?;
        let setting = Setting { profile, offsets: self.offsets.clone(), name, tells: true };
        let server = Server::start(setting, ports, open).map_err(Failure::Board)?;
        interrupt::watch();
        if console.json() {
            console.json_line(&json!({ "grbl": ways }))?;
        } else {
            console.result(&format!("Grbl 1.1h is served at {}\n", ways.join(" and ")))?;
        }
        while !interrupt::asked() {
            std::thread::sleep(Duration::from_millis(50));
        }
        drop(server);
        Ok(())
    }

    /// The board, and the way to it whenever it was lost.
    fn board(
        &self,
        profile: &lang::profile::Profile,
        options: &Options,
        console: &Console,
    ) -> Result<(String, crate::grbl::drive::Open<Box<dyn Link>>), Failure> {
        if let Some(name) = self.port.name() {
            let mut client = self.port.connect(options, console)?;
            crate::client::identity::must_match(&client.board_record()?, profile)
                .map_err(Failure::Board)?;
            if client.stream_slots()?.is_none() {
                return Err(Failure::Board(
                    "this board's firmware has no feature `stream`: it cannot be fed by Grbl's clients"
                        .to_owned(),
                ));
            }
            let name = name.to_owned();
            let (address, again) = (client.address(), name.clone());
            // The thread that owns the board opens it again.
            drop(client);
            return Ok((
                name,
                Box::new(move || {
                    let mut client = Client::new(link::open(&again)?, address);
                    client.find().map_err(|error| format!("{again}: {error}"))?;
                    Ok(client)
                }),
            ));
        }
        let world = world::load(self.world.as_deref(), World::empty(), console)?;
        let live =
            Live::start(self.part.or_default(), profile, &world).map_err(|error| match error {
                LiveError::World(error) => world::wrong(&error, console),
                LiveError::Firmware(words) => Failure::Board(format!("firmware: {words}")),
            })?;
        let live = Arc::new(live);
        Ok(("the virtual board".to_owned(), Box::new(move || live.connect())))
    }
}
