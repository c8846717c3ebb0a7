//! PRINT: texts and numbers into the ring that the host reads.

use crate::controller::Controller;
use crate::flash::Image;
use crate::observe;
use crate::vm::vm;
use firmware::verify::Bytes;
use lang::wire::{Seen, TraceKind};

impl Controller {
    /// Puts text into the ring; in trace mode it waits for room, without it drops the line. A line
    /// longer than the ring is announced before it is complete, so that the host begins to take it.
    fn put(&mut self, byte: u8) -> bool {
        if !self.trace.on {
            self.print.put_or_drop(byte);
        }
        if !self.trace.on || self.print.put(byte) {
            observe::beside(Seen::Byte, byte, self.pc_of_effect());
            return true;
        }
        self.print.flush();
        if !self.announced {
            self.announced = true;
            self.emit(TraceKind::Print, 0, 0);
        }
        false
    }

    pub(super) fn print_text(&mut self, far: bool) -> bool {
        if self.first() {
            let offset = if far { vm().operand_word() } else { u16::from(vm().operand()) };
            self.effect.left = i32::from(vm().data + offset + 1);
        }
        let at = self.effect.left as u16;
        let text = Image(at - 1);
        while self.effect.n < text.byte(0) {
            if !self.put(Image(at).byte(u16::from(self.effect.n))) {
                return false;
            }
            self.effect.n += 1;
        }
        true
    }

    pub(super) fn print_number(&mut self) -> bool {
        if self.first() {
            self.effect.left = vm().pop();
        }
        // A sign and ten digits.
        let mut text: heapless::String<11> = heapless::String::new();
        let _ = ufmt::uwrite!(Text(&mut text), "{}", self.effect.left);
        let bytes = text.as_bytes();
        while usize::from(self.effect.n) < bytes.len() {
            if !self.put(bytes[usize::from(self.effect.n)]) {
                return false;
            }
            self.effect.n += 1;
        }
        true
    }

    pub(super) fn print_end(&mut self) -> bool {
        if !self.put(b'\n') {
            return false;
        }
        self.print.end();
        if !self.announced {
            self.emit(TraceKind::Print, 0, 0);
        }
        self.announced = false;
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
