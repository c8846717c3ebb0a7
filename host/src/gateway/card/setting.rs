//! `[[card]]` of the gateway's file.

use std::net::SocketAddr;
use std::path::PathBuf;

use import::card;
use serde::Deserialize;

/// `[[card]]`
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CardSetting {
    /// The board that it moves.
    pub board: String,
    /// Where clients connect by TCP.
    pub listen: Option<SocketAddr>,
    /// Serial port that the client's computer is wired to.
    pub port: Option<String>,
    /// Bits per second of that port.
    #[serde(default = "rate")]
    pub rate: u32,
    /// Link to a pseudo-terminal for a program on this computer.
    pub pty: Option<PathBuf>,
    /// The machine: steps that clients count are its steps.
    #[serde(default = "profile")]
    pub profile: String,
    /// Which card it is.
    #[serde(default)]
    pub dialect: Dialect,
    /// What stands behind each answer.
    #[serde(default)]
    pub answer: Answer,
}

const fn rate() -> u32 {
    9_600
}

fn profile() -> String {
    "charly".to_owned()
}

/// Which card it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Dialect {
    /// charlyrobot's, and isel's of system versions 4.0 and 5.0.
    #[default]
    Charlyrobot,
    /// iMC-S8 and its like.
    Imcs8,
}

/// What stands behind each answer, until the client says otherwise by `@0C`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Answer {
    /// Nothing: one character.
    #[default]
    Bare,
    /// A carriage return, for programs that wait for the end of a line.
    Cr,
}

impl From<Dialect> for card::Dialect {
    fn from(dialect: Dialect) -> card::Dialect {
        match dialect {
            Dialect::Charlyrobot => card::Dialect::Binder,
            Dialect::Imcs8 => card::Dialect::Newer,
        }
    }
}

impl Answer {
    /// What it is on the line.
    pub const fn line_end(self) -> &'static [u8] {
        match self {
            Answer::Bare => b"",
            Answer::Cr => b"\r",
        }
    }
}

impl CardSetting {
    /// What is wrong with it, in words; `boards` are those of the file.
    ///
    /// # Errors
    /// It names no board, or not one place for its clients.
    pub fn check<'a>(&self, mut boards: impl Iterator<Item = &'a str>) -> Result<(), String> {
        if !boards.any(|board| board == self.board) {
            return Err(format!("there is no board `{}`", self.board));
        }
        let places = [self.listen.is_some(), self.port.is_some(), self.pty.is_some()];
        if places.into_iter().filter(|there| *there).count() != 1 {
            return Err("a card has one place for its clients: listen, port or pty".to_owned());
        }
        if !(300..=1_000_000).contains(&self.rate) {
            return Err("a rate is 300 to 1000000".to_owned());
        }
        Ok(())
    }
}
