//! The Grbl server in front of a virtual board in real time: lines, a jog's cancel, status.

use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::sync::Arc;
use std::time::{Duration, Instant};

use lang::profile::Profile;

use super::{Sink, at_least, at_most};
use crate::board::DEFAULT;
use crate::board::live::Live;
use crate::grbl::port::Ports;
use crate::grbl::{Server, Setting};
use crate::sim::world::World;

/// Lines of the job, 0.1 mm each.
const LINES: usize = 2_000;
/// Characters that a client has on the way at most.
const WINDOW: usize = 127;
/// Longest wait for an answer.
const PATIENCE: Duration = Duration::from_secs(60);

/// A client that counts characters.
struct Talk {
    stream: TcpStream,
    heard: String,
}

impl Talk {
    fn read(&mut self) -> Result<(), String> {
        let mut bytes = [0; 4096];
        match self.stream.read(&mut bytes) {
            Ok(0) => Err("the server closed".to_owned()),
            Ok(count) => {
                self.heard += &String::from_utf8_lossy(&bytes[..count]);
                Ok(())
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                Ok(())
            }
            Err(error) => Err(error.to_string()),
        }
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.stream.write_all(bytes).map_err(|error| error.to_string())
    }

    /// Reads until a text is there.
    fn until(&mut self, text: &str) -> Result<(), String> {
        let begun = Instant::now();
        while !self.heard.contains(text) {
            self.read()?;
            if begun.elapsed() > PATIENCE {
                return Err(format!("no {text:?} in {:?}", self.heard));
            }
        }
        Ok(())
    }

    /// Asks for reports until one has a state.
    fn state(&mut self, state: &str) -> Result<(), String> {
        let begun = Instant::now();
        loop {
            self.heard.clear();
            self.send(b"?")?;
            self.until(">")?;
            if self.heard.contains(&format!("<{state}|")) {
                return Ok(());
            }
            if begun.elapsed() > PATIENCE {
                return Err(format!("never {state}: {:?}", self.heard));
            }
        }
    }

    /// Sends lines with no more than [`WINDOW`] characters unanswered.
    fn job(&mut self, lines: &[String]) -> Result<(), String> {
        let (mut open, mut next) = (std::collections::VecDeque::new(), 0);
        self.heard.clear();
        while next < lines.len() || !open.is_empty() {
            while next < lines.len() && open.iter().sum::<usize>() + lines[next].len() <= WINDOW {
                self.send(lines[next].as_bytes())?;
                open.push_back(lines[next].len());
                next += 1;
            }
            self.read()?;
            while let Some((line, rest)) = self.heard.split_once("\r\n") {
                if line != "ok" {
                    return Err(line.to_owned());
                }
                open.pop_front();
                self.heard = rest.to_owned();
            }
        }
        Ok(())
    }
}

/// Figures `grbl_lines`: short lines a second through server, link and board on a machine with steep
/// ramps; `grbl_cancel`: from a jog's cancel at 50 mm/s to Idle, less its ramp of 200 ms; `grbl_status`:
/// the median time of a report while a job runs.
///
/// # Errors
/// The server or the board does not do it.
pub fn run(sink: Sink<'_>) -> Result<(), String> {
    let mut profile = Profile::built_in("mill").map_err(|error| error.to_string())?;
    for axis in profile.x.iter_mut().chain(&mut profile.y) {
        axis.accel = 2_000_000;
    }
    let mut talk = Bench::start(&profile)?;
    let line = |n: usize| format!("G1X{:.1}\n", (n % 1000) as f64 / 10.0 + 0.1);
    let lines: Vec<String> = (0..LINES).map(line).collect();
    talk.talk.job(&["G21G90F60000\n".to_owned(), "G4P0\n".to_owned()])?;
    let begun = Instant::now();
    talk.talk.job(&lines)?;
    talk.talk.job(&["G4P0\n".to_owned()])?;
    let rate = LINES as f64 / begun.elapsed().as_secs_f64();
    sink(at_least("grbl_lines", "lines/s", rate, 1500.0, 1500.0))?;
    drop(talk);

    let profile = Profile::built_in("mill").map_err(|error| error.to_string())?;
    let mut talk = Bench::start(&profile)?;
    talk.talk.job(&["$J=G91X200F3000\n".to_owned()])?;
    std::thread::sleep(Duration::from_secs(1));
    let mut times = Vec::new();
    for _ in 0..50 {
        let begun = Instant::now();
        talk.talk.state("Jog")?;
        times.push(begun.elapsed().as_secs_f64() * 1000.0);
        std::thread::sleep(Duration::from_millis(10));
    }
    times.sort_by(f64::total_cmp);
    let begun = Instant::now();
    talk.talk.send(b"\x85")?;
    talk.talk.state("Idle")?;
    let ramp = 200.0;
    let cancel = begun.elapsed().as_secs_f64() * 1000.0 - ramp;
    sink(at_most("grbl_cancel", "ms", cancel, 100.0, 100.0))?;
    sink(at_most("grbl_status", "ms", times[times.len() / 2], 10.0, 10.0))
}

/// A server with its board and its client.
struct Bench {
    talk: Talk,
    _server: Server,
}

impl Bench {
    fn start(profile: &Profile) -> Result<Bench, String> {
        let live = Live::start(DEFAULT, profile, &World::empty());
        let live = Arc::new(live.map_err(|_| "the virtual board does not start".to_owned())?);
        let mut ports = Ports::default();
        let address = ports.listen(SocketAddr::from((Ipv4Addr::LOCALHOST, 0)))?;
        let setting = Setting {
            profile: profile.clone(),
            offsets: None,
            name: "bench".to_owned(),
            tells: false,
        };
        let server = Server::start(setting, ports, Box::new(move || live.connect()))?;
        let words = |error: std::io::Error| error.to_string();
        let stream = TcpStream::connect(address).map_err(words)?;
        stream.set_nodelay(true).map_err(words)?;
        stream.set_read_timeout(Some(Duration::from_millis(5))).map_err(words)?;
        let mut talk = Talk { stream, heard: String::new() };
        talk.until("Grbl 1.1h")?;
        talk.state("Idle")?;
        talk.heard.clear();
        Ok(Bench { talk, _server: server })
    }
}
