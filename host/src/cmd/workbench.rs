//! `pasapas workbench`: script, simulation and board on one page of the browser.

use std::net::{Ipv4Addr, SocketAddr};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use clap::Args;
use serde_json::json;

use super::console::{Console, Options};
use super::part::Choice;
use super::world;
use crate::board::live::{Live, LiveError};
use crate::client::Client;
use crate::failure::Failure;
use crate::helm::{Helm, Open};
use crate::link;
use crate::sim::world::World;
use crate::workbench::{Door, Opens, Setting, Workbench as Served, password};

/// Environment variable with the password for `--listen`: arguments can be read by everybody.
const PASSWORD: &str = "PASAPAS_PASSWORD";

/// `pasapas workbench`
#[derive(Debug, Args)]
pub struct Workbench {
    /// The script; without it a new one
    file: Option<String>,
    /// Serial port, pseudo-terminal or `tcp:PORT` of the board; without it a virtual board
    #[arg(long, value_name = "PORT", conflicts_with = "part")]
    port: Option<String>,
    /// Modbus address of the board; without it the profile's, else 1
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=247))]
    address: Option<u8>,
    #[command(flatten)]
    part: Choice,
    /// Scenario around the virtual board and the simulation
    #[arg(long, value_name = "W.rhai")]
    world: Option<String>,
    /// Serve the network at this address too, with a password (PASAPAS_PASSWORD, else a random one).
    /// Nothing is encrypted: whoever listens on the network can read all of it
    #[arg(long, value_name = "ADDR:PORT")]
    listen: Option<SocketAddr>,
    /// A name by which a proxy asks
    #[arg(long, value_name = "NAME[:PORT]", requires = "listen")]
    allowed_host: Vec<String>,
    /// Do not open the browser
    #[arg(long)]
    no_open: bool,
    /// Only what a person at the machine needs: programs, quantities, Start, Pause, Stop
    #[arg(long)]
    operator: bool,
    /// The set-up of a new machine: its profile step by step, each tried on the machine
    #[arg(long, conflicts_with = "operator")]
    setup: bool,
}

impl Workbench {
    /// Serves until a page or Ctrl-C ends the tool.
    ///
    /// # Errors
    /// Script, world or profile are wrong, or the address is taken.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let profile = options.profile(console)?;
        let world = world::load(self.world.as_deref(), World::empty(), console)?;
        let part = self.part.or_default();
        let machine = options.machine(console)?;
        let address = Arc::new(AtomicU8::new(self.address.unwrap_or(machine.link.address)));
        let (open, live, board): (Open, _, _) = match &self.port {
            Some(port) => (real(port.clone(), address.clone()), None, port.clone()),
            None => {
                let live = Live::light(part, &machine, &world).map_err(|error| match error {
                    LiveError::World(error) => world::wrong(&error, console),
                    LiveError::Firmware(words) => Failure::Board(format!("firmware: {words}")),
                })?;
                let live = Arc::new(live);
                let own = live.clone();
                (Box::new(move || own.connect()), Some(live), part.part.name.to_owned())
            }
        };
        let opens = match (self.operator, self.setup) {
            (true, _) => Opens::Operator,
            (_, true) => Opens::Setup,
            _ => Opens::Workbench,
        };
        let setting = Setting { profile, world, part, live, board, opens, address };
        let served = Served::open(self.door()?, Helm::start(open), setting, self.file.as_deref());
        let served = served.map_err(Failure::Board)?;
        let url = served.url();
        if console.json() {
            console.json_line(&json!({ "url": url }))?;
        } else {
            console.result(&format!("the workbench is at {url}\n"))?;
        }
        if self.listen.is_some_and(|at| !at.ip().is_loopback()) {
            console.complain(
                "the network can reach it, and can read what goes over the line; the password is what \
                 stands behind # in the address",
            );
        }
        if !self.no_open && !browse(&url) {
            console.complain("no browser could be opened: open the address in one");
        }
        served.wait();
        Ok(())
    }

    fn door(&self) -> Result<Door, Failure> {
        let names = self.allowed_host.clone();
        let Some(address) = self.listen else {
            let address = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
            return Ok(Door { address, names, secret: None });
        };
        let secret = match std::env::var(PASSWORD) {
            Ok(own) if own.len() >= 8 && !own.contains(char::is_whitespace) => own,
            Ok(_) => {
                let text = format!("{PASSWORD} has fewer than 8 signs, or blanks");
                return Err(Failure::Usage(text));
            }
            Err(_) => password().map_err(Failure::Board)?,
        };
        Ok(Door { address, names, secret: Some(secret) })
    }
}

/// Opens a real port, and finds the board's rate and parity.
fn real(port: String, address: Arc<AtomicU8>) -> Open {
    Box::new(move || {
        let address = address.load(Ordering::SeqCst);
        let mut client = Client::new(link::open(&port)?, address);
        client.find().map_err(|error| format!("board {address} on {port}: {error}"))?;
        client.identity().map_err(|error| error.to_string())?.check()?;
        Ok(client)
    })
}

/// Opens an address in the user's browser.
fn browse(url: &str) -> bool {
    let (program, arguments): (&str, &[&str]) = if cfg!(target_os = "windows") {
        ("rundll32", &["url.dll,FileProtocolHandler"])
    } else if cfg!(target_os = "macos") {
        ("open", &[])
    } else {
        ("xdg-open", &[])
    };
    Command::new(program)
        .args(arguments)
        .arg(url)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .is_ok()
}
