//! Two lines: both read, one writes.

use crate::controller::Controller;
use lang::wire::{Control, Exception, HELM_MS, RUN_CONTROL};

impl Controller {
    /// The line that is served wants to write, one `value` or several: it takes the helm, or has it, or only stops the
    /// machine.
    ///
    /// # Errors
    /// Busy while the other one holds it.
    pub fn take_helm(&mut self, address: u16, value: Option<u16>) -> Result<(), Exception> {
        let own = self.line + 1;
        if self.helm == own || self.helm_left == 0 {
            self.helm = own;
            self.helm_left = HELM_MS;
            return Ok(());
        }
        let control = value.filter(|_| address == RUN_CONTROL);
        match control.and_then(Control::from_number) {
            Some(Control::Stop | Control::Pause | Control::EmergencyStop) => Ok(()),
            _ => Err(Exception::Busy),
        }
    }

    /// The line that holds the helm, from 1; 0 while it is free.
    pub fn helm_now(&self) -> u16 {
        if self.helm_left == 0 { 0 } else { u16::from(self.helm) }
    }

    /// A sound request has come on the line that is served. What commands move goes on only as long as those of
    /// who commanded it come.
    pub fn heard(&mut self) {
        self.host = true;
        if self.helm == 0 || self.helm == self.line + 1 {
            self.silence = 0;
        }
    }
}
