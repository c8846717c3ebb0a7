//! The gateway: boards on several lines, clients on several protocols.
//!
//! Each line has a thread ([`line`]), which serves all clients in turns. The servers are
//! tasks of one thread: they wait, and hold little for each client. `rights` says who may write what.

mod backoff;
mod cache;
mod card;
pub mod config;
pub mod describe;
mod gcode;
mod grbl;
mod inside;
pub mod light;
pub mod line;
mod looks;
mod mqtt;
mod named;
mod opcua;
mod open;
mod outbox;
mod pdu;
mod rights;
mod secret;
mod server;
mod sparkplug;
mod station;
#[cfg(test)]
mod tests;
mod turns;

use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use tokio::sync::mpsc::unbounded_channel;
use tokio::sync::oneshot;

pub use crate::hall::{counters, known};
pub use card::CardSetting;
pub use config::Config;
pub use gcode::GcodeSetting;
pub use grbl::GrblSetting;
pub use rights::Ranges;

use card::Cards;
use counters::{Counters, OWN_UNIT, Totals};
use gcode::{Buffers, Hosts, Texts};
use grbl::Grbls;
use known::{Book, Known, READ_FILE, WRITE_FILE};
use line::{Line, Look, Open, Watch};
use mqtt::{Mqtt, MqttSetting, Note};
use pdu::{NO_ANSWER, NO_PATH, Touch, refusal};
use rights::Rule;
use server::Guests;
use sparkplug::Sparkplug;
use station::Station;
use turns::Asker;

/// A board as clients see it.
struct Place {
    unit: u8,
    fresh_unit: Option<u8>,
    line: usize,
    station: usize,
}

/// Everything that servers share.
pub struct Gateway {
    lines: Vec<Line>,
    places: Vec<Place>,
    rules: Vec<Rule>,
    cache: Duration,
    totals: Totals,
    guests: Guests,
    /// Names of the boards, in the order of the file.
    names: Vec<String>,
    /// What is known of them.
    book: Arc<Book>,
    /// G-code that waits for boards, by their number in the file.
    texts: OnceLock<Buffers>,
    /// What orders by MQTT may write.
    orders: Ranges,
}

/// Who hears of looks at a board, by its number in the file.
type Tell = Arc<dyn Fn(usize, Look) + Send + Sync>;

/// A gateway that serves until this is dropped.
pub struct Running {
    address: SocketAddr,
    /// Go before all others: they stop what they move.
    cards: Option<Cards>,
    /// And these.
    grbls: Option<Grbls>,
    /// These end their runs.
    hosts: Option<Hosts>,
    #[cfg(feature = "opcua")]
    opcua: Option<self::opcua::Opcua>,
    /// Go first: they say goodbye.
    talks: (Option<Mqtt>, Option<Sparkplug>),
    gateway: Arc<Gateway>,
    runtime: Option<tokio::runtime::Runtime>,
}

impl Gateway {
    /// Opens lines by `open`, which gets a port and the addresses of its boards.
    ///
    /// # Errors
    /// A list of rights is wrong; in words.
    fn new(
        config: &Config,
        rules: Vec<Rule>,
        tell: Option<&Tell>,
        mut open: impl FnMut(&str, &[u8]) -> Open,
    ) -> Result<Gateway, String> {
        let mut ports: Vec<(&str, Vec<u8>)> = Vec::new();
        let mut places = Vec::new();
        for board in &config.boards {
            let line =
                ports.iter().position(|(port, _)| *port == board.port).unwrap_or_else(|| {
                    ports.push((&board.port, Vec::new()));
                    ports.len() - 1
                });
            let station = ports[line].1.len();
            ports[line].1.push(board.address);
            let (unit, fresh_unit) = (board.unit(), board.fresh_unit);
            places.push(Place { unit, fresh_unit, line, station });
        }
        let known = |board: &config::BoardSetting| Known {
            board: board.name.clone(),
            unit: board.unit(),
            tags: board.tags.clone(),
            program: board.program.clone(),
        };
        let book = Book::open(config.boards.iter().map(known).collect(), config.names.as_deref());
        let book = Arc::new(book);
        let watch = |line: usize| {
            let (tell, every, prints) = (tell?.clone(), config.every()?, config.mqtt.is_some());
            let mine = |(_, place): &(usize, &Place)| place.line == line;
            let boards: Vec<usize> =
                places.iter().enumerate().filter(mine).map(|(board, _)| board).collect();
            let (book, own) = (book.clone(), boards.clone());
            let program = Box::new(move |station: usize, crc| book.program(own[station], crc));
            let tell = Box::new(move |station: usize, look| tell(boards[station], look));
            Some(Watch { every, prints, program, tell })
        };
        let start = |(line, (port, addresses)): (usize, &(&str, Vec<u8>))| {
            Line::start(addresses, config.reply_time(port), watch(line), open(port, addresses))
        };
        let lines: Vec<Line> = ports.iter().enumerate().map(start).collect();
        for place in &places {
            let station = &lines[place.line].stations[place.station];
            station.counters.unit.set(place.unit.into());
        }
        let totals = Totals::default();
        totals.boards.set(places.len() as u32);
        let cache = Duration::from_millis(config.modbus.cache_ms);
        let guests = Guests::new(config.modbus.clients);
        let names = config.boards.iter().map(|board| board.name.clone()).collect();
        let orders = config.mqtt.as_ref().map_or(Ok(Ranges::default()), MqttSetting::rights)?;
        Ok(Gateway {
            lines,
            places,
            rules,
            cache,
            totals,
            guests,
            names,
            book,
            texts: OnceLock::new(),
            orders,
        })
    }

    /// What a client from this address may do.
    fn rule(&self, address: IpAddr) -> Rule {
        self.rules
            .iter()
            .find(|rule| rule.from.holds(address))
            .cloned()
            .unwrap_or_else(Rule::reader)
    }

    fn station(&self, place: &Place) -> &Arc<Station> {
        &self.lines[place.line].stations[place.station]
    }

    /// The board behind a unit. 0 and 255 are the one that is asked, where there is only one.
    fn place(&self, unit: u8) -> Option<&Place> {
        match &self.places[..] {
            [only] if matches!(unit, 0 | 255) => Some(only),
            places => places.iter().find(|one| one.unit == unit || one.fresh_unit == Some(unit)),
        }
    }

    /// The reply to a client's request, whatever comes: never silence.
    async fn answer(&self, asker: Asker, rule: &Rule, unit: u8, pdu: Vec<u8>) -> Vec<u8> {
        self.totals.requests.add();
        if unit == OWN_UNIT {
            return match pdu.first() {
                Some(&(READ_FILE | WRITE_FILE)) => self.file(rule, &pdu),
                _ => self.own(&pdu),
            };
        }
        let Some(place) = self.place(unit).filter(|place| rule.sees(place.unit)) else {
            self.totals.astray.add();
            return refusal(&pdu, NO_PATH);
        };
        let station = self.station(place);
        station.counters.requests.add();
        let touch = match Touch::of(&pdu) {
            Ok(touch) => touch,
            Err(exception) => return refusal(&pdu, exception as u8),
        };
        let may_write = || rule.write.hold(&touch) || rule.stop && touch.only_stops(&pdu);
        if touch.write && !may_write() {
            station.counters.refused.add();
            use lang::wire::Exception::{IllegalAddress, IllegalFunction};
            let code = if rule.write.is_empty() { IllegalFunction } else { IllegalAddress };
            return refusal(&pdu, code as u8);
        }
        let texts = self.texts(place);
        if touch.write
            && let Some(reply) = texts.and_then(|texts| texts.write(&touch, &pdu))
        {
            return reply;
        }
        let fresh = rule.fresh || place.fresh_unit == Some(unit);
        let age = if fresh { Duration::ZERO } else { self.cache };
        let (to, reply) = oneshot::channel();
        let none = refusal(&pdu, NO_ANSWER);
        // The client may be gone when the answer comes.
        let answer = Box::new(move |reply| drop(to.send(reply)));
        self.lines[place.line].ask(asker, place.station, (pdu, touch), age, answer);
        let mut reply = reply.await.unwrap_or(none);
        if let Some(texts) = texts {
            texts.show(&touch, &mut reply);
        }
        reply
    }

    /// The G-code that waits for a board, if it takes any.
    fn texts(&self, place: &Place) -> Option<&Texts> {
        let list = self.texts.get()?;
        let found = list.iter().find(|(board, _)| self.places[*board].unit == place.unit);
        found.map(|(_, texts)| &**texts)
    }

    /// A board's file: whoever sees the board reads it, whoever may upload a program writes it.
    fn file(&self, rule: &Rule, pdu: &[u8]) -> Vec<u8> {
        use lang::wire::{self, Exception, Table};
        let table = Table::Holding;
        let upload = Touch { table, first: wire::UPLOAD_CONTROL, count: 1, write: true };
        let answer = Book::file_of(pdu).and_then(|(file, writes)| {
            let unit = u8::try_from(file).map_err(|_| Exception::IllegalAddress)?;
            let place = self.place(unit).ok_or(Exception::IllegalAddress)?;
            if !rule.sees(place.unit) || writes && !rule.write.hold(&upload) {
                return Err(Exception::IllegalAddress);
            }
            let board = self.places.iter().position(|one| one.unit == place.unit);
            self.book.answer(board.unwrap_or(usize::MAX), pdu)
        });
        answer.unwrap_or_else(|exception| refusal(pdu, exception as u8))
    }

    /// The counters' registers.
    fn own(&self, pdu: &[u8]) -> Vec<u8> {
        use lang::wire::{Exception, Table};
        self.totals.clients.set(self.guests.count() as u32);
        let touch = match Touch::of(pdu) {
            Ok(touch) if touch.write => return refusal(pdu, Exception::IllegalFunction as u8),
            Ok(touch) => touch,
            Err(exception) => return refusal(pdu, exception as u8),
        };
        let boards: Vec<&Counters> =
            self.places.iter().map(|place| &self.station(place).counters).collect();
        let words = counters::registers(&self.totals, &boards);
        let registers = matches!(touch.table, Table::Holding | Table::InputRegisters);
        let range = touch.range().start as usize..touch.range().end as usize;
        match words.get(range).filter(|_| registers) {
            None => refusal(pdu, Exception::IllegalAddress as u8),
            Some(words) => {
                let bytes = words.iter().flat_map(|word| word.to_be_bytes());
                [touch.table as u8, 2 * words.len() as u8].into_iter().chain(bytes).collect()
            }
        }
    }
}

impl Running {
    /// Serves the boards of a file.
    ///
    /// # Errors
    /// An address cannot be listened on; in words.
    pub fn start(config: &Config) -> Result<Running, String> {
        Running::with(config, |port, addresses| {
            let (port, addresses) = (port.to_owned(), addresses.to_vec());
            let mode = config.mode(&port);
            Box::new(move || open::open(&port, &addresses, mode))
        })
    }

    /// The same with lines that `open` makes, from a port and the addresses of its boards.
    ///
    /// # Errors
    /// An address cannot be listened on; in words.
    pub fn with(config: &Config, open: impl FnMut(&str, &[u8]) -> Open) -> Result<Running, String> {
        server::make_room(config.modbus.clients)?;
        let listener = server::bind(config.modbus.listen)?;
        let words = |error: std::io::Error| error.to_string();
        let address = listener.local_addr().map_err(words)?;
        let (mqtt, sparkplug) = (unbounded_channel(), unbounded_channel());
        #[cfg(feature = "opcua")]
        let looks = unbounded_channel();
        let to: Vec<_> = [
            config.mqtt.as_ref().map(|_| mqtt.0.clone()),
            config.sparkplug.as_ref().map(|_| sparkplug.0.clone()),
            #[cfg(feature = "opcua")]
            config.opcua.as_ref().map(|_| looks.0.clone()),
        ]
        .into_iter()
        .flatten()
        .collect();
        let watched = !to.is_empty();
        let tell: Tell = Arc::new(move |board, look: Look| {
            for one in &to {
                // A conversation is over when nobody hears it.
                let _ = one.send(Note::Look(board, look.clone()));
            }
        });
        let tell = watched.then_some(&tell);
        let gateway = Arc::new(Gateway::new(config, config.rules()?, tell, open)?);
        let cards = Cards::start(&config.cards, &gateway)?;
        let grbls = Grbls::start(&config.grbl, &gateway)?;
        let (hosts, texts) = Hosts::start(&config.gcode, &gateway)?;
        gateway.texts.get_or_init(|| texts);
        #[cfg(feature = "opcua")]
        let opcua = match &config.opcua {
            Some(setting) => Some(self::opcua::Opcua::start(setting, &gateway, looks)?),
            None => None,
        };
        let talks = match &config.mqtt {
            None => (None, None),
            Some(setting) => {
                let node = match &config.sparkplug {
                    Some(own) => Some(Sparkplug::start(own, setting, &gateway, sparkplug)?),
                    None => None,
                };
                (Some(Mqtt::start(setting, &gateway, mqtt)?), node)
            }
        };
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build()
            .map_err(words)?;
        let guard = runtime.enter();
        let listener = tokio::net::TcpListener::from_std(listener).map_err(words)?;
        runtime.spawn(server::serve(listener, gateway.clone()));
        drop(guard);
        Ok(Running {
            address,
            cards: Some(cards),
            grbls: Some(grbls),
            hosts: Some(hosts),
            #[cfg(feature = "opcua")]
            opcua,
            talks,
            gateway,
            runtime: Some(runtime),
        })
    }

    /// Where the Modbus TCP server listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Cards: each one's board, and where it answers.
    pub fn cards(&self) -> &[(String, String)] {
        self.cards.as_ref().map_or(&[], |cards| &cards.places)
    }

    /// Grbl servers: each one's board, and where it answers.
    pub fn grbls(&self) -> &[(String, String)] {
        self.grbls.as_ref().map_or(&[], |grbls| &grbls.places)
    }

    /// Where the OPC UA server listens, if there is one.
    pub fn opcua(&self) -> Option<SocketAddr> {
        #[cfg(feature = "opcua")]
        return self.opcua.as_ref().map(self::opcua::Opcua::address);
        #[cfg(not(feature = "opcua"))]
        None
    }

    /// What is counted of the boards, in the order of the file.
    pub fn counters(&self) -> Vec<Vec<u32>> {
        let of = |place| self.gateway.station(place).counters.values();
        self.gateway.places.iter().map(of).collect()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        (self.cards, self.grbls, self.hosts) = (None, None, None);
        #[cfg(feature = "opcua")]
        {
            self.opcua = None;
        }
        self.talks = (None, None);
        if let Some(runtime) = self.runtime.take() {
            // Tasks that wait for nobody any more.
            runtime.shutdown_background();
        }
    }
}
