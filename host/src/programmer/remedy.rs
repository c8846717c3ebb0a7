//! The remedy for each failure of a programmer, on this system.

use std::io::{Error, ErrorKind};

/// The rules that the Debian package installs.
const UDEV: &str = include_str!("../../dist/70-pasapas.rules");

/// What mspdebug and TI's library say when something failed, in lower case, and what helps. The
/// first that fits counts: causes stand before what follows from them.
const FAILURES: [(&[&str], Help); 9] = [
    (&["can't find libmsp430", "cannot open shared object", "wrong elf class"], Help::Library),
    (&["firmware update is required"], Help::FetUpdate),
    (&["permission denied", "operation not permitted", "insufficient permissions"], Help::Rights),
    (&["resource busy", "can't claim interface"], Help::Busy),
    (&["device database not loaded"], Help::Database),
    (
        &[
            "could not find device",
            "unknown device",
            "identify failed",
            "fuse is blown",
            "could not set device vcc",
        ],
        Help::Chip,
    ),
    (&["no unused fet found", "unable to find a device", "failed to open"], Help::NotFound),
    (&["timed out", "communication error"], Help::Restart),
    (&["mismatch", "verification failed", "could not write", "could not read"], Help::Again),
];

#[derive(Clone, Copy)]
enum Help {
    Library,
    FetUpdate,
    Rights,
    Busy,
    Database,
    Chip,
    NotFound,
    Restart,
    Again,
}

/// Whether these are the words of a failure that a good exit code may hide: warnings and second
/// attempts of the driver rf2500 say some of them too.
pub fn is_failure(said: &str) -> bool {
    let said = said.to_lowercase();
    let library = |line: &str| {
        line.starts_with("tilib: ")
            && ["(error = ", "failed", "can't"].iter().any(|words| line.contains(words))
    };
    said.lines().any(library)
        || ["no unused fet found", "mismatch", "verification failed"]
            .iter()
            .any(|words| said.contains(words))
}

/// What to do.
pub fn of(said: &str, driver: &str) -> String {
    let said = said.to_lowercase();
    let fits = |(words, _): &&(&[&str], Help)| words.iter().any(|words| said.contains(words));
    match FAILURES.iter().find(fits).map(|(_, help)| *help) {
        Some(Help::Library) => return format!("{}; {ITSELF}", library()),
        Some(Help::FetUpdate) => {
            "its own firmware is older than TI's library: `mspdebug tilib --allow-fw-update` renews \
             it once; leave it plugged in until that ends"
        }
        Some(Help::Rights) => return rights(driver),
        Some(Help::Busy) => {
            "another program has the programmer (Code Composer, UniFlash, mspdebug): close it"
        }
        Some(Help::Database) => {
            "this libmsp430.so does not fit mspdebug: install that of TI's MSPDebugStack 3.15 \
             (SLAC460) for your processor"
        }
        Some(Help::Chip) => {
            "the programmer reaches no chip: the jumpers of RST and TEST must be set, the chip must \
             stand in its socket with pin 1 at the notch, and nothing else may pull RST; then press \
             the reset button and try again"
        }
        Some(Help::NotFound) if cfg!(target_os = "linux") && driver == "tilib" => {
            return rights(driver);
        }
        Some(Help::NotFound) => "the programmer is not there: plug the LaunchPad in by its USB \
             connector, with a cable that carries data",
        Some(Help::Restart) => "unplug the LaunchPad, plug it in and try again",
        Some(Help::Again) | None => {
            "press the reset button and try again; if it stays, unplug the LaunchPad and plug it in"
        }
    }
    .to_owned()
}

/// The way without any tool.
const ITSELF: &str = "an MSP-EXP430F5529LP needs none of this: hold its button BSL while you plug it in, and start \
                      this again";

fn library() -> &'static str {
    if cfg!(target_os = "windows") {
        "TI's library is missing: put MSP430.dll of TI's MSPDebugStack (SLAC460) beside mspdebug.exe, \
         or write the file of `pasapas flash --save FILE.hex` with TI's UniFlash"
    } else if cfg!(target_os = "macos") {
        "TI's library is missing: put libmsp430.dylib of TI's MSPDebugStack (SLAC460) into \
         /usr/local/lib, or write the file of `pasapas flash --save FILE.hex` with TI's UniFlash"
    } else {
        "TI's library is missing: build libmsp430.so from TI's MSPDebugStack (SLAC460), put it into \
         /usr/local/lib and run `sudo ldconfig`; or write the file of `pasapas flash --save FILE.hex` \
         with TI's UniFlash"
    }
}

/// Who may open the device behind a driver.
pub fn rights(driver: &str) -> String {
    if !cfg!(target_os = "linux") {
        return "your user may not open it: run this once as administrator".to_owned();
    }
    let vendor = if driver == "rf2500" { "0451" } else { "2047" };
    let line = UDEV.lines().find(|line| line.contains(vendor)).unwrap_or_default();
    format!(
        "your user may not open it: put this line into /etc/udev/rules.d/70-pasapas.rules, then \
         unplug it and plug it in\n  {line}"
    )
}

/// mspdebug cannot be started.
pub fn not_started(error: &Error) -> String {
    if error.kind() != ErrorKind::NotFound {
        return format!("mspdebug cannot be started: {error}");
    }
    let install = if cfg!(target_os = "windows") {
        "download mspdebug for Windows from https://dlbeer.co.nz/mspdebug and put it into the PATH"
    } else if cfg!(target_os = "macos") {
        "`brew install mspdebug`"
    } else {
        "`sudo apt install mspdebug` (Debian, Ubuntu) or https://dlbeer.co.nz/mspdebug"
    };
    format!(
        "mspdebug is needed to write the flash: {install}; `pasapas flash --save FILE.hex` writes \
         the image for another tool such as TI's UniFlash; {ITSELF}"
    )
}

/// Where a newer mspdebug comes from.
pub fn newer(since: (u32, u32)) -> String {
    let how = if cfg!(target_os = "macos") {
        "`brew install mspdebug`".to_owned()
    } else {
        "from https://dlbeer.co.nz/mspdebug".to_owned()
    };
    format!(
        "install {}.{} or later, {how}; or write the file of `pasapas flash --save FILE.hex` with \
         TI's UniFlash",
        since.0, since.1
    )
}
