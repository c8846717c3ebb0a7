//! What is meant of the library: the selected program, and what the next upload brings.

use firmware::store::NAME;

/// What the link says of the library, and of the next upload.
#[derive(Clone, Copy)]
pub struct Library {
    /// Number of the program that Start runs, 0 for none.
    pub selected: u8,
    /// Number that the next upload or erase is for, 0 for the selected one or a free one.
    pub number: u8,
    /// Name that the next upload gives.
    pub name: [u16; NAME],
    /// The button for the next program was down a millisecond ago.
    pub pressed: bool,
    /// Number that the status lamp blinks, once; 0 for none.
    pub shown: u8,
}

/// Words of an image on their way to flash, in the memory of streamed pieces: they are written once the reply is on its
/// way, while the next request arrives.
#[derive(Clone, Copy)]
pub struct Staged {
    /// Place of the first in the image, words.
    pub first: u16,
    /// How many.
    pub count: u8,
    /// One was not taken: the upload cannot be sound any more.
    pub failed: bool,
}
