//! The board's surroundings: plant, serial line, recording.

use super::Board;
use crate::line::Format;
use crate::plant::Plant;
use crate::record::{Edge, EdgeSink};

impl Board {
    /// The world around the pins; changes take effect at the present time.
    pub fn plant_mut(&mut self) -> &mut Plant {
        self.world_changed = true;
        &mut self.bus.plant
    }

    /// The world around the pins.
    #[must_use]
    pub fn plant(&self) -> &Plant {
        &self.bus.plant
    }

    /// Sets rate and parity of the host's port.
    pub fn set_uart_format(&mut self, format: Format) {
        self.bus.line.format = format;
    }

    /// Queues characters on the line to the chip, at the host's rate and behind what is queued
    /// already. Returns the time when the last of them has left.
    pub fn uart_send(&mut self, bytes: &[u8]) -> u64 {
        self.uart_send_at(self.bus.now, bytes)
    }

    /// Queues characters that begin to leave at `cycle`, or behind what is queued already.
    pub fn uart_send_at(&mut self, cycle: u64, bytes: &[u8]) -> u64 {
        let end = self.bus.line.send(bytes, cycle.max(self.bus.now));
        self.world_changed = true;
        end
    }

    /// Queues raw levels on the line to the chip, each for a number of ticks: glitches, breaks.
    pub fn uart_send_raw(&mut self, levels: &[(bool, u64)]) {
        self.bus.line.send_raw(levels, self.bus.now);
        self.world_changed = true;
    }

    /// When everything queued on the line has left.
    #[must_use]
    pub fn uart_free(&self) -> u64 {
        self.bus.line.free().max(self.bus.now)
    }

    /// Characters that the chip sent, each with the time of its stop bit.
    pub fn uart_take(&mut self) -> Vec<(u64, u8)> {
        self.bus.line.take(self.bus.now)
    }

    /// Characters from the chip that had wrong parity or no stop bit.
    #[must_use]
    pub fn uart_errors(&self) -> u64 {
        self.bus.line.errors
    }

    /// Flips `per_million` of all bits on the line in both directions; 0 ends it.
    pub fn set_uart_noise(&mut self, seed: u64, per_million: u32) {
        self.bus.line.set_noise(seed, per_million);
    }

    /// Keeps edges from now on, or no longer.
    pub fn record(&mut self, on: bool) {
        self.bus.plant.recorder.on = on;
    }

    /// Edges since the last call.
    pub fn take_edges(&mut self) -> Vec<Edge> {
        std::mem::take(&mut self.bus.plant.recorder.edges)
    }

    /// Tells `sink` of every edge as it happens; `None` ends that.
    pub fn set_edge_sink(&mut self, sink: Option<EdgeSink>) {
        self.bus.plant.recorder.sink = sink;
    }
}
