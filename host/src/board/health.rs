//! Health of a board after a run: stack, deadlines, and the emulator's warnings.

use emulator::Board;

use super::Build;
use crate::client::identity::Identity;

/// Start of RAM that the firmware's variables leave to the stack: the symbol of the compact image, and
/// the linker's.
const STACK_ENDS: [&str; 2] = ["POOL_END", "_edata"];

/// A board after a run.
#[derive(Clone, Debug, Default)]
pub struct Health {
    /// Bytes of stack never used, as the board says.
    pub stack_free: u16,
    /// Bytes between the variables and the lowest stack pointer that the emulator saw since its
    /// measurements began.
    pub stack_left: Option<u16>,
    /// Milliseconds that the board served late, as it says.
    pub missed_deadlines: u16,
    /// Step events that came late in the run, as it says.
    pub late_events: u16,
    /// Broken rules of the chip.
    pub warnings: Vec<String>,
    /// Step pulses that broke a limit of the drivers.
    pub violations: u64,
}

impl Health {
    /// What is known of a board.
    pub fn of(board: &Board, identity: &Identity) -> Health {
        Health {
            stack_free: identity.stack_free,
            stack_left: stack_left(board),
            missed_deadlines: identity.missed_deadlines,
            late_events: 0,
            warnings: board.warnings().iter().map(ToString::to_string).collect(),
            violations: board.plant().violation_count,
        }
    }
}

/// Bytes of stack when the deepest interrupt that the emulator saw comes at the deepest place that it saw
/// outside interrupts, whether it came there or not.
pub fn stack_used(build: &Build, board: &Board) -> Option<u16> {
    let end = build.chip.ram.end() + 1;
    let stats = board.stats();
    let outside = end.saturating_sub(stats.lowest_outside?.into());
    Some(outside as u16 + stats.deepest_interrupt)
}

/// Bytes between the firmware's variables and the lowest stack pointer that the emulator saw.
pub fn stack_left(board: &Board) -> Option<u16> {
    let end = STACK_ENDS.iter().find_map(|name| board.symbol(name))?;
    board.stats().lowest_sp.map(|lowest| lowest.saturating_sub(end))
}
