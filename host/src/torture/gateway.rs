//! Kind `gateway`: clients that say nothing, half of it, garbage, or leave in the middle, boards that die
//! and come back, while another client must get each of its answers, the right one, in time.

use std::io::Write;
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use emulator::Rng;

use super::{Row, Settings, Sink, Verdict};
use crate::client::Client;
use crate::gateway::light::{self, Light, Memory, first_value};
use crate::gateway::{Config, Running};
use crate::link::Link;
use crate::link::adu::Mbap;

/// Boards: the last one dies and lives.
const BOARDS: u8 = 3;
/// Connections at a time that the gateway of a case takes.
const ROOM: u64 = 40;
/// Longest wait for an answer, on a loaded machine too.
const PATIENCE: Duration = Duration::from_secs(5);
/// What the honest client asks in a case.
const QUESTIONS: u16 = 15;

/// Tries the kind.
///
/// # Errors
/// The sink refuses.
pub fn run(settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    let fault = "clients without manners, dead boards";
    let mut row = Row::new("gateway", fault, settings);
    let count = settings.count(4, 100, 5_000);
    row.run(settings, count, |n| case(&mut settings.rng(fault, n)));
    sink(row)
}

fn stand(memory: &Arc<Mutex<Memory>>) -> Result<Running, String> {
    let mut text = format!("[modbus]\nlisten = \"127.0.0.1:0\"\nclients = {ROOM}\n");
    for address in 1..=BOARDS {
        text += &format!("[[board]]\nname = \"b{address}\"\nport = \"p\"\naddress = {address}\n");
    }
    let config = Config::parse("case", &text).map_err(|note| note.text)?;
    Running::with(&config, |_, _| {
        let memory = memory.clone();
        Box::new(move || {
            let link: Box<dyn Link> = Box::new(Light::new(memory.clone()));
            Ok(Client::new(link, 1))
        })
    })
}

fn case(rng: &mut Rng) -> Verdict {
    let addresses: Vec<u8> = (1..=BOARDS).collect();
    let memory = light::boards(&addresses);
    let running = match stand(&memory) {
        Ok(running) => running,
        Err(why) => return Verdict::Lost(why),
    };
    let over = AtomicBool::new(false);
    let seeds: Vec<u64> = (0..3).map(|_| rng.bits()).collect();
    let dies = rng.bits();
    std::thread::scope(|scope| {
        for seed in seeds {
            let (to, over) = (running.address(), &over);
            scope.spawn(move || rude(&mut Rng::new(seed), to, over));
        }
        let (memory, ended) = (&memory, &over);
        scope.spawn(move || {
            let mut rng = Rng::new(dies);
            while !ended.load(Ordering::Relaxed) {
                let dead = if rng.below(2) == 0 { vec![BOARDS] } else { Vec::new() };
                memory.lock().unwrap_or_else(PoisonError::into_inner).dead = dead;
                std::thread::sleep(Duration::from_millis(rng.below(60)));
            }
        });
        let said = honest(running.address());
        over.store(true, Ordering::Relaxed);
        said.map_or_else(Verdict::Lost, |()| Verdict::Survived)
    })
}

/// A client that asks boards that live, and looks at each answer.
fn honest(to: SocketAddr) -> Result<(), String> {
    let words = |error: std::io::Error| format!("the honest client: {error}");
    let mut stream = TcpStream::connect(to).map_err(words)?;
    stream.set_read_timeout(Some(PATIENCE)).map_err(words)?;
    let mut received = Vec::new();
    for n in 0..QUESTIONS {
        let unit = (n % u16::from(BOARDS - 1)) as u8 + 1;
        let [high, low] = n.to_be_bytes();
        let message = Mbap { transaction: n, unit, pdu: vec![3, high, low, 0, 1] };
        let begun = Instant::now();
        stream.write_all(&message.bytes()).map_err(words)?;
        let reply = Mbap::read(&mut stream, &mut received).map_err(words)?;
        let pdu = [vec![3, 2], first_value(unit, n).to_be_bytes().to_vec()].concat();
        let wanted = Mbap { transaction: n, unit, pdu };
        if reply != wanted {
            return Err(format!("{reply:?} instead of {wanted:?}"));
        }
        if begun.elapsed() > PATIENCE {
            return Err(format!("question {n} took {:?}", begun.elapsed()));
        }
    }
    Ok(())
}

/// A client that does what it should not, again and again.
fn rude(rng: &mut Rng, to: SocketAddr, over: &AtomicBool) {
    let mut kept = Vec::new();
    while !over.load(Ordering::Relaxed) {
        let Ok(mut stream) = TcpStream::connect(to) else { continue };
        let request = |rng: &mut Rng| {
            let pdu: Vec<u8> = match rng.below(3) {
                0 => vec![3, 0, rng.below(256) as u8, 0, rng.below(140) as u8],
                1 => vec![6, 11, rng.below(256) as u8, 0, rng.below(256) as u8],
                _ => (0..=rng.below(20)).map(|_| rng.below(256) as u8).collect(),
            };
            Mbap { transaction: rng.below(65_536) as u16, unit: rng.below(6) as u8, pdu }.bytes()
        };
        let bytes: Vec<u8> = match rng.below(5) {
            0 => Vec::new(),
            1 => (0..rng.below(400)).map(|_| rng.below(256) as u8).collect(),
            2 => request(rng)[..3].to_vec(),
            3 => (0..30).flat_map(|_| request(rng)).collect(),
            _ => request(rng),
        };
        let _ = stream.write_all(&bytes);
        // Some stay, some wait a little, some leave at once.
        match rng.below(4) {
            0 if (kept.len() as u64) < ROOM => kept.push(stream),
            1 => std::thread::sleep(Duration::from_millis(rng.below(20))),
            _ => {}
        }
    }
}
