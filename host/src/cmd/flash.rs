//! `pasapas flash`: writes the firmware to a LaunchPad.

use std::io::{ErrorKind, Write as _};
use std::path::PathBuf;
use std::process::Command;

use clap::Args;

use super::{Console, Options};
use crate::board::{BUILDS, Build, G2553, VIRTUAL};
use crate::failure::Failure;
use crate::output;

/// `pasapas flash`
#[derive(Debug, Args)]
pub struct Flash {
    /// The image to write: g2553, the LaunchPad's own, g2553-handlers for the same chip (ON ERROR and
    /// events)
    #[arg(long, value_name = "NAME", value_parser = super::part::named)]
    part: Option<&'static Build>,
    /// Driver of mspdebug: rf2500 for the LaunchPad's own programmer, tilib for newer ones
    #[arg(long, default_value = "rf2500")]
    driver: String,
    /// Write the image to this file instead, for another tool
    #[arg(long, value_name = "FILE.elf")]
    save: Option<PathBuf>,
}

/// Told when the programmer's tool is missing.
const INSTALL: &str = "mspdebug is needed to write the flash: `apt install mspdebug` (Debian, \
    Ubuntu), `brew install mspdebug` (macOS), or https://dlbeer.co.nz/mspdebug; --save writes the \
    image for another tool such as UniFlash";

impl Flash {
    /// Writes and verifies the image.
    ///
    /// # Errors
    /// mspdebug is missing or fails, or the chip is not that of the image.
    pub fn run(&self, _options: &Options, console: &Console) -> Result<(), Failure> {
        if self.part.is_some_and(|build| build.part == VIRTUAL.part) {
            return Err(Failure::Usage(
                "the part `virtual` runs in the emulator only, no chip has its pins: write g2553 or \
                 g2553-handlers, or use `pasapas board` for a board without a board"
                    .to_owned(),
            ));
        }
        if let Some(path) = &self.save {
            return output::write(path, self.part.unwrap_or(&G2553).elf);
        }
        let build = self.build(console)?;
        let image = std::env::temp_dir();
        let image = tempfile::Builder::new()
            .suffix(".elf")
            .tempfile_in(&image)
            .and_then(|mut file| file.write_all(build.elf).map(|()| file))
            .map_err(|error| Failure::writing(&image.display().to_string(), &error))?;
        let name = image.path().display();
        let status = self
            .mspdebug()
            .args([format!("prog {name}"), format!("verify {name}")])
            .status()
            .map_err(|error| missing(&error))?;
        if !status.success() {
            return Err(unplugged(&status.to_string()));
        }
        console.result(&format!(
            "the firmware {} for the {} is on the board; set the TX and RX jumpers to HW UART\n",
            build.part.name, build.part.chip
        ))
    }

    /// The build of the chip that mspdebug names, of the LaunchPad's own when it names none.
    fn build(&self, console: &Console) -> Result<&'static Build, Failure> {
        let asked = self.mspdebug().arg("exit").output().map_err(|error| missing(&error))?;
        if !asked.status.success() {
            return Err(unplugged(&asked.status.to_string()));
        }
        let said = [asked.stdout, asked.stderr].concat();
        let said = String::from_utf8_lossy(&said);
        let found = BUILDS.into_iter().find(|build| said.contains(build.part.chip));
        match (self.part, found) {
            (Some(wanted), Some(found)) if wanted.part.chip != found.part.chip => {
                Err(Failure::Board(format!(
                    "the chip on the board is the {}, whose firmware is another one than the {}'s: \
                     leave --part away, or exchange the chip",
                    found.part.chip, wanted.part.chip
                )))
            }
            (Some(wanted), _) => Ok(wanted),
            (None, Some(found)) => Ok(found),
            (None, None) => {
                console.complain("mspdebug does not name the chip: it is taken for an MSP430G2553");
                Ok(&G2553)
            }
        }
    }

    fn mspdebug(&self) -> Command {
        let mut command = Command::new("mspdebug");
        command.arg(&self.driver);
        command
    }
}

fn missing(error: &std::io::Error) -> Failure {
    Failure::Board(match error.kind() {
        ErrorKind::NotFound => INSTALL.to_owned(),
        _ => format!("mspdebug cannot be started: {error}"),
    })
}

fn unplugged(status: &str) -> Failure {
    Failure::Board(format!(
        "mspdebug failed ({status}): is the LaunchPad plugged in and its programmer free?"
    ))
}
