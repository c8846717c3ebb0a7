//! Errors of a serial port that does not open or has gone, with the remedy for this system.

use std::io;

use super::holders;
use crate::usb;

/// What keeps a port from us.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// There is no such port, or it is something else.
    Missing,
    /// Another program has it.
    Busy,
    /// The user may not open it.
    Rights,
    /// It was there and is not any more.
    Gone,
    /// The system did not answer in time.
    Stuck,
    /// Something else, in the system's words only.
    Other,
}

impl Trouble {
    /// Of an error of opening `path`. Windows says "access denied" of a port that another program
    /// has, and has no other rights for ports.
    pub fn of(error: &io::Error, path: &str) -> Trouble {
        match error.kind() {
            io::ErrorKind::PermissionDenied if cfg!(windows) => Trouble::Busy,
            io::ErrorKind::PermissionDenied => Trouble::Rights,
            io::ErrorKind::NotFound if known(path) => Trouble::Busy,
            io::ErrorKind::NotFound
            | io::ErrorKind::InvalidInput
            | io::ErrorKind::IsADirectory
            | io::ErrorKind::NotADirectory => Trouble::Missing,
            io::ErrorKind::ResourceBusy | io::ErrorKind::WouldBlock => Trouble::Busy,
            // No such device, no such device or address: its driver is gone.
            _ if matches!(error.raw_os_error(), Some(6 | 19)) && cfg!(unix) => Trouble::Gone,
            io::ErrorKind::TimedOut => Trouble::Stuck,
            _ => Trouble::Other,
        }
    }

    /// What to do.
    pub fn remedy(self, path: &str) -> String {
        match self {
            Trouble::Missing => match usb::serial_ports() {
                ports if ports.is_empty() => "no serial port was found: plug the board in".into(),
                ports => format!("there are {}", usb::list(&ports)),
            },
            Trouble::Busy => match holders::of(path) {
                holders if !holders.is_empty() => {
                    format!("{} has it open: end it", holders.join(", "))
                }
                _ if cfg!(windows) => "another program has it open: close it (terminal, Arduino, \
                    workbench); if there is none, unplug the board and plug it in again"
                    .into(),
                _ => format!("another program has it open; `sudo lsof {path}` names it"),
            },
            Trouble::Rights => rights(path),
            Trouble::Gone => "the board was unplugged or its programmer restarted: plug it in and \
                try again; it may come back under another name"
                .into(),
            Trouble::Stuck => "its driver hangs: unplug the board, plug it in and try again".into(),
            Trouble::Other => "unplug the board, plug it in and try again".into(),
        }
    }
}

/// Whether the system lists this port.
fn known(path: &str) -> bool {
    let name = path.trim_start_matches(r"\\.\");
    usb::serial_ports().iter().any(|port| port.name.eq_ignore_ascii_case(name))
}

#[cfg(not(unix))]
fn rights(_path: &str) -> String {
    "your user may not open it".into()
}

/// Names the group that owns the device.
#[cfg(unix)]
fn rights(path: &str) -> String {
    use std::os::unix::fs::MetadataExt as _;
    let group = std::fs::metadata(path).ok().map(|device| device.gid());
    let groups = std::fs::read_to_string("/etc/group").unwrap_or_default();
    let name = group.and_then(|id| group_name(&groups, id)).filter(|name| *name != "root");
    let name = name.unwrap_or("dialout");
    format!(
        "your user must be in the group `{name}`: `sudo usermod -aG {name} $USER`, then log out and \
         in again"
    )
}

/// Name of a group in the text of /etc/group.
#[cfg(unix)]
fn group_name(groups: &str, id: u32) -> Option<&str> {
    groups.lines().find_map(|line| {
        let mut fields = line.split(':');
        let name = fields.next()?;
        (fields.nth(1)?.parse() == Ok(id)).then_some(name)
    })
}

#[cfg(test)]
mod tests {
    use super::Trouble;
    use std::io::{Error, ErrorKind};

    #[cfg(unix)]
    #[test]
    fn each_error_of_the_system_has_its_trouble() {
        // Linux: ENXIO, EIO, EACCES, EBUSY, ENODEV, ENOENT.
        let cases = [
            (6, Trouble::Gone),
            (5, Trouble::Other),
            (13, Trouble::Rights),
            (16, Trouble::Busy),
            (19, Trouble::Gone),
            (2, Trouble::Missing),
        ];
        for (number, trouble) in cases {
            let error = Error::from_raw_os_error(number);
            assert_eq!(Trouble::of(&error, "/dev/no such port"), trouble, "{error}");
        }
        assert_eq!(Trouble::of(&ErrorKind::TimedOut.into(), "x"), Trouble::Stuck);
    }

    #[cfg(unix)]
    #[test]
    fn the_group_of_a_device_is_found_by_its_number() {
        let groups = "root:x:0:\ndialout:x:20:anna\nuucp:x:14:\n";
        assert_eq!(super::group_name(groups, 14), Some("uucp"));
        assert_eq!(super::group_name(groups, 15), None);
    }
}
