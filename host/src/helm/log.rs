//! Log of the board's events, for readers that come later or read at another pace.

use std::collections::VecDeque;

use serde::Serialize;

use crate::sim::trace::What;

/// Entries that are kept; whoever looks more seldom misses the oldest.
const KEPT: usize = 2_000;

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Entry {
    /// The program printed a line.
    Print(String),
    /// An effect of a run that is followed.
    Effect(What),
    /// A run began: its number since the board's reset.
    Begun(u16),
    /// The port was opened or lost; the text says which and why.
    Port(String),
    /// A held jog is over.
    Hold {
        /// Its number.
        id: u64,
        /// Why, in words.
        why: String,
    },
}

/// The newest entries.
#[derive(Debug, Default)]
pub struct Log {
    entries: VecDeque<Entry>,
    /// Entries that there ever were.
    count: u64,
}

impl Log {
    /// Adds one.
    pub fn push(&mut self, entry: Entry) {
        self.entries.push_back(entry);
        self.count += 1;
        if self.entries.len() > KEPT {
            self.entries.pop_front();
        }
    }

    /// Those behind number `seen`, and the number of the newest.
    pub fn behind(&self, seen: u64) -> (u64, Vec<Entry>) {
        let new = usize::try_from(self.count.saturating_sub(seen)).unwrap_or(usize::MAX);
        let first = self.entries.len().saturating_sub(new);
        (self.count, self.entries.iter().skip(first).cloned().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::{Entry, KEPT, Log};

    #[test]
    fn who_looks_seldom_misses_only_the_oldest() {
        let mut log = Log::default();
        assert_eq!(log.behind(0), (0, vec![]));
        for n in 0..KEPT + 5 {
            log.push(Entry::Print(n.to_string()));
        }
        let (seen, all) = log.behind(0);
        assert_eq!((seen, all.len()), (KEPT as u64 + 5, KEPT));
        assert_eq!(all[0], Entry::Print("5".to_owned()));
        assert_eq!(log.behind(seen - 1).1, [Entry::Print((KEPT + 4).to_string())]);
        assert_eq!(log.behind(seen + 9).1, []);
    }
}
