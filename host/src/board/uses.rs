//! Use of each output in a run: how often it was switched on, and for how long.

use std::collections::BTreeMap;

use crate::sim::record::{Edge, OutputUse};

/// Adds edges up.
#[derive(Debug, Default)]
pub struct Uses(BTreeMap<i32, Use>);

#[derive(Clone, Copy, Debug, Default)]
struct Use {
    switched_on: u32,
    on_us: u64,
    since: Option<u64>,
}

impl Uses {
    /// An output changed.
    pub fn edge(&mut self, edge: &Edge) {
        let used = self.0.entry(edge.n).or_default();
        match (edge.on, used.since) {
            (true, None) => {
                used.switched_on += 1;
                used.since = Some(edge.us);
            }
            (false, Some(since)) => {
                used.on_us += edge.us.saturating_sub(since);
                used.since = None;
            }
            _ => {}
        }
    }

    /// What those that were on did until `end_us`, ascending; of those that still are it counts up to
    /// there.
    pub fn until(&self, end_us: u64) -> Vec<OutputUse> {
        let used = self.0.iter().filter(|(_, used)| used.switched_on > 0);
        used.map(|(n, used)| {
            let open = used.since.map_or(0, |since| end_us.saturating_sub(since));
            OutputUse { n: *n, switched_on: used.switched_on, on_us: used.on_us + open }
        })
        .collect()
    }
}
