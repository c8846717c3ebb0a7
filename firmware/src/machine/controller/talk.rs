//! Characters and PRINT text between program and host.

use crate::print::Print;

/// PRINT, Send and the character of the host.
pub struct Talk {
    /// Print ring.
    pub print: Print,
    /// The host knows of the line that is being printed.
    pub announced: bool,
    /// Last Send: character and count.
    pub char_out: u16,
    /// Character from the host, 0 for none.
    pub char_in: u8,
}

impl Talk {
    /// The line that is being printed does not come to its end.
    pub fn abandon(&mut self) {
        self.announced = false;
        self.print.abandon();
    }

    /// Send.
    pub fn send(&mut self, c: u8) {
        self.char_out = (self.char_out & 0xFF00).wrapping_add(0x100) | u16::from(c);
    }
}
