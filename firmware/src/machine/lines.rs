//! Two lines: both read, one writes.

use lang::wire::{
    Control, Exception, HELM_MS, RUN_CONTROL, STREAM_ACCEPTED, STREAM_CALL, STREAM_RESULT,
};

/// The lines of the link, and who steers.
pub struct Lines {
    /// The line that is served: 0 the back channel, 1 RS-485.
    pub line: u8,
    /// No reply is being sent: flash may be written, which would tear it apart.
    pub rests: bool,
    /// The line that wrote last, and one more; 0 for none since reset.
    holder: u8,
    /// Milliseconds that it still holds the helm.
    left: u16,
    /// Milliseconds since the last sound request of who steers.
    pub silence: u16,
    /// Milliseconds since the host that feeds a streamed job last did so: wrote to it, or asked how it stands.
    pub unfed: u16,
    /// A read request has begun whose first register has not been looked at.
    opens: bool,
    /// A host has spoken since reset.
    pub spoken: bool,
    /// Of each line: high half of a 32-bit value being read.
    latch: [u16; 2],
    /// Of each line: address after the one whose value is latched.
    latched: [u16; 2],
}

impl Lines {
    /// The line that is served wants to write, one `value` or several: it takes the helm, or has it, or only stops the
    /// machine.
    ///
    /// # Errors
    /// Busy while the other one holds it.
    pub fn take_helm(&mut self, address: u16, value: Option<u16>) -> Result<(), Exception> {
        let own = self.line + 1;
        if self.holder == own || self.left == 0 {
            self.holder = own;
            self.left = HELM_MS;
            return Ok(());
        }
        let control = value.filter(|_| address == RUN_CONTROL);
        match control.and_then(Control::from_number) {
            Some(Control::Stop | Control::Pause | Control::EmergencyStop) => Ok(()),
            _ => Err(Exception::Busy),
        }
    }

    /// The line that holds the helm, from 1; 0 while it is free.
    pub fn helm(&self) -> u16 {
        if self.left == 0 { 0 } else { u16::from(self.holder) }
    }

    /// A sound request has come on the line that is served. What commands move goes on only as long as those of
    /// who commanded it come.
    pub fn heard(&mut self) {
        self.spoken = true;
        if self.holder == 0 || self.holder == self.line + 1 {
            self.silence = 0;
        }
    }

    /// A host has fed the streamed job. One that does not steer feeds none.
    pub fn feed(&mut self) {
        if self.holder == 0 || self.holder == self.line + 1 {
            self.unfed = 0;
        }
    }

    /// A register is read. The first one of a request says who asks: a host that feeds a job begins with one of the
    /// job's own, any other, as `status`, with what is every run's.
    pub fn reads(&mut self, address: u16) {
        let first = core::mem::replace(&mut self.opens, false);
        if first && matches!(address, STREAM_CALL | STREAM_ACCEPTED..=STREAM_RESULT) {
            self.feed();
        }
    }

    /// A millisecond.
    pub fn tick(&mut self) {
        self.silence = self.silence.saturating_add(1);
        self.unfed = self.unfed.saturating_add(1);
        self.left = self.left.saturating_sub(1);
    }

    /// Milliseconds at once.
    #[cfg(any(test, feature = "physics"))]
    pub fn skip(&mut self, ms: u16) {
        self.silence = self.silence.saturating_add(ms);
        self.unfed = self.unfed.saturating_add(ms);
        self.left = self.left.saturating_sub(ms);
    }

    /// A request begins on the line that is served.
    pub fn begin(&mut self) {
        self.latched[usize::from(self.line & 1)] = 0;
        self.opens = true;
    }

    /// One half of a 32-bit value: both are of one instant when they are read in one request.
    pub fn half(&mut self, address: u16, value: i32) -> u16 {
        let line = usize::from(self.line & 1);
        if address & 1 == 0 {
            self.latch[line] = (value >> 16) as u16;
            self.latched[line] = address + 1;
            return value as u16;
        }
        if self.latched[line] == address { self.latch[line] } else { (value >> 16) as u16 }
    }
}
