//! OPC UA: boards as objects with their values, the variables of their programs by name, and
//! methods.
//!
//! The server brings 160 crates, so it needs the feature `opcua`; its section of the gateway's file is known
//! to every build.

#[cfg(feature = "opcua")]
mod server;
#[cfg(feature = "opcua")]
mod space;

use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;

use serde::Deserialize;

use super::rights::Ranges;

#[cfg(feature = "opcua")]
pub use server::Opcua;

/// `[opcua]`
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OpcuaSetting {
    /// Where to listen.
    #[serde(default = "listen")]
    pub listen: SocketAddr,
    /// Folder of certificates: `own`, `private`, and those of clients; made where it is not there.
    #[serde(default = "pki")]
    pub pki: PathBuf,
    /// User name.
    pub user: Option<String>,
    /// File whose first line is the password.
    pub password_file: Option<PathBuf>,
    /// What methods may write; without it none is carried out.
    #[serde(default)]
    pub write: Vec<String>,
    /// Between two looks at a board, ms.
    #[serde(default = "look")]
    pub look_ms: u64,
}

fn listen() -> SocketAddr {
    SocketAddr::from((Ipv4Addr::LOCALHOST, 4840))
}

fn pki() -> PathBuf {
    PathBuf::from("pasapas-pki")
}

const fn look() -> u64 {
    250
}

impl OpcuaSetting {
    /// What is wrong with it, in words.
    ///
    /// # Errors
    /// A number or a list is none, or the network could reach it without a password.
    pub fn check(&self) -> Result<(), String> {
        if cfg!(not(feature = "opcua")) {
            return Err(
                "this build has no OPC UA: `cargo install --path host --features opcua` makes one that has"
                .to_owned(),
            );
        }
        if self.user.is_some() != self.password_file.is_some() {
            return Err("user and password_file belong together".to_owned());
        }
        if self.user.is_none() && !self.listen.ip().is_loopback() {
            return Err("what the network can reach wants user and password_file".to_owned());
        }
        if !(20..=60_000).contains(&self.look_ms) {
            return Err("look_ms is 20 to 60000".to_owned());
        }
        Ranges::parse(self.write.iter().map(String::as_str)).map(drop)
    }
}
