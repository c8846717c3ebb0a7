//! Boot loaders at the computer's USB, by the system's own driver for HID.

use std::io;
use std::time::{Duration, Instant};

use hidapi::{HidApi, HidDevice, HidError};

use super::frame::{REPORT, Report};
use super::{Desk, Hid};
use crate::programmer::remedy;

/// What `remedy` calls it.
const BOOT_LOADER: &str = "boot loader";

/// USB vendor and product of the boot loader (SLAU319, "USB BSL").
pub const ID: (u16, u16) = (0x2047, 0x0200);

/// This computer.
pub struct Computer {
    api: HidApi,
    begun: Instant,
}

impl Computer {
    /// # Errors
    /// The system has no HID.
    pub fn new() -> Result<Computer, String> {
        HidApi::new()
            .map(|api| Computer { api, begun: Instant::now() })
            .map_err(|error| format!("USB: {error}"))
    }
}

/// How many boot loaders are plugged in; none where the system cannot tell.
pub fn count() -> usize {
    let Ok(mut computer) = Computer::new() else { return 0 };
    computer.list().map_or(0, |paths| paths.len())
}

impl Computer {
    fn list(&mut self) -> Result<Vec<std::ffi::CString>, HidError> {
        self.api.reset_devices()?;
        self.api.add_devices(ID.0, ID.1)?;
        let mut paths: Vec<_> =
            self.api.device_list().map(|device| device.path().to_owned()).collect();
        // One for each use that its descriptor names.
        paths.sort();
        paths.dedup();
        Ok(paths)
    }
}

impl Desk for Computer {
    fn open(&mut self) -> Result<Option<Box<dyn Hid>>, String> {
        let paths = self.list().map_err(|error| format!("USB: {error}"))?;
        match &paths[..] {
            [] => Ok(None),
            [path] => match self.api.open_path(path) {
                Ok(device) => Ok(Some(Box::new(Plugged(device)))),
                Err(error) => {
                    let error = plain(error);
                    let remedy = match error.kind() {
                        io::ErrorKind::PermissionDenied => remedy::rights(BOOT_LOADER),
                        _ => "unplug the board, and hold its BSL button while you plug it in"
                            .to_owned(),
                    };
                    Err(format!("the boot loader cannot be opened: {error}; {remedy}"))
                }
            },
            _ => {
                Err("more than one boot loader is plugged in: leave only the board to write"
                    .to_owned())
            }
        }
    }

    fn pause(&mut self, time: Duration) {
        std::thread::sleep(time);
    }

    fn now(&self) -> Duration {
        self.begun.elapsed()
    }
}

struct Plugged(HidDevice);

fn plain(error: HidError) -> io::Error {
    match error {
        HidError::IoError { error } => error,
        other => io::Error::other(other.to_string()),
    }
}

impl Hid for Plugged {
    fn send(&mut self, report: &Report) -> io::Result<()> {
        self.0.write(report).map(drop).map_err(plain)
    }

    fn receive(&mut self, patience: Duration) -> io::Result<Option<Report>> {
        let mut report = [0; REPORT];
        let patience = i32::try_from(patience.as_millis()).unwrap_or(i32::MAX);
        let bytes = self.0.read_timeout(&mut report, patience).map_err(plain)?;
        Ok((bytes > 0).then_some(report))
    }
}
