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
        // A zero timeout means "for ever" to the socket, and the shortest one takes as long as the system's
        // clock ticks: up to 10 ms of each exchange.
        let read = if patience.is_zero() {
            self.stream.set_nonblocking(true)?;
            let read = self.stream.read(buffer);
            self.stream.set_nonblocking(false)?;
            read
        } else {
            self.stream.set_read_timeout(Some(patience.max(Duration::from_millis(1))))?;
            self.stream.read(buffer)
        };
        match read {
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

#[cfg(test)]
mod tests {
    use super::Tcp;
    use crate::link::Link;
    use std::io::Write;
    use std::net::TcpListener;
    use std::time::{Duration, Instant};

    #[test]
    fn a_look_without_patience_takes_no_time_and_finds_what_is_there() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("a port").to_string();
        let mut link = Tcp::connect(&address).expect("it listens");
        let (mut other, _) = listener.accept().expect("it came");
        let mut buffer = [0; 8];
        let begun = Instant::now();
        for _ in 0..100 {
            assert_eq!(link.receive(&mut buffer, Duration::ZERO).expect("open"), 0);
        }
        assert!(begun.elapsed() < Duration::from_millis(90), "{:?}", begun.elapsed());
        other.write_all(b"abc").expect("open");
        assert_eq!(link.receive(&mut buffer, Duration::from_secs(5)).expect("open"), 3);
        other.write_all(b"de").expect("open");
        std::thread::sleep(Duration::from_millis(50));
        assert_eq!(link.receive(&mut buffer, Duration::ZERO).expect("open"), 2);
        drop(other);
        std::thread::sleep(Duration::from_millis(50));
        assert!(link.receive(&mut buffer, Duration::ZERO).is_err(), "the other side closed");
    }
}
