//! Launch arguments: the program to debug, and the machine to debug it on.

use std::sync::Arc;
use std::sync::mpsc::{self, Receiver};

use lang::profile::Profile;
use serde_json::Value;

use super::board;
use super::program::{self, Loaded};
use super::sim::{self, Ear};
use super::snapshot::Order;
use crate::board::DEFAULT;
use crate::board::live::Live;
use crate::client::Client;
use crate::helm::Board;
use crate::input;
use crate::link;
use crate::sim::world::World;

/// What the command line says for every session.
#[derive(Clone, Debug, Default)]
pub struct Setup {
    /// The machine for scripts that name none.
    pub profile: Option<Profile>,
}

/// Where the program runs.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Target {
    Simulator,
    Virtual,
    Port(String),
}

/// The arguments of launch and attach.
#[derive(Clone, Debug)]
pub struct Launch {
    /// The program is on the board already.
    pub attach: bool,
    program: String,
    target: Target,
    profile: Option<String>,
    world: Option<String>,
    halts: bool,
    trace: bool,
}

impl Launch {
    /// Reads the arguments.
    ///
    /// # Errors
    /// What is wrong with them, in words.
    pub fn read(attach: bool, arguments: &Value) -> Result<Launch, String> {
        let text = |name: &str| match &arguments[name] {
            Value::Null => Ok(None),
            Value::String(text) if text.is_empty() => Ok(None),
            Value::String(text) => Ok(Some(text.clone())),
            other => Err(format!("`{name}` is a text, not {other}")),
        };
        let flag = |name: &str| arguments[name].as_bool().unwrap_or(false);
        let program = text("program")?.ok_or("`program` names the script")?;
        let target = match text("board")?.as_deref() {
            None | Some("simulator") if attach => {
                return Err("`board` names the port of the board to attach to".to_owned());
            }
            None | Some("simulator") => Target::Simulator,
            Some("virtual") if attach => {
                return Err("a virtual board of a session of its own is launched".to_owned());
            }
            Some("virtual") => Target::Virtual,
            Some(port) => Target::Port(port.to_owned()),
        };
        Ok(Launch {
            attach,
            program,
            target,
            profile: text("profile")?,
            world: text("world")?,
            halts: flag("stopOnEntry"),
            trace: flag("trace"),
        })
    }

    /// Whether it runs on the simulated machine, which can go back.
    pub fn is_simulated(&self) -> bool {
        self.target == Target::Simulator
    }

    /// Reads and compiles the program.
    ///
    /// # Errors
    /// It cannot be read or is wrong; in words.
    pub fn load(&self, setup: &Setup) -> Result<Loaded, String> {
        let profile = match &self.profile {
            Some(name) => Some(input::profile(name).map_err(|note| note.line())?),
            None => setup.profile.clone(),
        };
        program::load(&self.program, profile)
    }

    fn world(&self) -> Result<World, String> {
        let Some(file) = &self.world else {
            // As `sim` and `board` have it.
            return Ok(if self.is_simulated() { World::unattended() } else { World::empty() });
        };
        let text = input::read_text(file).map_err(|note| note.line())?;
        World::parse(file, &text).map_err(|error| error.to_string())
    }

    /// Starts the run in a thread of its own; the channel ends with it.
    ///
    /// # Errors
    /// The world is wrong, or the board does not take the program; in words.
    pub fn start(
        &self,
        loaded: Arc<Loaded>,
        orders: Receiver<Order>,
        ear: Ear,
    ) -> Result<Receiver<()>, String> {
        let (halts, trace) = (self.halts, self.trace);
        let world = self.world()?;
        let (over, ended) = mpsc::channel();
        if self.is_simulated() {
            std::thread::spawn(move || {
                sim::run(&loaded, &world, halts, trace, orders, &ear);
                drop(over);
            });
            return Ok(ended);
        }
        let own = self.clone();
        let (ready, begun) = mpsc::channel();
        std::thread::spawn(move || {
            // A link stays in the thread that opened it.
            match own.connect(&world, &loaded) {
                Ok((board, live)) => {
                    let _ = ready.send(Ok(()));
                    let how = board::Meeting { attach: own.attach, halts, trace };
                    board::run(board, &loaded, how, orders, &ear);
                    drop(live);
                }
                Err(words) => drop(ready.send(Err(words))),
            }
            drop(over);
        });
        begun.recv().unwrap_or_else(|_| Err("the board's thread ended".to_owned())).map(|()| ended)
    }

    /// The board with the program in it, and what keeps it alive.
    fn connect(&self, world: &World, loaded: &Loaded) -> Result<(Board, Option<Live>), String> {
        let (board, live) = match &self.target {
            Target::Port(port) => (open(port, loaded)?, None),
            Target::Simulator | Target::Virtual => {
                let profile = &loaded.program.profile;
                let live = Live::start(DEFAULT, profile, world).map_err(|e| format!("{e:?}"))?;
                (live.connect()?, Some(live))
            }
        };
        Ok((self.prepared(board, loaded)?, live))
    }

    /// The same board after the program was brought to it.
    fn prepared(&self, mut board: Board, loaded: &Loaded) -> Result<Board, String> {
        let there = board::holds(&mut board, loaded)?;
        if there {
            return Ok(board);
        }
        if self.attach {
            return Err(format!(
                "the board's program is not {file}: launch it, or `pasapas upload {file}`",
                file = loaded.file
            ));
        }
        board::fits(&mut board, loaded)?;
        let place = (None, loaded.file.as_str());
        board
            .bring(&loaded.compiled.image, place, false, &mut |_| {})
            .map_err(|e| e.to_string())?;
        Ok(board)
    }
}

fn open(port: &str, loaded: &Loaded) -> Result<Board, String> {
    let mut client = Client::new(link::open(port)?, loaded.program.profile.link.address);
    client.find().map_err(|error| format!("{port}: {error}"))?;
    Ok(client)
}
