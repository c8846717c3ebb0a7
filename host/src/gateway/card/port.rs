//! The port of a card's client: a serial port, a pseudo-terminal or a TCP connection. One client at a time.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use lang::profile::Parity;

use super::setting::CardSetting;
use crate::board::pty::Pty;
use crate::link::{Link, Mode, Serial};

/// A client that takes its answers for so long no more is gone.
const WRITE_TIME: Duration = Duration::from_secs(2);
/// A silent client makes room for another one after this.
const SILENT: Duration = Duration::from_secs(60);
/// Between two tries to open a serial port that was lost.
const AGAIN: Duration = Duration::from_secs(1);

/// See the module.
pub struct Port {
    name: String,
    way: Way,
}

enum Way {
    Tcp { listener: TcpListener, client: Option<(TcpStream, Instant)> },
    Pty(Pty),
    Serial { path: String, mode: Mode, port: Option<Serial>, open_at: Instant },
}

impl Port {
    /// Opens the place that the setting names.
    ///
    /// # Errors
    /// It cannot be opened; in words.
    pub fn open(setting: &CardSetting) -> Result<Port, String> {
        if let Some(address) = setting.listen {
            let words = |error: std::io::Error| format!("{address} cannot be listened on: {error}");
            let listener = TcpListener::bind(address).map_err(words)?;
            listener.set_nonblocking(true).map_err(words)?;
            let name = format!("tcp:{}", listener.local_addr().map_err(words)?);
            return Ok(Port { name, way: Way::Tcp { listener, client: None } });
        }
        if let Some(link) = &setting.pty {
            let pty = Pty::open(Some(link))
                .map_err(|error| format!("{} cannot be made: {error}", link.display()))?;
            return Ok(Port { name: link.display().to_string(), way: Way::Pty(pty) });
        }
        let path = setting.port.clone().unwrap_or_default();
        let mode = Mode { rate: setting.rate, parity: Parity::None };
        let port = Some(open(&path, mode)?);
        let way = Way::Serial { path: path.clone(), mode, port, open_at: Instant::now() };
        Ok(Port { name: path, way })
    }

    /// For people.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Appends what has come, waiting a moment for it. `false`: the client that was there is gone.
    pub fn read(&mut self, bytes: &mut Vec<u8>, wait: Duration) -> bool {
        match &mut self.way {
            Way::Tcp { listener, client } => {
                accept(listener, client);
                match client {
                    None => {
                        std::thread::sleep(wait);
                        true
                    }
                    Some((stream, heard)) => {
                        let there = read(stream, bytes);
                        if !bytes.is_empty() {
                            *heard = Instant::now();
                        }
                        if !there {
                            *client = None;
                        }
                        there
                    }
                }
            }
            // Their other end is a cable: nobody tells when it is pulled.
            Way::Pty(pty) => {
                pty.read(bytes, wait);
                true
            }
            Way::Serial { path, mode, port, open_at } => {
                let Some(serial) = port else {
                    if Instant::now() >= *open_at {
                        *port = open(path, *mode).ok();
                        *open_at = Instant::now() + AGAIN;
                    }
                    std::thread::sleep(wait);
                    return true;
                };
                let mut buffer = [0; 256];
                match serial.receive(&mut buffer, wait) {
                    Ok(count) => bytes.extend(&buffer[..count]),
                    Err(_) => *port = None,
                }
                port.is_some()
            }
        }
    }

    /// Sends bytes to the client, if there is one.
    pub fn write(&mut self, bytes: &[u8]) {
        match &mut self.way {
            Way::Tcp { client, .. } => {
                if let Some((stream, _)) = client
                    && stream.write_all(bytes).is_err()
                {
                    // The next read finds it closed.
                    let _ = stream.shutdown(std::net::Shutdown::Both);
                }
            }
            Way::Pty(pty) => pty.write(bytes),
            Way::Serial { port, .. } => {
                if port.as_mut().is_some_and(|serial| serial.send(bytes).is_err()) {
                    *port = None;
                }
            }
        }
    }
}

fn open(path: &str, mode: Mode) -> Result<Serial, String> {
    let mut port = Serial::open(path)?;
    port.set_mode(mode).map_err(|error| format!("{path}: {error}"))?;
    Ok(port)
}

/// Takes a client where none is; one more is let go unless the first one has been silent for long.
fn accept(listener: &TcpListener, client: &mut Option<(TcpStream, Instant)>) {
    let Ok((stream, _)) = listener.accept() else { return };
    if client.as_ref().is_some_and(|(_, heard)| heard.elapsed() < SILENT) {
        return;
    }
    let ready = stream
        .set_nonblocking(false)
        .and_then(|()| stream.set_nodelay(true))
        .and_then(|()| stream.set_read_timeout(Some(super::WAIT)))
        .and_then(|()| stream.set_write_timeout(Some(WRITE_TIME)));
    if ready.is_ok() {
        *client = Some((stream, Instant::now()));
    }
}

fn read(stream: &mut TcpStream, bytes: &mut Vec<u8>) -> bool {
    let mut buffer = [0; 512];
    match stream.read(&mut buffer) {
        Ok(0) => false,
        Ok(count) => {
            bytes.extend(&buffer[..count]);
            true
        }
        Err(error) => matches!(
            error.kind(),
            ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
        ),
    }
}
