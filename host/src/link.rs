//! Ways to a board: a serial port or a pseudo-terminal, Modbus TCP, the bytes of a line over TCP, or
//! an emulator in this process.
//!
//! A link moves bytes and has a clock of its own, so that the same client code talks to a real
//! port in real time and to an emulated board in its simulated time.

pub mod adu;
mod holders;
mod modbus_tcp;
pub mod mover;
mod pipe;
mod serial;
mod tcp;
mod trouble;
#[cfg(unix)]
mod turn;

use std::fmt;
use std::io;
use std::time::Duration;

use lang::profile::Parity;

pub use modbus_tcp::ModbusTcp;
pub use pipe::{Pipe, pipe};
pub use serial::Serial;
pub use tcp::Tcp;

/// Bits per second and parity of a serial line; 8 data bits, 1 stop bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mode {
    /// Bits per second.
    pub rate: u32,
    /// Parity bit.
    pub parity: Parity,
}

impl Mode {
    /// What a board has when nobody changed it.
    pub const DEFAULT: Mode = Mode { rate: 115_200, parity: Parity::None };

    /// Every mode that a board can have, in the order in which to try them: the default, the one
    /// that Stop at reset gives, and what the Modbus standard asks for come first.
    pub fn all() -> impl Iterator<Item = Mode> {
        let parities = [Parity::None, Parity::Even, Parity::Odd];
        let rates = [115_200, 9_600, 19_200, 57_600];
        parities.into_iter().flat_map(move |parity| rates.map(|rate| Mode { rate, parity }))
    }

    /// Time on the line of `bytes` characters: start bit, 8 data bits, parity, stop bit.
    pub fn time_of(self, bytes: usize) -> Duration {
        let bits = if self.parity == Parity::None { 10 } else { 11 };
        Duration::from_micros((bytes as u64 * bits * 1_000_000).div_ceil(u64::from(self.rate)))
    }

    /// Rest of the line between two frames: 3.5 characters, at more than 19 200 bits/s 1750 us
    /// (Modbus over serial line V1.02, 2.5.1.1).
    pub fn silence(self) -> Duration {
        (self.time_of(7) / 2).max(Duration::from_micros(1750))
    }
}

impl fmt::Display for Mode {
    /// `115200 8N1`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parity = match self.parity {
            Parity::None => 'N',
            Parity::Even => 'E',
            Parity::Odd => 'O',
        };
        write!(f, "{} 8{parity}1", self.rate)
    }
}

/// A way to a board.
pub trait Link {
    /// Sends all of `bytes`.
    ///
    /// # Errors
    /// The port is gone.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Receives what has come, waiting at most `patience` for the first byte. 0: nothing came.
    ///
    /// # Errors
    /// The port is gone.
    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize>;

    /// Time on the link's own clock: simulated for an emulated board.
    fn now(&self) -> Duration;

    /// Lets `time` pass on the link's clock.
    fn pause(&mut self, time: Duration);

    /// Changes rate and parity. `false`: the link has none (TCP, a pseudo-terminal ignores it).
    ///
    /// # Errors
    /// The port does not know the rate.
    fn set_mode(&mut self, mode: Mode) -> io::Result<bool>;

    /// Takes the line for one request and its reply, at `mode`. `true`: others may have used it a
    /// moment ago. A link that is ours alone has nothing to take.
    ///
    /// # Errors
    /// Another process keeps it; the text names it.
    fn claim(&mut self, _mode: Mode) -> io::Result<bool> {
        Ok(false)
    }

    /// Lets others have the line.
    fn release(&mut self) {}
}

impl<L: Link + ?Sized> Link for Box<L> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        (**self).send(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        (**self).receive(buffer, patience)
    }

    fn now(&self) -> Duration {
        (**self).now()
    }

    fn pause(&mut self, time: Duration) {
        (**self).pause(time);
    }

    fn set_mode(&mut self, mode: Mode) -> io::Result<bool> {
        (**self).set_mode(mode)
    }

    fn claim(&mut self, mode: Mode) -> io::Result<bool> {
        (**self).claim(mode)
    }

    fn release(&mut self) {
        (**self).release();
    }
}

/// Opens `tcp:PORT` or `tcp:HOST:PORT` (Modbus TCP), `rtu:PORT` or `rtu:HOST:PORT` (RTU frames over
/// TCP), or the path of a serial device or pseudo-terminal.
///
/// # Errors
/// The text says what could not be opened, why, and what to do.
pub fn open(port: &str) -> Result<Box<dyn Link>, String> {
    if let Some(address) = port.strip_prefix("tcp:") {
        return Ok(Box::new(ModbusTcp::new(Tcp::connect(address)?)));
    }
    if let Some(address) = port.strip_prefix("rtu:") {
        return Ok(Box::new(Tcp::connect(address)?));
    }
    Ok(Box::new(Serial::open(port)?))
}

#[cfg(test)]
mod tests {
    use super::Mode;
    use lang::profile::Parity;
    use std::time::Duration;

    #[test]
    fn all_modes_are_tried_once_and_the_default_first() {
        let modes: Vec<Mode> = Mode::all().collect();
        assert_eq!(modes[0], Mode::DEFAULT);
        assert_eq!(modes.len(), 12);
        for (i, mode) in modes.iter().enumerate() {
            assert!(!modes[..i].contains(mode), "{mode} twice");
        }
    }

    #[test]
    fn a_parity_bit_takes_its_time() {
        let mode = Mode { rate: 9_600, parity: Parity::Even };
        assert_eq!(mode.time_of(96), Duration::from_micros(110_000));
        assert_eq!(mode.to_string(), "9600 8E1");
    }
}
