//! A serial port or a pseudo-terminal.

use std::io::{self, Read, Write};
use std::path::Path;
use std::sync::mpsc;
use std::time::{Duration, Instant};

use lang::profile::Parity;
use serialport::{ClearBuffer, SerialPort};

use super::trouble::Trouble;
#[cfg(unix)]
use super::turn::{Turn, Turns};
use super::{Link, Mode};

/// Longest time to open a port, twice that of waiting for a turn: a driver may hang for ever.
const OPENING: Duration = Duration::from_secs(10);

/// A serial device of the system.
pub struct Serial {
    path: String,
    port: Box<dyn SerialPort>,
    /// None where the port is ours alone.
    #[cfg(unix)]
    turns: Option<Turns>,
    opened: Instant,
    /// When we last let others have the line.
    #[cfg(unix)]
    given: Duration,
}

impl Serial {
    /// Opens the device `path` (`/dev/ttyACM0`, `COM3`, `COM12`, a link to a pseudo-terminal).
    ///
    /// # Errors
    /// The text says why, and what to do.
    pub fn open(path: &str) -> Result<Serial, String> {
        let (sender, receiver) = mpsc::channel();
        let name = path.to_owned();
        std::thread::spawn(move || {
            // Nobody waits any more when the deadline is over.
            let _ = sender.send(open(name));
        });
        let late = |_| Err(io::Error::new(io::ErrorKind::TimedOut, "it does not open"));
        receiver.recv_timeout(OPENING).unwrap_or_else(late).map_err(|error| {
            let remedy = Trouble::of(&error, path).remedy(path);
            format!("port {path} cannot be opened: {error}; {remedy}")
        })
    }

    /// Sets rate and parity; the line must be ours.
    fn apply(&mut self, mode: Mode) -> io::Result<bool> {
        let parity = parity(mode);
        self.port.set_baud_rate(mode.rate)?;
        // A pseudo-terminal has no parity and may refuse to be told of one.
        let has_parity = self.port.set_parity(parity).is_ok();
        if !has_parity && mode.parity != Parity::None {
            return Ok(false);
        }
        self.port.clear(ClearBuffer::Input)?;
        Ok(true)
    }

    /// The error, in plain words where the device is gone.
    fn explained(&self, error: io::Error) -> io::Error {
        if Path::new(&self.path).exists() || cfg!(windows) {
            return error;
        }
        let remedy = Trouble::Gone.remedy(&self.path);
        io::Error::new(io::ErrorKind::NotConnected, format!("{} is gone: {remedy}", self.path))
    }
}

fn parity(mode: Mode) -> serialport::Parity {
    match mode.parity {
        Parity::None => serialport::Parity::None,
        Parity::Even => serialport::Parity::Even,
        Parity::Odd => serialport::Parity::Odd,
    }
}

/// Opens the port, in its turn: to open it changes its rate.
#[cfg(unix)]
fn open(path: String) -> io::Result<Serial> {
    let turns = Turns::of(&path)?;
    let shared = turns.take()? != Turn::NoLocks;
    let port = builder(&path).exclusive(!shared).open();
    turns.give();
    let port = port.map_err(plain)?;
    let turns = shared.then_some(turns);
    Ok(Serial { path, port, turns, opened: Instant::now(), given: Duration::ZERO })
}

#[cfg(not(unix))]
fn open(path: String) -> io::Result<Serial> {
    let port = builder(&path).open().map_err(plain)?;
    Ok(Serial { path, port, opened: Instant::now() })
}

fn builder(path: &str) -> serialport::SerialPortBuilder {
    serialport::new(path, Mode::DEFAULT.rate).timeout(Duration::from_millis(50))
}

/// The library says "no device" of one that is not there, and of one that another program has.
fn plain(error: serialport::Error) -> io::Error {
    let kind = match error.kind() {
        serialport::ErrorKind::NoDevice if cfg!(unix) => io::ErrorKind::ResourceBusy,
        serialport::ErrorKind::NoDevice => io::ErrorKind::NotFound,
        serialport::ErrorKind::Io(kind) => kind,
        _ => io::ErrorKind::Other,
    };
    io::Error::new(kind, error.description)
}

impl Link for Serial {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let sent = self.port.write_all(bytes).and_then(|()| self.port.flush());
        sent.map_err(|error| self.explained(error))
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        self.port.set_timeout(patience)?;
        match self.port.read(buffer) {
            // The end of a device that is gone, and of a pseudo-terminal whose other end closed: it
            // comes at once, so that a caller that waits for a reply would spin.
            Ok(0) if !Path::new(&self.path).exists() && cfg!(unix) => {
                Err(self.explained(io::ErrorKind::UnexpectedEof.into()))
            }
            Ok(0) => {
                std::thread::sleep(patience.min(Duration::from_millis(10)));
                Ok(0)
            }
            Err(error)
                if matches!(
                    error.kind(),
                    io::ErrorKind::TimedOut
                        | io::ErrorKind::WouldBlock
                        | io::ErrorKind::Interrupted
                ) =>
            {
                Ok(0)
            }
            result => result.map_err(|error| self.explained(error)),
        }
    }

    fn now(&self) -> Duration {
        self.opened.elapsed()
    }

    fn pause(&mut self, time: Duration) {
        std::thread::sleep(time);
    }

    fn set_mode(&mut self, mode: Mode) -> io::Result<bool> {
        self.claim(mode)?;
        let set = self.apply(mode);
        self.release();
        set.map_err(|error| self.explained(error))
    }

    #[cfg(unix)]
    fn claim(&mut self, mode: Mode) -> io::Result<bool> {
        let Some(turns) = &self.turns else { return Ok(false) };
        let turn = turns.take()?;
        // Nobody else's exchange fits into less: it begins with the line's rest.
        let others = turn == Turn::Waited || self.now() > self.given + 2 * mode.silence();
        // Another process may look for a board that has another rate.
        let same = self.port.baud_rate().is_ok_and(|rate| rate == mode.rate)
            && self.port.parity().is_ok_and(|own| own == parity(mode));
        if !same && let Err(error) = self.apply(mode) {
            self.release();
            return Err(self.explained(error));
        }
        Ok(others)
    }

    #[cfg(unix)]
    fn release(&mut self) {
        if let Some(turns) = &self.turns {
            turns.give();
            self.given = self.opened.elapsed();
        }
    }
}
