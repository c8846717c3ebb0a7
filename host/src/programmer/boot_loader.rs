//! Writing a firmware by the USB boot loader that every MSP430F5529 has in its own flash, without a
//! programmer.
//!
//! It takes a password, the 32 bytes of the last 16 vectors; a wrong one erases the main flash and leaves the
//! information memory. After the right one it only writes RAM and starts code there (SLAU319, "USB
//! BSL"). So writing goes by rounds of a small program in RAM, `boot_loader/writer.s`: each writes six
//! segments and ends in a reset that leads back to the boot loader, as long as the reset vector is blank. The vector is
//! erased first and written last, after all the rest has been verified: if anything fails on the way, the chip comes up in
//! the boot loader. The chip reports the result of the verification by the time that it takes to come back: asking by the
//! password would erase everything if the answer is no.

mod frame;
mod rounds;
#[cfg(test)]
mod tests;
pub mod usb;

use std::fmt;
use std::io;
use std::time::Duration;

use frame::{Answer, Report};
use rounds::Round;
pub use rounds::Segments;

/// The link to a boot loader: reports of 64 bytes.
pub trait Hid {
    /// Sends a report.
    ///
    /// # Errors
    /// The device is gone, or refuses.
    fn send(&mut self, report: &Report) -> io::Result<()>;

    /// The next report, or nothing when none comes in time.
    ///
    /// # Errors
    /// The device is gone.
    fn receive(&mut self, patience: Duration) -> io::Result<Option<Report>>;
}

/// Where boot loaders are plugged in.
pub trait Desk {
    /// Opens the boot loader that is there, if one is.
    ///
    /// # Errors
    /// It is there and cannot be opened, or several are: the text says what to do.
    fn open(&mut self) -> Result<Option<Box<dyn Hid>>, String>;

    /// Lets time pass.
    fn pause(&mut self, time: Duration);

    /// Time since some instant.
    fn now(&self) -> Duration;
}

/// What is told on the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Told {
    /// The password was right: nothing but the firmware's own segments is erased.
    Kept,
    /// The password was wrong: the chip has erased its main flash.
    Erased,
    /// So many of so many rounds are done.
    Rounds(usize, usize),
    /// What stands in flash is not all that was sent: it is sent once more.
    Again,
}

/// Why the firmware does not run. In all of these cases the boot loader comes up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// No boot loader is there.
    Absent,
    /// It cannot be opened.
    Closed(String),
    /// It refuses the password of a blank chip.
    Refused(u8),
    /// It does not come back, or does not answer.
    Silent,
    /// The flash does not hold what was written.
    Unverified,
    /// The firmware is on the chip, and the boot loader came up all the same.
    Button,
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let again = "unplug the board, hold its BSL button while you plug it in, and try again";
        match self {
            Trouble::Absent => write!(f, "no boot loader is there: {again}"),
            Trouble::Closed(text) => f.write_str(text),
            Trouble::Refused(code) => write!(f, "the boot loader refuses its password (code {code}): {again}"),
            Trouble::Silent => write!(f, "the boot loader does not answer any more: {again}"),
            Trouble::Unverified => write!(
                f,
                "the chip's flash does not hold what was written: {again}; if it stays so, it is worn"
            ),
            Trouble::Button => f.write_str(
                "the firmware is on the board and compared, but the BSL button was still pressed: let go of it \
                 and press the reset button",
            ),
        }
    }
}

/// Longest wait for an answer; a mass erase is done within it.
const ANSWER: Duration = Duration::from_millis(1_000);
/// Time behind a start before the boot loader is looked for: one that is still there has not begun.
const GOING: Duration = Duration::from_millis(300);
/// Between two looks.
const LOOK: Duration = Duration::from_millis(100);
/// Longest time of a round and of coming back: six segments take 0.5 s at most, a computer some seconds to
/// know the device again, and [`LATE`].
const RETURN: Duration = Duration::from_secs(25);
/// By so much a comparison that found something wrong comes back later than any round before it; the chip waits
/// 6.3 s at its 8 MHz.
const LATE: Duration = Duration::from_secs(4);
/// Behind the last round: who is not back by then runs the firmware.
const GONE: Duration = Duration::from_secs(5);
/// So often all of it is sent before it counts as not written; what is there already takes no time.
const PASSES: usize = 8;

/// Writes the segments of a firmware, compares them, and starts it.
///
/// # Errors
/// See [`Trouble`].
pub fn write(
    desk: &mut dyn Desk,
    firmware: &Segments,
    tell: &mut dyn FnMut(Told),
) -> Result<(), Trouble> {
    let mut device = desk.open().map_err(Trouble::Closed)?.ok_or(Trouble::Absent)?;
    // The vectors of a chip that has this firmware; any other erases itself.
    let own = firmware.password();
    let (mut known, told) = match password(&mut *device, &own).unwrap_or(None) {
        Some(frame::SUCCESS) => (own, Some(Told::Kept)),
        Some(_) => (frame::BLANK, Some(Told::Erased)),
        // The answer was lost: it is asked for again.
        None => (own, None),
    };
    drop(device);
    told.into_iter().for_each(&mut *tell);
    let mut rounds = firmware.rounds();
    rounds.push(firmware.comparison());
    let all = rounds.len() + 1;
    let mut device = connect(desk, &known)?;
    for pass in 0..PASSES {
        if pass > 0 {
            tell(Told::Again);
        }
        let (mut longest, mut last) = (Duration::ZERO, Duration::ZERO);
        for (n, round) in rounds.iter().enumerate() {
            let begun = desk.now();
            run(&mut *device, round).map_err(|_| Trouble::Silent)?;
            drop(device);
            desk.pause(GOING);
            // From the first round on the vectors are blank.
            known = frame::BLANK;
            device = connect(desk, &known)?;
            longest = longest.max(last);
            last = desk.now().saturating_sub(begun);
            tell(Told::Rounds(n + 1, all));
        }
        if last > longest + LATE {
            continue;
        }
        run(&mut *device, &firmware.last_round()).map_err(|_| Trouble::Silent)?;
        drop(device);
        match back(desk, &own) {
            None => {
                tell(Told::Rounds(all, all));
                return Ok(());
            }
            Some(frame::SUCCESS) => return Err(Trouble::Button),
            Some(_) => device = connect(desk, &known)?,
        }
    }
    Err(Trouble::Unverified)
}

/// The boot loader's word on a password; nothing when it says nothing.
fn password(device: &mut dyn Hid, bytes: &[u8; frame::PASSWORD]) -> io::Result<Option<u8>> {
    device.send(&frame::password(bytes))?;
    while let Some(report) = device.receive(ANSWER)? {
        if let Some(Answer::Code(code)) = frame::answer(&report) {
            return Ok(Some(code));
        }
    }
    Ok(None)
}

/// Waits for the boot loader and opens it by the password that it should have, else by that of a blank
/// chip, which is what a wrong one makes of it.
fn connect(desk: &mut dyn Desk, known: &[u8; frame::PASSWORD]) -> Result<Box<dyn Hid>, Trouble> {
    let mut refused = None;
    let begun = desk.now();
    while desk.now() < begun + RETURN {
        // While it comes up its rights may not be set yet.
        if let Ok(Some(mut device)) = desk.open() {
            for bytes in [known, &frame::BLANK] {
                match password(&mut *device, bytes) {
                    Ok(Some(frame::SUCCESS)) => return Ok(device),
                    Ok(Some(code)) => refused = Some(code),
                    // It is about to go, or a report was lost.
                    Ok(None) | Err(_) => break,
                }
            }
        }
        desk.pause(LOOK);
    }
    Err(refused.map_or(Trouble::Silent, Trouble::Refused))
}

/// Puts a round into RAM and starts it. Nothing of this is answered: the round looks itself at what came.
fn run(device: &mut dyn Hid, round: &Round) -> io::Result<()> {
    for report in round.reports() {
        device.send(&report)?;
    }
    device.send(&frame::start(rounds::ENTRY))
}

/// Whether the boot loader comes up behind the last round: nothing where the firmware does, else its word on
/// the firmware's password.
fn back(desk: &mut dyn Desk, own: &[u8; frame::PASSWORD]) -> Option<u8> {
    let begun = desk.now();
    desk.pause(GOING);
    while desk.now() < begun + GONE {
        desk.pause(LOOK);
        if let Ok(Some(mut device)) = desk.open()
            && let Ok(Some(code)) = password(&mut *device, own)
        {
            return Some(code);
        }
    }
    None
}
