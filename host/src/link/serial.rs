//! A serial port or a pseudo-terminal.

use std::io::{self, Read, Write};
use std::time::{Duration, Instant};

use lang::profile::Parity;
use serialport::{ClearBuffer, SerialPort};

use super::{Link, Mode};

/// A serial device of the system.
pub struct Serial {
    port: Box<dyn SerialPort>,
    opened: Instant,
}

impl Serial {
    /// Opens the device `path` (`/dev/ttyACM0`, `COM3`, a link to a pseudo-terminal).
    ///
    /// # Errors
    /// The text says why, and for the usual reasons what to do.
    pub fn open(path: &str) -> Result<Serial, String> {
        let builder = serialport::new(path, Mode::DEFAULT.rate).timeout(Duration::from_millis(50));
        match builder.open() {
            Ok(port) => Ok(Serial { port, opened: Instant::now() }),
            Err(error) => Err(explain(path, &error)),
        }
    }
}

fn explain(path: &str, error: &serialport::Error) -> String {
    let text = format!("port {path} cannot be opened: {error}");
    match error.kind() {
        serialport::ErrorKind::Io(io::ErrorKind::PermissionDenied) => {
            format!("{text}; on Linux your user must be in the group that owns it (often dialout)")
        }
        serialport::ErrorKind::NoDevice | serialport::ErrorKind::Io(io::ErrorKind::NotFound) => {
            match ports() {
                known if known.is_empty() => format!("{text}; no serial port was found"),
                known => format!("{text}; there are {}", known.join(", ")),
            }
        }
        _ => text,
    }
}

/// Names of the system's serial ports; empty when the system does not tell.
fn ports() -> Vec<String> {
    let known = serialport::available_ports().unwrap_or_default();
    known.into_iter().map(|port| port.port_name).collect()
}

impl Link for Serial {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.port.write_all(bytes)?;
        self.port.flush()
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        self.port.set_timeout(patience)?;
        match self.port.read(buffer) {
            // A pseudo-terminal whose other end closed reads 0 bytes at once: without the pause a
            // caller that waits for a reply would spin.
            Ok(0) => {
                std::thread::sleep(patience.min(Duration::from_millis(10)));
                Ok(0)
            }
            Err(error)
                if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock) =>
            {
                Ok(0)
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => Ok(0),
            result => result,
        }
    }

    fn now(&self) -> Duration {
        self.opened.elapsed()
    }

    fn pause(&mut self, time: Duration) {
        std::thread::sleep(time);
    }

    fn set_mode(&mut self, mode: Mode) -> io::Result<bool> {
        let parity = match mode.parity {
            Parity::None => serialport::Parity::None,
            Parity::Even => serialport::Parity::Even,
            Parity::Odd => serialport::Parity::Odd,
        };
        self.port.set_baud_rate(mode.rate)?;
        // A pseudo-terminal has no parity and may refuse to be told of one.
        let has_parity = self.port.set_parity(parity).is_ok();
        if !has_parity && mode.parity != Parity::None {
            return Ok(false);
        }
        self.port.clear(ClearBuffer::Input)?;
        Ok(true)
    }
}
