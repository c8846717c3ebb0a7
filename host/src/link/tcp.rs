//! The bytes of a connection over TCP: those of a serial line, or what carries Modbus TCP.

use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use super::{Link, Mode};

/// How long to wait for a connection.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);

/// A connection to a virtual board, a gateway or a serial device server.
pub struct Tcp {
    stream: TcpStream,
    opened: Instant,
}

impl Tcp {
    /// Connects to `PORT` on this machine or to `HOST:PORT`.
    ///
    /// # Errors
    /// The text says why no connection came about.
    pub fn connect(address: &str) -> Result<Tcp, String> {
        let full =
            if address.contains(':') { address.to_owned() } else { format!("127.0.0.1:{address}") };
        let failed = |error: io::Error| format!("{address} cannot be reached: {error}");
        let target = full
            .to_socket_addrs()
            .map_err(failed)?
            .next()
            .ok_or_else(|| format!("{address} names no host"))?;
        let stream = TcpStream::connect_timeout(&target, CONNECT_TIMEOUT).map_err(failed)?;
        stream.set_nodelay(true).map_err(failed)?;
        Ok(Tcp { stream, opened: Instant::now() })
    }
}

impl Link for Tcp {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.stream.write_all(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        // A zero timeout means "for ever" to the socket.
        self.stream.set_read_timeout(Some(patience.max(Duration::from_millis(1))))?;
        match self.stream.read(buffer) {
            Ok(0) => Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the other side closed")),
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
            result => result,
        }
    }

    fn now(&self) -> Duration {
        self.opened.elapsed()
    }

    fn pause(&mut self, time: Duration) {
        std::thread::sleep(time);
    }

    fn set_mode(&mut self, _mode: Mode) -> io::Result<bool> {
        Ok(false)
    }
}
