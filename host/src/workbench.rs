//! The workbench: script, simulation, board, commissioning and operation on one local web page.
//!
//! Threads and blocking calls throughout, as the port, the emulator and the language server are: a
//! page has two threads, and there are a few dozen at most. `gate` checks who may connect, `server`,
//! `http` and `ws` are the transport, `session` and `machine` execute a page's requests, `bench` is the state that
//! all pages share. The page itself is in `page`, one file for each part, and is part of the tool.

mod around;
mod assets;
mod bench;
#[cfg(test)]
mod bench_tests;
mod client;
mod commission;
mod desk;
mod file;
mod gate;
mod http;
mod library;
mod machine;
mod message;
mod places;
mod programs;
mod server;
mod session;
mod setup;
mod simulation;
mod stored;
mod streamed;
mod teach;
mod ws;

use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;

pub use bench::{Opens, Setting};

use crate::helm::Helm;
use crate::interrupt;

/// A workbench that serves pages.
pub struct Workbench {
    bench: Arc<bench::Bench>,
    address: SocketAddr,
    secret: String,
}

/// Where to serve, and to whom.
pub struct Door {
    /// The address to listen on.
    pub address: SocketAddr,
    /// Names that a proxy asks by.
    pub names: Vec<String>,
    /// What a page must know; without it a random key.
    pub secret: Option<String>,
}

/// A password for a server on the network that a person can type.
///
/// # Errors
/// The system gives no random numbers.
pub fn password() -> Result<String, String> {
    gate::password()
}

impl Workbench {
    /// Opens the port, the script and everything behind it.
    ///
    /// # Errors
    /// The address is taken or the script cannot be read; in words.
    pub fn open(
        door: Door,
        helm: Helm,
        setting: Setting,
        file: Option<&str>,
    ) -> Result<Workbench, String> {
        let listener = TcpListener::bind(door.address)
            .map_err(|error| format!("{} cannot be listened on: {error}", door.address))?;
        let address = listener.local_addr().map_err(|error| error.to_string())?;
        let secret = match door.secret {
            Some(secret) => secret,
            None => gate::random()?,
        };
        let gate = gate::Gate::new(address, door.names, secret.clone());
        let bench = bench::Bench::start(gate, helm, setting, file)?;
        let own = bench.clone();
        std::thread::spawn(move || server::serve(listener, &own));
        Ok(Workbench { bench, address, secret })
    }

    /// The page's address, with the key behind `#`, which no server and no log sees.
    pub fn url(&self) -> String {
        let path = match self.bench.setting.opens {
            Opens::Workbench => "/",
            Opens::Operator => "/operator",
            Opens::Setup => "/setup",
        };
        let mut address = self.address;
        if address.ip().is_unspecified() {
            address.set_ip(std::net::Ipv4Addr::LOCALHOST.into());
        }
        format!("http://{address}{path}#{}", self.secret)
    }

    /// Serves until a page or Ctrl-C ends the tool. What is held by hand rests, a stored program goes on.
    pub fn wait(&self) {
        interrupt::watch();
        while !self.bench.is_over() && !interrupt::asked() {
            std::thread::sleep(Duration::from_millis(50));
        }
        if !self.bench.is_over() {
            self.bench.end();
        }
        // What was said last goes out first.
        std::thread::sleep(Duration::from_millis(200));
    }
}
