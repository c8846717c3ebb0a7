//! A program in flash as the store leaves it, for boards that come up with one.

use lang::image::at;
use lang::part::{Part, SEGMENT, slot_head};

/// Where the first slot begins, and its bytes with this image: committed, in a library as program 1 without a name.
pub fn slot(part: &Part, image: &[u8]) -> (u16, Vec<u8>) {
    let mut slot = vec![0xFF; slot_head(part.programs)];
    slot[..2].copy_from_slice(&0xA500u16.to_le_bytes());
    slot.extend(image);
    if part.programs > 1 {
        let keeps = image[at::KEEPS] != 0;
        slot[4] = 1;
        slot[5] = slot.len().div_ceil(SEGMENT) as u8 + if keeps { 2 } else { 0 };
    }
    (0xFE00 - (SEGMENT * usize::from(part.segments)) as u16, slot)
}
