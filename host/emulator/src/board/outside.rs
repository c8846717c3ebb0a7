//! The board's surroundings: plant, serial line, recording.

use super::Board;
use super::chip::{Chip, with};
use crate::line::{Format, HostLine};
use crate::plant::Plant;
use crate::record::{Edge, EdgeSink, Recorder};

/// A serial line of the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Link {
    /// To the host: USCI_A0 of the G2553, the back channel of the F5529 LaunchPad.
    Host,
    /// USCI_A0 of the F5529, at P3.3 and P3.4.
    Rs485,
}

impl Board {
    /// The world around the pins; changes take effect at the present time.
    pub fn plant_mut(&mut self) -> &mut Plant {
        self.world_changed = true;
        with!(&mut self.chip, c => &mut c.bus.plant)
    }

    /// The world around the pins.
    #[must_use]
    pub fn plant(&self) -> &Plant {
        with!(&self.chip, c => &c.bus.plant)
    }

    /// Sets rate and parity of the host's port.
    pub fn set_uart_format(&mut self, format: Format) {
        self.set_uart_format_on(Link::Host, format);
    }

    /// Sets rate and parity of what is at the other end of a line.
    pub fn set_uart_format_on(&mut self, link: Link, format: Format) {
        self.line(link).format = format;
    }

    /// Queues characters on the line to the chip, at the host's rate and behind what is queued
    /// already. Returns the time when the last of them has left.
    pub fn uart_send(&mut self, bytes: &[u8]) -> u64 {
        self.uart_send_at(self.cycles(), bytes)
    }

    /// Queues characters that begin to leave at `cycle`, or behind what is queued already.
    pub fn uart_send_at(&mut self, cycle: u64, bytes: &[u8]) -> u64 {
        self.uart_send_on(Link::Host, cycle, bytes)
    }

    /// The same on either line.
    pub fn uart_send_on(&mut self, link: Link, cycle: u64, bytes: &[u8]) -> u64 {
        let from = cycle.max(self.cycles());
        self.world_changed = true;
        self.line(link).send(bytes, from)
    }

    /// Queues raw levels on the line to the chip, each for a number of ticks: glitches, breaks.
    pub fn uart_send_raw(&mut self, levels: &[(bool, u64)]) {
        let now = self.cycles();
        self.world_changed = true;
        self.line(Link::Host).send_raw(levels, now);
    }

    /// When everything queued on the line has left.
    #[must_use]
    pub fn uart_free(&self) -> u64 {
        with!(&self.chip, c => c.bus.line.free().max(c.bus.now))
    }

    /// Characters that the chip sent, each with the time of its stop bit.
    pub fn uart_take(&mut self) -> Vec<(u64, u8)> {
        self.uart_take_on(Link::Host)
    }

    /// Characters that the chip sent on either line.
    pub fn uart_take_on(&mut self, link: Link) -> Vec<(u64, u8)> {
        let now = self.cycles();
        self.line(link).take(now)
    }

    /// Characters from the chip that had wrong parity or no stop bit.
    #[must_use]
    pub fn uart_errors(&self) -> u64 {
        with!(&self.chip, c => c.bus.line.errors)
    }

    /// Characters from the host that the chip overwrote before it had read them, since its reset.
    #[must_use]
    pub fn uart_overruns(&self) -> u64 {
        with!(&self.chip, c => c.bus.overruns())
    }

    /// Flips `per_million` of all bits on the line in both directions; 0 ends it.
    pub fn set_uart_noise(&mut self, seed: u64, per_million: u32) {
        self.line(Link::Host).set_noise(seed, per_million);
    }

    /// A part without a second line has its only one under both names.
    fn line(&mut self, link: Link) -> &mut HostLine {
        match (&mut self.chip, link) {
            (Chip::Msp430X(c), Link::Rs485) => &mut c.bus.rs485,
            (Chip::Msp430X(c), Link::Host) => &mut c.bus.line,
            (Chip::Msp430(c), _) => &mut c.bus.line,
        }
    }

    fn recorder(&mut self) -> &mut Recorder {
        with!(&mut self.chip, c => &mut c.bus.plant.recorder)
    }

    /// Keeps edges from now on, or no longer.
    pub fn record(&mut self, on: bool) {
        self.recorder().on = on;
    }

    /// Edges since the last call.
    pub fn take_edges(&mut self) -> Vec<Edge> {
        std::mem::take(&mut self.recorder().edges)
    }

    /// Tells `sink` of every edge as it happens; `None` ends that.
    pub fn set_edge_sink(&mut self, sink: Option<EdgeSink>) {
        self.recorder().sink = sink;
    }
}
