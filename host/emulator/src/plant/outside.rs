//! What is around the pins, for a board that is no emulated chip.

use super::Plant;
use crate::record::Edge;

impl Plant {
    /// Keeps the edges of all signals from now on, or no more.
    pub fn record(&mut self, on: bool) {
        self.recorder.on = on;
    }

    /// Edges since the last call.
    pub fn take_edges(&mut self) -> Vec<Edge> {
        std::mem::take(&mut self.recorder.edges)
    }

    /// Whether [`Plant::take_output_changes`] has any.
    #[must_use]
    pub fn output_has_changed(&self) -> bool {
        !self.changes.is_empty()
    }
}
