//! Turns on a serial device that several processes have open, so that `stop` works while `watch`
//! runs: a process that sends a request holds a lock of the device until its reply is there.
//!
//! It is a POSIX record lock (`fcntl`), which the system releases however the process
//! ends; `flock` is used by the library that opens the port.

use std::fs::File;
use std::io;
use std::time::{Duration, Instant};

use rustix::fs::{FlockOperation, Mode, OFlags, fcntl_lock};
use rustix::io::Errno;
use rustix::process::{Flock, FlockOffsetType, FlockType, fcntl_getlk};

/// Longest wait for a turn: a request with all its attempts takes less.
const PATIENCE: Duration = Duration::from_secs(5);
/// Time between two looks; shorter than the line's rest, in which others leave it free
/// ([`crate::link::Mode::silence`]).
const LOOK: Duration = Duration::from_micros(400);

/// The right to ask for the line of one device.
pub struct Turns {
    /// A descriptor of its own: the port's may be duplicated and closed.
    device: File,
}

/// How a turn was got.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// At once.
    Free,
    /// Behind another process.
    Waited,
    /// The system knows no such lock for devices: the port must be opened for one process alone.
    NoLocks,
}

impl Turns {
    /// Opens the device a first time.
    ///
    /// # Errors
    /// It is not there, is another's alone, or the user has no right to it.
    pub fn of(path: &str) -> io::Result<Turns> {
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let device = rustix::fs::open(path, flags, Mode::empty())?;
        if !rustix::termios::isatty(&device) {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is no serial port"));
        }
        Ok(Turns { device: device.into() })
    }

    /// Takes the line.
    ///
    /// # Errors
    /// Another process keeps it; its name and number are in the text.
    pub fn take(&self) -> io::Result<Turn> {
        let begun = Instant::now();
        let mut turn = Turn::Free;
        loop {
            match fcntl_lock(&self.device, FlockOperation::NonBlockingLockExclusive) {
                Ok(()) => return Ok(turn),
                Err(Errno::AGAIN | Errno::ACCESS) if begun.elapsed() < PATIENCE => {
                    turn = Turn::Waited;
                    std::thread::sleep(LOOK);
                }
                Err(Errno::AGAIN | Errno::ACCESS) => return Err(self.kept()),
                Err(Errno::INTR) => {}
                Err(_) => return Ok(Turn::NoLocks),
            }
        }
    }

    /// Lets others have the line.
    pub fn give(&self) {
        // It fails only where there are no such locks.
        let _ = fcntl_lock(&self.device, FlockOperation::NonBlockingUnlock);
    }

    fn kept(&self) -> io::Error {
        let whole = Flock {
            start: 0,
            length: 0,
            pid: None,
            typ: FlockType::WriteLock,
            offset_type: FlockOffsetType::Set,
        };
        let holder = fcntl_getlk(&self.device, &whole).ok().flatten().and_then(|lock| lock.pid);
        let who = holder.map_or("another process".to_owned(), |pid| {
            super::holders::describe(pid.as_raw_nonzero().get())
        });
        let text = format!("{who} keeps the line and does not let it go: end it");
        io::Error::new(io::ErrorKind::ResourceBusy, text)
    }
}
