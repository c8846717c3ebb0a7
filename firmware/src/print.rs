//! The print ring: lines for the host, dropped whole when there is no room, and numbers as text.

use ufmt::uWrite;

/// Bytes of the ring, a power of two.
pub const RING: usize = 512;

/// The ring. Lines are put byte by byte and become visible when they are complete.
#[derive(Debug)]
pub struct Print {
    bytes: [u8; RING],
    /// Number of the first byte that waits, modulo 65536.
    tail: u16,
    /// Bytes that wait and belong to complete lines.
    ready: u16,
    /// Bytes of the line that is being put.
    open: u16,
    /// The line that is being put does not fit.
    dropped: bool,
}

impl Default for Print {
    fn default() -> Print {
        Print::new()
    }
}

impl Print {
    /// An empty ring.
    pub const fn new() -> Print {
        Print { bytes: [0; RING], tail: 0, ready: 0, open: 0, dropped: false }
    }

    /// Appends a byte to the line; `false` when there is no room.
    pub fn put(&mut self, byte: u8) -> bool {
        if usize::from(self.ready + self.open) >= RING {
            return false;
        }
        let at = usize::from(self.tail).wrapping_add(usize::from(self.ready + self.open)) % RING;
        if let Some(place) = self.bytes.get_mut(at) {
            *place = byte;
        }
        self.open += 1;
        true
    }

    /// Appends a byte or drops the line.
    pub fn put_or_drop(&mut self, byte: u8) {
        if !self.put(byte) {
            self.dropped = true;
        }
    }

    /// The line is complete: it becomes visible, or goes if it was dropped.
    pub fn end(&mut self) {
        if !self.dropped {
            self.ready += self.open;
        }
        self.open = 0;
        self.dropped = false;
    }

    /// What was put so far becomes visible: the line goes on after the host has taken some.
    pub fn flush(&mut self) {
        self.ready += self.open;
        self.open = 0;
    }

    /// The line that is being put comes to nothing: its statement failed.
    pub fn abandon(&mut self) {
        self.open = 0;
        self.dropped = false;
    }

    /// Bytes that wait.
    pub fn count(&self) -> u16 {
        self.ready
    }

    /// Number of the first of them.
    pub fn tail(&self) -> u16 {
        self.tail
    }

    /// The byte `index` places behind the first one; 0 beyond those that wait.
    pub fn byte(&self, index: u16) -> u8 {
        if index >= self.ready {
            return 0;
        }
        let at = usize::from(self.tail).wrapping_add(usize::from(index)) % RING;
        self.bytes.get(at).copied().unwrap_or(0)
    }

    /// The host has taken what lies before number `tail`; `false` when it is not one of those.
    pub fn take(&mut self, tail: u16) -> bool {
        let taken = tail.wrapping_sub(self.tail);
        if taken > self.ready {
            return false;
        }
        self.tail = tail;
        self.ready -= taken;
        true
    }
}

impl uWrite for Print {
    type Error = core::convert::Infallible;

    fn write_str(&mut self, text: &str) -> Result<(), Self::Error> {
        for &byte in text.as_bytes() {
            self.put_or_drop(byte);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Print, RING};

    fn text(print: &mut Print) -> String {
        let bytes: Vec<u8> = (0..print.count()).map(|index| print.byte(index)).collect();
        let tail = print.tail().wrapping_add(bytes.len() as u16);
        assert!(print.take(tail));
        String::from_utf8(bytes).unwrap()
    }

    #[test]
    fn lines_come_out_as_they_went_in() {
        let mut print = Print::new();
        for round in 0..40 {
            ufmt::uwrite!(print, "hole {}\n", round * 1000).unwrap();
            assert_eq!(print.count(), 0, "an open line is not visible");
            print.end();
            assert_eq!(text(&mut print), format!("hole {}\n", round * 1000));
        }
    }

    #[test]
    fn a_line_without_room_is_dropped_whole() {
        let mut print = Print::new();
        ufmt::uwrite!(print, "first\n").unwrap();
        print.end();
        for _ in 0..=RING {
            print.put_or_drop(b'x');
        }
        print.end();
        ufmt::uwrite!(print, "second\n").unwrap();
        print.end();
        assert_eq!(text(&mut print), "first\nsecond\n");
    }

    #[test]
    fn a_line_that_is_abandoned_leaves_nothing() {
        let mut print = Print::new();
        ufmt::uwrite!(print, "half of").unwrap();
        print.abandon();
        ufmt::uwrite!(print, "whole\n").unwrap();
        print.end();
        assert_eq!(text(&mut print), "whole\n");
    }

    #[test]
    fn a_host_cannot_take_what_is_not_there() {
        let mut print = Print::new();
        assert!(!print.take(1));
        assert!(print.take(0));
    }
}
