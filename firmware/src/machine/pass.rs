//! One pass of a board's main loop.

use crate::machine::chip::Chip;
use crate::machine::controller::Controller;
use crate::modbus::{Line, Slave};

/// The serial port of a line.
pub trait Port: Line {
    /// Length of the frame that was received, once its silence has passed. After a reply the next character listens.
    fn frame(&mut self) -> Option<u8>;
    /// Whether no reply is being sent.
    fn rests(&self) -> bool;
    /// Keeps the line's rate when the crystal has failed.
    fn follow_clock(&self);
}

impl<C: Chip> Controller<C> {
    /// A pass begins: no line is known to send.
    pub fn begin_pass(&mut self) {
        self.lines.rests = true;
    }

    /// Serves line `n`, on which the board has an address.
    pub fn serve_line<P: Port>(&mut self, n: u8, port: &mut P, slave: &mut Slave, address: u8) {
        self.lines.line = n;
        if let Some(length) = port.frame()
            && slave.request(port, self, address, length)
        {
            self.lines.heard();
            slave.poll(port, self);
            // A request of many registers takes as long as a short segment lasts.
            self.motor.poll(self.trace.full);
        }
        slave.poll(port, self);
        if port.rests() {
            port.follow_clock();
        } else {
            self.lines.rests = false;
        }
    }

    /// What a pass does after its lines: flash, milliseconds, motion, the program.
    pub fn pass(&mut self) {
        self.write_incoming();
        self.ticks();
        self.motor.poll(self.trace.full);
        self.tripped();
        if !self.motor.actions.is_empty() {
            self.act();
        }
        if self.motor.has_enough() {
            self.run();
        }
    }

    /// Whether the chip is to be reset now: the reply to who asked for it is out.
    pub fn wants_reset(&self) -> bool {
        self.reset.wanted && self.lines.rests
    }
}
