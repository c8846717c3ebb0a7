//! mspdebug, which writes a chip's flash through a programmer: its commands, and the meaning of its
//! output.

use std::process::Command;

use lang::part;
use lang::part::chip::{self, Family};

pub mod boot_loader;
mod remedy;

/// The first release of mspdebug that works with TI's library of today.
const TILIB_SINCE: (u32, u32) = (0, 25);

/// A programmer behind a driver of mspdebug.
#[derive(Clone, Debug)]
pub struct Programmer {
    /// Name of the driver.
    pub driver: String,
}

/// What a programmer says of the chip.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Chip {
    /// One that a firmware is for.
    Known(&'static chip::Chip),
    /// Another, by its two bytes or its name.
    Other(String),
    /// It says nothing.
    Unnamed,
}

impl Programmer {
    /// Whether mspdebug is there and new enough for the driver.
    ///
    /// # Errors
    /// The text says what to install.
    pub fn check(&self) -> Result<(), String> {
        let output = Command::new("mspdebug").arg("--version").output();
        let output = output.map_err(|error| remedy::not_started(&error))?;
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        match version(&text) {
            Some(found) if self.driver == "tilib" && found < TILIB_SINCE => Err(format!(
                "mspdebug {}.{} is too old for this programmer: with TI's library of today it says \
                 that it writes and writes nothing; {}",
                found.0,
                found.1,
                remedy::newer(TILIB_SINCE)
            )),
            _ => Ok(()),
        }
    }

    /// Asks for the chip's identity.
    ///
    /// # Errors
    /// What the programmer said, and the remedy.
    pub fn chip(&self) -> Result<Chip, String> {
        let commands = Family::ALL.map(|family| format!("md {:#06x} 16", family.id_address()));
        self.ask(&commands).map(|text| told(&text))
    }

    /// Writes and verifies an image; all of the main flash is erased before.
    ///
    /// # Errors
    /// What the programmer said, and the remedy.
    pub fn write(&self, image: &str) -> Result<(), String> {
        self.ask(&[format!("prog {image}"), format!("verify {image}")]).map(drop)
    }

    /// Writes and verifies an image; nothing but the given ranges of whole flash segments, first address and
    /// bytes, is erased before.
    ///
    /// # Errors
    /// What the programmer said, and the remedy.
    pub fn write_ranges(&self, image: &str, ranges: &[(u32, u32)]) -> Result<(), String> {
        let erase =
            |(first, bytes): &(u32, u32)| format!("erase segrange {first:#x} {bytes:#x} 0x200");
        let mut commands: Vec<String> = ranges.iter().map(erase).collect();
        commands.extend([format!("load {image}"), format!("verify {image}")]);
        self.ask(&commands).map(drop)
    }

    /// Runs commands; gives what was said.
    fn ask(&self, commands: &[String]) -> Result<String, String> {
        let output = Command::new("mspdebug").arg(&self.driver).args(commands).output();
        let output = output.map_err(|error| remedy::not_started(&error))?;
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said).into_owned();
        // TI's library ends some failures with a good exit code.
        if output.status.success() && !remedy::is_failure(&said) {
            return Ok(said);
        }
        let remedy = remedy::of(&said, &self.driver);
        Err(format!("the programmer said:\n{}\n{remedy}", quoted(&said)))
    }
}

/// What mspdebug said without its greeting.
fn quoted(said: &str) -> String {
    let greeting = ["MSPDebug version", "Copyright (C)", "This is free software", "warranty; not"];
    let lines = said.lines().filter(|line| !greeting.iter().any(|words| line.starts_with(words)));
    let lines: Vec<String> =
        lines.filter(|line| !line.trim().is_empty()).map(|line| format!("  {line}")).collect();
    lines.join("\n")
}

/// `MSPDebug version 0.25 - debugging tool ...`
fn version(text: &str) -> Option<(u32, u32)> {
    let word = text.split_once("MSPDebug version ")?.1.split_whitespace().next()?;
    let (major, minor) = word.split_once('.')?;
    let digits = minor.split(|c: char| !c.is_ascii_digit()).next()?;
    Some((major.parse().ok()?, digits.parse().ok()?))
}

/// The chip that the programmer's words tell of.
fn told(said: &str) -> Chip {
    let is = |chip: &&chip::Chip| identity(said, chip.family.id_address()) == Some(chip.id);
    if let Some(chip) = part::chips().find(is) {
        return Chip::Known(chip);
    }
    // Erased flash, an address that leads nowhere, and vacant memory say nothing.
    let told = Family::ALL.map(|family| identity(said, family.id_address()));
    match told.into_iter().flatten().find(|id| !matches!(id, [0xFF, 0xFF] | [0, 0] | [0xFF, 0x3F]))
    {
        Some([high, low]) => Chip::Other(format!("{high:02x}{low:02x}")),
        None => named(said),
    }
}

/// The bytes in the line of the address: `    00ff0: 25 53 00 ...`
fn identity(said: &str, wanted: u32) -> Option<[u8; 2]> {
    said.lines().find_map(|line| {
        let (address, bytes) = line.trim().split_once(':')?;
        (u32::from_str_radix(address, 16).ok()? == wanted).then_some(())?;
        let mut bytes = bytes.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).ok());
        Some([bytes.next()??, bytes.next()??])
    })
}

/// The chip of the line `Device: NAME`.
fn named(said: &str) -> Chip {
    let names = said.lines().filter_map(|line| line.trim().strip_prefix("Device: "));
    let names: Vec<&str> = names.filter_map(|rest| rest.split_whitespace().next()).collect();
    let is = |chip: &&chip::Chip| {
        names.iter().any(|name| chip.aliases.iter().any(|own| name.starts_with(own)))
    };
    match (part::chips().find(is), names.last()) {
        (Some(chip), _) => Chip::Known(chip),
        (None, Some(name)) if name.starts_with("MSP430") => Chip::Other((*name).to_owned()),
        _ => Chip::Unnamed,
    }
}

#[cfg(test)]
mod tests;
