//! USB devices, their serial ports, and which of them are known boards.
//!
//! Linux lists all in its sysfs; elsewhere the library for serial ports lists those with a port.

use std::fs;
use std::path::{Path, PathBuf};

/// A kind of USB device that we know.
#[derive(Debug, PartialEq, Eq)]
pub struct Kind {
    /// USB vendor and product.
    pub id: (u16, u16),
    /// Its name.
    pub name: &'static str,
    /// What it is for the flash.
    pub role: Role,
    /// Interface of the serial port that leads to the chip; other ports of it are the programmer's.
    pub uart: Option<u8>,
}

/// How a device gets at the flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A programmer that mspdebug's driver of this name knows.
    Programmer(&'static str),
    /// The chip's own boot loader.
    BootLoader,
}

/// The devices that we know. Sources: mspdebug's transport/rf2500.c; MSP-EXP430G2ET user's guide
/// (SLAU772), 2.2.4, and MSP-EXP430F5529LP user's guide (SLAU533D), 2.2.4 and 2.6.
pub static KINDS: [Kind; 3] = [
    Kind {
        id: (0x0451, 0xF432),
        name: "MSP-EXP430G2 LaunchPad",
        role: Role::Programmer("rf2500"),
        uart: Some(0),
    },
    Kind {
        id: (0x2047, 0x0013),
        name: "LaunchPad with eZ-FET",
        role: Role::Programmer("tilib"),
        uart: Some(2),
    },
    Kind {
        id: (0x2047, 0x0200),
        name: "USB boot loader of an MSP430F5529",
        role: Role::BootLoader,
        uart: None,
    },
];

/// A device of a kind that we know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Device {
    /// What it is.
    pub kind: &'static Kind,
    /// Its serial number, by which two of a kind are told apart.
    pub serial: Option<String>,
}

/// A serial port of the system.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Port {
    /// What `--port` takes.
    pub name: String,
    /// What its device calls itself.
    pub product: Option<String>,
    /// Whether it leads to the chip of a board that we know.
    pub board: Option<Device>,
}

/// The devices that we know among those that are plugged in.
pub fn devices() -> Vec<Device> {
    if cfg!(target_os = "linux") {
        return sysfs_devices(&sysfs())
            .into_iter()
            .filter_map(|(_, found)| known(&found))
            .collect();
    }
    let mut devices: Vec<Device> =
        serial_ports().into_iter().filter_map(|port| port.board).collect();
    devices.dedup();
    devices
}

/// The serial ports, by name.
pub fn serial_ports() -> Vec<Port> {
    let mut ports = if cfg!(target_os = "linux") { sysfs_ports(&sysfs()) } else { Vec::new() };
    // The library panics where this folder is missing.
    if !cfg!(target_os = "linux") || Path::new("/sys/class/tty").is_dir() {
        for port in serialport::available_ports().unwrap_or_default() {
            if ports.iter().all(|known| known.name != port.port_name) {
                ports.push(listed(port));
            }
        }
    }
    // macOS lists each port twice; who opens the one called `tty` waits for a modem.
    ports.retain(|port| !(cfg!(target_os = "macos") && port.name.starts_with("/dev/tty.")));
    ports.sort_by(|a, b| a.name.cmp(&b.name));
    ports
}

/// `/dev/ttyACM1 (LaunchPad with eZ-FET), /dev/ttyUSB0 (FT232R USB UART), /dev/ttyS0`
pub fn list(ports: &[Port]) -> String {
    let one = |port: &Port| {
        let serial = port.board.as_ref().and_then(|board| board.serial.as_deref());
        let serial = serial.map(|serial| format!(" {serial}")).unwrap_or_default();
        match (&port.board, &port.product) {
            (Some(board), _) => format!("{} ({}{serial})", port.name, board.kind.name),
            (None, Some(product)) => format!("{} ({product})", port.name),
            (None, None) => port.name.clone(),
        }
    };
    ports.iter().map(one).collect::<Vec<_>>().join(", ")
}

fn listed(port: serialport::SerialPortInfo) -> Port {
    let serialport::SerialPortType::UsbPort(usb) = port.port_type else {
        return Port { name: port.port_name, product: None, board: None };
    };
    let found =
        Found { id: (usb.vid, usb.pid), serial: usb.serial_number, product: usb.product.clone() };
    let board = leads_to_chip(&found, usb.interface);
    Port { name: port.port_name, product: usb.product, board }
}

/// A USB device as it describes itself.
#[derive(Debug)]
struct Found {
    id: (u16, u16),
    serial: Option<String>,
    product: Option<String>,
}

fn known(found: &Found) -> Option<Device> {
    let kind = KINDS.iter().find(|kind| kind.id == found.id)?;
    Some(Device { kind, serial: found.serial.clone() })
}

fn leads_to_chip(found: &Found, interface: Option<u8>) -> Option<Device> {
    known(found).filter(|device| device.kind.uart.is_some() && device.kind.uart == interface)
}

/// Where Linux shows its devices; containers may have it elsewhere.
fn sysfs() -> PathBuf {
    std::env::var_os("PASAPAS_SYSFS").map_or_else(|| "/sys".into(), PathBuf::from)
}

/// Every USB device with the name of its folder.
fn sysfs_devices(sysfs: &Path) -> Vec<(String, Found)> {
    let mut devices: Vec<_> = folders(&sysfs.join("bus/usb/devices"))
        .filter_map(|folder| {
            let id = (hex(&folder, "idVendor")?, hex(&folder, "idProduct")?);
            let found =
                Found { id, serial: text(&folder, "serial"), product: text(&folder, "product") };
            Some((folder.file_name()?.to_str()?.to_owned(), found))
        })
        .collect();
    devices.sort_by(|a, b| a.0.cmp(&b.0));
    devices
}

/// The serial ports of USB devices.
fn sysfs_ports(sysfs: &Path) -> Vec<Port> {
    let mut ports = Vec::new();
    let mut interfaces: Vec<PathBuf> = folders(&sysfs.join("bus/usb/devices")).collect();
    interfaces.sort();
    for (device, found) in sysfs_devices(sysfs) {
        // `1-2:1.0` is interface 0 in configuration 1 of the device `1-2`.
        let own = format!("{device}:");
        let own = interfaces.iter().filter(|folder| name_of(folder).starts_with(&own));
        for folder in own {
            let number = hex(folder, "bInterfaceNumber").and_then(|n| u8::try_from(n).ok());
            // A modem's port stands in `tty`, an adapter's in a folder of its own name.
            let adapters = folders(folder).filter(|inner| name_of(inner).starts_with("ttyUSB"));
            let names = folders(&folder.join("tty")).chain(adapters);
            for name in names.map(|inner| name_of(&inner)) {
                ports.push(Port {
                    // Sysfs writes `!` for a slash in a name.
                    name: format!("/dev/{}", name.replace('!', "/")),
                    product: text(folder, "interface").or_else(|| found.product.clone()),
                    board: leads_to_chip(&found, number),
                });
            }
        }
    }
    ports
}

fn folders(of: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    let entries = fs::read_dir(of).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).filter(|path| path.is_dir())
}

fn name_of(folder: &Path) -> String {
    folder.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn text(folder: &Path, file: &str) -> Option<String> {
    let text = fs::read_to_string(folder.join(file)).ok()?;
    Some(text.trim().to_owned()).filter(|text| !text.is_empty())
}

fn hex(folder: &Path, file: &str) -> Option<u16> {
    u16::from_str_radix(&text(folder, file)?, 16).ok()
}

#[cfg(test)]
mod tests {
    use super::{Role, list, sysfs_devices, sysfs_ports};
    use std::fs;
    use std::path::Path;

    fn write(root: &Path, file: &str, text: &str) {
        let path = root.join("bus/usb/devices").join(file);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, text).expect("a file");
    }

    /// An eZ-FET with both of its ports, an adapter, a hub.
    fn desk() -> tempfile::TempDir {
        let root = tempfile::tempdir().expect("a folder");
        let files = [
            ("1-2/idVendor", "2047\n"),
            ("1-2/idProduct", "0013\n"),
            ("1-2/product", "MSP Tools Driver\n"),
            ("1-2/serial", "A1B2\n"),
            ("1-2:1.0/bInterfaceNumber", "00\n"),
            ("1-2:1.0/interface", "MSP Debug Interface\n"),
            ("1-2:1.0/tty/ttyACM0/dev", "166:0\n"),
            ("1-2:1.2/bInterfaceNumber", "02\n"),
            ("1-2:1.2/interface", "MSP Application UART1\n"),
            ("1-2:1.2/tty/ttyACM1/dev", "166:1\n"),
            ("1-3/idVendor", "0403\n"),
            ("1-3/idProduct", "6001\n"),
            ("1-3/product", "FT232R USB UART\n"),
            ("1-3:1.0/bInterfaceNumber", "00\n"),
            ("1-3:1.0/ttyUSB0/port_number", "0\n"),
            ("usb1/idVendor", "1d6b\n"),
            ("usb1/idProduct", "0002\n"),
        ];
        for (file, text) in files {
            write(root.path(), file, text);
        }
        root
    }

    #[test]
    fn the_port_that_leads_to_the_chip_is_told_from_the_programmers() {
        let root = desk();
        let ports = sysfs_ports(root.path());
        let told = "/dev/ttyACM0 (MSP Debug Interface), /dev/ttyACM1 (LaunchPad with eZ-FET A1B2), \
                    /dev/ttyUSB0 (FT232R USB UART)";
        assert_eq!(list(&ports), told);
        let boards: Vec<&str> =
            ports.iter().filter(|port| port.board.is_some()).map(|port| &*port.name).collect();
        assert_eq!(boards, ["/dev/ttyACM1"]);
    }

    #[test]
    fn devices_are_known_by_vendor_and_product() {
        let root = desk();
        write(root.path(), "1-4/idVendor", "2047\n");
        write(root.path(), "1-4/idProduct", "0200\n");
        let known = sysfs_devices(root.path()).into_iter().filter_map(|(_, f)| super::known(&f));
        let roles: Vec<Role> = known.map(|device| device.kind.role).collect();
        assert_eq!(roles, [Role::Programmer("tilib"), Role::BootLoader]);
        assert!(sysfs_devices(Path::new("/no such folder")).is_empty());
    }
}
