//! PRINT: texts and numbers into the ring that the host reads.

use crate::machine::chip::Chip;
use crate::machine::controller::Controller;
use crate::verify::Bytes;
use lang::wire::{Seen, TraceKind};

impl<C: Chip> Controller<C> {
    /// Puts text into the ring; in trace mode it waits for room, without it drops the line. A line
    /// longer than the ring is announced before it is complete, so that the host begins to take it.
    fn put(&mut self, byte: u8) -> bool {
        if !self.trace.on {
            self.talk.print.put_or_drop(byte);
        }
        if !self.trace.on || self.talk.print.put(byte) {
            self.chip.beside(Seen::Byte, byte, self.pc_of_effect());
            return true;
        }
        self.talk.print.flush();
        if !self.talk.announced {
            self.talk.announced = true;
            self.emit(TraceKind::Print, 0, 0);
        }
        false
    }

    pub(super) fn print_text(&mut self, far: bool) -> bool {
        if self.program.first() {
            let offset = if far { self.vm.operand_word() } else { u16::from(self.vm.operand()) };
            self.program.effect.left = i32::from(self.vm.data + offset + 1);
        }
        let at = self.program.effect.left as u16;
        let text = self.image_at(at - 1);
        while self.program.effect.n < text.byte(0) {
            if !self.put(self.image_at(at).byte(u16::from(self.program.effect.n))) {
                return false;
            }
            self.program.effect.n += 1;
        }
        true
    }

    pub(super) fn print_number(&mut self) -> bool {
        if self.program.first() {
            self.program.effect.left = self.vm.pop();
        }
        // A sign and ten digits.
        let mut text: heapless::String<11> = heapless::String::new();
        let _ = ufmt::uwrite!(Text(&mut text), "{}", self.program.effect.left);
        let bytes = text.as_bytes();
        while usize::from(self.program.effect.n) < bytes.len() {
            if !self.put(bytes[usize::from(self.program.effect.n)]) {
                return false;
            }
            self.program.effect.n += 1;
        }
        true
    }

    pub(super) fn print_end(&mut self) -> bool {
        if !self.put(b'\n') {
            return false;
        }
        self.talk.print.end();
        if !self.talk.announced {
            self.emit(TraceKind::Print, 0, 0);
        }
        self.talk.announced = false;
        true
    }
}

/// What `ufmt` writes a number into.
struct Text<'a>(&'a mut heapless::String<11>);

impl ufmt::uWrite for Text<'_> {
    type Error = ();
    fn write_str(&mut self, text: &str) -> Result<(), ()> {
        self.0.push_str(text).map_err(|_| ())
    }
}
