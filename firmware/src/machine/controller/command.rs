//! Commands over the link while no program runs.

/// Registers of the command buffer.
const BUFFER: usize = 21;

/// InterpCNC commands.
pub struct Command {
    /// Number and arguments.
    pub words: [u16; BUFFER],
    /// A motion by 102 or 1111 is under way.
    pub jogs: bool,
    /// Milliseconds that what commands move still goes on, 0 without such a bound.
    pub hold: u16,
    /// Bit per axis: homing failed.
    pub homing_error: u8,
    /// Bit per axis: probing failed.
    pub probe_error: u8,
    /// The word of the next argument.
    pub next: u8,
    /// Axes that are meant, and 64 for distances.
    pub axes: u8,
    /// What flags say of the rate that comes next: whether there is one, and its unit.
    pub unit: u8,
    /// Where a distance begins, or a run ends, steps.
    pub start: i32,
    /// um/s.
    pub feed: i32,
    /// New places of the axes, steps.
    pub places: [i32; 3],
}

impl Command {
    /// Word `n` of the command, 0 behind its end.
    pub fn word(&self, n: usize) -> u16 {
        self.words.get(n).copied().unwrap_or(0)
    }

    /// The 32 bits at word `n`, the low word first.
    #[inline(never)]
    pub fn long(&self, n: usize) -> i32 {
        (u32::from(self.word(n + 1)) << 16 | u32::from(self.word(n))) as i32
    }
}
