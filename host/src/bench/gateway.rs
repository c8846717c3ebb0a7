//! Overhead of the gateway on the time of its lines: model boards on lines with the timing of a real
//! wire, asked by TCP clients as fast as they are answered.

use std::io::Write;
use std::net::{SocketAddr, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use super::{Sink, at_least, at_most};
use crate::client::Client;
use crate::gateway::light::{self, Light, Memory, cycle};
use crate::gateway::{Config, Running};
use crate::link::Link;
use crate::link::adu::Mbap;

/// Boards on each line.
const BOARDS: u8 = 10;
/// Registers of a read.
const REGISTERS: u8 = 10;
/// A board's unit and this is the one that gets nothing from memory.
const FRESH: usize = 100;
/// Clients on each line that are compared.
const CROWD: usize = 10;
/// Lines of the large one.
const LINES: usize = 10;

/// What the boards of a line hold.
type Boards = Arc<Mutex<Memory>>;

/// A gateway with light boards on so many lines; units go through, line by line.
fn stand(lines: usize) -> Result<(Vec<Boards>, Running), String> {
    let mut text = "[modbus]\nlisten = \"127.0.0.1:0\"\n".to_owned();
    for line in 0..lines {
        for address in 1..=BOARDS {
            let unit = line * usize::from(BOARDS) + usize::from(address);
            text += &format!(
                "[[board]]\nname = \"b{unit}\"\nport = \"{line}\"\naddress = {address}\nunit = {unit}\n\
                 fresh_unit = {}\n",
                unit + FRESH
            );
        }
    }
    let config = Config::parse("bench", &text).map_err(|note| note.text)?;
    let addresses: Vec<u8> = (1..=BOARDS).collect();
    let memories: Vec<_> = (0..lines).map(|_| light::boards(&addresses)).collect();
    let running = Running::with(&config, |port, _| {
        let memory = port.parse().ok().and_then(|line: usize| memories.get(line).cloned());
        let memory = memory.unwrap_or_default();
        Box::new(move || {
            let link: Box<dyn Link> = Box::new(Light::new(memory.clone()));
            Ok(Client::new(link, 1))
        })
    })?;
    Ok((memories, running))
}

/// What a client got: good answers, and the time of each, us.
#[derive(Default)]
struct Got {
    good: u32,
    times: Vec<u64>,
}

/// Asks units in turns until the time is over, `ahead` requests before the answers.
fn ask(to: SocketAddr, units: &[u8], until: Instant, ahead: usize) -> Result<Got, String> {
    let words = |error: std::io::Error| format!("a client of the gateway: {error}");
    let mut stream = TcpStream::connect(to).map_err(words)?;
    stream.set_nodelay(true).map_err(words)?;
    stream.set_read_timeout(Some(Duration::from_secs(10))).map_err(words)?;
    let mut got = Got::default();
    let mut received = Vec::new();
    for (n, unit) in units.iter().cycle().enumerate() {
        let begun = Instant::now();
        if begun >= until {
            break;
        }
        let pdu = vec![3, 0x13, 0x88, 0, REGISTERS];
        let message = Mbap { transaction: 1, unit: *unit, pdu };
        stream.write_all(&message.bytes()).map_err(words)?;
        if n < ahead {
            continue;
        }
        let reply = Mbap::read(&mut stream, &mut received).map_err(words)?;
        if reply.pdu[0] == 3 {
            got.good += 1;
            got.times.push(begun.elapsed().as_micros() as u64);
        }
    }
    Ok(got)
}

/// Clients that ask at the same time, each its units.
fn all(
    to: SocketAddr,
    clients: &[Vec<u8>],
    time: Duration,
    ahead: usize,
) -> Result<Vec<Got>, String> {
    let until = Instant::now() + time;
    std::thread::scope(|scope| {
        let threads: Vec<_> =
            clients.iter().map(|units| scope.spawn(move || ask(to, units, until, ahead))).collect();
        threads
            .into_iter()
            .map(|thread| thread.join().unwrap_or_else(|_| Err("a client panicked".to_owned())))
            .collect()
    })
}

/// How far the clients' numbers of answers differ, % of the largest one.
fn spread(got: &[Got]) -> f64 {
    let counts = || got.iter().map(|one| one.good);
    let (least, most) = (counts().min().unwrap_or(0), counts().max().unwrap_or(0));
    100.0 * f64::from(most - least) / f64::from(most.max(1))
}

/// Measures the group.
///
/// # Errors
/// A connection fails.
pub fn run(sink: Sink<'_>) -> Result<(), String> {
    // A client for each line, which goes round its boards.
    let (_memories, running) = stand(LINES)?;
    let units = |line: usize| -> Vec<u8> {
        (1..=BOARDS).map(|address| (FRESH + line * usize::from(BOARDS)) as u8 + address).collect()
    };
    let time = Duration::from_secs(3);
    let clients: Vec<Vec<u8>> = (0..LINES).map(units).collect();
    let got = all(running.address(), &clients, time, 0)?;
    let good: u32 = got.iter().map(|one| one.good).sum();
    let a_line = f64::from(good) / time.as_secs_f64() / LINES as f64;
    let wire = 1.0 / cycle(REGISTERS.into()).as_secs_f64();
    sink(at_least("gateway_line", "% of the wire", 100.0 * a_line / wire, 90.0, 95.0))?;
    let mut times: Vec<u64> = got.into_iter().flat_map(|one| one.times).collect();
    times.sort_unstable();
    let middle = times.get(times.len() / 2).copied().unwrap_or(u64::MAX) as f64 / 1000.0;
    let added = middle - cycle(REGISTERS.into()).as_secs_f64() * 1000.0;
    sink(at_most("gateway_added", "ms", added.max(0.0), 1.0, 0.3))?;
    // Ten clients on each line: none gets more than the others there. Each has requests ahead, so that this
    // computer's own turns for its threads do not show.
    let crowd: Vec<Vec<u8>> = clients.iter().flat_map(|units| vec![units.clone(); CROWD]).collect();
    let got = all(running.address(), &crowd, Duration::from_secs(4), 3)?;
    let unfair = got.chunks(CROWD).map(spread).fold(0.0, f64::max);
    sink(at_most("gateway_unfair", "%", unfair, 5.0, 3.0))?;
    drop(running);
    one_line(sink)
}

fn one_line(sink: Sink<'_>) -> Result<(), String> {
    let (memories, running) = stand(1)?;
    let to = running.address();
    let alive: Vec<u8> = (1..BOARDS).map(|address| FRESH as u8 + address).collect();
    let time = Duration::from_secs(4);
    let clients = vec![alive.clone(); 5];
    let got = all(to, &clients, time, 0)?;
    let before: u32 = got.iter().map(|one| one.good).sum();
    // The tenth board dies, and a client asks for nothing else.
    for memory in &memories {
        memory.lock().unwrap_or_else(std::sync::PoisonError::into_inner).dead.push(BOARDS);
    }
    let mut clients = clients;
    clients.push(vec![FRESH as u8 + BOARDS]);
    let got = all(to, &clients, time, 0)?;
    let after: u32 = got.iter().take(5).map(|one| one.good).sum();
    let cost = 100.0 * (1.0 - f64::from(after) / f64::from(before.max(1)));
    sink(at_most("gateway_dead_board", "%", cost.max(0.0), 10.0, 7.0))?;
    let time = Duration::from_secs(1);
    let got = all(to, &vec![vec![1]; 4], time, 0)?;
    let cached: u32 = got.iter().map(|one| one.good).sum();
    sink(at_least("gateway_cached", "reads/s", f64::from(cached), 2_000.0, 10_000.0))
}
