//! `pasapas flash`: writes the firmware to a LaunchPad.

use std::io::ErrorKind;
use std::path::PathBuf;
use std::process::Command;

use clap::Args;

use super::part::Choice;
use super::{Console, Options};
use crate::failure::Failure;

/// `pasapas flash`
#[derive(Debug, Args)]
pub struct Flash {
    #[command(flatten)]
    part: Choice,
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
    /// mspdebug is missing or fails.
    pub fn run(&self, _options: &Options, console: &Console) -> Result<(), Failure> {
        if let Some(path) = &self.save {
            let name = path.display().to_string();
            return std::fs::write(path, self.part.or_default().elf)
                .map_err(|error| Failure::writing(&name, &error));
        }
        let image = std::env::temp_dir().join(format!("pasapas-{}.elf", std::process::id()));
        let name = image.display().to_string();
        std::fs::write(&image, self.part.or_default().elf)
            .map_err(|error| Failure::writing(&name, &error))?;
        let result = Command::new("mspdebug")
            .args([self.driver.as_str(), &format!("prog {name}"), &format!("verify {name}")])
            .status();
        let _ = std::fs::remove_file(&image);
        match result {
            Ok(status) if status.success() => console
                .result("the firmware is on the board; set the TX and RX jumpers to HW UART\n"),
            Ok(status) => Err(Failure::Board(format!(
                "mspdebug failed ({status}): is the LaunchPad plugged in and its programmer free?"
            ))),
            Err(error) if error.kind() == ErrorKind::NotFound => {
                Err(Failure::Board(INSTALL.to_owned()))
            }
            Err(error) => Err(Failure::Board(format!("mspdebug cannot be started: {error}"))),
        }
    }
}
