//! `[mqtt]` of the gateway's file.

use std::path::{Path, PathBuf};
use std::time::Duration;

use rumqttc::mqttbytes::QoS;
use rumqttc::{LastWill, MqttOptions, TlsConfiguration, Transport};
use serde::Deserialize;

use crate::gateway::rights::Ranges;
use crate::gateway::secret;

/// Longest packet that is taken from a broker, bytes; an order is much shorter.
const MOST_INCOMING: usize = 256 << 10;
/// Seconds between signs of life; a broker gives a client up after one and a half of it.
const KEEP_ALIVE: u16 = 10;

/// `[mqtt]`
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MqttSetting {
    /// `HOST` or `HOST:PORT`.
    pub broker: String,
    /// Name of this gateway in topics and as a client.
    #[serde(default = "name")]
    pub name: String,
    /// User name.
    pub user: Option<String>,
    /// File whose first line is the password.
    pub password_file: Option<PathBuf>,
    /// Certificates that the broker's must be signed by, PEM; with it the connection is TLS.
    pub ca_file: Option<PathBuf>,
    /// Our own certificate and key, PEM.
    pub certificate: Option<PathBuf>,
    /// The key to it.
    pub key: Option<PathBuf>,
    /// File of what has not arrived yet.
    #[serde(default = "outbox")]
    pub outbox: PathBuf,
    /// Messages that it keeps.
    #[serde(default = "keep")]
    pub keep: usize,
    /// Between two looks at a board, ms.
    #[serde(default = "look")]
    pub look_ms: u64,
    /// What orders may write; without it none is carried out.
    #[serde(default)]
    pub write: Vec<String>,
    /// Beginnings of topics to which a reply may go beside those of its board.
    #[serde(default)]
    pub replies: Vec<String>,
    /// Tell Home Assistant of the boards.
    #[serde(default)]
    pub home_assistant: bool,
}

fn name() -> String {
    "gateway".to_owned()
}

fn outbox() -> PathBuf {
    PathBuf::from("pasapas-outbox.jsonl")
}

const fn keep() -> usize {
    10_000
}

const fn look() -> u64 {
    250
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    std::fs::read(path).map_err(|error| format!("{} cannot be read: {error}", path.display()))
}

impl MqttSetting {
    /// What is wrong with it, in words.
    ///
    /// # Errors
    /// A name, a number or a list is none.
    pub fn check(&self) -> Result<(), String> {
        let good = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        if self.name.is_empty() || self.name.len() > 64 || !self.name.chars().all(good) {
            return Err(format!("`{}` is no name: letters, digits, - _ .", self.name));
        }
        if !(1..=1_000_000).contains(&self.keep) {
            return Err("keep is 1 to 1000000".to_owned());
        }
        if !(20..=60_000).contains(&self.look_ms) {
            return Err("look_ms is 20 to 60000".to_owned());
        }
        for topic in &self.replies {
            let ours = self.base().starts_with(topic.as_str()) || topic.starts_with("pasapas/");
            if ours || topic.starts_with('$') || topic.contains(['+', '#']) {
                return Err(format!(
                    "replies = [\"{topic}\"]: the beginning of a topic that no gateway and no broker \
                     takes orders by, such as \"panel/\""
                ));
            }
        }
        if self.certificate.is_some() != self.key.is_some() {
            return Err("certificate and key belong together".to_owned());
        }
        if self.certificate.is_some() && self.ca_file.is_none() {
            return Err(
                "a certificate of our own needs ca_file: the broker's is checked too".into()
            );
        }
        self.place().map(drop)?;
        self.rights().map(drop)
    }

    /// What orders may write.
    ///
    /// # Errors
    /// An item is none; in words.
    pub fn rights(&self) -> Result<Ranges, String> {
        Ranges::parse(self.write.iter().map(String::as_str))
    }

    /// Between two looks.
    pub fn every(&self) -> Duration {
        Duration::from_millis(self.look_ms)
    }

    fn place(&self) -> Result<(String, u16), String> {
        let usual = if self.ca_file.is_some() { 8883 } else { 1883 };
        match self.broker.rsplit_once(':') {
            None if self.broker.is_empty() => Err("broker names no host".to_owned()),
            None => Ok((self.broker.clone(), usual)),
            Some((host, port)) => match port.parse() {
                Ok(port) if !host.is_empty() => Ok((host.to_owned(), port)),
                _ => Err(format!("`{}` is no HOST:PORT", self.broker)),
            },
        }
    }

    /// First part of all topics of this gateway.
    pub fn base(&self) -> String {
        format!("pasapas/{}", self.name)
    }

    /// Topic that shows whether the gateway is there.
    pub fn status(&self) -> String {
        format!("{}/status", self.base())
    }

    /// How to connect.
    ///
    /// # Errors
    /// A file cannot be read; in words.
    pub fn options(&self) -> Result<MqttOptions, String> {
        let mut options = MqttOptions::new(format!("pasapas-{}", self.name), self.place()?);
        options.set_keep_alive(KEEP_ALIVE).set_clean_session(true);
        options.set_max_packet_size(MOST_INCOMING, MOST_INCOMING);
        options.set_last_will(LastWill::new(self.status(), "offline", QoS::AtLeastOnce, true));
        let password = match &self.password_file {
            None => String::new(),
            Some(file) => {
                secret::warn(file);
                let text = String::from_utf8_lossy(&read(file)?).into_owned();
                text.lines().next().unwrap_or_default().to_owned()
            }
        };
        if let Some(user) = &self.user {
            options.set_credentials(user.clone(), password);
        }
        if let Some(ca) = &self.ca_file {
            let own = match (&self.certificate, &self.key) {
                (Some(certificate), Some(key)) => Some((read(certificate)?, read(key)?)),
                _ => None,
            };
            let tls = TlsConfiguration::Simple { ca: read(ca)?, alpn: None, client_auth: own };
            options.set_transport(Transport::tls_with_config(tls));
        }
        Ok(options)
    }
}
