//! The virtual board: the shipped firmware image in the emulator, with a world around it.

pub mod engine;
pub mod health;
pub mod link;
mod path;
mod pty;
pub mod rig;
pub mod serve;
pub mod size;
mod stuck;

use emulator::{Image, LoadError, Part};

/// The shipped image, with its symbols.
pub const FIRMWARE: &[u8] = include_bytes!("../../../firmware/image/pasapas-g2955.elf");

/// The part that the shipped image is for.
pub const PART: Part = Part::G2955;

/// The shipped firmware image.
///
/// # Errors
/// The image is no ELF file: the build that made this tool was damaged.
pub fn firmware() -> Result<Image, LoadError> {
    Image::parse(FIRMWARE)
}
