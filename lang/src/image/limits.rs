//! Limits of AT variables: the values that the link may give them. The program is not bound by them.
//!
//! Only the image of a program with MIN or MAX has them ([`MachineRecord::AT_LIMITS`]): a [`Column`] of
//! four values for each variable that has limits, in the order of their cells.
//!
//! | value | holds |
//! |---|---|
//! | 0 | first cell |
//! | 1 | cells: 1, or the size of an array |
//! | 2 | least value |
//! | 3 | greatest value |
//!
//! [`MachineRecord::AT_LIMITS`]: crate::record::MachineRecord::AT_LIMITS

use super::Column;

/// Values of an entry.
const ENTRY: u16 = 4;

/// The limits in an image.
#[derive(Clone, Copy, Debug)]
pub struct Limits<'a>(Column<'a>);

/// The limits of one variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// First cell.
    pub cell: i32,
    /// Cells.
    pub count: i32,
    /// Least value.
    pub least: i32,
    /// Greatest value.
    pub greatest: i32,
}

impl<'a> Limits<'a> {
    /// Those that stand in a column, `None` when it does not hold whole entries.
    pub const fn new(column: Column<'a>) -> Option<Limits<'a>> {
        if column.rows().is_multiple_of(ENTRY) { Some(Limits(column)) } else { None }
    }

    fn value(&self, entry: u16, which: u16) -> i32 {
        self.0.get(i32::from(entry * ENTRY + which)).unwrap_or(0)
    }

    /// Entry `n`, of those that there are.
    fn entry(&self, n: u16) -> Entry {
        let [cell, count, least, greatest] = [0, 1, 2, 3].map(|which| self.value(n, which));
        Entry { cell, count, least, greatest }
    }

    /// All of them, in the order of their cells.
    pub fn entries(&self) -> impl Iterator<Item = Entry> {
        (0..self.0.rows() / ENTRY).map(|n| self.entry(n))
    }

    /// Whether the link may give a cell this value.
    pub fn allow(&self, cell: u16, value: i32) -> bool {
        let cell = i32::from(cell);
        // The last entry that does not begin behind the cell.
        let (mut low, mut high) = (0, self.0.rows() / ENTRY);
        while low < high {
            let middle = (low + high) / 2;
            if self.value(middle, 0) <= cell {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        let Some(n) = low.checked_sub(1) else { return true };
        let entry = self.entry(n);
        cell.wrapping_sub(entry.cell) >= entry.count
            || (entry.least <= value && value <= entry.greatest)
    }
}

#[cfg(all(test, feature = "compiler"))]
mod tests {
    use proptest::prelude::*;

    use super::{Column, Entry, Limits};

    /// A column as the compiler writes it.
    fn column(entries: &[Entry]) -> Vec<u8> {
        let values = entries.iter().flat_map(|own| [own.cell, own.count, own.least, own.greatest]);
        crate::back::column(&values.collect::<Vec<_>>())
    }

    proptest! {
        #[test]
        fn every_cell_finds_its_limits_and_no_others(
            variables in prop::collection::vec((0..3i32, 1..5i32, any::<i32>(), any::<i32>()), 0..20),
            values in prop::collection::vec(any::<i32>(), 8),
        ) {
            let mut end = 0;
            let mut entries = Vec::new();
            for (gap, count, one, other) in variables {
                let cell = end + gap;
                end = cell + count;
                let (least, greatest) = (one.min(other), one.max(other));
                entries.push(Entry { cell, count, least, greatest });
            }
            let bytes = column(&entries);
            let limits = Limits::new(Column::new(&bytes).expect("a column")).expect("whole");
            prop_assert!(limits.entries().eq(entries.iter().copied()));
            for cell in 0..end + 3 {
                let own = entries.iter().find(|own| (own.cell..own.cell + own.count).contains(&cell));
                let edges = own.into_iter().flat_map(|own| {
                    [own.least, own.greatest, own.least.wrapping_sub(1), own.greatest.wrapping_add(1)]
                });
                for value in values.iter().copied().chain(edges.collect::<Vec<_>>()) {
                    let wanted = own.is_none_or(|own| (own.least..=own.greatest).contains(&value));
                    prop_assert_eq!(limits.allow(cell as u16, value), wanted, "{} {}", cell, value);
                }
            }
        }

        #[test]
        fn no_column_at_all_leads_it_astray(
            bytes in prop::collection::vec(any::<u8>(), 0..80),
            cell: u16,
            value: i32,
        ) {
            if let Some(limits) = Column::new(&bytes).and_then(Limits::new) {
                limits.allow(cell, value);
            }
        }
    }
}
