//! `pasapas flash`: writes the firmware to a LaunchPad.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use emulator::Family;

use super::{Console, Options};
use crate::board::image_file::Format;
use crate::board::{Build, G2553, VIRTUAL};
use crate::failure::Failure;
use crate::output;
use crate::programmer::{Chip, Programmer};
use crate::usb::{self, Device, Role};

/// `pasapas flash`
#[derive(Debug, Args)]
pub struct Flash {
    /// The image to write: g2553, the LaunchPad's own, g2553-handlers for the same chip (ON ERROR and
    /// events), f5529 to a file
    #[arg(long, value_name = "NAME", value_parser = super::part::named)]
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

impl Flash {
    /// Writes and verifies the image.
    ///
    /// # Errors
    /// No programmer is there, mspdebug is missing or fails, or the chip is not that of the image.
    pub fn run(&self, _options: &Options, console: &Console) -> Result<(), Failure> {
        let build = self.part.unwrap_or(&G2553);
        if build.part == VIRTUAL.part {
            return Err(Failure::Usage(
                "the part `virtual` runs in the emulator only, no chip has its pins: write g2553 or \
                 g2553-handlers, or use `pasapas board` for a board without a board"
                    .to_owned(),
            ));
        }
        if let Some(path) = &self.save {
            return save(build, path);
        }
        if build.chip.family == Family::Msp430X {
            return Err(Failure::Usage(format!(
                "this command cannot write to the {} yet: save the image with --save FILE.txt and write it \
                 with a tool of the chip's maker",
                build.part.chip
            )));
        }
        let driver = match &self.driver {
            Some(driver) => driver.clone(),
            None => driver(&usb::devices())?,
        };
        let programmer = Programmer { driver };
        programmer.check().map_err(Failure::Board)?;
        self.judge(programmer.chip().map_err(Failure::Board)?)?;
        console.complain(
            "writing erases the main flash: the stored program and the KEEP values go; the machine's \
             profile and the log of faults stay",
        );
        let folder = std::env::temp_dir();
        let image = tempfile::Builder::new()
            .suffix(".elf")
            .tempfile_in(&folder)
            .and_then(|mut file| file.write_all(build.elf).map(|()| file))
            .map_err(|error| Failure::writing(&folder.display().to_string(), &error))?;
        programmer.write(&image.path().display().to_string()).map_err(Failure::Board)?;
        console.result(&format!(
            "the firmware {} for the {} is on the board; set the TX and RX jumpers to HW UART\n",
            build.part.name, build.part.chip
        ))
    }

    /// Whether the chip is that of the image. Every image that comes here is for the G2553.
    fn judge(&self, chip: Chip) -> Result<(), Failure> {
        match chip {
            Chip::G2553 => Ok(()),
            Chip::Unnamed if self.part.is_some() => Ok(()),
            Chip::Unnamed => Err(Failure::Board(format!(
                "the programmer does not name the chip: if it is an {0}, write with --part {1}",
                G2553.part.chip, G2553.part.name
            ))),
            Chip::Other(name) => Err(Failure::Board(format!(
                "the chip says that it is {name}, and the firmware is for the {}: nothing was \
                 written; exchange the chip",
                G2553.part.chip
            ))),
        }
    }
}

/// Writes the image in the format that the file's ending says.
fn save(build: &Build, path: &Path) -> Result<(), Failure> {
    let ending = path.extension().and_then(|ending| ending.to_str());
    let format = Format::of(ending)
        .map_err(|error| Failure::Usage(format!("--save {}: {error}", path.display())))?;
    let bytes = format
        .of_image(build.elf)
        .map_err(|error| Failure::Board(format!("the image {}: {error}", build.part.name)))?;
    output::write(path, bytes)
}

/// The driver of the one programmer that is there.
fn driver(devices: &[Device]) -> Result<String, Failure> {
    let programmers: Vec<(&Device, &str)> = devices
        .iter()
        .filter_map(|device| match device.kind.role {
            Role::Programmer(driver) => Some((device, driver)),
            Role::BootLoader => None,
        })
        .collect();
    match &programmers[..] {
        [(_, driver)] => Ok((*driver).to_owned()),
        [] if !devices.is_empty() => Err(Failure::Board(format!(
            "a {} is plugged in: there is no firmware for that chip; plug in a LaunchPad with an {}",
            devices[0].kind.name, G2553.part.chip
        ))),
        // Only Linux shows devices that have no serial port.
        [] if cfg!(target_os = "linux") => Err(Failure::Board(
            "no LaunchPad is plugged in (USB 0451:f432 or 2047:0013): use a cable that carries data; \
             for another programmer name mspdebug's --driver"
                .to_owned(),
        )),
        [] => Ok("rf2500".to_owned()),
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
