//! The client's port: a TCP connection, a pseudo-terminal or a serial port. One client drives; another
//! one that connects meanwhile gets a message and is disconnected.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::time::{Duration, Instant};

use lang::profile::Parity;

use crate::link::{Link, Mode, Serial};

/// Bytes of answers that a client may leave unread; then it is gone.
const MOST_UNREAD: usize = 65_536;
/// Longest wait for a client's system to take bytes.
const WRITE: Duration = Duration::from_millis(1);
/// Longest wait for a byte while nobody drives.
const CALM: Duration = Duration::from_millis(20);
/// A client at a serial port that was silent for so long is gone: nobody tells when its cable is pulled.
pub const SILENT: Duration = Duration::from_secs(10);
/// Between two tries to open a serial port that was lost.
const AGAIN: Duration = Duration::from_secs(1);
/// What a second client is told.
const TAKEN: &[u8] = b"[MSG:another client drives this machine]\r\n";

/// What has happened at the ports.
#[derive(Debug, PartialEq, Eq)]
pub enum Event {
    /// A client came, from there.
    Came(String),
    /// Bytes of the client.
    Bytes(Vec<u8>),
    /// The client is gone.
    Gone,
    /// Nothing within the time.
    Nothing,
}

/// All ways in.
#[derive(Default)]
pub struct Ports {
    ways: Vec<Way>,
    /// Which one drives, and what it has not taken yet.
    client: Option<(usize, Vec<u8>)>,
}

enum Way {
    Tcp {
        listener: TcpListener,
        stream: Option<TcpStream>,
    },
    #[cfg(unix)]
    Pty(pty::Pty),
    Serial {
        path: String,
        mode: Mode,
        port: Option<Serial>,
        open_at: Instant,
        heard: Instant,
    },
}

impl Ports {
    /// Adds a TCP port; its address comes back.
    ///
    /// # Errors
    /// It cannot be listened on; in words.
    pub fn listen(&mut self, address: SocketAddr) -> Result<SocketAddr, String> {
        let words = |error: io::Error| format!("{address} cannot be listened on: {error}");
        let listener = TcpListener::bind(address).map_err(words)?;
        listener.set_nonblocking(true).map_err(words)?;
        let address = listener.local_addr().map_err(words)?;
        self.ways.push(Way::Tcp { listener, stream: None });
        Ok(address)
    }

    /// Adds a pseudo-terminal, with a link to it.
    ///
    /// # Errors
    /// There is none to be had here, or the link cannot be made; in words.
    #[cfg(unix)]
    pub fn pty(&mut self, link: &Path) -> Result<(), String> {
        let pty = pty::Pty::open(link)
            .map_err(|error| format!("{} cannot be made: {error}", link.display()))?;
        self.ways.push(Way::Pty(pty));
        Ok(())
    }

    /// Systems without pseudo-terminals use TCP.
    ///
    /// # Errors
    /// Always.
    #[cfg(not(unix))]
    pub fn pty(&mut self, _link: &Path) -> Result<(), String> {
        Err("there are no pseudo-terminals here: use --tcp".to_owned())
    }

    /// Adds a serial port that another computer is wired to.
    ///
    /// # Errors
    /// It cannot be opened; in words.
    pub fn serial(&mut self, path: &str, rate: u32) -> Result<(), String> {
        let mode = Mode { rate, parity: Parity::None };
        let port = Some(open(path, mode)?);
        let now = Instant::now();
        let path = path.to_owned();
        // Nobody has been heard yet.
        let heard = now.checked_sub(SILENT).unwrap_or(now);
        self.ways.push(Way::Serial { path, mode, port, open_at: now, heard });
        Ok(())
    }

    /// Whether somebody drives.
    pub fn is_driven(&self) -> bool {
        self.client.is_some()
    }

    /// Waits for something to happen.
    pub fn wait(&mut self, wait: Duration) -> Event {
        self.flush();
        match self.client.as_ref().map(|(driver, _)| *driver) {
            Some(driver) => {
                self.refuse_others(driver);
                self.hear(driver, wait)
            }
            None => self.meet(),
        }
    }

    /// Puts bytes behind what the client has not taken yet.
    pub fn send(&mut self, bytes: &[u8]) {
        if let Some((_, unread)) = &mut self.client {
            unread.extend(bytes);
        }
        self.flush();
    }

    fn flush(&mut self) {
        let Some((driver, unread)) = &mut self.client else { return };
        while !unread.is_empty() {
            match self.ways[*driver].write(unread) {
                Ok(count) if count > 0 => drop(unread.drain(..count)),
                _ => break,
            }
        }
    }

    fn hear(&mut self, driver: usize, wait: Duration) -> Event {
        let mut bytes = vec![0; 512];
        let full = self.client.as_ref().is_some_and(|(_, unread)| unread.len() > MOST_UNREAD);
        match self.ways[driver].read(&mut bytes, wait) {
            Ok(count) if !full => {
                bytes.truncate(count);
                if bytes.is_empty() { Event::Nothing } else { Event::Bytes(bytes) }
            }
            _ => {
                self.ways[driver].leave();
                self.client = None;
                Event::Gone
            }
        }
    }

    /// Looks for a client at every way.
    fn meet(&mut self) -> Event {
        for (n, way) in self.ways.iter_mut().enumerate() {
            if let Some(name) = way.meet() {
                self.client = Some((n, Vec::new()));
                return Event::Came(name);
            }
        }
        std::thread::sleep(CALM);
        Event::Nothing
    }

    fn refuse_others(&mut self, driver: usize) {
        for (n, way) in self.ways.iter_mut().enumerate() {
            way.refuse(n == driver);
        }
    }
}

fn open(path: &str, mode: Mode) -> Result<Serial, String> {
    let mut port = Serial::open(path)?;
    port.set_mode(mode).map_err(|error| format!("{path}: {error}"))?;
    Ok(port)
}

fn waits(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}

impl Way {
    /// A client that is there now.
    fn meet(&mut self) -> Option<String> {
        match self {
            Way::Tcp { listener, stream } => {
                let (new, from) = listener.accept().ok()?;
                new.set_nonblocking(false).ok()?;
                new.set_nodelay(true).ok()?;
                new.set_write_timeout(Some(WRITE)).ok()?;
                *stream = Some(new);
                Some(from.to_string())
            }
            #[cfg(unix)]
            Way::Pty(pty) => pty.is_open().then(|| pty.name()),
            Way::Serial { path, mode, port, open_at, heard } => {
                if port.is_none() && Instant::now() >= *open_at {
                    *port = open(path, *mode).ok();
                    *open_at = Instant::now() + AGAIN;
                }
                // The cable is there, whoever is at its end; the welcome goes out once.
                port.as_ref()?;
                *heard = Instant::now();
                Some(path.clone())
            }
        }
    }

    /// Lets one of the others than the driver go: of as many as come, none keeps the driver from being heard.
    fn refuse(&mut self, drives: bool) {
        match self {
            Way::Tcp { listener, .. } => {
                if let Ok((mut second, _)) = listener.accept() {
                    let _ = second.set_nonblocking(false);
                    let _ = second.set_write_timeout(Some(WRITE));
                    let _ = second.write_all(TAKEN);
                    // Dropped with bytes unread it would be reset, and the words with it.
                    let _ = second.shutdown(std::net::Shutdown::Write);
                    let _ = second.set_read_timeout(Some(WRITE));
                    let _ = second.read(&mut [0; 512]);
                }
            }
            #[cfg(unix)]
            Way::Pty(pty) => {
                if !drives {
                    pty.refuse(TAKEN);
                }
            }
            Way::Serial { port, .. } => {
                let mut heard = [0; 64];
                if !drives
                    && let Some(own) = port
                    && own.receive(&mut heard, Duration::ZERO).is_ok_and(|count| count > 0)
                {
                    let _ = own.send(TAKEN);
                }
            }
        }
    }

    fn read(&mut self, bytes: &mut [u8], wait: Duration) -> io::Result<usize> {
        match self {
            Way::Tcp { stream: Some(stream), .. } => {
                stream.set_read_timeout(Some(wait))?;
                match stream.read(bytes) {
                    Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
                    Err(error) if waits(&error) => Ok(0),
                    other => other,
                }
            }
            Way::Tcp { .. } => Err(ErrorKind::NotConnected.into()),
            #[cfg(unix)]
            Way::Pty(pty) => pty.read(bytes, wait),
            Way::Serial { port, heard, .. } => {
                let own = port.as_mut().ok_or(ErrorKind::NotConnected)?;
                match own.receive(bytes, wait) {
                    Ok(0) if heard.elapsed() > SILENT => Err(ErrorKind::TimedOut.into()),
                    Ok(count) => {
                        if count > 0 {
                            *heard = Instant::now();
                        }
                        Ok(count)
                    }
                    Err(error) => {
                        *port = None;
                        Err(error)
                    }
                }
            }
        }
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Way::Tcp { stream: Some(stream), .. } => stream.write(bytes),
            Way::Tcp { .. } => Err(ErrorKind::NotConnected.into()),
            #[cfg(unix)]
            Way::Pty(pty) => pty.write(bytes),
            Way::Serial { port, .. } => {
                let own = port.as_mut().ok_or(ErrorKind::NotConnected)?;
                own.send(bytes).map(|()| bytes.len())
            }
        }
    }

    fn leave(&mut self) {
        if let Way::Tcp { stream, .. } = self {
            *stream = None;
        }
    }
}

#[cfg(unix)]
mod pty {
    //! A pseudo-terminal that knows whether its far end is open.

    use std::fs;
    use std::io::{self, ErrorKind, Read, Write};
    use std::path::{Path, PathBuf};
    use std::time::Duration;

    use serialport::{SerialPort, TTYPort};

    use super::{WRITE, waits};

    /// See the module.
    pub struct Pty {
        master: TTYPort,
        device: String,
        link: PathBuf,
        /// Bytes that came when it was looked at.
        early: Vec<u8>,
        refused: bool,
    }

    impl Pty {
        /// Opens one and makes a link to it.
        pub fn open(link: &Path) -> io::Result<Pty> {
            // The far end is closed again: the master then reads errors until a client opens it.
            let (master, slave) = TTYPort::pair()?;
            let device = slave.name().unwrap_or_default();
            drop(slave);
            crate::board::pty::make_link(&device, link)?;
            let link = link.to_owned();
            Ok(Pty { master, device, link, early: Vec::new(), refused: false })
        }

        pub fn name(&self) -> String {
            self.link.display().to_string()
        }

        /// Whether a client has it open.
        pub fn is_open(&mut self) -> bool {
            let mut bytes = [0; 512];
            match self.read(&mut bytes, Duration::ZERO) {
                Ok(count) => {
                    self.early.extend(&bytes[..count]);
                    true
                }
                Err(_) => false,
            }
        }

        /// Tells a client that it is one too many, once; what it says is not heard.
        pub fn refuse(&mut self, words: &[u8]) {
            let open = self.is_open();
            self.early.clear();
            if open && !self.refused {
                let _ = self.write(words);
            }
            self.refused = open;
        }

        pub fn read(&mut self, bytes: &mut [u8], wait: Duration) -> io::Result<usize> {
            if !self.early.is_empty() {
                let count = self.early.len().min(bytes.len());
                bytes[..count].copy_from_slice(&self.early[..count]);
                self.early.drain(..count);
                return Ok(count);
            }
            self.master.set_timeout(wait)?;
            match self.master.read(bytes) {
                Err(error) if waits(&error) => Ok(0),
                Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
                other => other,
            }
        }

        pub fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.master.set_timeout(WRITE)?;
            self.master.write(bytes)
        }
    }

    impl Drop for Pty {
        fn drop(&mut self) {
            if fs::read_link(&self.link).is_ok_and(|target| target == Path::new(&self.device)) {
                let _ = fs::remove_file(&self.link);
            }
        }
    }
}
