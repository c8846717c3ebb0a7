//! The open calls, for debuggers on the host.

use super::Vm;

impl Vm<'_, '_> {
    /// Kind ([`super::entry`]) and address of each open call, the newest first: where it goes back to,
    /// or of an error handler what failed.
    pub fn frames(&self) -> Vec<(u8, usize)> {
        (0..self.state.calls).rev().filter_map(|index| self.call(index)).collect()
    }
}
