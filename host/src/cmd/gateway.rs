//! `pasapas gateway`: boards on several lines, for programs on several protocols.

use std::net::SocketAddr;
use std::path::Path;

use clap::Args;
use serde_json::json;

use super::console::{Console, Options};
use super::{script, upload};
use crate::client::Client;
use crate::failure::Failure;
use crate::gateway::config::{BoardSetting, ClientSetting};
use crate::gateway::describe::{COLUMNS, rows};
use crate::gateway::known::{Known, Program, programs_in, variables};
use crate::gateway::{CardSetting, Config, GrblSetting, Ranges, Running};
use crate::{input, interrupt, link};

/// `pasapas gateway`
#[derive(Debug, Args)]
pub struct Gateway {
    /// The gateway's file: boards, servers, rights
    #[arg(required_unless_present = "port", value_name = "FILE.toml")]
    file: Option<String>,
    /// Instead of a file: serial port, pseudo-terminal, `tcp:[HOST:]PORT` or `rtu:[HOST:]PORT` of the
    /// one board
    #[arg(long, value_name = "PORT", conflicts_with = "file")]
    port: Option<String>,
    /// Its Modbus address; without it the profile's, else 1
    #[arg(long, value_name = "N", requires = "port", value_parser = clap::value_parser!(u8).range(1..=247))]
    address: Option<u8>,
    /// Where to listen for Modbus TCP, instead of what the file says; port 0 takes a free one. Modbus
    /// knows no login
    #[arg(long, value_name = "ADDR:PORT")]
    listen: Option<SocketAddr>,
    /// What clients may write with --port: all, `coils 0..7`, `registers 3000..3071`, or a register's
    /// name; without it nothing
    #[arg(long, value_name = "WHAT", requires = "port", value_delimiter = ',', value_parser = writable)]
    write: Vec<String>,
    /// Write what can be read and written of each board, as CSV or JSON lines, and end; with --port
    /// tcp:PORT of a gateway that runs, of all of its boards
    #[arg(long)]
    describe: bool,
}

fn writable(text: &str) -> Result<String, String> {
    Ranges::parse([text]).map(|_| text.to_owned())
}

impl Gateway {
    /// Serves until Ctrl-C or SIGTERM ends it. The boards' programs go on.
    ///
    /// # Errors
    /// The file is wrong, or an address cannot be listened on.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let mut config = self.config(options, console)?;
        if self.describe {
            return self.describe(&config, options, console);
        }
        for board in &mut config.boards {
            let Some(file) = &board.script else { continue };
            board.program = self.program(file, options, console);
            if board.program.is_none() {
                let name = &board.name;
                console.complain(&format!("the variables of {name} have no names: see above"));
            }
        }
        let running = Running::start(&config).map_err(Failure::Board)?;
        interrupt::watch();
        let address = running.address();
        for board in &config.boards {
            let (name, unit) = (&board.name, board.unit());
            if console.json() {
                let listen = format!("tcp:{address}");
                console.json_line(&json!({ "board": name, "unit": unit, "port": listen }))?;
            } else {
                console.result(&format!("{name} is unit {unit} of Modbus TCP at {address}\n"))?;
            }
        }
        for (board, place) in running.cards() {
            if console.json() {
                console.json_line(&json!({ "board": board, "card": place }))?;
            } else {
                console.result(&format!("{board} is an interface card at {place}\n"))?;
            }
        }
        for (board, place) in running.grbls() {
            if console.json() {
                console.json_line(&json!({ "board": board, "grbl": place }))?;
            } else {
                console.result(&format!("{board} is served as Grbl 1.1h at {place}\n"))?;
            }
        }
        if let Some(address) = running.opcua() {
            let url = format!("opc.tcp://{address}/");
            if console.json() {
                console.json_line(&json!({ "opcua": url }))?;
            } else {
                console.result(&format!("OPC UA is at {url}\n"))?;
            }
        }
        let open = |card: &CardSetting| card.listen.is_some_and(|at| !at.ip().is_loopback());
        if config.cards.iter().any(open) {
            console.complain("the network can reach a card, and cards know no login");
        }
        let open = |grbl: &GrblSetting| grbl.listen.is_some_and(|at| !at.ip().is_loopback());
        if config.grbl.iter().any(open) {
            console.complain("the network can drive a board by Grbl, which knows no login");
        }
        if !address.ip().is_loopback() {
            console.complain(
                "the network can reach it, and Modbus knows no login: what clients may write stands in \
                 [[client]]",
            );
        }
        while !interrupt::asked() {
            std::thread::sleep(std::time::Duration::from_millis(50));
        }
        Ok(())
    }

    /// What the script is that a board has by the file; none when it is wrong, which was written.
    fn program(&self, file: &str, options: &Options, console: &Console) -> Option<Program> {
        let script = script::load(&self.beside(file), options, console).ok()?;
        let compiled = script::compile_any(&script, console).ok()?;
        Some(upload::about(&compiled, &script))
    }

    /// A table for Node-RED, Telegraf, Ignition and whoever else wants to know.
    fn describe(
        &self,
        config: &Config,
        options: &Options,
        console: &Console,
    ) -> Result<(), Failure> {
        let given = options.machine(console)?;
        let mut text = format!("{COLUMNS}\n");
        for (known, script) in self.known(config) {
            let (machine, variables) = match (&script, &known.program) {
                (Some(file), _) => {
                    let program = script::load(&self.beside(file), options, console)?.program;
                    let variables = variables(&program);
                    (program.profile, variables)
                }
                (None, Some(program)) => {
                    // `--profile` stands for a machine that this tool does not know by name.
                    let machine = match &options.profile {
                        None => input::profile(&program.profile).unwrap_or_else(|_| given.clone()),
                        Some(_) => given.clone(),
                    };
                    (machine, program.variables.clone())
                }
                (None, None) => (given.clone(), Vec::new()),
            };
            for row in rows(&known.board, known.unit, &machine, &variables) {
                if console.json() {
                    console.json_line(&row)?;
                } else {
                    text += &(row.csv() + "\n");
                }
            }
        }
        if console.json() { Ok(()) } else { console.result(&text) }
    }

    /// The boards with what is known of their programs, and the script that the gateway's file names:
    /// of a gateway that runs at the port what it says, otherwise what its file says.
    fn known(&self, config: &Config) -> Vec<(Known, Option<String>)> {
        let running = self.port.as_deref().filter(|port| port.starts_with("tcp:"));
        let hall = running.and_then(|port| {
            let mut gateway = Client::new(link::open(port).ok()?, 1);
            gateway.hall().ok()
        });
        if let Some(hall) = hall {
            return hall.into_iter().map(|known| (known, None)).collect();
        }
        let mut programs = config.names.as_deref().map(programs_in).unwrap_or_default();
        let known = |board: &BoardSetting| {
            let program = programs.remove(&board.name);
            let (name, tags) = (board.name.clone(), board.tags.clone());
            let known = Known { board: name, unit: board.unit(), tags, program };
            (known, board.script.clone())
        };
        config.boards.iter().map(known).collect()
    }

    /// A file that the gateway's names: it stands beside that unless it says where.
    fn beside(&self, file: &str) -> String {
        let folder = self.file.as_ref().and_then(|own| Path::new(own).parent());
        folder.map_or_else(|| file.to_owned(), |folder| folder.join(file).display().to_string())
    }

    fn config(&self, options: &Options, console: &Console) -> Result<Config, Failure> {
        let mut config = match (&self.file, &self.port) {
            (Some(file), _) => {
                let text = input::read_text(file).map_err(|note| console.refuse(&note))?;
                Config::parse(file, &text).map_err(|note| console.refuse(&note))?
            }
            (None, port) => {
                let profile = options.profile(console)?.map(|profile| profile.link.address);
                let address = self.address.or(profile).unwrap_or(1);
                let mut config = Config::of_port(port.as_deref().unwrap_or_default(), address);
                config.clients.push(ClientSetting {
                    from: "any".to_owned(),
                    units: None,
                    write: self.write.clone(),
                    stop: true,
                    fresh: false,
                });
                config
            }
        };
        if let Some(listen) = self.listen {
            config.modbus.listen = listen;
        }
        let cards = config.cards.iter_mut().map(|card| &mut card.profile);
        let profiles = cards.chain(config.gcode.iter_mut().map(|one| &mut one.profile));
        for profile in profiles.filter(|profile| profile.ends_with(".toml")) {
            *profile = self.beside(profile);
        }
        config.names = config.names.map(|names| self.beside(&names.to_string_lossy()).into());
        Ok(config)
    }
}
