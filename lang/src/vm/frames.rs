//! The open calls, for debuggers on the host.

use super::Vm;

/// Shift of the kind in an entry of two bytes, and in one of four.
const KIND: [u32; 2] = [12, 24];

impl Vm<'_, '_> {
    /// Kind ([`super::entry`]) and address of each open call, the newest first: where it goes back to,
    /// or of an error handler what failed.
    pub fn frames(&self) -> Vec<(u8, usize)> {
        let header = &self.image.header;
        let entry = |index: u8| {
            let above = (usize::from(index) + 1) * header.call_bytes();
            let at = header.pool_bytes().checked_sub(above)?;
            let bytes = self.pool.get(at..)?;
            let (entry, shift) = if header.wide() {
                (u32::from_le_bytes(*bytes.first_chunk()?), KIND[1])
            } else {
                (u32::from(u16::from_le_bytes(*bytes.first_chunk()?)), KIND[0])
            };
            Some(((entry >> shift) as u8, (entry & ((1 << shift) - 1)) as usize))
        };
        (0..self.state.calls).rev().filter_map(entry).collect()
    }
}
