//! `[[grbl]]` of the gateway's file: boards for Grbl clients.
//!
//! The server itself is [`crate::grbl`]; its requests to the board take their turns among all others.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;

use serde::Deserialize;

use super::Gateway;
use super::inside::{ADDRESS, Inside};
use super::turns::Asker;
use crate::client::Client;
use crate::grbl::port::Ports;
use crate::grbl::{Server, Setting};
use crate::input;

/// Client number of Grbl servers, apart from those of clients, cards and G-code.
const FIRST_ASKER: Asker = 1 << 60;

/// `[[grbl]]`
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GrblSetting {
    /// The board that is driven.
    pub board: String,
    /// Its machine.
    #[serde(default = "profile")]
    pub profile: String,
    /// Where clients connect by TCP.
    pub listen: Option<SocketAddr>,
    /// Serial port that the client's computer is wired to.
    pub port: Option<String>,
    /// Bits per second of that port.
    #[serde(default = "rate")]
    pub rate: u32,
    /// Link to a pseudo-terminal for a program on this computer.
    pub pty: Option<PathBuf>,
    /// File of G54 to G59, G28, G30, `$10` and `$13`.
    pub offsets: Option<PathBuf>,
}

fn profile() -> String {
    lang::profile::DEFAULT_NAME.to_owned()
}

const fn rate() -> u32 {
    115_200
}

impl GrblSetting {
    /// What is wrong with it, in words; `boards` are those of the file.
    ///
    /// # Errors
    /// It names no board, or no place for its clients.
    pub fn check<'a>(&self, mut boards: impl Iterator<Item = &'a str>) -> Result<(), String> {
        if !boards.any(|board| board == self.board) {
            return Err(format!("there is no board `{}`", self.board));
        }
        if self.listen.is_none() && self.port.is_none() && self.pty.is_none() {
            return Err("a place for its clients is missing: listen, port or pty".to_owned());
        }
        if !(300..=1_000_000).contains(&self.rate) {
            return Err("a rate is 300 to 1000000".to_owned());
        }
        Ok(())
    }
}

/// Servers that serve until this is dropped.
pub struct Grbls {
    /// Each one's board and the places where clients find it.
    pub places: Vec<(String, String)>,
    _servers: Vec<Server>,
}

impl Grbls {
    /// Opens the places of all servers and serves.
    ///
    /// # Errors
    /// A place cannot be opened, or a profile or a file of offsets is none; in words.
    pub fn start(settings: &[GrblSetting], gateway: &Arc<Gateway>) -> Result<Grbls, String> {
        let (mut places, mut servers) = (Vec::new(), Vec::new());
        for (n, one) in settings.iter().enumerate() {
            let words = |error: String| format!("[[grbl]] of {}: {error}", one.board);
            let profile = input::profile(&one.profile).map_err(|note| words(note.line()))?;
            let board = gateway.names.iter().position(|name| *name == one.board);
            let board = board.ok_or_else(|| words("there is no such board".to_owned()))?;
            let (mut ports, mut ways) = (Ports::default(), Vec::new());
            if let Some(address) = one.listen {
                ways.push(format!("tcp:{}", ports.listen(address).map_err(words)?));
            }
            if let Some(link) = &one.pty {
                ports.pty(link).map_err(words)?;
                ways.push(link.display().to_string());
            }
            if let Some(path) = &one.port {
                ports.serial(path, one.rate).map_err(words)?;
                ways.push(path.clone());
            }
            let setting = Setting {
                profile,
                offsets: one.offsets.clone(),
                name: one.board.clone(),
                tells: true,
            };
            let inside = Arc::downgrade(gateway);
            let open = Box::new(move || {
                let gateway = inside.upgrade().ok_or("the gateway ends")?;
                Ok(Client::new(Inside::new(&gateway, board, FIRST_ASKER + n as Asker), ADDRESS))
            });
            servers.push(Server::start(setting, ports, open).map_err(words)?);
            places.push((one.board.clone(), ways.join(" and ")));
        }
        Ok(Grbls { places, _servers: servers })
    }
}
