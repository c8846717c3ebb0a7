//! The virtual board: the shipped firmware image in the emulator, with a world around it.

mod chip;
pub mod clients;
pub mod engine;
pub mod hardware;
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
#[cfg(test)]
mod pwm;
pub mod rig;
mod run;
pub mod serve;
pub mod size;
mod stuck;
mod switches;
pub mod teller;
pub mod turns;
mod uart;
mod uses;
mod within;

use emulator::{Board, Image, LoadError, Part};
use lang::part;
use lang::record::BoardRecord;

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

// Of each part of `lang::part` a static with its name, and `BUILDS`.
include!(concat!(env!("OUT_DIR"), "/builds.rs"));

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

/// Gives a virtual board that has not run yet the profile `mill`: one that was never told its wiring drives no output.
pub(crate) fn tell_default(build: &Build, board: &mut Board) {
    let record = BoardRecord::DEFAULT.sealed().to_bytes();
    (build.part.profiles[0]..).zip(record).for_each(|(at, byte)| board.poke8(at, byte));
}
