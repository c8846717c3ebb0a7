//! The virtual board: the shipped firmware image in the emulator, with a world around it.

pub mod clients;
pub mod engine;
pub mod health;
pub mod image_file;
pub mod judge;
#[cfg(test)]
mod laser;
pub mod link;
pub mod live;
pub mod observe;
mod path;
pub(crate) mod pty;
pub mod rig;
mod run;
pub mod serve;
pub mod size;
mod stuck;
pub mod teller;
pub mod turns;
mod uart;
mod uses;

use emulator::{Image, LoadError, Part};
use lang::part;

/// A shipped image, with its symbols, and the chip that it is for.
#[derive(Clone, Debug)]
pub struct Build {
    /// What it runs.
    pub part: part::Part,
    /// The emulated chip.
    pub chip: Part,
    /// An ELF file.
    pub elf: &'static [u8],
}

/// The build for 16 KB of flash and 512 bytes of RAM.
pub static G2553: Build = Build {
    part: part::G2553,
    chip: Part::G2553,
    elf: include_bytes!("../../../firmware/image/pasapas-g2553.elf"),
};

/// The same chip with ON ERROR, ON IN and ON EVERY.
pub static G2553_HANDLERS: Build = Build {
    part: part::G2553_HANDLERS,
    chip: Part::G2553,
    elf: include_bytes!("../../../firmware/image/pasapas-g2553-handlers.elf"),
};

/// The build with everything.
pub static F5529: Build = Build {
    part: part::F5529,
    chip: Part::F5529,
    elf: include_bytes!("../../../firmware/image/pasapas-f5529.elf"),
};

/// Every build, in the order in which a program finds its own ([`part::PARTS`]).
pub static BUILDS: [&Build; 3] = [&G2553, &G2553_HANDLERS, &F5529];

/// The build of a board that nobody chose: what runs every program.
pub static DEFAULT: &Build = &F5529;

impl Build {
    /// The build for the part with this name.
    pub fn named(name: &str) -> Option<&'static Build> {
        BUILDS.into_iter().find(|build| build.part.name == name)
    }

    /// This build and no other.
    pub fn alone(&'static self) -> &'static [&'static Build] {
        BUILDS.iter().position(|build| build.part == self.part).map_or(&[], |n| &BUILDS[n..=n])
    }

    /// The shipped image.
    ///
    /// # Errors
    /// The image is no ELF file: the build that made this tool was damaged.
    pub fn image(&self) -> Result<Image, LoadError> {
        Image::parse(self.elf)
    }
}
