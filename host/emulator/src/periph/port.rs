//! Digital I/O (SLAU144, chapter 8). Levels are put together in `bus::pins`.

/// Registers of one port.
#[derive(Debug, Clone, Default)]
pub struct Port {
    /// PxOUT; a reset leaves it.
    pub out: u8,
    /// PxDIR
    pub dir: u8,
    /// PxIFG
    pub ifg: u8,
    /// PxIES; a reset leaves it.
    pub ies: u8,
    /// PxIE
    pub ie: u8,
    /// PxSEL
    pub sel: u8,
    /// PxSEL2
    pub sel2: u8,
    /// PxREN
    pub ren: u8,
    /// PxDS of the MSP430x5xx, stored only.
    pub drive: u8,
    /// Level of each pin.
    pub level: u8,
    /// Pins that the chip drives.
    pub driven: u8,
    /// Pins at which nothing defines the level.
    pub floating: u8,
}

impl Port {
    /// What a PUC does; `sel` is PxSEL's reset value.
    pub fn reset(&mut self, sel: u8) {
        let Port { out, ies, level, .. } = *self;
        *self = Port { out, ies, level, sel, ..Port::default() };
    }

    /// Writes PxIES. An edge select that contradicts the level may set the flag (section 8.2.7);
    /// here it always does.
    pub fn write_ies(&mut self, value: u8) {
        let to_falling = value & !self.ies & !self.level;
        let to_rising = self.ies & !value & self.level;
        self.ifg |= to_falling | to_rising;
        self.ies = value;
    }

    /// Pins changed to `level`: sets the flags of enabled edges on pins used as plain I/O.
    pub fn edges(&mut self, level: u8) {
        let changed = level ^ self.level;
        let wanted = changed & (level ^ self.ies);
        self.ifg |= wanted & !self.sel;
        self.level = level;
    }

    /// A disturbance at the pins in `mask`, too short for a read to see.
    pub fn spike(&mut self, mask: u8) {
        let level = self.level;
        self.edges(level ^ mask);
        self.edges(level);
    }
}
