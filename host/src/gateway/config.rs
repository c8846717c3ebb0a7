//! The gateway's file: boards, lines, servers, rights.

use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::time::Duration;

use lang::profile::Parity;
use serde::Deserialize;

use super::card::CardSetting;
use super::counters::OWN_UNIT;
use super::gcode::GcodeSetting;
use super::grbl::GrblSetting;
use super::known::Program;
use super::mqtt::MqttSetting;
use super::opcua::OpcuaSetting;
use super::rights::{Network, Ranges, Rule};
use super::sparkplug::SparkplugSetting;
use crate::input::{self, code};
use crate::link::Mode;
use crate::render::Note;

/// Port of the Modbus TCP server; 502 itself is for the system's administrator.
pub const USUAL_PORT: u16 = 1502;
/// Boards of one gateway: as many as Modbus has units.
const MOST_BOARDS: usize = 247;

/// All of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// The Modbus TCP server.
    #[serde(default)]
    pub modbus: Modbus,
    /// File of what is known of the boards' programs; without it that ends with the gateway.
    pub names: Option<PathBuf>,
    /// The broker, if there is one.
    pub mqtt: Option<MqttSetting>,
    /// The edge node at that broker, if there is one.
    pub sparkplug: Option<SparkplugSetting>,
    /// The OPC UA server, if there is one.
    pub opcua: Option<OpcuaSetting>,
    /// The old cards that boards stand in for.
    #[serde(default, rename = "card")]
    pub cards: Vec<CardSetting>,
    /// Boards that take G-code as text.
    #[serde(default)]
    pub gcode: Vec<GcodeSetting>,
    /// Boards that Grbl's clients drive.
    #[serde(default)]
    pub grbl: Vec<GrblSetting>,
    /// What a serial line needs beyond its name.
    #[serde(default, rename = "line")]
    pub lines: Vec<LineSetting>,
    /// The boards.
    #[serde(rename = "board")]
    pub boards: Vec<BoardSetting>,
    /// Who may do what; the first rule that fits a client holds.
    #[serde(default, rename = "client")]
    pub clients: Vec<ClientSetting>,
}

/// `[modbus]`
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Modbus {
    /// Where to listen.
    pub listen: SocketAddr,
    /// Clients at a time.
    pub clients: usize,
    /// Age up to which an answer is given again, ms; 0: never.
    pub cache_ms: u64,
}

impl Default for Modbus {
    fn default() -> Modbus {
        let listen = SocketAddr::from((Ipv4Addr::LOCALHOST, USUAL_PORT));
        Modbus { listen, clients: 128, cache_ms: 50 }
    }
}

/// `[[line]]`
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LineSetting {
    /// The port as its boards name it.
    pub port: String,
    /// Bits per second; without it found by trying.
    pub rate: Option<u32>,
    /// Parity; none without it.
    pub parity: Option<Parity>,
    /// Longest wait for a reply beside its time on the wire, ms.
    pub reply_ms: Option<u64>,
}

/// `[[board]]`
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoardSetting {
    /// For people, topics and lists.
    pub name: String,
    /// Serial port, pseudo-terminal, `tcp:[HOST:]PORT` or `rtu:[HOST:]PORT`.
    pub port: String,
    /// Modbus address on that line.
    #[serde(default = "one")]
    pub address: u8,
    /// Unit by which clients ask for it; its address without it.
    pub unit: Option<u8>,
    /// Unit by which clients ask for it past the memory.
    pub fresh_unit: Option<u8>,
    /// For lists and orders to several boards.
    #[serde(default)]
    pub tags: Vec<String>,
    /// The script that is on it: names of its AT and KEEP variables, where no upload left them.
    pub script: Option<String>,
    /// What that script is, when it could be read.
    #[serde(skip)]
    pub program: Option<Program>,
}

const fn one() -> u8 {
    1
}

/// `[[client]]`
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClientSetting {
    /// `any`, an address or a network.
    pub from: String,
    /// Units that it sees; all without it.
    pub units: Option<Vec<u8>>,
    /// What it may write.
    #[serde(default)]
    pub write: Vec<String>,
    /// It may end motion (Stop, Pause, emergency stop), whatever else it may write.
    #[serde(default = "yes")]
    pub stop: bool,
    /// It gets nothing from memory.
    #[serde(default)]
    pub fresh: bool,
}

fn yes() -> bool {
    true
}

/// What is wrong: the text where it stands, and words.
struct Wrong(String, String);

impl BoardSetting {
    /// Unit by which clients ask for it.
    pub fn unit(&self) -> u8 {
        self.unit.unwrap_or(self.address)
    }
}

impl Config {
    /// A gateway for one board.
    pub fn of_port(port: &str, address: u8) -> Config {
        let board = BoardSetting {
            name: "board".to_owned(),
            port: port.to_owned(),
            address,
            unit: (address == OWN_UNIT).then_some(1),
            fresh_unit: None,
            tags: Vec::new(),
            script: None,
            program: None,
        };
        let (modbus, boards) = (Modbus::default(), vec![board]);
        Config {
            modbus,
            names: None,
            mqtt: None,
            sparkplug: None,
            opcua: None,
            cards: Vec::new(),
            gcode: Vec::new(),
            grbl: Vec::new(),
            lines: Vec::new(),
            boards,
            clients: Vec::new(),
        }
    }

    /// Reads a file's text; `file` is its name for the note.
    ///
    /// # Errors
    /// The note says what is wrong, and where.
    pub fn parse(file: &str, text: &str) -> Result<Config, Box<Note>> {
        let config: Config = toml::from_str(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            let (words, hint) = cell::problem::of_toml(&error);
            Note::error(file, code::GATEWAY, words).at(input::place(text, at)).hint(hint)
        })?;
        config.check().map_err(|Wrong(at, words)| {
            let at = text.find(&at).unwrap_or(0);
            Note::error(file, code::GATEWAY, words).at(input::place(text, at))
        })?;
        Ok(config)
    }

    fn check(&self) -> Result<(), Wrong> {
        let board = || "[[board]]".to_owned();
        if self.boards.is_empty() || self.boards.len() > MOST_BOARDS {
            return Err(Wrong(board(), format!("a gateway has 1 to {MOST_BOARDS} boards")));
        }
        if !(1..=10_000).contains(&self.modbus.clients) {
            return Err(Wrong("clients".into(), "clients is 1 to 10000".into()));
        }
        let mut units: Vec<u8> = Vec::new();
        for (i, one) in self.boards.iter().enumerate() {
            let name = &one.name;
            let good = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
            if name.is_empty() || name.len() > 64 || !name.chars().all(good) {
                let words = format!(
                    "`{name}` is no name of a board: 1 to 64 letters, digits, hyphens, underscores \
                     and points, as topics and lists have them"
                );
                return Err(Wrong(format!("\"{name}\""), words));
            }
            let before = &self.boards[..i];
            if before.iter().any(|other| other.name == *name) {
                return Err(Wrong(format!("\"{name}\""), format!("two boards are named {name}")));
            }
            let same =
                |other: &&BoardSetting| (&other.port, other.address) == (&one.port, one.address);
            if let Some(other) = before.iter().find(same) {
                let words = format!("{name} is where {} is: same port and address", other.name);
                return Err(Wrong(format!("\"{name}\""), words));
            }
            if !(1..=247).contains(&one.address) {
                return Err(Wrong(format!("\"{name}\""), "an address is 1 to 247".to_owned()));
            }
            for unit in [Some(one.unit()), one.fresh_unit].into_iter().flatten() {
                if !(1..OWN_UNIT).contains(&unit) {
                    let words = format!(
                        "{name}: a unit is 1 to {}, {OWN_UNIT} is the gateway's own; give it another `unit`",
                        OWN_UNIT - 1
                    );
                    return Err(Wrong(format!("\"{name}\""), words));
                }
                if units.contains(&unit) {
                    let words = format!("{name}: unit {unit} is taken; give it another `unit`");
                    return Err(Wrong(format!("\"{name}\""), words));
                }
                units.push(unit);
            }
        }
        for line in &self.lines {
            if !self.boards.iter().any(|board| board.port == line.port) {
                let words = format!("no board is on {}", line.port);
                return Err(Wrong("[[line]]".to_owned(), words));
            }
            if line.rate.is_some_and(|rate| !(300..=4_000_000).contains(&rate)) {
                return Err(Wrong("rate".to_owned(), "a rate is 300 to 4000000".to_owned()));
            }
            if line.reply_ms.is_some_and(|ms| !(1..=10_000).contains(&ms)) {
                return Err(Wrong("reply_ms".to_owned(), "reply_ms is 1 to 10000".to_owned()));
            }
        }
        if let Some(mqtt) = &self.mqtt {
            mqtt.check().map_err(|words| Wrong("[mqtt]".to_owned(), words))?;
        }
        if let Some(sparkplug) = &self.sparkplug {
            let at = || "[sparkplug]".to_owned();
            sparkplug.check().map_err(|words| Wrong(at(), words))?;
            if self.mqtt.is_none() {
                return Err(Wrong(at(), "[sparkplug] goes by the broker of [mqtt]: add it".into()));
            }
        }
        if let Some(opcua) = &self.opcua {
            opcua.check().map_err(|words| Wrong("[opcua]".to_owned(), words))?;
        }
        for (n, card) in self.cards.iter().enumerate() {
            let at = || "[[card]]".to_owned();
            card.check(self.boards.iter().map(|board| board.name.as_str()))
                .map_err(|words| Wrong(at(), words))?;
            if self.cards[..n].iter().any(|other| other.board == card.board) {
                let words = format!("{} has one card already: one talks at a time", card.board);
                return Err(Wrong(at(), words));
            }
        }
        for (n, one) in self.gcode.iter().enumerate() {
            let at = || "[[gcode]]".to_owned();
            if !self.boards.iter().any(|board| board.name == one.board) {
                return Err(Wrong(at(), format!("there is no board `{}`", one.board)));
            }
            if self.gcode[..n].iter().any(|other| other.board == one.board) {
                return Err(Wrong(at(), format!("{} takes G-code already", one.board)));
            }
        }
        for (n, one) in self.grbl.iter().enumerate() {
            let at = || "[[grbl]]".to_owned();
            one.check(self.boards.iter().map(|board| board.name.as_str()))
                .map_err(|words| Wrong(at(), words))?;
            let drives = self.grbl[..n].iter().map(|other| &other.board);
            let drives = drives.chain(self.cards.iter().map(|card| &card.board));
            let mut drives = drives.chain(self.gcode.iter().map(|gcode| &gcode.board));
            if drives.any(|board| *board == one.board) {
                let words = format!(
                    "{} is driven already, by a [[grbl]], a [[card]] or a [[gcode]]: one drives",
                    one.board
                );
                return Err(Wrong(at(), words));
            }
        }
        for client in &self.clients {
            client.rule().map_err(|words| Wrong(format!("\"{}\"", client.from), words))?;
        }
        Ok(())
    }

    /// Rate and parity of a port, if they are told.
    pub fn mode(&self, port: &str) -> Option<Mode> {
        let line = self.lines.iter().find(|line| line.port == port)?;
        if line.rate.is_none() && line.parity.is_none() {
            return None;
        }
        let usual = Mode::DEFAULT;
        let (rate, parity) = (line.rate.unwrap_or(usual.rate), line.parity.unwrap_or(usual.parity));
        Some(Mode { rate, parity })
    }

    /// Longest wait for a reply beside its time on the wire. Over a network other masters may have
    /// their turns first.
    pub fn reply_time(&self, port: &str) -> Duration {
        let line = self.lines.iter().find(|line| line.port == port);
        let usual = if port.starts_with("tcp:") || port.starts_with("rtu:") { 1000 } else { 150 };
        Duration::from_millis(line.and_then(|line| line.reply_ms).unwrap_or(usual))
    }

    /// Between two looks at a board, if somebody wants to see it.
    pub fn every(&self) -> Option<Duration> {
        let opcua = self.opcua.as_ref().map(|one| Duration::from_millis(one.look_ms));
        self.mqtt.as_ref().map(MqttSetting::every).into_iter().chain(opcua).min()
    }

    /// The rules for clients.
    ///
    /// # Errors
    /// One of them is wrong; in words.
    pub fn rules(&self) -> Result<Vec<Rule>, String> {
        self.clients.iter().map(ClientSetting::rule).collect()
    }
}

impl ClientSetting {
    fn rule(&self) -> Result<Rule, String> {
        Ok(Rule {
            from: Network::parse(&self.from)?,
            units: self.units.clone(),
            write: Ranges::parse(self.write.iter().map(String::as_str))?,
            stop: self.stop,
            fresh: self.fresh,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Config;

    const GOOD: &str = "[[board]]\nname = \"drill\"\nport = \"/dev/ttyACM0\"\n";

    #[test]
    fn a_board_needs_its_name_and_its_port() {
        let config = Config::parse("g.toml", GOOD).expect("good");
        assert_eq!((config.boards[0].unit(), config.modbus.cache_ms), (1, 50));
        assert!(config.modbus.listen.ip().is_loopback());
        assert!(config.rules().expect("good").is_empty());
    }

    #[test]
    fn what_is_wrong_is_told_where_it_stands() {
        let second = "[[board]]\nname = \"saw\"\nport = \"/dev/ttyACM1\"\n";
        let cases = [
            (format!("{GOOD}{second}"), (5, 8), "unit 1 is taken"),
            (format!("{GOOD}{second}unit = 0\n"), (5, 8), "a unit is 1 to 246"),
            (GOOD.replace("drill", "dr/ill"), (2, 8), "is no name of a board"),
            (format!("{GOOD}[[client]]\nfrom = \"hall\"\n"), (5, 8), "is no machine"),
            (format!("{GOOD}[[line]]\nport = \"COM9\"\n"), (4, 1), "no board is on COM9"),
            (format!("{GOOD}colour = 3\n"), (4, 1), "no key `colour`"),
            (format!("{GOOD}[[grbl]]\nboard = \"saw\"\n"), (4, 1), "there is no board `saw`"),
            (format!("{GOOD}[[grbl]]\nboard = \"drill\"\n"), (4, 1), "listen, port or pty"),
            (
                format!(
                    "{GOOD}[[gcode]]\nboard = \"drill\"\n[[grbl]]\nboard = \"drill\"\npty = \"g\"\n"
                ),
                (6, 1),
                "is driven already",
            ),
            (
                format!("{GOOD}{}", GOOD.replace("/dev/ttyACM0", "x")),
                (2, 8),
                "two boards are named",
            ),
        ];
        for (text, place, words) in cases {
            let note = Config::parse("g.toml", &text).expect_err(&text);
            assert!(note.text.contains(words), "{}", note.text);
            // Of two places with the same text the first is shown.
            assert_eq!(note.place, place, "{text}");
        }
    }
}
