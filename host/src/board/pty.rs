//! A pseudo-terminal whose other end any Modbus client can open.

#[cfg(not(unix))]
use std::{io, path::Path, time::Duration};

#[cfg(unix)]
pub use unix::{Pty, make_link};

#[cfg(unix)]
mod unix {
    use std::fs;
    use std::io::{self, Read, Write};
    use std::path::{Path, PathBuf};
    use std::time::Duration;

    use serialport::{SerialPort, TTYPort};

    /// See the module.
    pub struct Pty {
        master: TTYPort,
        /// Held open: without it the master reads errors whenever no client is there.
        _slave: TTYPort,
        device: String,
        link: Option<PathBuf>,
    }

    impl Pty {
        /// Opens one; `link`, if given, is made a symbolic link to its device.
        ///
        /// # Errors
        /// The system has none left, or `link` exists and is no symbolic link.
        pub fn open(link: Option<&Path>) -> io::Result<Pty> {
            let (master, slave) = TTYPort::pair()?;
            let device = slave.name().unwrap_or_default();
            if let Some(link) = link {
                make_link(&device, link)?;
            }
            Ok(Pty { master, _slave: slave, device, link: link.map(Path::to_owned) })
        }

        /// Path of the device.
        pub fn device(&self) -> &str {
            &self.device
        }

        /// Appends what has come, waiting at most `wait` for its first byte.
        pub fn read(&mut self, bytes: &mut Vec<u8>, wait: Duration) {
            let mut buffer = [0; 512];
            let mut wait = wait;
            // A frame that the client writes in one go is taken whole: a gap would spoil it.
            while self.master.set_timeout(wait).is_ok() {
                match self.master.read(&mut buffer) {
                    Ok(count) if count > 0 => bytes.extend(&buffer[..count]),
                    _ => break,
                }
                wait = Duration::ZERO;
            }
        }

        /// Sends bytes to whoever has the device open. Nobody there to read them is no error.
        pub fn write(&mut self, bytes: &[u8]) {
            let _ = self.master.set_timeout(Duration::from_millis(20));
            let _ = self.master.write_all(bytes);
        }
    }

    impl Drop for Pty {
        fn drop(&mut self) {
            if let Some(link) = &self.link
                && fs::read_link(link).is_ok_and(|target| target == Path::new(&self.device))
            {
                let _ = fs::remove_file(link);
            }
        }
    }

    /// Puts the link in place of an older one, but of nothing else.
    ///
    /// # Errors
    /// Something else has that name, or the folder takes none.
    pub fn make_link(device: &str, link: &Path) -> io::Result<()> {
        match fs::symlink_metadata(link) {
            Ok(old) if old.file_type().is_symlink() => fs::remove_file(link)?,
            Ok(_) => {
                return Err(io::Error::new(
                    io::ErrorKind::AlreadyExists,
                    "it exists and is no symbolic link",
                ));
            }
            Err(_) => {}
        }
        std::os::unix::fs::symlink(device, link)
    }
}

/// Systems without pseudo-terminals use the TCP port.
#[cfg(not(unix))]
pub struct Pty {}

#[cfg(not(unix))]
impl Pty {
    /// There are none here.
    ///
    /// # Errors
    /// Always.
    pub fn open(_link: Option<&Path>) -> io::Result<Pty> {
        Err(io::Error::new(io::ErrorKind::Unsupported, "no pseudo-terminals here: use --tcp"))
    }

    /// Path of the device.
    pub fn device(&self) -> &str {
        ""
    }

    /// Nothing comes.
    pub fn read(&mut self, _bytes: &mut Vec<u8>, wait: Duration) {
        std::thread::sleep(wait);
    }

    /// Nobody hears it.
    pub fn write(&mut self, _bytes: &[u8]) {}
}
