//! What an image and a VM must agree on.

use super::{ROWS, Shape};
use crate::wire::{CRC_START, crc16};

const fn sum_over(mut sum: u16, bytes: &[u8]) -> u16 {
    let mut i = 0;
    while i < bytes.len() {
        sum = crc16(sum, bytes[i]);
        i += 1;
    }
    sum
}

const fn fingerprint() -> u16 {
    let mut sum = CRC_START;
    let mut r = 0;
    while r < ROWS.len() {
        let row = &ROWS[r];
        if row.code >= EXTRA.0 && row.code <= EXTRA.1 {
            r += 1;
            continue;
        }
        let shape = Shape::of(row).0;
        sum = sum_over(sum, &[row.code, row.count, shape as u8, (shape >> 8) as u8]);
        sum = sum_over(sum, row.name.as_bytes());
        sum = sum_over(sum, row.doc.as_bytes());
        r += 1;
    }
    sum
}

/// First and last code of the instructions that only larger parts have. A board says by its features which it has, so
/// that the table of all others goes on when one is added.
pub const EXTRA: (u8, u8) = (0x53, 0x5F);

/// CRC of the opcode table but for [`EXTRA`]: an image runs only on a VM with the same one.
pub const FINGERPRINT: u16 = fingerprint();
