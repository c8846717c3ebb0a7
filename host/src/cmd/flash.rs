//! `pasapas flash`: writes the firmware to a LaunchPad.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use emulator::Family;
use indicatif::ProgressBar;
use lang::part;

use super::console::{Console, Options};
use crate::board::image_file::Format;
use crate::board::{BUILDS, Build, F5529, G2553};
use crate::failure::Failure;
use crate::output;
use crate::programmer::boot_loader::{self, Segments, Told};
use crate::programmer::{Chip, Programmer};
use crate::usb::{self, Device, Role};

/// `pasapas flash`
#[derive(Debug, Args)]
pub struct Flash {
    #[arg(long, value_name = "NAME", help = super::part::listed("The image to write:", "; without it that of the chip"), value_parser = super::part::named)]
    part: Option<&'static Build>,
    /// Driver of mspdebug; without it that of the programmer that is plugged in: rf2500 for the
    /// MSP-EXP430G2, tilib for newer LaunchPads
    #[arg(long, value_name = "NAME")]
    driver: Option<String>,
    /// Write the image to this file instead, for another tool: Intel HEX (.hex), TI-TXT (.txt) or
    /// ELF (.elf)
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
}

/// What leads to the chip's flash.
enum Way {
    /// A driver of mspdebug.
    Driver(String),
    /// The chip's own boot loader.
    BootLoader,
}

impl Flash {
    /// Writes and verifies the image.
    ///
    /// # Errors
    /// No programmer is there, mspdebug is missing or fails, or the chip is not that of the image.
    pub fn run(&self, _options: &Options, console: &Console) -> Result<(), Failure> {
        if let Some(path) = &self.save {
            return save(self.part.unwrap_or(&G2553), path);
        }
        let way = match &self.driver {
            Some(driver) => Way::Driver(driver.clone()),
            None => way(&usb::devices())?,
        };
        match way {
            Way::BootLoader => self.by_boot_loader(console),
            Way::Driver(driver) => self.by_mspdebug(driver, console),
        }
    }

    fn by_mspdebug(&self, driver: String, console: &Console) -> Result<(), Failure> {
        let programmer = Programmer { driver };
        programmer.check().map_err(Failure::Board)?;
        let build = self.judge(programmer.chip().map_err(Failure::Board)?)?;
        let elf = Format::Elf.of_image(build.elf).map_err(|error| broken(build, &error))?;
        let folder = std::env::temp_dir();
        let image = tempfile::Builder::new()
            .suffix(".elf")
            .tempfile_in(&folder)
            .and_then(|mut file| file.write_all(&elf).map(|()| file))
            .map_err(|error| Failure::writing(&folder.display().to_string(), &error))?;
        let image = image.path().display().to_string();
        if build.chip.family == Family::Msp430X {
            let segments = segments(build)?;
            console.complain(&format!(
                "writing erases {} segments, the firmware's own: the stored program, the KEEP values, the \
                 machine's profile and the log of faults stay",
                segments.len()
            ));
            programmer.write_ranges(&image, &segments.ranges()).map_err(Failure::Board)?;
            return console.result(&on_board(build, "its link is the second of its two ports"));
        }
        console.complain(
            "writing erases the main flash: the stored program and the KEEP values go; the machine's \
             profile and the log of faults stay",
        );
        programmer.write(&image).map_err(Failure::Board)?;
        console.result(&on_board(build, "set the TX and RX jumpers to HW UART"))
    }

    fn by_boot_loader(&self, console: &Console) -> Result<(), Failure> {
        let build = self.part.unwrap_or(&F5529);
        if build.chip.family != F5529.chip.family {
            return Err(Failure::Board(format!(
                "this is the boot loader of an {}, and the firmware {} is for the {}: nothing was written",
                F5529.part.chip.name, build.part.name, build.part.chip.name
            )));
        }
        let segments = segments(build)?;
        console.complain(
            "a board with this very firmware keeps program and KEEP values; any other erases its main flash as \
             the boot loader is opened, and the stored program and the KEEP values go. The machine's profile \
             and the log of faults stay. Let go of the BSL button",
        );
        let mut computer = boot_loader::usb::Computer::new().map_err(Failure::Board)?;
        let bar = console.shows_progress().then(|| ProgressBar::new(0));
        let written = boot_loader::write(&mut computer, &segments, &mut |told| match told {
            Told::Kept => console.complain("it has this firmware: only that is written anew"),
            Told::Erased => console.complain("it had another one: it has erased its main flash"),
            Told::Again => console.complain("not all has arrived: once more"),
            Told::Rounds(done, all) => bar.iter().for_each(|bar| {
                bar.set_length(all as u64);
                bar.set_position(done as u64);
            }),
        });
        bar.iter().for_each(ProgressBar::finish_and_clear);
        written.map_err(|trouble| Failure::Board(trouble.to_string()))?;
        console.result(&on_board(build, "its link is the second of the LaunchPad's two ports"))
    }

    /// The image for this chip, or the one that was asked for if it is for it.
    fn judge(&self, chip: Chip) -> Result<&'static Build, Failure> {
        let fits = match chip {
            Chip::Known(chip) => firsts().find(|build| build.part.chip == chip),
            Chip::Unnamed | Chip::Other(_) => None,
        };
        match (fits, self.part, chip) {
            (Some(fits), None, _) => Ok(fits),
            (Some(fits), Some(asked), _) if asked.part.chip == fits.part.chip => Ok(asked),
            (None, Some(asked), Chip::Unnamed) => Ok(asked),
            (None, None, Chip::Unnamed) => {
                let ways = firsts().map(|build| {
                    format!("of an {} with --part {}", build.part.chip.name, build.part.name)
                });
                Err(Failure::Board(format!(
                    "the programmer does not name the chip: write that {}",
                    ways.collect::<Vec<_>>().join(", that ")
                )))
            }
            (_, asked, chip) => {
                let name = match chip {
                    Chip::Other(name) => name,
                    _ => fits.map_or("another one", |fits| fits.part.chip.name).to_owned(),
                };
                let wanted = asked.map_or_else(
                    || {
                        firsts()
                            .map(|build| build.part.chip.name)
                            .collect::<Vec<_>>()
                            .join(" or the ")
                    },
                    |asked| asked.part.chip.name.to_owned(),
                );
                Err(Failure::Board(format!(
                    "the chip says that it is {name}, and the firmware is for the {wanted}: nothing was \
                     written; exchange the chip"
                )))
            }
        }
    }
}

fn on_board(build: &Build, then: &str) -> String {
    format!(
        "the firmware {} for the {} is on the board; {then}\n",
        build.part.name, build.part.chip.name
    )
}

/// The first build of each chip.
fn firsts() -> impl Iterator<Item = &'static Build> {
    let of = |chip| BUILDS.into_iter().find(move |build| build.part.chip == chip);
    part::chips().filter_map(of)
}

fn segments(build: &Build) -> Result<Segments, Failure> {
    Segments::of_image(build.elf).map_err(|error| broken(build, &error))
}

fn broken(build: &Build, error: &str) -> Failure {
    Failure::Board(format!("the image {}: {error}", build.part.name))
}

/// Writes the image in the format that the file's ending says.
fn save(build: &Build, path: &Path) -> Result<(), Failure> {
    let ending = path.extension().and_then(|ending| ending.to_str());
    let format = Format::of(ending)
        .map_err(|error| Failure::Usage(format!("--save {}: {error}", path.display())))?;
    let bytes = format.of_image(build.elf).map_err(|error| broken(build, &error))?;
    output::write(path, bytes)
}

/// By the one device that is there. A board whose boot loader is up shows its programmer too: the boot loader
/// was asked for by hand.
fn way(devices: &[Device]) -> Result<Way, Failure> {
    let loaders = devices.iter().filter(|device| device.kind.role == Role::BootLoader).count();
    // Only Linux shows devices that have no serial port.
    if loaders > 0 || !cfg!(target_os = "linux") && boot_loader::usb::count() > 0 {
        return Ok(Way::BootLoader);
    }
    let programmers: Vec<(&Device, &str)> = devices
        .iter()
        .filter_map(|device| match device.kind.role {
            Role::Programmer(driver) => Some((device, driver)),
            Role::BootLoader => None,
        })
        .collect();
    match &programmers[..] {
        [(_, driver)] => Ok(Way::Driver((*driver).to_owned())),
        [] if cfg!(target_os = "linux") => Err(Failure::Board(
            "no LaunchPad is plugged in (USB 0451:f432, 2047:0013, or the boot loader 2047:0200 of an \
             MSP-EXP430F5529LP whose BSL button was held): use a cable that carries data; for another \
             programmer name mspdebug's --driver"
                .to_owned(),
        )),
        [] => Ok(Way::Driver("rf2500".to_owned())),
        _ => {
            let names = programmers.iter().map(|(device, _)| {
                let serial = device.serial.as_deref().unwrap_or("without a number");
                format!("{} {serial}", device.kind.name)
            });
            let names: Vec<String> = names.collect();
            Err(Failure::Board(format!(
                "more than one LaunchPad is plugged in ({}): leave only the one to write",
                names.join(", ")
            )))
        }
    }
}
